//! Warnings for unused declarations.

use super::scope::{DeclarationPlace, DeclarationSort};
use super::{Checker, errors};

impl Checker<'_> {
    /// Warns of unused names of the program's own file; other files may be shared by several programs.
    ///
    /// After an error the warnings would mislead: an unreadable part may use the name, and so may the body of a loop
    /// that was never entered. A file that builds nothing is itself a file to be used.
    pub fn warn_of_unused(&mut self) {
        let module = &self.modules[0];
        let builds = self.declares(DeclarationSort::Task) || self.declares(DeclarationSort::Program);
        if self.sink.errors() > 0 || self.has_idle_loop || !builds {
            return;
        }
        for (name, declaration) in &module.names {
            match declaration.sort {
                DeclarationSort::Let
                | DeclarationSort::Device
                | DeclarationSort::Instrument
                | DeclarationSort::Output
                | DeclarationSort::Scene => {}
                DeclarationSort::Task | DeclarationSort::Program => continue,
            }
            if !self.used.contains(&DeclarationPlace { module: 0, item: declaration.item }) {
                self.sink.push(errors::unused(declaration.span, declaration.sort, name));
            }
        }
        for (alias, import) in &module.imports {
            if !self.used_imports.contains(&(0, alias.clone())) {
                self.sink.push(errors::unused_file(import.span, alias));
            }
        }
    }
}
