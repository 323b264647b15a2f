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
    E0820 "a value of the schedule is not a finite number"
    E0821 "a format that only holds values meets one that changes steadily"
    E0822 "a file would be larger than its readers take"
    E0823 "a schedule has more sample points than the instrument takes"
    E0824 "a schedule has more channels than the instrument has outputs"
    E0825 "a file could not be composed"
    E0840 "a file is no MCAP log"
    E0841 "a log breaks off"
    E0842 "a log is damaged"
    E0843 "a part of a log is larger than is read"
    E0844 "a log lacks a part that every log of Tweeze has"
    E0845 "a part of a log cannot be read"
    E0846 "the voltages in a log are not those of its schedule"
    E0847 "a log shows something else than its schedule"
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
