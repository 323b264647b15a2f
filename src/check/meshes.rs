//! Mesh files: finds those that a program names, and reads each once.

use super::scope::Scope;
use super::value::{MeshFile, Value};
use super::{Checker, errors};
use crate::diagnostic::Diagnostic;
use crate::geometry::mesh::Mesh;
use crate::source::Span;
use crate::syntax::tree::{self, Expr, ExprKind, Item, SceneEntry, Text};
use std::rc::Rc;

/// Field that names a mesh file.
const FIELD: &str = "file";

/// The strings of a program file that name mesh files: those after `file:` in the shapes of its values and scenes.
pub fn named(tree: &tree::Tree) -> Vec<&Text> {
    let mut found = Vec::new();
    for item in &tree.items {
        if let Item::Let(item) = item {
            in_expr(&item.value, &mut found);
        } else if let Item::Scene(item) = item {
            in_scene(&item.entries, &mut found);
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

/// Shapes occur alone, in lists and in the fields of other shapes.
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
        let key = self.named_file(expr, scope, errors::mesh_file_not_plain)?;
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

    /// The module and the path of a file that a string names; `not_plain` reports an expression that is not a string
    /// without braces.
    pub fn named_file(
        &mut self,
        expr: &Expr,
        scope: &Scope,
        not_plain: fn(Span) -> Diagnostic,
    ) -> Option<(usize, String)> {
        let path = match &expr.kind {
            ExprKind::Text(text) => text.plain(),
            ExprKind::Error => return None,
            _ => None,
        };
        if path.is_none() {
            self.sink.push(not_plain(expr.span));
        }
        path.map(|path| (scope.module, path))
    }
}
