//! Labels of findings about a device: on its fields, on cells of its tables, and where a named value was given.

use super::devices::CheckedDevice;
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Label of a finding: a place in a device, and the label's text.
#[derive(Debug, Clone)]
pub struct DeviceLabel {
    place: DevicePlace,
    text: String,
}

#[derive(Debug, Clone)]
enum DevicePlace {
    Field(&'static str),
    Cell(Span),
}

impl DeviceLabel {
    /// On the value of a field, its own or inherited; no label where the device lacks it.
    pub fn field(name: &'static str, text: impl Into<String>) -> DeviceLabel {
        DeviceLabel { place: DevicePlace::Field(name), text: text.into() }
    }

    /// On a cell of a table, or the whole of one.
    pub fn cell(span: Span, text: impl Into<String>) -> DeviceLabel {
        DeviceLabel { place: DevicePlace::Cell(span), text: text.into() }
    }
}

impl CheckedDevice {
    /// Adds labels to a finding, those in the device's own file first; where there are none, one on the device's name.
    ///
    /// A field whose value came from a name has a second label where that value was given.
    pub fn labelled(&self, finding: Diagnostic, labels: impl IntoIterator<Item = DeviceLabel>) -> Diagnostic {
        let (own, inherited): (Vec<_>, Vec<_>) =
            labels.into_iter().flat_map(|label| self.placed(label)).partition(|(span, _)| span.file == self.span.file);
        let finding = if own.is_empty() { finding.label(self.span, "this device") } else { finding };
        own.into_iter().chain(inherited).fold(finding, |finding, (span, text)| finding.label(span, text))
    }

    fn placed(&self, DeviceLabel { place, text }: DeviceLabel) -> Vec<(Span, String)> {
        match place {
            DevicePlace::Cell(span) => vec![(span, text)],
            DevicePlace::Field(name) => {
                let Some(field) = self.fields.get(name) else { return Vec::new() };
                let origin = self.origins.get(name).filter(|origin| origin.span != field.span);
                let given = origin.map(|origin| (origin.span, origin.text.clone()));
                std::iter::once((field.span, text)).chain(given).collect()
            }
        }
    }
}
