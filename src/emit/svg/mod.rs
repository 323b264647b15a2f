//! SVG: a static picture of a schedule for papers and readmes.
//!
//! Each device has one panel or several: its scene to scale with numbered positions at chosen instants (strobes), or at
//! one instant. Above the panels stand the cost of each plan and what is proven of it; below them are the scale bars,
//! the instants and the legend. There are no scripts, style sheets or other files. The width is 85 mm, as a column of a
//! paper, or 175 mm for several panels.

pub(super) mod drawing;
pub(super) mod legend;
pub(super) mod scenery;
pub(super) mod strobe;
#[cfg(test)]
mod tests;
pub(super) mod text_width;

use super::error::MAX_TEXT_BYTES;
use super::{EmitError, Format, Signals};
use crate::claims::Order;
use crate::device::each_kind;
use crate::quantity::count;
use crate::schedule::cost::cost;
use crate::verify::Verified;
use drawing::{
    Anchor, Drawing, LINE_PT, PT_PER_MM, PaperBox, PaperView, TEXT_PT, TITLE_PT, TextStyle, color, escaped, number,
};
use legend::PanelLegend;

/// Width of a picture: one column of a paper, or both.
const COLUMN_MM: f64 = 85.0;
const PAGE_MM: f64 = 175.0;

/// Margin of a picture, and gaps between panels.
const MARGIN_PT: f64 = 4.0;
const GAP_PT: f64 = 12.0;

/// Greatest and least height of a scene, as shares of its width.
const TALLEST: f64 = 1.2;
const FLATTEST: f64 = 0.2;

/// Width of a row of panels in a two-column picture, in columns.
const ROW_SHARES: f64 = 2.0;

/// Greatest number of plans whose costs are shown.
const MAX_COSTS: usize = 6;

/// Greatest number of panels.
const MAX_PANELS: usize = 12;

/// The subject of a picture of a device.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub verified: &'a Verified,
    pub signals: &'a Signals<'a>,
    pub device: &'a str,
    /// The instant to draw; `None` for strobes.
    pub moment_ns: Option<u64>,
}

/// A part of a picture with its own scale.
pub(super) trait Panel {
    fn title(&self) -> String;

    /// Lower and upper corner of the visible area, in the panel's unit.
    fn extent(&self) -> [[f64; 2]; 2];

    /// Length of its unit, in micrometres.
    fn unit_um(&self) -> f64 {
        1.0
    }

    /// Its width, in columns.
    fn share(&self) -> f64 {
        1.0
    }

    /// Draws the scene; returns its legend.
    fn draw(&self, view: &PaperView, to: &mut Drawing) -> PanelLegend;

    /// Draws below the scene, from a height on, within the width of a box; returns the height at which that ends.
    fn draw_foot(&self, _room: PaperBox, top_pt: f64, _to: &mut Drawing) -> f64 {
        top_pt
    }
}

/// Pictures of a device kind, implemented by its orders.
pub(super) trait Pictured {
    /// The panels of a device whose first order this is; empty if another device's panel shows it.
    fn panels<'a>(&'a self, subject: Subject<'a>) -> Vec<Box<dyn Panel + 'a>>;
}

fn pictured(order: &Order) -> &dyn Pictured {
    each_kind!(Order, order, order => order)
}

/// The bytes of the picture, with strobes or at one instant within the schedule.
///
/// # Errors
/// [`EmitError::OutsideSchedule`] for an instant after the end; [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(verified: &Verified, moment_ns: Option<u64>) -> Result<Vec<u8>, EmitError> {
    let schedule = verified.schedule();
    if let Some(t_ns) = moment_ns.filter(|t_ns| *t_ns > schedule.duration_ns) {
        let (name, duration_ns) = (schedule.name.clone(), schedule.duration_ns);
        return Err(EmitError::OutsideSchedule { name, t_ns, duration_ns });
    }
    let signals = Signals::new(schedule);
    let mut devices: Vec<&str> = Vec::new();
    let mut panels = Vec::new();
    for job in &verified.claims().jobs {
        if !devices.contains(&job.device.as_str()) {
            devices.push(&job.device);
            panels.extend(pictured(&job.order).panels(Subject {
                verified,
                signals: &signals,
                device: &job.device,
                moment_ns,
            }));
        }
    }
    let picture = composed(verified, moment_ns, &panels);
    EmitError::refuse_size(Format::Svg, picture.len() as u64, MAX_TEXT_BYTES)?;
    Ok(picture.into_bytes())
}

fn composed(verified: &Verified, moment_ns: Option<u64>, panels: &[Box<dyn Panel + '_>]) -> String {
    let shown = &panels[..panels.len().min(MAX_PANELS)];
    let shares: f64 = shown.iter().map(|panel| panel.share()).sum();
    let (width_mm, row) = if shares <= 1.0 { (COLUMN_MM, 1.0) } else { (PAGE_MM, ROW_SHARES) };
    let width_pt = width_mm * PT_PER_MM;
    let inside = PaperBox { left: MARGIN_PT, top: MARGIN_PT, right: width_pt - MARGIN_PT, bottom: f64::INFINITY };
    let mut to = Drawing::default();
    let mut top_pt = heading(verified, moment_ns, inside, &mut to);
    let mut legends = Vec::new();
    for row_of in rows(shown, row) {
        let mut bottom_pt = top_pt;
        let mut left = inside.left;
        let width = (inside.right - inside.left + GAP_PT) / row;
        for panel in row_of {
            let right = left + width * panel.share() - GAP_PT;
            let (legend, end_pt) = draw_panel(panel, PaperBox { left, right, top: top_pt, ..inside }, &mut to);
            legends.push(legend);
            bottom_pt = bottom_pt.max(end_pt);
            left = right + GAP_PT;
        }
        top_pt = bottom_pt;
    }
    let mut notes: Vec<String> = Vec::new();
    if shown.len() < panels.len() {
        notes.push(format!("{} of {} panels are drawn", shown.len(), panels.len()));
    }
    let height_pt = legend::draw(&legends, &notes, PaperBox { top: top_pt, ..inside }, &mut to) + MARGIN_PT;
    document(verified, [width_mm, width_pt, height_pt], &to.into_body())
}

/// Places panels side by side while they fit.
fn rows<'p, 'a>(panels: &'p [Box<dyn Panel + 'a>], most: f64) -> Vec<Vec<&'p (dyn Panel + 'a)>> {
    const ROUNDING: f64 = 1e-6;
    let mut rows: Vec<(f64, Vec<&(dyn Panel + 'a)>)> = Vec::new();
    for panel in panels.iter().map(|panel| &**panel) {
        match rows.last_mut() {
            Some((used, row)) if *used + panel.share() <= most + ROUNDING => {
                *used += panel.share();
                row.push(panel);
            }
            Some(_) | None => rows.push((panel.share(), vec![panel])),
        }
    }
    rows.into_iter().map(|(_, row)| row).collect()
}

/// Draws name, duration and costs; returns the height at which they end.
fn heading(verified: &Verified, moment_ns: Option<u64>, inside: PaperBox, to: &mut Drawing) -> f64 {
    let schedule = verified.schedule();
    let width_pt = inside.right - inside.left;
    let lasts = strobe::time(schedule.duration_ns);
    let lasts = match moment_ns {
        Some(t_ns) => format!("at {} of {lasts}, verified", strobe::time(t_ns)),
        None => format!("{lasts}, verified"),
    };
    let mut top_pt = inside.top + TITLE_PT;
    let title = TextStyle { size_pt: TITLE_PT, ..TextStyle::SMALL.bold() };
    let right = TextStyle::SMALL.colored(color::SOFT).anchored(Anchor::End);
    let room_pt = width_pt - right.width_pt(&lasts) - GAP_PT;
    to.text([inside.left, top_pt], &text_width::cut(&schedule.name, room_pt / TITLE_PT, true), title);
    to.text([inside.right, top_pt], &lasts, right);
    top_pt += 2.0;
    let runs = schedule.plans.iter().zip(&verified.claims().jobs);
    let costs =
        runs.map(|(plan, job)| format!("{} on {}: {}", plan.task, plan.device, strobe::micro(&cost(&job.order, plan))));
    let mut lines: Vec<String> = costs.take(MAX_COSTS).collect();
    if schedule.plans.len() > MAX_COSTS {
        lines.push(format!("and {} more runs", schedule.plans.len() - MAX_COSTS));
    }
    for line in lines.iter().flat_map(|line| text_width::wrapped(line, width_pt / TEXT_PT, false)) {
        top_pt += LINE_PT;
        to.text([inside.left, top_pt], &line, TextStyle::SMALL);
    }
    top_pt + 6.0
}

/// Draws a panel with its title, foot and notes from the top of a box; returns its legend and the height at which it
/// ends.
fn draw_panel(panel: &dyn Panel, inside: PaperBox, to: &mut Drawing) -> (PanelLegend, f64) {
    let width_pt = inside.right - inside.left;
    let title = text_width::cut(&panel.title(), width_pt / TEXT_PT, true);
    let mut top_pt = inside.top;
    if !title.is_empty() {
        top_pt += TEXT_PT;
        to.text([inside.left, top_pt], &title, TextStyle::SMALL.bold());
        top_pt += 4.0;
    }
    let [low, high] = panel.extent();
    let shape = (high[1] - low[1]) / (high[0] - low[0]).max(f64::MIN_POSITIVE);
    let height_pt = width_pt * shape.clamp(FLATTEST, TALLEST);
    let room = PaperBox { top: top_pt, bottom: top_pt + height_pt, ..inside };
    let view = PaperView::fitted([low, high], room);
    let mut data = vec![("unit-um", drawing::decimal(panel.unit_um(), 6))];
    data.extend(view.data_attributes());
    to.open_clipped("scene", room, &data);
    let mut legend = panel.draw(&view, to);
    to.close();
    let left_out = to.place_labels(room);
    if left_out > 0 {
        legend.notes.push(format!("{} left out for want of room", count(left_out, "label")));
    }
    let mut bottom_pt = legend::scale_bar(&view, panel.unit_um(), room, to);
    bottom_pt = panel.draw_foot(room, bottom_pt, to);
    for line in legend.under.iter().flat_map(|line| text_width::wrapped(line, width_pt / TEXT_PT, false)) {
        bottom_pt += LINE_PT;
        to.text([inside.left, bottom_pt], &line, TextStyle::SMALL.colored(color::SOFT));
    }
    (legend, bottom_pt + GAP_PT)
}

/// The whole document.
fn document(verified: &Verified, [width_mm, width_pt, height_pt]: [f64; 3], body: &str) -> String {
    let schedule = verified.schedule();
    let size = format!("width=\"{}mm\" height=\"{}mm\"", number(width_mm), number(height_pt / PT_PER_MM));
    let view = format!("viewBox=\"0 0 {} {}\"", number(width_pt), number(height_pt));
    let name = escaped(&schedule.name);
    let fonts = text_width::FONTS;
    let background =
        format!("<rect width=\"{}\" height=\"{}\" fill=\"#ffffff\"/>", number(width_pt), number(height_pt));
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" {size} {view} font-family=\"{fonts}\" data-duration-ns=\"{}\">\n\
         <title>{name}</title>\n{background}\n{body}</svg>\n",
        schedule.duration_ns
    )
}
