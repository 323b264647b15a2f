//! Files of triangles: which of them a program names, and their meshes, each made once.

use super::scope::Scope;
use super::value::{MeshFile, Value};
use super::{Checker, errors};
use crate::geometry::mesh::Mesh;
use crate::syntax::tree::{self, Expr, ExprKind, Item, SceneEntry, Text};
use std::rc::Rc;

/// The name of the field that names such a file.
const FIELD: &str = "file";

/// The strings of a file that name files of triangles: those after `file:` in the shapes of its values and scenes.
pub fn named(tree: &tree::Tree) -> Vec<&Text> {
    let mut found = Vec::new();
    for item in &tree.items {
        match item {
            Item::Let(item) => in_expr(&item.value, &mut found),
            Item::Scene(item) => in_scene(&item.entries, &mut found),
            Item::Use(_)
            | Item::Device(_)
            | Item::Instrument(_)
            | Item::Output(_)
            | Item::Task(_)
            | Item::Program(_)
            | Item::Wiring(_)
            | Item::Error(_) => {}
        }
    }
    found
}

fn in_scene<'t>(entries: &'t [SceneEntry], found: &mut Vec<&'t Text>) {
    for entry in entries {
        match entry {
            SceneEntry::Object(object) => object.shape.iter().for_each(|shape| in_expr(shape, found)),
            SceneEntry::For(each) => {
                in_expr(&each.over, found);
                in_scene(&each.entries, found);
            }
            SceneEntry::Error(_) => {}
        }
    }
}

/// Shapes stand alone, in lists and in the fields of others.
fn in_expr<'t>(expr: &'t Expr, found: &mut Vec<&'t Text>) {
    match &expr.kind {
        ExprKind::With { fields, .. } => {
            for field in fields {
                match &field.value.kind {
                    ExprKind::Text(text) if field.name.text == FIELD => found.push(text),
                    _ => in_expr(&field.value, found),
                }
            }
        }
        ExprKind::List(parts) => parts.iter().for_each(|part| in_expr(part, found)),
        ExprKind::Number(_)
        | ExprKind::Quantity { .. }
        | ExprKind::Word(_)
        | ExprKind::Text(_)
        | ExprKind::Bool(_)
        | ExprKind::Path(_)
        | ExprKind::Tuple(_)
        | ExprKind::Range { .. }
        | ExprKind::Negative(_)
        | ExprKind::Binary { .. }
        | ExprKind::Call { .. }
        | ExprKind::Table(_)
        | ExprKind::Error => {}
    }
}

impl Checker<'_> {
    /// The mesh of a file that was read with the program; `None` after an error.
    pub fn accept_mesh(&mut self, expr: &Expr, scope: &Scope) -> Option<Value> {
        let path = match &expr.kind {
            ExprKind::Text(text) => text.plain(),
            ExprKind::Error => return None,
            _ => None,
        };
        let Some(path) = path else {
            self.sink.push(errors::mesh_file_not_plain(expr.span));
            return None;
        };
        let key = (scope.module, path);
        if !self.meshes.contains_key(&key) {
            // A file that could not be read was reported where the program was loaded.
            let text = self.modules[scope.module].named_files.get(&key.1)?;
            let mesh = match Mesh::read(text.as_bytes()) {
                Ok(mesh) => Some(Rc::new(MeshFile { path: key.1.clone(), mesh })),
                Err(fault) => {
                    self.sink.push(errors::bad_mesh(expr.span, &key.1, &fault.to_string()));
                    None
                }
            };
            self.meshes.insert(key.clone(), mesh);
        }
        self.meshes.get(&key).cloned().flatten().map(Value::Mesh)
    }
}
