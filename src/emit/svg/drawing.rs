//! Elements of a picture on paper: lines, discs and texts with numbers of a fixed form, and the view that maps a scene
//! onto it.
//!
//! One unit is one point, 1/72 of an inch. Guarantees: the output is well-formed XML whatever the texts, and no text
//! covers another.

use super::text_width::{self, ASCENT, DESCENT};

/// Points in a millimetre.
pub const PT_PER_MM: f64 = 72.0 / 25.4;

/// Font sizes.
pub const TEXT_PT: f64 = 7.0;
pub const TITLE_PT: f64 = 9.0;

/// Line spacing of small text.
pub const LINE_PT: f64 = 9.0;

/// The thinnest line that prints well.
pub const HAIR_PT: f64 = 0.35;

/// Width of ordinary lines, and of paths.
pub const THIN_PT: f64 = 0.6;
pub const WAY_PT: f64 = 1.2;

/// Colours of the page that plays a schedule, in its light theme; distinguishable with any colour vision (Okabe and
/// Ito).
pub mod color {
    pub const PAPER: &str = "#ffffff";
    pub const INK: &str = "#1c2128";
    pub const SOFT: &str = "#57606a";
    pub const FAINT: &str = "#b6bec8";
    pub const DOTS: &str = "#c9d1da";
    pub const PANEL: &str = "#f6f7f9";
    pub const OBSTACLE: &str = "#d55e00";
    pub const GROWN: &str = "#f7d9c3";
    pub const LIT: &str = "#f0c000";
    pub const STOP: &str = "#00745a";
    pub const AHEAD: &str = "#8c959f";
    pub const BOARD: &str = "#f0f2f5";
    pub const ELECTRODE: &str = "#d5dbe2";
    pub const LIVE: &str = "#ffe066";
    pub const LIVE_EDGE: &str = "#b08800";
    pub const HEATER: &str = "#f6bfa0";
    pub const DETECTOR: &str = "#a5dcc8";
    pub const MAGNET: &str = "#c9b8e8";
    pub const ALARM: &str = "#d00000";

    /// Colours that are cycled through by items of one sort.
    pub const TURNS: [&str; 7] = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#f0e442"];

    /// The colour of an item of a sort, by its index.
    pub fn in_turn(index: usize) -> &'static str {
        TURNS[index % TURNS.len()]
    }
}

/// A rectangle on paper: left, top, right, bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperBox {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl PaperBox {
    pub fn about([x, y]: [f64; 2], half: f64) -> PaperBox {
        PaperBox { left: x - half, top: y - half, right: x + half, bottom: y + half }
    }

    fn meets(&self, other: &PaperBox) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    fn holds(&self, other: &PaperBox) -> bool {
        self.left <= other.left && other.right <= self.right && self.top <= other.top && other.bottom <= self.bottom
    }

    /// Whether a point lies in the box.
    pub fn surrounds(&self, at: [f64; 2]) -> bool {
        self.holds(&PaperBox::about(at, 0.0))
    }

    pub fn middle(&self) -> [f64; 2] {
        [(self.left + self.right) / 2.0, (self.top + self.bottom) / 2.0]
    }
}

/// Fill, stroke and opacity.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShapeStyle {
    fill: Option<&'static str>,
    stroke: Option<&'static str>,
    width_pt: f64,
    dash: Option<&'static str>,
    opacity: Option<f64>,
}

impl ShapeStyle {
    pub fn filled(color: &'static str) -> ShapeStyle {
        ShapeStyle { fill: Some(color), ..ShapeStyle::default() }
    }

    pub fn line(color: &'static str, width_pt: f64) -> ShapeStyle {
        ShapeStyle { stroke: Some(color), width_pt, ..ShapeStyle::default() }
    }

    /// Adds a rim.
    pub fn with_stroke(self, color: &'static str, width_pt: f64) -> ShapeStyle {
        ShapeStyle { stroke: Some(color), width_pt, ..self }
    }

    /// Makes the line dashed.
    pub fn dashed(self, dash: &'static str) -> ShapeStyle {
        ShapeStyle { dash: Some(dash), ..self }
    }

    /// Sets the opacity, from 0 to 1.
    pub fn with_opacity(self, opacity: f64) -> ShapeStyle {
        ShapeStyle { opacity: Some(opacity), ..self }
    }

    fn attributes(&self) -> String {
        let mut text = format!(" fill=\"{}\"", self.fill.unwrap_or("none"));
        if let Some(stroke) = self.stroke {
            text.push_str(&format!(" stroke=\"{stroke}\" stroke-width=\"{}\"", number(self.width_pt)));
            text.push_str(" stroke-linejoin=\"round\" stroke-linecap=\"round\"");
        }
        if let Some(dash) = self.dash {
            text.push_str(&format!(" stroke-dasharray=\"{dash}\""));
        }
        if let Some(opacity) = self.opacity {
            text.push_str(&format!(" opacity=\"{}\"", number(opacity)));
        }
        text
    }
}

/// Meaning of an element, for programs that read the picture: names of `data-` attributes with their values.
pub type DataAttributes<'a> = &'a [(&'a str, String)];

/// Horizontal anchor of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// Font style of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextStyle {
    pub size_pt: f64,
    pub is_bold: bool,
    pub color: &'static str,
    pub anchor: Anchor,
}

impl TextStyle {
    pub const SMALL: TextStyle =
        TextStyle { size_pt: TEXT_PT, is_bold: false, color: color::INK, anchor: Anchor::Start };

    pub fn bold(self) -> TextStyle {
        TextStyle { is_bold: true, ..self }
    }

    pub fn colored(self, color: &'static str) -> TextStyle {
        TextStyle { color, ..self }
    }

    pub fn anchored(self, anchor: Anchor) -> TextStyle {
        TextStyle { anchor, ..self }
    }

    /// Estimated width of a text.
    pub fn width_pt(&self, text: &str) -> f64 {
        text_width::width_em(text, self.is_bold) * self.size_pt
    }

    /// The box of a text whose baseline starts, is centred, or ends at a point.
    fn room(&self, text: &str, [x, y]: [f64; 2]) -> PaperBox {
        let width_pt = self.width_pt(text);
        let left = match self.anchor {
            Anchor::Start => x,
            Anchor::Middle => x - width_pt / 2.0,
            Anchor::End => x - width_pt,
        };
        let (top, bottom) = (y - ASCENT * self.size_pt, y + DESCENT * self.size_pt);
        PaperBox { left, top, right: left + width_pt, bottom }
    }
}

/// A text that is placed after all shapes are drawn, near a point and not on another text.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedLabel {
    pub text: String,
    pub text_style: TextStyle,
    pub at: [f64; 2],
    /// Radius of the mark at the point.
    pub radius_pt: f64,
    /// Whether the text may stand on the point itself.
    pub may_cover: bool,
}

/// A picture in progress.
#[derive(Debug, Default)]
pub struct Drawing {
    body: String,
    texts: Vec<PaperBox>,
    /// Areas that labels avoid if possible.
    marks: Vec<PaperBox>,
    waiting: Vec<PlacedLabel>,
    clips: usize,
}

impl Drawing {
    /// The markup of all elements.
    pub fn into_body(self) -> String {
        self.body
    }

    fn element(&mut self, name: &str, form: &str, style: &ShapeStyle, data: DataAttributes) {
        self.body.push_str(&format!("<{name} {form}{}", style.attributes()));
        self.data_attributes(data);
        self.body.push_str("/>\n");
    }

    fn data_attributes(&mut self, data: DataAttributes) {
        for (name, value) in data {
            self.body.push_str(&format!(" data-{name}=\"{}\"", escaped(value)));
        }
    }

    /// Begins a group; [`Drawing::close`] ends it.
    pub fn open(&mut self, class: &str, data: DataAttributes) {
        self.body.push_str(&format!("<g class=\"{class}\""));
        self.data_attributes(data);
        self.body.push_str(">\n");
    }

    /// Begins a group that is clipped to a box.
    pub fn open_clipped(&mut self, class: &str, room: PaperBox, data: DataAttributes) {
        self.clips += 1;
        let id = self.clips;
        self.body.push_str(&format!("<clipPath id=\"clip{id}\"><rect {}/></clipPath>\n", rectangle(room)));
        self.body.push_str(&format!("<g class=\"{class}\" clip-path=\"url(#clip{id})\""));
        self.data_attributes(data);
        self.body.push_str(">\n");
    }

    pub fn close(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// A polyline.
    pub fn line(&mut self, points: &[[f64; 2]], style: ShapeStyle, data: DataAttributes) {
        if points.len() > 1 {
            self.element("path", &format!("d=\"{}\"", path(points)), &style, data);
        }
    }

    /// A closed shape.
    pub fn shape(&mut self, points: &[[f64; 2]], style: ShapeStyle, data: DataAttributes) {
        if !points.is_empty() {
            self.element("path", &format!("d=\"{}Z\"", path(points)), &style, data);
        }
    }

    pub fn rect(&mut self, room: PaperBox, style: ShapeStyle, data: DataAttributes) {
        self.element("rect", &rectangle(room), &style, data);
    }

    pub fn disc(&mut self, [x, y]: [f64; 2], radius_pt: f64, style: ShapeStyle, data: DataAttributes) {
        let form = format!("cx=\"{}\" cy=\"{}\" r=\"{}\"", number(x), number(y), number(radius_pt));
        self.element("circle", &form, &style, data);
    }

    /// Many dots of one diameter.
    pub fn dots(&mut self, places: impl IntoIterator<Item = [f64; 2]>, diameter_pt: f64, color: &'static str) {
        let mut form = String::new();
        for [x, y] in places {
            form.push_str(&format!("M{} {}h0", number(x), number(y)));
        }
        if !form.is_empty() {
            self.element("path", &format!("d=\"{form}\""), &ShapeStyle::line(color, diameter_pt), &[]);
        }
    }

    /// Reserves an area that labels avoid.
    pub fn mark(&mut self, room: PaperBox) {
        self.marks.push(room);
    }

    /// A text on its baseline.
    pub fn text(&mut self, at: [f64; 2], text: &str, text_style: TextStyle) {
        if text.is_empty() {
            return;
        }
        self.texts.push(text_style.room(text, at));
        let anchor = match text_style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if text_style.is_bold { " font-weight=\"bold\"" } else { "" };
        let (x, y, size) = (number(at[0]), number(at[1]), number(text_style.size_pt));
        self.body.push_str(&format!("<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{weight}"));
        // A rim in the colour of paper keeps it readable on lines.
        self.body.push_str(" stroke=\"#ffffff\" stroke-width=\"1.5\" stroke-linejoin=\"round\" paint-order=\"stroke\"");
        self.body.push_str(&format!(" fill=\"{}\">{}</text>\n", text_style.color, escaped(text)));
    }

    /// A text for [`Drawing::place_labels`] to place.
    pub fn label(&mut self, label: PlacedLabel) {
        self.waiting.push(label);
    }

    /// Places the waiting labels inside a box, earlier ones first; returns the number of those without room.
    pub fn place_labels(&mut self, room: PaperBox) -> usize {
        let mut left_out = 0;
        for label in std::mem::take(&mut self.waiting) {
            match self.free_place(&label, room) {
                Some(at) => self.text(at, &label.text, TextStyle { anchor: Anchor::Middle, ..label.text_style }),
                None => left_out += 1,
            }
        }
        self.marks.clear();
        left_out
    }

    /// A free middle point for the baseline of a label.
    fn free_place(&self, label: &PlacedLabel, room: PaperBox) -> Option<[f64; 2]> {
        let text_style = TextStyle { anchor: Anchor::Middle, ..label.text_style };
        let is_free = |at: &[f64; 2]| {
            let own = text_style.room(&label.text, *at);
            let spaced = PaperBox { left: own.left - SPACE_PT, right: own.right + SPACE_PT, ..own };
            room.holds(&own) && !self.texts.iter().any(|text| text.meets(&spaced))
        };
        let is_clear = |at: &[f64; 2]| {
            let own = text_style.room(&label.text, *at);
            // The box of a text has room above small letters.
            let seen = PaperBox {
                top: own.top + 0.15 * text_style.size_pt,
                bottom: own.bottom - 0.15 * text_style.size_pt,
                ..own
            };
            !self.marks.iter().any(|mark| mark.meets(&seen))
        };
        let places = around(label);
        // On the point itself is only the label's own mark.
        let is_own = |at: &[f64; 2]| label.may_cover && *at == places[0];
        let clear = places.iter().find(|at| is_free(at) && (is_own(at) || is_clear(at)));
        clear.or_else(|| places.iter().find(|at| is_free(at))).copied()
    }
}

/// Least gap between two labels side by side.
const SPACE_PT: f64 = 1.6;

/// Distances from a labelled mark to its label, in points.
const GAPS_PT: [f64; 3] = [1.0, 4.0, 8.0];

/// Candidate positions of a label, best first.
fn around(label: &PlacedLabel) -> Vec<[f64; 2]> {
    let [x, y] = label.at;
    let (half_width, size) = (label.text_style.width_pt(&label.text) / 2.0, label.text_style.size_pt);
    // From the baseline to the middle of a digit, and half of its height.
    let (lift, half_height) = (0.36 * size, 0.36 * size);
    let mut places = if label.may_cover { vec![[x, y + lift]] } else { Vec::new() };
    for gap in GAPS_PT {
        let reach = label.radius_pt + gap;
        let slant = 0.75 * reach;
        let [right, above] = [reach + half_width, reach + half_height];
        let [right_slant, above_slant] = [slant + half_width, slant + half_height];
        let offsets = [
            [right_slant, -above_slant],
            [-right_slant, -above_slant],
            [right_slant, above_slant],
            [-right_slant, above_slant],
            [right, 0.0],
            [-right, 0.0],
            [0.0, -above],
            [0.0, above],
        ];
        places.extend(offsets.map(|[dx, dy]| [x + dx, y + dy + lift]));
    }
    places
}

/// Mapping from a scene to a box on paper: y points up, lengths are in the scene's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperView {
    /// Points on paper per unit of the scene.
    pub scale: f64,
    left_pt: f64,
    base_pt: f64,
    /// The box of the scene on paper.
    pub room: PaperBox,
}

impl PaperView {
    /// The view that fits the area between two corners into a box, as large as possible and centred.
    pub fn fitted([low, high]: [[f64; 2]; 2], room: PaperBox) -> PaperView {
        let scale = scale_of([low, high], [room.right - room.left, room.bottom - room.top]);
        let [x, y] = room.middle();
        let left_pt = x - scale * (low[0] + high[0]) / 2.0;
        let base_pt = y + scale * (low[1] + high[1]) / 2.0;
        PaperView { scale, left_pt, base_pt, room }
    }

    /// A scene position on paper.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.left_pt + x * self.scale, self.base_pt - y * self.scale]
    }

    pub fn all(&self, places: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
        places.into_iter().map(|place| self.at(place)).collect()
    }

    /// The mapping as data attributes: `x` on paper is `left` + `scale` times x of the scene, `y` is `base` - `scale`
    /// times y.
    pub fn data_attributes(&self) -> [(&'static str, String); 3] {
        let exact = |value: f64| format!("{value:.9}");
        [("scale", exact(self.scale)), ("left", exact(self.left_pt)), ("base", exact(self.base_pt))]
    }
}

/// The scale at which the area between two corners fits into a width and a height on paper.
pub fn scale_of([low, high]: [[f64; 2]; 2], [width_pt, height_pt]: [f64; 2]) -> f64 {
    let least = f64::MIN_POSITIVE.sqrt();
    (width_pt / (high[0] - low[0]).max(least)).min(height_pt / (high[1] - low[1]).max(least))
}

/// A number with at most three decimals, never minus zero.
pub fn number(value: f64) -> String {
    decimal(value, 3)
}

/// A number with at most `decimals` decimals, without trailing zeros, never minus zero.
pub fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn rectangle(room: PaperBox) -> String {
    let [x, y, width, height] = [room.left, room.top, room.right - room.left, room.bottom - room.top].map(number);
    format!("x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"")
}

fn path(points: &[[f64; 2]]) -> String {
    let mut text = String::new();
    for (index, [x, y]) in points.iter().enumerate() {
        text.push_str(match index {
            0 => "M",
            1 => "L",
            2.. => " ",
        });
        text.push_str(&format!("{} {}", number(*x), number(*y)));
    }
    text
}

/// A text escaped for the content of an element or an attribute. Characters that XML does not allow become U+FFFD.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\t' | '\n' | '\r' => safe.push(' '),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}
