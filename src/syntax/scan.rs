pub(super) const HOLE: char = '\u{1}';
pub(super) const CUT: char = '\u{2}';
