//! Lists of lists: consecutive rows of equal length are aligned, so that their values end in the same columns.

use super::layout::{Alignment, CanonicalLine};
use unicode_width::UnicodeWidthStr;

/// Pads the values of each group of rows.
pub(super) fn align(lines: &mut [CanonicalLine]) {
    let mut start = 0;
    while start < lines.len() {
        let Some(count) = values(&lines[start]).map(|row| row.len()) else {
            start += 1;
            continue;
        };
        let first = lines[start].indent;
        let continues = |line: &&CanonicalLine| {
            !line.after_gap && line.indent == first && values(line).is_some_and(|row| row.len() == count)
        };
        let end = start + 1 + lines[start + 1..].iter().take_while(continues).count();
        if end > start + 1 {
            pad(&mut lines[start..end]);
        }
        start = end;
    }
}

/// The values of a line that consists of a list of at least two plain values; `None` for other lines.
fn values<'l>(line: &'l CanonicalLine) -> Option<Vec<&'l str>> {
    let [part] = line.parts.as_slice() else { return None };
    let inner = part.strip_suffix(',').unwrap_or(part).strip_prefix('[')?.strip_suffix(']')?;
    let row: Vec<&str> = inner.split(", ").collect();
    let is_plain = |value: &str| !value.is_empty() && !value.contains(['[', ']', '(', ')', '{', '}', '"', ',', '/']);
    let is_row = line.kept.is_none() && line.goes_on && line.alignment == Alignment::Alone;
    (is_row && row.len() >= 2 && row.iter().all(|value| is_plain(value))).then_some(row)
}

fn pad(rows: &mut [CanonicalLine]) {
    let mut widths: Vec<usize> = Vec::new();
    for row in rows.iter().filter_map(values) {
        widths.resize(row.len(), 0);
        widths.iter_mut().zip(&row).for_each(|(width, value)| *width = (*width).max(value.width()));
    }
    for line in rows {
        let Some(row) = values(line) else { continue };
        let blanks = |(value, width): (&&str, &usize)| " ".repeat(width - value.width());
        let cells: Vec<String> = row.iter().zip(&widths).map(|(value, width)| blanks((value, width)) + value).collect();
        let comma = if line.parts[0].ends_with(',') { "," } else { "" };
        line.parts = vec![format!("[{}]{comma}", cells.join(", "))];
    }
}
