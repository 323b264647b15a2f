//! Fenced blocks of a page.

/// A fenced block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// The line of its opening fence, from 1.
    pub line: usize,
    /// Its language: the first word after the fence.
    pub language: String,
    /// The other words after the fence.
    words: Vec<String>,
    /// The line before the fence.
    pub before: String,
    /// Its lines.
    pub lines: Vec<String>,
    /// The rest of the program, from the comment before the block.
    hidden: Vec<String>,
}

impl Block {
    /// The value of `key=value` among its words.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.words.iter().find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }

    pub fn has(&self, word: &str) -> bool {
        self.words.iter().any(|other| other == word)
    }

    /// Its lines as one text.
    pub fn shown(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// The whole program: its lines inserted into the hidden ones.
    pub fn text(&self) -> String {
        let mut lines: Vec<&str> = Vec::new();
        let mut is_placed = false;
        for line in &self.hidden {
            if line == ELISION {
                lines.extend(self.lines.iter().map(String::as_str));
                is_placed = true;
            } else {
                lines.push(line);
            }
        }
        if !is_placed {
            lines.extend(self.lines.iter().map(String::as_str));
        }
        lines.join("\n") + "\n"
    }
}

/// Stands for any lines, or within a line for any text.
pub const ELISION: &str = "…";

const FENCE: &str = "```";
const HIDDEN: &str = "<!-- twz";

/// The blocks of a page, from top to bottom.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut hidden: Vec<String> = Vec::new();
    let mut before = "";
    let mut lines = (1..).zip(text.lines());
    while let Some((line, content)) = lines.next() {
        if content == HIDDEN {
            let rest = lines.by_ref().map(|(_, content)| content).take_while(|content| *content != "-->");
            hidden = rest.map(str::to_owned).collect();
        } else if let Some(info) = content.strip_prefix(FENCE) {
            let mut words = info.split_whitespace().map(str::to_owned);
            let language = words.next().unwrap_or_default();
            let body = lines.by_ref().map(|(_, content)| content).take_while(|content| *content != FENCE);
            let body = body.map(str::to_owned).collect();
            let hidden = std::mem::take(&mut hidden);
            let before = before.to_owned();
            blocks.push(Block { line, language, words: words.collect(), before, lines: body, hidden });
        } else if !content.is_empty() {
            hidden.clear();
        }
        before = content;
    }
    blocks
}

/// The text of a page with the lines of some blocks replaced.
pub fn rewritten(text: &str, replaced: &[(Block, Vec<String>)]) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    for (block, new) in replaced.iter().rev() {
        let end = block.line + block.lines.len();
        lines.splice(block.line..end, new.iter().map(String::as_str));
    }
    lines.join("\n") + "\n"
}

/// Whether lines match the expected ones, which may contain elisions.
pub fn matches(expected: &[String], lines: &[String]) -> bool {
    match (expected.split_first(), lines.split_first()) {
        (None, None) => true,
        (None, Some(_)) => false,
        (Some((head, rest)), _) if head == ELISION => (0..=lines.len()).any(|skipped| matches(rest, &lines[skipped..])),
        (Some(_), None) => false,
        (Some((head, rest)), Some((line, others))) => matches_line(head, line) && matches(rest, others),
    }
}

fn matches_line(expected: &str, line: &str) -> bool {
    let mut parts = expected.trim_end().split(ELISION);
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = line.trim_end().strip_prefix(first) else { return false };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[test]
fn blocks_and_elisions_are_read() {
    let page = "text\n<!-- twz\na\n…\nz\n-->\n```twz file=x.twz\nm\n```\n\n```console exit=1\n$ false\n```\n";
    let blocks = blocks(page);
    assert_eq!(blocks.len(), 2);
    assert_eq!((blocks[0].text().as_str(), blocks[0].value("file"), blocks[0].line), ("a\nm\nz\n", Some("x.twz"), 7));
    assert_eq!((blocks[1].language.as_str(), blocks[1].value("exit")), ("console", Some("1")));
    assert_eq!(blocks[1].text(), "$ false\n");
    let changed = rewritten(page, &[(blocks[1].clone(), vec!["$ false".to_owned(), "no".to_owned()])]);
    assert!(changed.ends_with("```console exit=1\n$ false\nno\n```\n"), "{changed}");
    let owned = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>();
    let is_match = |expected: &[&str], lines: &[&str]| matches(&owned(expected), &owned(lines));
    assert!(is_match(&["a", "…", "b"], &["a", "x", "y", "b"]) && is_match(&["…"], &[]));
    assert!(is_match(&["a … c"], &["a b c"]) && !is_match(&["a … c"], &["a b d"]) && !is_match(&["a"], &["a", "b"]));
}
