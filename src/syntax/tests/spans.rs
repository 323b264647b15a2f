//! Every text gets a tree, every span lies in its parent's, and no text makes the parser fail.

use super::*;

/// Checks a span against its parent's and returns it.
fn within(parent: Span, child: Span, text: &str) -> Span {
    assert!(child.start <= child.end && parent.contains(child), "{child:?} is not in {parent:?} of {text:?}");
    let is_whole = text.is_char_boundary(child.start as usize) && text.is_char_boundary(child.end as usize);
    assert!(is_whole, "{child:?} cuts a character of {text:?}");
    child
}

/// Walks a tree together with the text that it was parsed from.
struct Walk<'t>(&'t str);

impl Walk<'_> {
    fn place(&self, parent: Span, child: Span) {
        within(parent, child, self.0);
    }

    fn tree(&self, tree: &Tree) {
        let whole = Span::new(tree.file, 0, self.0.len());
        for item in &tree.items {
            self.item(whole, item);
        }
        for name in &tree.broken_names {
            within(whole, name.span, self.0);
        }
    }

    fn item(&self, whole: Span, item: &Item) {
        match item {
            Item::Use(item) => {
                let span = within(whole, item.span, self.0);
                match &item.path {
                    UsePath::Library { words, span: path } => {
                        let path = within(span, *path, self.0);
                        words.iter().for_each(|word| self.place(path, word.span));
                    }
                    UsePath::File(text) => self.text(span, text),
                }
                item.alias.iter().for_each(|alias| self.place(span, alias.span));
            }
            Item::Let(item) => {
                let span = within(whole, item.span, self.0);
                within(span, item.name.span, self.0);
                self.expr(span, &item.value);
            }
            Item::Device(item) | Item::Instrument(item) | Item::Output(item) => {
                let span = within(whole, item.span, self.0);
                within(span, item.name.span, self.0);
                self.path(span, &item.base);
                item.fields.iter().for_each(|field| self.field(span, field));
            }
            Item::Scene(item) => {
                let span = within(whole, item.span, self.0);
                within(span, item.name.span, self.0);
                item.base.iter().for_each(|base| self.path(span, base));
                item.entries.iter().for_each(|entry| self.scene_entry(span, entry));
            }
            Item::Task(item) => {
                let span = within(whole, item.span, self.0);
                within(span, item.name.span, self.0);
                self.parameters(span, &item.parameters);
                self.path(span, &item.device);
                item.scene.iter().for_each(|scene| self.path(span, scene));
                item.entries.iter().for_each(|entry| self.entry(span, entry));
            }
            Item::Program(item) => {
                let span = within(whole, item.span, self.0);
                within(span, item.name.span, self.0);
                self.parameters(span, &item.parameters);
                item.entries.iter().for_each(|entry| self.entry(span, entry));
            }
            Item::Wiring(item) => {
                let span = within(whole, item.span, self.0);
                self.path(span, &item.device);
                item.entries.iter().for_each(|entry| self.wiring_entry(span, entry));
            }
            Item::Error(span) => self.place(whole, *span),
        }
    }

    fn parameters(&self, parent: Span, parameters: &[Parameter]) {
        for parameter in parameters {
            let span = within(parent, parameter.span, self.0);
            within(span, parameter.name.span, self.0);
            within(span, parameter.sort.span, self.0);
        }
    }

    fn each<E>(&self, parent: Span, each: &For<E>, entry: impl Fn(Span, &E)) {
        let span = within(parent, each.span, self.0);
        each.counter.iter().for_each(|counter| self.place(span, counter.span));
        within(span, each.element.span, self.0);
        self.expr(span, &each.over);
        each.entries.iter().for_each(|inner| entry(span, inner));
    }

    fn scene_entry(&self, parent: Span, entry: &SceneEntry) {
        match entry {
            SceneEntry::Object(object) => {
                let span = within(parent, object.span, self.0);
                within(span, object.noun.span, self.0);
                self.indexed(span, &object.name);
                object.shape.iter().chain(&object.at).for_each(|value| self.expr(span, value));
            }
            SceneEntry::For(each) => self.each(parent, each, |span, entry| self.scene_entry(span, entry)),
            SceneEntry::Error(span) => self.place(parent, *span),
        }
    }

    fn entry(&self, parent: Span, entry: &Entry) {
        match entry {
            Entry::Field(field) => self.field(parent, field),
            Entry::Step(step) => {
                let span = within(parent, step.span, self.0);
                within(span, step.head.span, self.0);
                step.noun.iter().for_each(|noun| self.place(span, noun.span));
                step.indices.iter().chain(&step.object).for_each(|value| self.expr(span, value));
                for phrase in &step.phrases {
                    let span = within(span, phrase.span, self.0);
                    within(span, phrase.preposition.span, self.0);
                    self.expr(span, &phrase.value);
                }
                step.block.iter().flatten().for_each(|entry| self.entry(span, entry));
            }
            Entry::For(each) => self.each(parent, each, |span, entry| self.entry(span, entry)),
            Entry::Error(span) => self.place(parent, *span),
        }
    }

    fn wiring_entry(&self, parent: Span, entry: &WiringEntry) {
        match entry {
            WiringEntry::Wire(wire) => {
                let span = within(parent, wire.span, self.0);
                self.path(span, &wire.channel);
                match &wire.output {
                    WireOutput::Named(text) => self.text(span, text),
                    WireOutput::Instrument(path) => self.path(span, path),
                }
                wire.fields.iter().for_each(|field| self.field(span, field));
            }
            WiringEntry::Field(field) => self.field(parent, field),
            WiringEntry::For(each) => self.each(parent, each, |span, entry| self.wiring_entry(span, entry)),
            WiringEntry::Error(span) => self.place(parent, *span),
        }
    }

    fn field(&self, parent: Span, field: &Field) {
        let span = within(parent, field.span, self.0);
        within(span, field.name.span, self.0);
        self.expr(span, &field.value);
    }

    fn path(&self, parent: Span, path: &Path) {
        let span = within(parent, path.span, self.0);
        assert!(!path.segments.is_empty());
        path.segments.iter().for_each(|segment| self.indexed(span, segment));
    }

    fn indexed(&self, parent: Span, name: &IndexedName) {
        let span = within(parent, name.span, self.0);
        within(span, name.name.span, self.0);
        name.indices.iter().for_each(|index| self.expr(span, index));
    }

    fn text(&self, parent: Span, text: &Text) {
        let span = within(parent, text.span, self.0);
        for part in &text.parts {
            match part {
                TextPart::Plain(plain) => assert!(!plain.is_empty()),
                TextPart::Hole(value) => self.expr(span, value),
            }
        }
    }

    fn expr(&self, parent: Span, expr: &Expr) {
        let span = within(parent, expr.span, self.0);
        match &expr.kind {
            ExprKind::Number(number) => assert!(number.parse::<f64>().is_ok_and(f64::is_finite)),
            ExprKind::Quantity { number, unit } => {
                assert!(number.parse::<f64>().is_ok_and(f64::is_finite));
                within(span, unit.span, self.0);
            }
            ExprKind::Word(_) | ExprKind::Bool(_) | ExprKind::Error => {}
            ExprKind::Text(text) => self.text(span, text),
            ExprKind::Path(path) => self.path(span, path),
            ExprKind::Tuple(values) => {
                assert!(matches!(values.len(), 2 | 3));
                values.iter().for_each(|value| self.expr(span, value));
            }
            ExprKind::List(values) => values.iter().for_each(|value| self.expr(span, value)),
            ExprKind::Range { from, to } => [from, to].into_iter().for_each(|value| self.expr(span, value)),
            ExprKind::Negative(value) => self.expr(span, value),
            ExprKind::Binary { left, operator_span, right, .. } => {
                within(span, *operator_span, self.0);
                [left, right].into_iter().for_each(|value| self.expr(span, value));
            }
            ExprKind::Call { function, arguments } => {
                self.path(span, function);
                arguments.iter().for_each(|value| self.expr(span, value));
            }
            ExprKind::With { base, fields } => {
                self.path(span, base);
                fields.iter().for_each(|field| self.field(span, field));
            }
            ExprKind::Table(table) => {
                for column in &table.columns {
                    within(span, column.name.span, self.0);
                    column.unit.iter().for_each(|unit| self.place(span, unit.span));
                }
                for row in &table.rows {
                    let span = within(span, row.span, self.0);
                    assert_eq!(row.cells.len(), table.columns.len());
                    row.cells.iter().for_each(|cell| self.expr(span, cell));
                }
            }
        }
    }
}

/// Parses a text and checks the result against the guarantees of `parse`.
fn holds(text: &str) {
    let (tree, findings) = read(text);
    Walk(text).tree(&tree);
    for finding in &findings {
        assert!(!finding.labels.is_empty() && finding.help.is_some(), "{finding:?}");
        for label in &finding.labels {
            assert!(
                text.is_char_boundary(label.span.start as usize) && text.is_char_boundary(label.span.end as usize),
                "{finding:?}"
            );
            within(Span::new(FileId(0), 0, text.len()), label.span, text);
        }
    }
    let mut sink = Sink::default();
    let value = parse_value(FileId(0), text, &mut sink);
    assert_eq!(value.is_none(), sink.errors() > 0, "{text:?}");
}

const TOKENS: &[&str] = &[
    "use", "as", "let", "device", "instrument", "output", "scene", "task", "program", "wiring", "table", "true", "for",
    "in", "on", "at", "to", "via", "after", "a", "b1", "move", "run", "together", "if", "else", "std.x", "0", "35",
    "1e-3", ".5", "5.", "0b101", "0b2", "um", "um/s", "%", "(", ")", "[", "]", "{", "}", "{", "}", ",", ",", ":", ":",
    "=", ":=", "==", "<=", "<", "+", "-", "*", "/", "^", "..", "->", "|", ";", "\n", "\n", "\n", " ", " ", " ", "\"",
    "\"a{b}\"", "\"{", "“", "”", "'", "// c\n", "/// d\n", "//! e\n", "/*", "*/", "#", "µm", "°", "≤", "→", "\u{a0}",
    "\u{1}", "\u{2}", "\u{feff}", "\r\n", "\t", "@", "…", "é", "🤖",
];

fn soup() -> impl Strategy<Value = String> {
    let tokens = proptest::collection::vec((0..TOKENS.len(), 0..3_u8), 0..120);
    tokens.prop_map(|tokens| {
        let mut text = String::new();
        for (token, blank) in tokens {
            text.push_str(TOKENS[token]);
            if blank > 0 {
                text.push(' ');
            }
        }
        text
    })
}

/// A valid program with some of its characters dropped, doubled or replaced by tokens.
fn mutant() -> impl Strategy<Value = String> {
    let changes = proptest::collection::vec((any::<prop::sample::Index>(), 0..TOKENS.len() + 2), 1..6);
    changes.prop_map(|changes| {
        let mut characters: Vec<String> = forms::EVERYTHING.chars().map(String::from).collect();
        for (place, change) in changes {
            let at = place.index(characters.len());
            match TOKENS.get(change) {
                Some(token) => characters[at].push_str(token),
                None if change == TOKENS.len() => characters[at].clear(),
                None => {
                    let twice = characters[at].repeat(2);
                    characters[at] = twice;
                }
            }
        }
        characters.concat()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn token_soup_has_a_tree(text in soup()) {
        holds(&text);
    }

    #[test]
    fn random_bytes_have_a_tree(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        holds(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn mutated_programs_have_a_tree(text in mutant()) {
        holds(&text);
    }
}

/// Stack size of a thread, the standard library's default.
const STACK_BYTES: usize = 2 * 1024 * 1024;

/// Runs in a thread with a small stack, so that the harness's larger one cannot hide an overflow.
fn on_a_small_stack(texts: Vec<String>) {
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
    let handle = thread.spawn(move || texts.iter().for_each(|text| holds(text)));
    assert!(handle.expect("a thread starts").join().is_ok());
}

/// The word before the place where parsing stopped may follow directly after a character of several bytes.
#[test]
fn a_misspelt_preposition_behind_a_sign_is_cut_at_its_border() {
    for sign in ["²", "→", "é²"] {
        holds(&format!("task go on bot {{\n  move (1, 2){sign}form dye\n}}\n"));
    }
}

#[test]
fn deep_nesting_and_long_chains_are_refused_without_a_crash() {
    let nest = |open: &str, close: &str| format!("let a = {}1{}\n", open.repeat(100_000), close.repeat(100_000));
    let mut texts = vec![
        nest("(", ")"),
        nest("[", "]"),
        nest("a[", "]"),
        nest("f(", ")"),
        nest("a { b: ", "}"),
        nest("(", ""),
        nest("{", ""),
    ];
    texts.push(format!("task t on b {{ {} }}", "a { ".repeat(100_000)));
    texts.push(format!("let a = \"{{{}1{}}}\"\n", "(".repeat(100_000), ")".repeat(100_000)));
    texts.push(format!("let a = {}1\n", "-".repeat(20_000)));
    texts.push(format!("let a = 1{}\n", " + 1".repeat(20_000)));
    texts.push(format!("let a = 1{}\n", " +\n 1".repeat(20_000)));
    texts.push(format!("let a = 1{}\n", " ^ 1".repeat(20_000)));
    texts.push(format!("let a = 1{}\n", ".b".repeat(20_000)));
    texts.push("}".repeat(100_000));
    texts.push(")".repeat(100_000));
    on_a_small_stack(texts);
}

#[test]
fn the_tallest_tree_that_is_allowed_fits_a_small_stack() {
    let level = |operators: usize| format!("{}(", "1 + ".repeat(operators));
    let heights = MAX_OPERATORS / MAX_NESTING;
    let brackets = format!("let a = {}1{}\n", level(heights).repeat(MAX_NESTING), ")".repeat(MAX_NESTING));
    assert_eq!(found(&brackets), []);
    let blocks =
        format!("task t on b {{ {}wait 1 s{} }}\n", "a { ".repeat(MAX_NESTING - 1), " }".repeat(MAX_NESTING - 1));
    assert_eq!(found(&blocks), []);
    let failing =
        format!("task t on b {{ {}$ {}$ }}\n", "a { x: ".repeat(MAX_NESTING - 1), "} $ ".repeat(MAX_NESTING - 1));
    on_a_small_stack(vec![brackets, blocks, failing]);
}

#[test]
fn the_limits_are_the_stated_ones() {
    let nested = |depth: usize| format!("let a = {}1{}\n", "(".repeat(depth), ")".repeat(depth));
    assert_eq!(found(&nested(MAX_NESTING)), []);
    assert_eq!(found(&nested(MAX_NESTING + 1)), [("E0120", "(".to_owned())]);
    let chain = |operators: usize| format!("let a = 1{}\n", "+1".repeat(operators));
    assert_eq!(found(&chain(MAX_OPERATORS)), []);
    assert_eq!(found(&chain(MAX_OPERATORS + 1)).first().map(|finding| finding.0), Some("E0121"));
}

#[test]
fn a_line_of_a_megabyte_is_read() {
    let numbers = format!("let a = [{}]\n", "1, ".repeat(30_000));
    assert_eq!(found(&numbers), []);
    let megabyte = "a".repeat(1024 * 1024);
    assert_eq!(found(&format!("let a = 1 // {megabyte}\n")), []);
    assert_eq!(found(&format!("let {megabyte} = 1\n")).iter().map(|finding| finding.0).collect::<Vec<_>>(), ["E0129"]);
    assert_eq!(found(&format!("use \"{megabyte}\"\n")), []);
    holds(&"é@".repeat(50_000));
    holds(&format!("let a = {}\n", "a b ".repeat(50_000)));
    holds(&format!("task t on b {{ {} }}", "move to (1, 2 ".repeat(10_000)));
}

#[test]
fn failing_levels_do_not_double_the_work() {
    let nests = [
        ("a { x: (", ") $ }"),
        ("(a { x: ", "} $)"),
        ("a[b { x: 1 z[", "] to"),
        ("table {\n a\n (", ") $\n}"),
        ("[a {\n x:\n ", "} $ ]"),
    ];
    for (open, close) in nests {
        let levels = MAX_NESTING / open.matches(['(', '[', '{']).count();
        holds(&format!("let a = {}1{}\n", open.repeat(levels), close.repeat(levels)));
        holds(&format!("task t on b {{\n x: {}1{}\n}}\n", open.repeat(levels - 1), close.repeat(levels - 1)));
    }
}
