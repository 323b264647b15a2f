//! What people read of an electrode array.

use super::{ReportedDevice, ReportedOrder, length};
use crate::claims::Claims;
use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::ElectrodeArrayFacts;

impl ReportedOrder for ElectrodeArrayOrder {}

impl ReportedDevice for ElectrodeArrayFacts {
    fn describe(&self, name: &str, _claims: &[Claims]) -> String {
        let (columns, rows, pitch) = (self.columns, self.rows, length(self.pitch_um()));
        format!("{name}: electrode_array, {columns} x {rows} electrodes {pitch} apart\n")
    }
}
