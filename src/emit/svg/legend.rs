//! Legend of a picture, and its scale bars.

use super::drawing::{
    Anchor, Drawing, LINE_PT, PaperBox, PaperView, ShapeStyle, TEXT_PT, THIN_PT, TextStyle, color, decimal,
};
use super::{strobe, text_width};
use crate::real::Real;

/// Width of a mark in the legend, with the gap to its text.
const MARK_PT: f64 = 13.0;

/// Gap between two entries.
const APART_PT: f64 = 9.0;

/// The longest scale bar, as a share of the width of its panel.
const LONGEST: f64 = 0.3;

/// Height of a scale bar with its text.
const BAR_PT: f64 = 14.0;

/// Symbol of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendSymbol {
    Line,
    Disc,
    Box,
}

/// An entry of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    pub symbol: LegendSymbol,
    pub style: ShapeStyle,
    pub text: String,
}

/// Legend content of one panel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PanelLegend {
    pub entries: Vec<LegendEntry>,
    /// Lines right below the panel.
    pub under: Vec<String>,
    /// Lines below the whole picture, each once.
    pub notes: Vec<String>,
}

impl PanelLegend {
    pub fn add(&mut self, symbol: LegendSymbol, style: ShapeStyle, text: impl Into<String>) {
        self.entries.push(LegendEntry { symbol, style, text: text.into() });
    }
}

/// Draws the entries and notes of all panels from the top of a box; returns the height at which they end.
pub fn draw(legends: &[PanelLegend], more: &[String], inside: PaperBox, to: &mut Drawing) -> f64 {
    let mut entries: Vec<&LegendEntry> = Vec::new();
    for entry in legends.iter().flat_map(|legend| &legend.entries) {
        if !entries.contains(&entry) {
            entries.push(entry);
        }
    }
    let mut notes: Vec<&String> = Vec::new();
    for note in legends.iter().flat_map(|legend| &legend.notes).chain(more) {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    let mut top_pt = inside.top;
    let mut left = inside.left;
    to.open("legend", &[]);
    for entry in entries {
        let most_em = (inside.right - inside.left - MARK_PT) / TEXT_PT;
        let text = text_width::cut(&entry.text, most_em, false);
        let width_pt = MARK_PT + TextStyle::SMALL.width_pt(&text);
        if left > inside.left && left + width_pt > inside.right {
            left = inside.left;
            top_pt += LINE_PT + 1.0;
        }
        mark(entry, [left, top_pt], to);
        to.text([left + MARK_PT, top_pt + TEXT_PT - 1.0], &text, TextStyle::SMALL);
        left += width_pt + APART_PT;
    }
    if left > inside.left {
        top_pt += LINE_PT;
    }
    for line in notes.iter().flat_map(|note| text_width::wrapped(note, (inside.right - inside.left) / TEXT_PT, false)) {
        to.text([inside.left, top_pt + TEXT_PT - 1.0], &line, TextStyle::SMALL.colored(color::SOFT));
        top_pt += LINE_PT;
    }
    to.close();
    top_pt
}

fn mark(entry: &LegendEntry, [left, top]: [f64; 2], to: &mut Drawing) {
    let middle = [left + 5.0, top + 3.5];
    match entry.symbol {
        LegendSymbol::Line => to.line(&[[left, middle[1]], [left + 10.0, middle[1]]], entry.style, &[]),
        LegendSymbol::Disc => to.disc(middle, 2.6, entry.style, &[]),
        LegendSymbol::Box => {
            let room = PaperBox { left: left + 1.0, right: left + 9.0, top: top + 0.8, bottom: top + 6.2 };
            to.rect(room, entry.style, &[]);
        }
    }
}

/// Draws the scale bar of a panel below its scene; returns the height at which it ends.
pub fn scale_bar(view: &PaperView, unit_um: f64, room: PaperBox, to: &mut Drawing) -> f64 {
    let pt_per_um = view.scale / unit_um;
    let longest_um = LONGEST * (room.right - room.left) / pt_per_um;
    let length_um = round_length(longest_um);
    let (y, end) = (room.bottom + 8.0, room.left + length_um * pt_per_um);
    let data = [("length-um", decimal(length_um, 9))];
    to.open("scale", &data);
    let ends = [[room.left, y - 2.0], [room.left, y], [end, y], [end, y - 2.0]];
    to.line(&ends, ShapeStyle::line(color::INK, THIN_PT), &[]);
    to.text([end + 4.0, y], &strobe::length(length_um), TextStyle::SMALL.anchored(Anchor::Start));
    to.close();
    room.bottom + BAR_PT
}

/// The greatest of 1, 2 and 5 times a power of ten that is at most a length.
fn round_length(most_um: f64) -> f64 {
    const ROUNDING: f64 = 1e-9;
    let power_um = 10f64.whole_power(most_um.common_logarithm().floor() as i32);
    let lengths = [5.0, 2.0, 1.0].map(|factor| factor * power_um);
    lengths.into_iter().find(|length_um| *length_um <= most_um * (1.0 + ROUNDING)).unwrap_or(power_um)
}
