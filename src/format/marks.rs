//! Information from the tree about characters with several meanings.

use crate::syntax::tree::{
    Entry, Expr, ExprKind, Field, For, IndexedName, Item, Path, SceneEntry, Step, Table, Text, TextPart, Tree, UsePath,
    WireOutput, WiringEntry,
};

/// Positions in the text, sorted.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// The units, as byte ranges.
    pub units: Vec<(u32, u32)>,
    /// The binary operators.
    pub operators: Vec<u32>,
    /// Brackets that belong to the name before them.
    pub joints: Vec<u32>,
    /// Indices of the declarations that contain an error node.
    pub broken_items: Vec<usize>,
    is_broken: bool,
}

impl Marks {
    /// Collects the marks of a tree.
    pub fn of(tree: &Tree) -> Marks {
        let mut marks = Marks::default();
        for (index, item) in tree.items.iter().enumerate() {
            marks.is_broken = false;
            marks.item(item);
            if marks.is_broken {
                marks.broken_items.push(index);
            }
        }
        marks.units.sort_unstable();
        marks.operators.sort_unstable();
        marks.joints.sort_unstable();
        marks
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::Use(used) => match &used.path {
                UsePath::Library { .. } => {}
                UsePath::File(text) => self.text(text),
            },
            Item::Let(item) => self.expr(&item.value),
            Item::Device(device) | Item::Instrument(device) | Item::Output(device) => {
                self.path(&device.base);
                self.fields(&device.fields);
            }
            Item::Scene(scene) => {
                scene.base.iter().for_each(|base| self.path(base));
                self.scene_entries(&scene.entries);
            }
            Item::Task(task) => {
                self.joints.push(task.name.span.end);
                self.path(&task.device);
                task.scene.iter().for_each(|scene| self.path(scene));
                self.entries(&task.entries);
            }
            Item::Program(program) => {
                self.joints.push(program.name.span.end);
                self.entries(&program.entries);
            }
            Item::Wiring(wiring) => {
                self.path(&wiring.device);
                self.wires(&wiring.entries);
            }
            Item::Error(_) => self.is_broken = true,
        }
    }

    fn fields(&mut self, fields: &[Field]) {
        fields.iter().for_each(|field| self.expr(&field.value));
    }

    fn scene_entries(&mut self, entries: &[SceneEntry]) {
        for entry in entries {
            match entry {
                SceneEntry::Object(object) => {
                    self.indexed(&object.name);
                    object.shape.iter().chain(&object.at).for_each(|value| self.expr(value));
                }
                SceneEntry::For(each) => self.each(each, Self::scene_entries),
                SceneEntry::Error(_) => self.is_broken = true,
            }
        }
    }

    fn each<E>(&mut self, each: &For<E>, entries: impl Fn(&mut Self, &[E])) {
        self.expr(&each.over);
        entries(self, &each.entries);
    }

    fn entries(&mut self, entries: &[Entry]) {
        for entry in entries {
            match entry {
                Entry::Field(field) => self.expr(&field.value),
                Entry::Step(step) => self.step(step),
                Entry::For(each) => self.each(each, Self::entries),
                Entry::Error(_) => self.is_broken = true,
            }
        }
    }

    fn step(&mut self, step: &Step) {
        if !step.indices.is_empty() {
            self.joints.push(step.head.span.end);
            self.exprs(&step.indices);
        }
        step.object.iter().for_each(|object| self.expr(object));
        step.phrases.iter().for_each(|phrase| self.expr(&phrase.value));
        step.block.iter().for_each(|block| self.entries(block));
    }

    fn wires(&mut self, entries: &[WiringEntry]) {
        for entry in entries {
            match entry {
                WiringEntry::Wire(wire) => {
                    self.path(&wire.channel);
                    match &wire.output {
                        WireOutput::Named(text) => self.text(text),
                        WireOutput::Instrument(path) => self.path(path),
                    }
                    self.fields(&wire.fields);
                }
                WiringEntry::Field(field) => self.expr(&field.value),
                WiringEntry::For(each) => self.each(each, Self::wires),
                WiringEntry::Error(_) => self.is_broken = true,
            }
        }
    }

    fn path(&mut self, path: &Path) {
        path.segments.iter().for_each(|segment| self.indexed(segment));
    }

    fn indexed(&mut self, name: &IndexedName) {
        if !name.indices.is_empty() {
            self.joints.push(name.name.span.end);
            self.exprs(&name.indices);
        }
    }

    /// A string stays as it is; the expressions in its braces may be broken.
    fn text(&mut self, text: &Text) {
        for part in &text.parts {
            match part {
                TextPart::Plain(_) => {}
                TextPart::Hole(value) => self.expr(value),
            }
        }
    }

    fn exprs(&mut self, values: &[Expr]) {
        values.iter().for_each(|value| self.expr(value));
    }

    fn expr(&mut self, value: &Expr) {
        match &value.kind {
            ExprKind::Number(_) | ExprKind::Word(_) | ExprKind::Bool(_) => {}
            ExprKind::Quantity { unit, .. } => self.units.push((unit.span.start, unit.span.end)),
            ExprKind::Text(text) => self.text(text),
            ExprKind::Path(path) => self.path(path),
            ExprKind::Tuple(values) | ExprKind::List(values) => self.exprs(values),
            ExprKind::Range { from, to } => {
                self.expr(from);
                self.expr(to);
            }
            ExprKind::Negative(value) => self.expr(value),
            ExprKind::Binary { left, operator_span, right, .. } => {
                self.expr(left);
                self.operators.push(operator_span.start);
                self.expr(right);
            }
            ExprKind::Call { function, arguments } => {
                self.path(function);
                self.joints.push(function.span.end);
                self.exprs(arguments);
            }
            ExprKind::With { base, fields } => {
                self.path(base);
                self.fields(fields);
            }
            ExprKind::Table(table) => self.table(table),
            ExprKind::Error => self.is_broken = true,
        }
    }

    fn table(&mut self, table: &Table) {
        let units = table.columns.iter().filter_map(|column| column.unit.as_ref());
        self.units.extend(units.map(|unit| (unit.span.start, unit.span.end)));
        table.rows.iter().for_each(|row| self.exprs(&row.cells));
    }
}
