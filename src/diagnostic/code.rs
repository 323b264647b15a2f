//! The ledger of codes: one row each, never used again for another thing.
//!
//! `E01xx` syntax, `02` names, `03` units and values, `04` devices, `05` scenes and tasks, `06` planning, `07` verification,
//! `08` files and formats; warnings `W…` share the numbers. Each row has its page in `explain/`.

use serde::{Serialize, Serializer};
use std::fmt;

/// How grave a diagnostic is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    Error,
    Warning,
}

macro_rules! ledger {
    ($($code:ident $summary:literal)*) => {
        /// The code of a diagnostic.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code { $(#[doc = $summary] $code,)* }

        impl Code {
            /// Every code, in the ledger's order.
            pub const ALL: &'static [Code] = &[$(Code::$code),*];

            /// The code as it is printed.
            pub fn name(self) -> &'static str {
                match self { $(Code::$code => stringify!($code),)* }
            }

            /// What it is about, in a few words.
            pub fn summary(self) -> &'static str {
                match self { $(Code::$code => $summary,)* }
            }

            /// The page that `tweeze explain` shows, as Markdown.
            pub fn page(self) -> &'static str {
                match self { $(Code::$code => include_str!(concat!("explain/", stringify!($code), ".md")),)* }
            }
        }
    };
}

ledger! {
    E0101 "something stands where an item, a step or a field should"
    E0102 "a value is missing"
    E0103 "two entries on one line"
    E0104 "a semicolon"
    E0105 "a `{` on a line of its own"
    E0106 "a line begins with an operator"
    E0107 "a line begins with a preposition"
    E0108 "a blank between a name and its bracket"
    E0109 "a doc comment that documents nothing"
    E0110 "a reserved word for a name, or no name"
    E0111 "a declaration begins with a word that is none of the language's"
    E0112 "a closing bracket that closes nothing"
    E0113 "a brace that is not closed"
    E0114 "a bracket that is not closed"
    E0115 "a string that does not end"
    E0116 "a number that is not well formed"
    E0117 "a table row with too few or too many cells"
    E0118 "a character that is not of the language"
    E0119 "a wrong sign between a name and its value"
    E0120 "brackets or blocks nested too deep"
    E0121 "too many operators in one expression"
    E0122 "a word of another language"
    E0123 "a declaration inside a block"
    E0124 "the head of a declaration is not complete"
    E0125 "a comment of another language"
    E0126 "no value in the braces of a string"
    E0127 "a place with too many coordinates"
    E0128 "a line of a table that is no row"
}

impl Code {
    /// The code of a printed name, in any case.
    pub fn find(name: &str) -> Option<Code> {
        Code::ALL.iter().copied().find(|code| code.name().eq_ignore_ascii_case(name))
    }

    /// An error stops the build, a warning does not: the first letter says which.
    pub fn severity(self) -> Severity {
        if self.name().starts_with('E') { Severity::Error } else { Severity::Warning }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
