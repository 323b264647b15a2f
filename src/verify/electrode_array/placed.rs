//! Places of operations that have alternatives: the record names the chosen one.

use super::{JudgedBoard, ReplayStop};
use crate::claims::electrode_array::AssayOperation;
use crate::verify::rule::{Findings, Rule};
use std::borrow::Cow;

impl JudgedBoard<'_, '_> {
    /// The operations of a step, each at its recorded place, which must be one that the program names.
    pub(super) fn placed<'o>(
        &self,
        nth: usize,
        operations: &'o [AssayOperation],
        findings: &mut Findings,
    ) -> Result<Cow<'o, [AssayOperation]>, ReplayStop> {
        let step = self.run.step(nth);
        let open = operations.iter().filter(|operation| !operation.among.is_empty()).count();
        let chosen = step.operations.iter().filter(|recorded| recorded.at.is_some()).count();
        findings.count_checks(Rule::Choice, open.max(chosen));
        let wrong = |title: String| self.run.violation(Rule::Choice, nth, step.start_ns, title);
        if open == 0 {
            return match step.operations.iter().find_map(|recorded| recorded.at) {
                Some([column, row]) => {
                    Err(wrong(format!("({column}, {row}) is recorded as chosen, but the program leaves no choice"))
                        .into())
                }
                None => Ok(Cow::Borrowed(operations)),
            };
        }
        if step.operations.len() != operations.len() {
            let (recorded, due) = (step.operations.len(), operations.len());
            return Err(
                wrong(format!("{recorded} operations are recorded with their places, but there are {due}")).into()
            );
        }
        let mut placed = Vec::with_capacity(operations.len());
        for (operation, recorded) in operations.iter().zip(&step.operations) {
            placed.push(match (recorded.at, operation.among.is_empty()) {
                (None, true) => operation.clone(),
                (Some(cell), false) if let Some(one) = operation.at_cell(cell) => one,
                (at, _) => {
                    let name = &self.order.parts[operation.part].name;
                    let title = match at {
                        Some([column, row]) => {
                            format!("`{name}` is at ({column}, {row}), which the program does not name")
                        }
                        None => format!("the record names no place for an operation of `{name}`"),
                    };
                    return Err(wrong(title).label(operation.span, "this operation").into());
                }
            });
        }
        Ok(Cow::Owned(placed))
    }
}
