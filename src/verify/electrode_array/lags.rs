//! Maximum delays between operations.

use super::JudgedBoard;
use super::assay::JudgedAssay;
use crate::claims::electrode_array::AssayOperation;
use crate::verify::rule::{Findings, Rule, ms};

impl JudgedBoard<'_, '_> {
    /// No operation begins too late after the operations that its `within` counts from.
    pub(super) fn lags(&self, nth: usize, assay: &JudgedAssay, operations: &[AssayOperation], findings: &mut Findings) {
        findings.count_checks(Rule::Lag, operations.iter().filter(|operation| operation.within.is_some()).count());
        let (step_ns, start_ns) = (self.order.facts.step_ns, self.run.step(nth).start_ns);
        for (operation, [ended, begins]) in assay.late(operations, step_ns) {
            let Some(within) = &operation.within else { continue };
            let name = &self.order.parts[operation.part].name;
            let (passed, most) = (ms((begins - ended) * step_ns), ms(within.most_ns));
            let title = format!("`{name}` begins {passed} after its predecessors end; at most {most} is allowed");
            let at_ns = start_ns + begins * step_ns;
            findings.push(self.run.violation(Rule::Lag, nth, at_ns, title).label(within.span, "this time"));
        }
    }
}
