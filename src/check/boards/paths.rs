//! Bounding boxes of SVG paths, which locate electrodes.

/// Most numbers of a path.
const MAX_NUMBERS: usize = 100_000;

/// Left, top, right and bottom of the points of a path; control points of curves count as points. `None` if the text is
/// not a path, has no area, or has numbers that are too large.
pub(super) fn bounds(path: &str) -> Option<[f64; 4]> {
    let mut pen = Pen {
        at: [0.0; 2],
        start: [0.0; 2],
        bounds: [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
    };
    let mut rest = path.trim_start_matches(is_blank);
    let mut count = 0;
    while let Some(word) = rest.chars().next() {
        rest = rest[word.len_utf8()..].trim_start_matches(is_blank);
        let mut numbers = Vec::new();
        while let Some((number, after)) = number(rest) {
            numbers.push(number);
            count += 1;
            if count > MAX_NUMBERS {
                return None;
            }
            rest = after.trim_start_matches(is_blank);
        }
        pen.draw(word, &numbers)?;
    }
    let [left, top, right, bottom] = pen.bounds;
    let is_sound = [left, top, right, bottom].iter().all(|side| side.abs() < 1e9) && left < right && top < bottom;
    is_sound.then_some(pen.bounds)
}

fn is_blank(c: char) -> bool {
    c == ',' || c.is_ascii_whitespace()
}

/// The number at the beginning of a text, and what follows it.
fn number(text: &str) -> Option<(f64, &str)> {
    let mut end = 0;
    let (mut has_point, mut has_digit, mut has_exponent) = (false, false, false);
    let mut before = ' ';
    for (index, c) in text.char_indices() {
        let fits = match c {
            '0'..='9' => true,
            '+' | '-' => index == 0 || matches!(before, 'e' | 'E'),
            '.' => !has_point && !has_exponent,
            'e' | 'E' => has_digit && !has_exponent,
            _ => false,
        };
        if !fits {
            break;
        }
        has_point |= c == '.';
        has_exponent |= matches!(c, 'e' | 'E');
        has_digit |= c.is_ascii_digit();
        before = c;
        end = index + c.len_utf8();
    }
    let value = text[..end].parse().ok().filter(|value: &f64| value.is_finite())?;
    Some((value, &text[end..]))
}

/// State of drawing a path: the current point, the start of the subpath, and the bounds so far.
struct Pen {
    at: [f64; 2],
    start: [f64; 2],
    bounds: [f64; 4],
}

impl Pen {
    /// Executes a path command with its numbers; `None` if they do not fit.
    fn draw(&mut self, word: char, numbers: &[f64]) -> Option<()> {
        // Numbers of one segment, which end with its end point or with one coordinate of it.
        let stride = match word.to_ascii_uppercase() {
            'M' | 'L' | 'T' => 2,
            'H' | 'V' => 1,
            'S' | 'Q' => 4,
            'C' => 6,
            'A' => 7,
            'Z' if numbers.is_empty() => {
                self.at = self.start;
                return Some(());
            }
            _ => return None,
        };
        if numbers.is_empty() || !numbers.len().is_multiple_of(stride) {
            return None;
        }
        let from = if word.is_ascii_lowercase() { 1.0 } else { 0.0 };
        for (index, stroke) in numbers.chunks(stride).enumerate() {
            let origin = self.at.map(|place| place * from);
            match (word.to_ascii_uppercase(), stroke) {
                ('H', [x]) => self.go([origin[0] + x, self.at[1]]),
                ('V', [y]) => self.go([self.at[0], origin[1] + y]),
                // Radii, rotation and flags of an arc are not points.
                ('A', [.., x, y]) => self.go([origin[0] + x, origin[1] + y]),
                (_, points) => {
                    for point in points.chunks(2) {
                        let [x, y] = point else { return None };
                        self.go([origin[0] + x, origin[1] + y]);
                    }
                }
            }
            if word.eq_ignore_ascii_case(&'M') && index == 0 {
                self.start = self.at;
            }
        }
        Some(())
    }

    fn go(&mut self, to: [f64; 2]) {
        let [left, top, right, bottom] = self.bounds;
        self.bounds = [left.min(to[0]), top.min(to[1]), right.max(to[0]), bottom.max(to[1])];
        self.at = to;
    }
}
