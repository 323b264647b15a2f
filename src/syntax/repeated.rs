//! Merges repeated findings: a habit such as `;` at every line end is one finding with all its places.

use crate::diagnostic::{Code, Diagnostic, Label};
use std::collections::BTreeMap;

/// Greatest number of places that a merged finding points to.
const MAX_PLACES: usize = 4;

/// Merges findings about the same foreign sign into the first of them. The findings are in the order of their places.
pub(super) fn joined(findings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut kept: Vec<Diagnostic> = Vec::with_capacity(findings.len());
    // For each habit, the index of its finding in `kept` and the number of repetitions since.
    let mut habits: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for finding in findings {
        if !is_habit(&finding) {
            kept.push(finding);
            continue;
        }
        let (nth, again) = habits.entry(finding.title.clone()).or_insert((kept.len(), 0));
        match kept.get_mut(*nth) {
            Some(first) => {
                *again += 1;
                if *again < MAX_PLACES {
                    let places = finding.labels.into_iter().take(1);
                    first.labels.extend(places.map(|label| Label { text: "here too".to_owned(), ..label }));
                }
                first.fix.extend(finding.fix);
            }
            None => kept.push(finding),
        }
    }
    for (nth, again) in habits.into_values().filter(|(_, again)| *again > 0) {
        if let Some(first) = kept.get_mut(nth) {
            let help = first.help.take().unwrap_or_default();
            let places = if again == 1 { "place" } else { "places" };
            first.help = Some(format!("{help}; the same at {again} more {places}"));
        }
    }
    kept
}

/// Whether a finding is about a foreign sign that people repeat and whose fix is known.
fn is_habit(finding: &Diagnostic) -> bool {
    matches!(finding.code, Code::E0104 | Code::E0119) && finding.labels.len() == 1 && !finding.fix.is_empty()
}
