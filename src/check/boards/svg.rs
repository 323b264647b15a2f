//! Boards in SVG: device files of MicroDrop, whose paths carry the channel of their electrode.

use super::paths::bounds;
use super::{DrawnElectrode, MAX_ELECTRODES};
use crate::device::BoardLimits;
use roxmltree::{Document, Node, ParsingOptions};

/// The attribute with the channel of an electrode.
const CHANNEL: &str = "data-channels";

/// Most XML nodes of a picture.
const MAX_NODES: u32 = 200_000;

/// The electrodes of a text.
///
/// # Errors
/// What is wrong with it, as the rest of a sentence.
pub(super) fn read(text: &str, BoardLimits { most_channel, .. }: BoardLimits) -> Result<Vec<DrawnElectrode>, String> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| format!("is not a picture, line {}, column {}: {error}", error.pos().row, error.pos().col))?;
    let mut electrodes = Vec::new();
    for node in document.descendants().filter(|node| node.has_attribute(CHANNEL)) {
        if electrodes.len() >= MAX_ELECTRODES {
            return Err(format!("has more than {MAX_ELECTRODES} electrodes"));
        }
        electrodes.push(electrode(node, most_channel)?);
    }
    Ok(electrodes)
}

fn electrode(node: Node, most_channel: u32) -> Result<DrawnElectrode, String> {
    let here = |what: String| {
        // Only after an error: lines are counted from the start of the file, which for every electrode would be
        // quadratic.
        let at = node.document().text_pos_at(node.range().start);
        format!("has {what}, line {}, column {}", at.row, at.col)
    };
    let written = node.attribute(CHANNEL).unwrap_or_default();
    let channel = written.trim().parse().ok().filter(|channel| *channel <= most_channel);
    let channel = channel
        .ok_or_else(|| here(format!("a channel `{}`, which is not from 0 to {most_channel}", plain(written))))?;
    let name = match node.attribute("id") {
        Some(id) => plain(id),
        None => format!("channel {channel}"),
    };
    let drawn = node.attribute("d").and_then(bounds);
    let [left, top, right, bottom] = drawn.ok_or_else(|| here(format!("a path of `{name}` that is not an outline")))?;
    let [x, y] = shift(node).ok_or_else(|| here(format!("a transform of `{name}` other than `translate`")))?;
    Ok(DrawnElectrode { name, channel, bounds: Some([left + x, top + y, right + x, bottom + y]) })
}

/// Translation of an element by the layers around it; `None` if one has another transform.
fn shift(node: Node) -> Option<[f64; 2]> {
    let mut moved = [0.0; 2];
    for transform in node.ancestors().filter_map(|node| node.attribute("transform")) {
        let inner = transform.trim().strip_prefix("translate(")?.strip_suffix(')')?;
        let numbers: Vec<f64> = inner
            .split(|c: char| c == ',' || c.is_whitespace())
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().ok().filter(|number: &f64| number.is_finite()))
            .collect::<Option<_>>()?;
        let (x, y) = match numbers.as_slice() {
            [x] => (*x, 0.0),
            [x, y] => (*x, *y),
            _ => return None,
        };
        moved = [moved[0] + x, moved[1] + y];
    }
    Some(moved)
}

/// Text from a file for one line of a message, without control characters and cut to 40 characters.
fn plain(text: &str) -> String {
    let most = 40;
    let kept = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let short: String = kept.take(most).collect();
    if text.chars().count() > most { format!("{short}…") } else { short }
}
