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
    E0701 "a schedule names a channel, step or plan that it does not have"
    E0702 "a number in a schedule cannot be"
    E0703 "actuations are not in order of time"
    E0704 "a channel has two values at a time"
    E0705 "a channel is not one of the program's devices"
    E0706 "a wire is not the one that the program names"
    E0707 "an actuation lies outside of its step"
    E0708 "the plans are not those of the program's tasks"
    E0709 "the steps of a run are not those of its task"
    E0710 "a run or the schedule is not timed as the program says"
    E0711 "a device is in two runs at a time"
    E0712 "a wait is not as long as claimed, or not quiet"
    E0713 "a recorded figure is not what the replay gives"
    E0714 "a recorded state is not what the replay gives"
    E0715 "a required limit is not kept"
    E0716 "a run does not start where its device stands"
    E0717 "a stop of a step is not reached"
    E0718 "a cell is not the one for its place"
    E0721 "a pulse is not that of the device"
    E0722 "a rest after a pulse is too short"
    E0723 "time passes in a step of moves"
    E0724 "a pulse does nothing"
    E0725 "a module is set and reset at once"
    E0726 "several modules are switched at once"
    E0727 "a move touches an obstacle"
    E0728 "modules switched at once can touch an obstacle"
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
