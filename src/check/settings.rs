//! `--set name=value`: a top-level value replaced from the command line.

use super::scope::{DeclarationPlace, DeclarationSort, Scope, nearest};
use super::value::Value;
use super::{Checker, errors};
use crate::diagnostic::Sink;
use crate::source::Sources;
use crate::syntax::{self, tree};
use std::collections::BTreeMap;
use std::rc::Rc;

/// A replacement as it was given.
pub struct Setting {
    name: String,
    value: tree::Expr,
}

/// Reads the settings; each becomes a small source of its own, so that messages can point into it.
pub fn parse(sources: &mut Sources, settings: &[String], sink: &mut Sink) -> Vec<Setting> {
    settings.iter().filter_map(|setting| parse_one(sources, setting, sink)).collect()
}

fn parse_one(sources: &mut Sources, setting: &str, sink: &mut Sink) -> Option<Setting> {
    let Some((name, value)) = setting.split_once('=') else {
        sink.push(errors::bad_setting(None, setting, "has no `=`", "write `--set pitch=80um`"));
        return None;
    };
    let name = name.trim();
    let file = sources.add_setting(name, value.trim());
    let value = syntax::parse_value(file, value.trim(), sink)?;
    Some(Setting { name: name.to_owned(), value })
}

impl Checker<'_> {
    /// Replaces the named values; each must be of the dimension that its declaration has.
    pub fn apply_settings(&mut self, settings: Vec<Setting>) {
        let mut declared: BTreeMap<DeclarationPlace, (Setting, Value)> = BTreeMap::new();
        for setting in settings {
            let Some(place) = self.setting_place(&setting.name) else { continue };
            let span = self.declaration(place).span;
            let own = self.value_of_let(place, span);
            if let Some((setting, _)) = declared.insert(place, (setting, own)) {
                self.sink.push(errors::bad_setting(Some(span), &setting.name, "is given twice", "give it once"));
            }
        }
        // Values evaluated so far may depend on a replaced value, and replacements on each other.
        self.lets.clear();
        let (exprs, declared): (BTreeMap<_, _>, Vec<_>) = declared
            .into_iter()
            .map(|(place, (setting, own))| ((place, Rc::new(setting.value)), (place, setting.name, own)))
            .unzip();
        self.replaced = exprs;
        for (place, name, own) in declared {
            if self.fits_declared(place, &name, &own).is_none() {
                // The fault is already reported; the declaration's own value is used.
                self.replaced.remove(&place);
                self.lets.clear();
            }
        }
    }

    fn setting_place(&mut self, name: &str) -> Option<DeclarationPlace> {
        let own = &self.modules[0];
        let (module, word) = match name.split_once('.') {
            Some((alias, word)) => (own.imports.get(alias).and_then(|import| import.module), word),
            None => (Some(0), name),
        };
        let declared = module.and_then(|module| Some((module, self.modules[module].names.get(word)?)));
        if let Some((module, declaration)) = declared.filter(|(_, d)| d.sort == DeclarationSort::Let) {
            return Some(DeclarationPlace { module, item: declaration.item });
        }
        let known = self.names_in_reach(&Scope::top(0), DeclarationSort::Let);
        let help = match nearest(name, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => "the file declares no value with `let`".to_owned(),
            None => format!("the values that can be set are {}", known.join(", ")),
        };
        self.sink.push(errors::bad_setting(None, name, "names no `let` at the top of a file", &help));
        None
    }

    /// Checks that a replacement is of the sort and dimension of the declaration's own value; `None` after an error.
    fn fits_declared(&mut self, place: DeclarationPlace, name: &str, declared: &Value) -> Option<()> {
        let span = self.declaration(place).span;
        let value = self.value_of_let(place, span);
        if value.is_unknown() || declared.is_unknown() || value.describe() == declared.describe() {
            return Some(());
        }
        let why = format!("is {}, but the value is declared as {}", value.describe_fully(), declared.describe_fully());
        let help = match declared {
            Value::Quantity(quantity) => {
                let unit = quantity.dimension.example_unit();
                format!("write {}, as `--set {name}=1{unit}`", declared.describe())
            }
            _ => format!("write {}", declared.describe()),
        };
        self.sink.push(errors::bad_setting(Some(span), name, &why, &help));
        None
    }
}
