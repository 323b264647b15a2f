//! Fields and arguments: each value is checked against the sort in its table.

use super::Checker;
use super::errors::{self, WantedName};
use super::scope::{STEP_WORDS, Scope, nearest, path_text};
use super::sorts::judge;
use super::value::{Accepted, ListValue, ObjectName, ShapeValue, Value};
use crate::device::instrument::Family;
use crate::device::shape::ShapeForm;
use crate::device::{self, Need, Sort};
use crate::diagnostic::Diagnostic;
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Expr, ExprKind};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Owner of the fields being read, for messages.
#[derive(Debug, Clone)]
pub struct Owner {
    /// "device `bot`".
    pub name: String,
    /// Its declaration, for a label.
    pub declared: Option<(Span, String)>,
}

impl Owner {
    fn wanted(&self, field: &device::VocabularyField) -> WantedName {
        WantedName {
            name: format!("`{}` of {}", field.name, self.name),
            doc: field.doc.to_owned(),
            declared: self.declared.clone(),
        }
    }
}

/// A field with the scope in which it was written.
pub struct Given<'a> {
    pub field: &'a tree::Field,
    pub scope: Scope,
}

/// A `width` and the `height` after it, given where the table has only a `size`.
fn extents<'a>(given: &'a [Given], table: &[device::VocabularyField]) -> Option<[&'a tree::Field; 2]> {
    let has = |name: &str| table.iter().any(|entry| entry.name == name);
    let is_sized = has("size") && !has("width") && given.iter().all(|one| one.field.name.text != "size");
    let mut pairs = given.windows(2).filter(|_| is_sized).map(|pair| [pair[0].field, pair[1].field]);
    pairs.find(|[one, other]| {
        one.name.text == "width" && other.name.text == "height" && one.span.file == other.span.file
    })
}

impl Checker<'_> {
    /// Reads fields against their table; unknown, repeated and unfit ones are reported. Missing ones are left to the
    /// caller.
    pub fn read_fields(
        &mut self,
        owner: &Owner,
        given: &[Given],
        table: &'static [device::VocabularyField],
    ) -> Accepted {
        let mut accepted = Accepted::new(table);
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        let extents = extents(given, table);
        if let Some([width, height]) = extents {
            self.sink.push(errors::extents(width, height, &owner.name));
            accepted.insert("size", Spanned::new(Value::Unknown, width.span));
        }
        for Given { field, scope } in given {
            if extents.is_some_and(|pair| pair.iter().any(|one| one.span == field.span)) {
                continue;
            }
            if let Some(earlier) = seen.insert(&field.name.text, field.name.span) {
                self.sink.push(errors::field_twice(&field.name, earlier));
                continue;
            }
            let known = table.iter().find(|entry| entry.name == field.name.text);
            let Some(entry) = known.or_else(|| self.misspelt(field, owner, given, table)) else { continue };
            let value = self.accept(entry.sort, &field.value, scope, &owner.wanted(entry));
            accepted.insert(entry.name, Spanned::new(value.unwrap_or(Value::Unknown), field.value.span));
        }
        accepted
    }

    /// Reports an unknown field. Returns the nearest known field unless that is given as well; the value is then read
    /// as that field's, so that the misspelling is the only error.
    fn misspelt(
        &mut self,
        field: &tree::Field,
        owner: &Owner,
        given: &[Given],
        table: &'static [device::VocabularyField],
    ) -> Option<&'static device::VocabularyField> {
        let word = field.name.text.as_str();
        // `start` is also a field of some instruments.
        let names = || table.iter().map(|entry| entry.name);
        let is_of_instruments =
            Family::ALL.iter().any(|family| family.fields().iter().map(|entry| entry.name).eq(names()));
        let is_setting = STEP_WORDS.contains(&word) || device::condition_of_any_kind(word).is_some();
        if is_setting && !is_of_instruments {
            self.sink.push(errors::setting_with_colon(&field.name));
            return None;
        }
        let known: Vec<&str> = names().collect();
        let near = nearest(&field.name.text, known.iter().copied());
        self.sink.push(errors::unknown_field(&field.name, &owner.name, near, &known));
        let is_free = |name: &str| !given.iter().any(|other| other.field.name.text == name);
        table.iter().find(|entry| Some(entry.name) == near && is_free(entry.name))
    }

    /// The required fields of a table that were not given.
    pub fn missing(
        accepted: &Accepted,
        table: &'static [device::VocabularyField],
    ) -> Vec<&'static device::VocabularyField> {
        let required = table.iter().filter(|field| field.need == Need::Required);
        required.filter(|field| !accepted.contains_key(field.name)).collect()
    }

    /// The value of an expression, if it is of a sort; `None` after an error, which has then been pushed.
    pub fn accept(&mut self, sort: Sort, expr: &Expr, scope: &Scope, wanted: &WantedName) -> Option<Value> {
        if let Sort::Word(choices) = sort {
            return self.accept_word(choices, expr, wanted);
        }
        if let Sort::CountOrWord { words, .. } = sort
            && let Some(word) = self.chosen(words, expr, scope)
        {
            return Some(word);
        }
        if let Some(wrong) = self.unknown_word(sort, expr, scope, wanted) {
            self.sink.push(wrong);
            return None;
        }
        if let Sort::CountRows { most } = sort {
            return self.accept_rows(most, expr, scope, wanted);
        }
        if let Sort::CountTables { most } = sort {
            return self.accept_count_tables(most, expr, scope, wanted);
        }
        if let Sort::Curve = sort {
            return self.accept_curve(expr, scope, wanted);
        }
        if let Sort::Text = sort {
            return self.accept_mesh(expr, scope);
        }
        if let Sort::Board(limits) = sort {
            return self.accept_board(limits, expr, scope);
        }
        if let Sort::Object(noun) = sort {
            return self.accept_object(noun, expr, scope, wanted);
        }
        if let Sort::Site(noun) = sort
            && let ExprKind::Path(path) = &expr.kind
            && path.segments.len() == 1
            && !self.names_value(path, scope)
        {
            return self.accept_object(noun, expr, scope, wanted);
        }
        if let Sort::Sites(noun) = sort
            && let Some(sites) = self.accept_sites(noun, expr, scope, wanted)
        {
            return sites;
        }
        let value = self.evaluate(expr, scope);
        if value.is_unknown() || !self.spend(value.elements() as u64, expr.span) {
            return None;
        }
        let value = if is_of_scene(sort) { self.in_scene(value, expr.span, scope) } else { value };
        if value.is_unknown() {
            return None;
        }
        let wanted = &self.with_origin(wanted, expr, scope);
        match judge(sort, &value, expr.span, wanted) {
            Ok(()) => Some(value),
            Err(diagnostic) => {
                self.sink.push(match sort {
                    Sort::Quantity { dimension, .. } => {
                        errors::unit_mended(*diagnostic, wanted, dimension, expr, &value)
                    }
                    _ => *diagnostic,
                });
                None
            }
        }
    }

    fn accept_word(
        &mut self,
        choices: &'static [device::WordChoice],
        expr: &Expr,
        wanted: &WantedName,
    ) -> Option<Value> {
        let text = match &expr.kind {
            ExprKind::Path(path) if path.segments.iter().all(|segment| segment.indices.is_empty()) => path_text(path),
            ExprKind::Error => return None,
            _ => truth_word(expr).unwrap_or_default(),
        };
        let found = choices.iter().find(|choice| choice.name == text);
        if found.is_none() {
            let near = nearest(&text, choices.iter().map(|choice| choice.name));
            self.sink.push(errors::wrong_word(wanted, choices, expr.span, &text, near));
        }
        found.map(|choice| Value::Text(choice.name.to_owned()))
    }

    /// The word of a bare name, unless that names a value.
    fn chosen(&self, words: &'static [device::WordChoice], expr: &Expr, scope: &Scope) -> Option<Value> {
        let ExprKind::Path(path) = &expr.kind else { return None };
        let text = path_text(path);
        let choice = words.iter().find(|choice| choice.name == text)?;
        (!self.names_value(path, scope)).then(|| Value::Text(choice.name.to_owned()))
    }

    /// Diagnostic for a bare name that is no value, where words or truth values are expected.
    fn unknown_word(&self, sort: Sort, expr: &Expr, scope: &Scope, wanted: &WantedName) -> Option<Diagnostic> {
        let ExprKind::Path(path) = &expr.kind else { return None };
        let text = path_text(path);
        if text.contains('.') || self.names_value(path, scope) {
            return None;
        }
        if matches!(sort, Sort::Flag) {
            return Some(errors::no_truth_value(wanted, expr.span, &text));
        }
        let Sort::CountOrWord { words, .. } = sort else { return None };
        let names: Vec<&str> = words.iter().map(|word| word.name).collect();
        let near = nearest(&text, names.iter().copied());
        Some(errors::neither_count_nor_word(wanted, &names, expr.span, &text, near))
    }

    /// A list of cells and of names of objects in the task's scene, as written; `None` for an expression that must be
    /// evaluated first.
    fn accept_sites(
        &mut self,
        noun: &'static str,
        expr: &Expr,
        scope: &Scope,
        wanted: &WantedName,
    ) -> Option<Option<Value>> {
        match &expr.kind {
            ExprKind::List(elements) => {
                let one = |element: &Expr| {
                    let value = self.accept(Sort::Site(noun), element, scope, wanted)?;
                    Some(Spanned { value, span: element.span })
                };
                let elements: Vec<Option<Spanned<Value>>> = elements.iter().map(one).collect();
                let elements: Option<Vec<Spanned<Value>>> = elements.into_iter().collect();
                Some(elements.map(|elements| Value::List(Rc::new(ListValue::new(elements)))))
            }
            // A single name where a list is expected.
            ExprKind::Path(path) if path.segments.len() == 1 && !self.names_value(path, scope) => {
                if let Some(value) = self.accept_object(noun, expr, scope, wanted)
                    && let Err(wrong) = judge(Sort::Sites(noun), &value, expr.span, wanted)
                {
                    self.sink.push(*wrong);
                }
                Some(None)
            }
            _ => None,
        }
    }

    /// The name of something in the task's scene: `m1`, `m[i]`, or a parameter that stands for one.
    pub fn accept_object(
        &mut self,
        noun: &'static str,
        expr: &Expr,
        scope: &Scope,
        wanted: &WantedName,
    ) -> Option<Value> {
        if let ExprKind::Path(path) = &expr.kind
            && let [segment] = path.segments.as_slice()
            && !self.names_value(path, scope)
        {
            let name = self.joined(&segment.name.text, &segment.indices, scope)?;
            return Some(Value::Object(ObjectName { noun, name, word: segment.name.span }));
        }
        if matches!(expr.kind, ExprKind::List(_)) {
            self.sink.push(errors::several_objects(wanted, noun, expr.span));
            return None;
        }
        match self.evaluate(expr, scope) {
            Value::Object(object) if object.noun == noun => Some(Value::Object(object)),
            Value::Unknown => None,
            found => {
                let example = if noun == "robot" { "D1" } else { "m1" };
                self.sink.push(errors::wrong_value(
                    wanted,
                    &format!("the name of a {noun}"),
                    example,
                    expr.span,
                    &found,
                ));
                None
            }
        }
    }

    /// A name with its indices: `m[3]` is `m3`, `e[5, 2]` is `e5_2`.
    pub fn joined(&mut self, name: &str, indices: &[Expr], scope: &Scope) -> Option<String> {
        let mut texts = Vec::with_capacity(indices.len());
        for index in indices {
            texts.push(self.index(index, scope)?.to_string());
        }
        Some(format!("{name}{}", texts.join("_")))
    }

    /// The wanted name, labelled with the origin of a named value, which is more useful than the owner's declaration.
    fn with_origin(&mut self, wanted: &WantedName, expr: &Expr, scope: &Scope) -> WantedName {
        match self.origin(expr, scope) {
            Some(origin) => WantedName { declared: Some((origin.span, origin.text)), ..wanted.clone() },
            None => wanted.clone(),
        }
    }

    /// A shape with some fields changed.
    pub fn shape_with(&mut self, shape: ShapeValue, span: Span, fields: &[tree::Field], scope: &Scope) -> Value {
        let mut shape = shape;
        let owner = Owner { name: shape.form.with_article(), declared: None };
        let given: Vec<Given> = fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        let errors_before = self.sink.errors();
        shape.fields.extend(self.read_fields(&owner, &given, shape.form.fields()));
        if shape.form.is_spatial() && !self.charge_iterations(SOLID_TURNS, span) {
            return Value::Unknown;
        }
        let missing = Self::missing(&shape.fields, shape.form.fields());
        // A misnamed field, already reported, is most likely the one that seems missing.
        if !missing.is_empty() && self.sink.errors() > errors_before {
            return Value::Unknown;
        }
        if !missing.is_empty() {
            return self.unknown(errors::missing_fields(span, &owner.name, &missing, None));
        }
        if shape.fields.values().any(|field| field.value.is_unknown()) {
            return Value::Unknown;
        }
        let corners = shape.fields.values().map(|field| field.value.elements()).max().unwrap_or(0) as u64;
        if shape.form == ShapeForm::Polygon && !self.spend(corners * corners / SIDES_AT_ONCE, span) {
            return Value::Unknown;
        }
        match super::shapes::impossible(&shape, span) {
            // An outline that is too rough takes long to reject.
            Some(_) if shape.form.is_spatial() && !self.charge_iterations(REFUSED_TURNS, span) => Value::Unknown,
            Some(diagnostic) => self.unknown(diagnostic),
            None => Value::Shape(shape),
        }
    }
}

/// Iterations of a loop charged for a shape in space: checking it takes as long.
const SOLID_TURNS: usize = 2_000;

/// Further iterations charged for a shape in space that is rejected.
const REFUSED_TURNS: usize = 10_000;

/// Pairs of sides of a polygon that are compared in the time of one subexpression.
const SIDES_AT_ONCE: u64 = 16;

/// Whether values of a sort are places and poses of a scene, which may be given in pixels of its image.
fn is_of_scene(sort: Sort) -> bool {
    matches!(sort, Sort::State | Sort::Target | Sort::Targets | Sort::Pose | Sort::Places)
}

/// The word `true` or `false`, if the expression is one.
fn truth_word(expr: &Expr) -> Option<String> {
    match &expr.kind {
        ExprKind::Bool(truth) => Some(truth.to_string()),
        _ => None,
    }
}
