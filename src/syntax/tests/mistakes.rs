//! One finding per mistake, at its place, and nothing around it is lost.

use super::*;

/// Texts with a mistake, the expected code, and the text that the finding points at.
const ENTRIES: &[(&str, &str, &str)] = &[
    // in a task
    ("move to (1, 2) move to (3, 4)", "E0103", "move"),
    ("run A run B", "E0103", "run"),
    ("wait 5 ms wait 5 ms", "E0103", "wait"),
    ("precision: 1 um move to (1, 2)", "E0103", "move"),
    ("left: 5 right: 5", "E0103", "right"),
    ("move to (1, 2);", "E0104", ";"),
    ("move to (1, 2); wait 5 ms", "E0104", ";"),
    ("together\n{ run A, run B }", "E0105", "{"),
    ("for i in 0..3\n\n{ move to (i, 2) }", "E0105", "{"),
    ("move to a\n  + b", "E0106", "+"),
    ("precision: 1 um\n  // why\n  * 2", "E0106", "*"),
    ("require time\n  <= 4 s", "E0106", "<="),
    ("* 3", "E0106", "*"),
    ("move m1\n  to (1, 2)", "E0107", "to"),
    ("move to (1, 2)\n  via (3, 4)", "E0107", "via"),
    ("together { run A }\n to (1, 2)", "E0107", "to"),
    ("move to spots [1]", "E0108", " ["),
    ("move to pose (1, 2, 3)", "E0108", " ("),
    ("run go (1)", "E0108", " ("),
    ("move to (1, 2) /// far", "E0109", "/// far"),
    ("/// far\n  move to (1, 2)", "E0109", "/// far"),
    ("left: 1\n  /// nothing", "E0109", "/// nothing"),
    ("left: 1\n  //! late", "E0109", "//! late"),
    ("for in in list { wait 1 s }", "E0110", "in"),
    ("move to (3, 4))", "E0112", ")"),
    ("move to 3]", "E0112", "]"),
    ("move to (3, 4", "E0114", "("),
    ("move to [(3, 4), (5, 6)", "E0114", "["),
    ("visit [(3, 4), (5, 6]", "E0114", "("),
    ("visit [\n (3, 4),\n (5, 6)", "E0114", "["),
    ("together { move m1 to (1, 2, move m2 to (3, 4) }", "E0114", "("),
    ("name: \"abc", "E0115", "\"abc"),
    ("precision: .5 um", "E0116", ".5"),
    ("precision: 5. um", "E0116", "5."),
    ("precision: 1e um", "E0116", "1e"),
    ("precision: 1e- um", "E0116", "1e-"),
    ("precision: 1.2.3 um", "E0116", "1.2.3"),
    ("precision: 1e999 um", "E0116", "1e999"),
    ("start at 0b12", "E0116", "0b12"),
    ("start at 0b", "E0116", "0b"),
    ("start at 0x1F", "E0116", "0x1F"),
    ("move to (1, 2) @", "E0118", "@"),
    ("move to (1, 2) & wait 3 s", "E0118", "&"),
    ("require time ≤ 3 s", "E0118", "≤"),
    ("angle: 80°", "E0118", "°"),
    ("name: “abc”", "E0118", "“abc”"),
    ("name: 'abc'", "E0118", "'abc'"),
    ("name: ‘a{b’", "E0118", "‘a{b’"),
    ("wait\u{a0}5 ms", "E0118", "\u{a0}"),
    ("wait 3 !", "E0118", "!"),
    ("precision = 1 um", "E0119", "="),
    ("precision := 1 um", "E0119", ":="),
    ("using astar { weight 2, bound: 3 }", "", ""),
    ("if a < b { move to (1, 2), wait .5 s }", "E0122", "if"),
    ("while x { move to (1, 2) }", "E0122", "while"),
    ("if (a) {\n move to (1, 2);\n } else {\n wait 1 s\n }", "E0122", "if"),
    ("for (i = 0; i < 3; i++) { move to (1, 2) }", "E0122", "for (i = 0; i < 3; i++)"),
    ("let x = 3", "E0123", "let"),
    ("  device x : y { left: 5 }", "E0123", "device"),
    ("name: \"{}\"", "E0126", "{}"),
    ("name: \"{1 2}\"", "E0126", "{1 2}"),
    ("name: \"{ a\"", "E0126", "{"),
    ("move to (1, 2, 3, 4)", "E0127", "(1, 2, 3, 4)"),
    ("move to (1, 2) via (3, 4), (5, 6)", "E0127", "(3, 4), (5, 6)"),
    ("precision:", "E0102", "precision:"),
    ("precision:\n  left: 5", "E0102", "precision:"),
    ("precision:\n  move to (1, 2)", "E0102", "precision:"),
    ("precision: 3 +", "E0102", "+"),
    ("precision: 3 + * 4", "E0102", "+"),
    ("precision: 3 +\n  left: 5", "E0102", "+"),
    ("move to", "E0102", "to"),
    ("move to // where", "E0102", "to"),
    ("move to via (1, 2)", "E0102", "to"),
    ("visit [1, , 2]", "E0102", ","),
    ("move to ()", "E0102", "("),
    ("name: \"{2*}\"", "E0102", "*"),
    ("this is not a step at all", "E0101", "a"),
    ("run A move m1 to goal", "E0101", "m1"),
    ("visit [(1, 2) (3, 4)]", "E0101", "("),
    ("visit [\n (1, 2)\n (3, 4)\n]", "E0101", "("),
    ("{ move to (1, 2) }", "E0105", "{"),
    ("42", "E0101", "42"),
    ("# far away", "E0125", "#"),
    ("wait 3 s /* far\n away */", "E0125", "/*"),
    ("rows: table {\n a | b [um]\n 1 | 2\n 3\n 4 | 5\n}", "E0117", "3"),
    ("rows: table {\n a | b [um]\n 1 | 2 | 3\n 4 | 5\n}", "E0117", "1 | 2 | 3"),
    ("rows: table {\n a | b [um]\n 1 | 2,\n 4 | 5\n}", "E0128", "1 | 2,"),
    ("rows: table {\n a | [um]\n 1 | 2\n 4 | 5\n}", "E0128", "a | [um]"),
    ("rows: table {\n a | b\n 1 | \n}", "E0102", "|"),
];

#[test]
fn a_mistake_in_a_task_is_found_once_and_leaves_its_neighbours() {
    for (entry, code, place) in ENTRIES {
        let text =
            format!("task t on bot {{\n  minimize time\n  {entry}\n  wait 7 ms\n}}\ntask u on bot {{ wait 1 s }}\n");
        let expected: Vec<_> = (!code.is_empty()).then(|| (*code, (*place).to_owned())).into_iter().collect();
        assert_eq!(found(&text), expected, "{text}");
        let (tree, _) = read(&text);
        let [Item::Task(task), Item::Task(_)] = tree.items.as_slice() else { panic!("{text}\n{tree:#?}") };
        let head = |entry: &'_ Entry| match entry {
            Entry::Step(step) => Some(step.head.text.clone()),
            Entry::Field(_) | Entry::For(_) | Entry::Error(_) => None,
        };
        let heads: Vec<_> = task.entries.iter().filter_map(head).collect();
        assert_eq!(heads.first().map(String::as_str), Some("minimize"), "{text}");
        assert_eq!(heads.last().map(String::as_str), Some("wait"), "{text}");
    }
}

/// Whole files with a mistake, the expected code, and the text that the finding points at.
const FILES: &[(&str, &str, &str)] = &[
    ("let a = 1 let b = 2\n", "E0103", "let"),
    ("let a = 1;\n", "E0104", ";"),
    ("scene s\n{\n}\n", "E0105", "{"),
    ("device a : b\n{ left: 5 }\n", "E0105", "{"),
    ("let a = 3\n+ 4\n", "E0106", "+"),
    ("let a = b [1]\n", "E0108", " ["),
    ("task t (p: cell) on b { wait 1 s }\n", "E0108", " ("),
    ("let a = 1 /// one\n", "E0109", "/// one"),
    ("let a = 1\n//! late\n", "E0109", "//! late"),
    ("/// nothing\nuse std.dimibot\n", "E0109", "/// nothing"),
    ("let a = 1\n/// at the end", "E0109", "/// at the end"),
    ("let table = 1\n", "E0110", "table"),
    ("task t(at: cell) on b { wait 1 s }\n", "E0110", "at"),
    ("use std.dimibot as in\n", "E0110", "in"),
    ("devise a : b { left: 5 }\n", "E0111", "devise"),
    ("Task t on b { wait 1 s }\n", "E0111", "Task"),
    ("lett a = 1\n", "E0111", "lett"),
    ("pitch = 70 um\n", "E0111", "pitch"),
    ("robot a : b { left: 5 }\n", "E0111", "robot"),
    ("let a = 1\n}\n", "E0112", "}"),
    ("let a = 1)\n", "E0112", ")"),
    ("scene s {\n  obstacle a at (1, 2)\n\nlet a = 1\n", "E0113", "{"),
    ("scene s {\n  obstacle a at (1, 2)\n", "E0113", "{"),
    ("scene s {", "E0113", "{"),
    ("let a = (1, 2\nlet b = 3\n", "E0114", "("),
    ("let a = [1,\n  2,\nlet b = 3\n", "E0114", "["),
    ("let a = (1, 2", "E0114", "("),
    ("use \"a.twz\n", "E0115", "\"a.twz"),
    ("let a = 1.\n", "E0116", "1."),
    ("let a = ?\n", "E0118", "?"),
    ("\u{1}\n", "E0118", "\u{1}"),
    ("let a : 3\n", "E0119", ":"),
    ("let a := 3\n", "E0119", ":="),
    ("device a : b { left = 5 }\n", "E0119", "="),
    ("device a : b { left 5 }\n", "E0119", "left"),
    ("import std.dimibot\n", "E0122", "import"),
    ("def go(x) {\n  return x;\n}\n", "E0122", "def"),
    ("const a = 3;\n", "E0122", "const"),
    ("device bot dimibot { left: 5 }\n", "E0124", "dimibot"),
    ("device bot : x\ntask a bot { wait 1 s }\n", "E0124", "bot"),
    ("device bot : x\ntask a onbot { wait 1 s }\n", "E0124", "onbot"),
    ("task t in b { wait 1 s }\n", "E0124", "in"),
    ("task t {\n  wait 1 s\n}\n", "E0124", "t"),
    ("program (p) { wait 1 s }\n", "E0124", "("),
    ("device : x { left: 5 }\n", "E0124", ":"),
    ("scene a, b { }\n", "E0124", ", b"),
    ("use\n", "E0124", "use"),
    ("use std.dimibot also\n", "E0124", "std.dimibot also"),
    ("let = 3\n", "E0124", "="),
    ("let a\n", "E0124", "a"),
    ("let a = 3 4\n", "E0124", "4"),
    ("/* a\n b */\nlet a = 1\n", "E0125", "/*"),
    ("/* a\nlet a = 1\n", "E0125", "/*"),
    ("let a =\nlet b = 2\n", "E0102", "="),
    ("let a = 3 +\nlet b = 2\n", "E0102", "+"),
    ("let a =\n", "E0102", "="),
    ("let a = -", "E0102", "-"),
    ("device a : b { left: , right: 5 }\n", "E0102", "left:"),
    ("move to (1, 2)\n", "E0101", "move to (1, 2)"),
    ("for i in 0..3 { move to (1, 2) }\n", "E0101", "for"),
    ("scene s { left: 5 }\n", "E0101", "left: 5"),
    ("scene s { obstacle }\n", "E0101", "obstacle"),
    ("scene s { obstacle at (1, 2) }\n", "E0110", "obstacle"),
    ("scene s { obstacle a at (1, 2) b }\n", "E0101", "b"),
    ("scene s { obstacle a at }\n", "E0102", "at"),
    ("scene s { obstacle a : disc { radius: 1 um }\n  at (1, 2) }\n", "E0107", "at"),
    ("scene s {\n  obstacle a at (1, 2)\n  if x { obstacle b at (1, 2) }\n}\n", "E0122", "if"),
    ("wiring b { bl0.set -> }\n", "E0102", "->"),
    ("wiring b { bl0.set -> a/b }\n", "E0101", "a/b"),
    ("wiring b { bl0.set \"a\" }\n", "E0101", "\"a\""),
    ("wiring b { bl0.set -> \"a }\nlet a = 1\n", "E0115", "\"a"),
];

#[test]
fn a_mistake_in_a_file_is_found_once() {
    for (text, code, place) in FILES {
        let expected = vec![(*code, (*place).to_owned())];
        assert_eq!(found(text), expected, "{text}");
    }
}

#[test]
fn a_missing_colon_is_reported_beside_another_mistake_of_its_line() {
    let text = "scene s { obstacle a : disc { radius 1 um } at (3 um, 4 um) obstacle b at (1, 1) }\n";
    assert_eq!(found(text), [("E0119", "radius".to_owned()), ("E0103", "obstacle".to_owned())]);
}

/// Eleven different mistakes; a misspelt verb and an unknown unit are left to later stages.
const ELEVEN: &str = r#"//! Eleven mistakes.
use std.dimibot

devise bot : dimibot.femto_st {
  left:
  right: 5
}

device fleet : dimibot.femto_st {
  robots: table {
    robot | speed [um/s]
    D1    | 200
    D2
    D3    | 210
  }
}

scene bench {
  obstacle bead = disc { radius: 0.8 um } at (4.0 um, 2.5 um)
  obstacle dust at (12, 7
  obstacle rim at (1, 2)
}

task fetch on bot in bench {
  minimize distance;
  mvoe to (3, 4)
  this is a stray line of text
  wait 5 parsecs
  move to (19, 28) move to (3, 4)
  together {
    wait 5 ms

task back on bot in bench { move to (0, 0) }
}

wiring bot {
  bl0.set -> "Dev1/port0
  bl0.reset -> "Dev1/port1"
}
"#;

#[test]
fn mistakes_of_eleven_sorts_are_eleven_findings_in_order() {
    let expected = [
        ("E0111", "devise"),
        ("E0102", "left:"),
        ("E0117", "D2"),
        ("E0119", "="),
        ("E0114", "("),
        ("E0104", ";"),
        ("E0101", "stray"),
        ("E0103", "move"),
        ("E0113", "{"),
        ("E0112", "}"),
        ("E0115", "\"Dev1/port0"),
    ];
    let expected: Vec<_> = expected.iter().map(|(code, place)| (*code, (*place).to_owned())).collect();
    assert_eq!(found(ELEVEN), expected);
}

#[test]
fn what_stands_around_the_mistakes_is_in_the_tree() {
    let (tree, _) = read(ELEVEN);
    let [
        Item::Use(_),
        Item::Device(bot),
        Item::Device(fleet),
        Item::Scene(bench),
        Item::Task(fetch),
        Item::Task(back),
        Item::Wiring(wiring),
    ] = tree.items.as_slice()
    else {
        panic!("{:#?}", tree.items)
    };
    let names = |fields: &[Field]| fields.iter().map(|field| field.name.text.clone()).collect::<Vec<_>>();
    assert_eq!((bot.name.text.as_str(), names(&bot.fields)), ("bot", vec!["left".to_owned(), "right".to_owned()]));
    let ExprKind::Table(table) = &fleet.fields[0].value.kind else { panic!() };
    assert_eq!(table.rows.iter().map(|row| row.cells.len()).collect::<Vec<_>>(), [2, 2, 2]);
    assert!(matches!(bench.entries.as_slice(), [SceneEntry::Object(_), SceneEntry::Object(_), SceneEntry::Object(_)]));
    let heads = fetch.entries.iter().map(|entry| match entry {
        Entry::Step(step) => step.head.text.as_str(),
        Entry::Field(_) => "field",
        Entry::For(_) => "for",
        Entry::Error(_) => "error",
    });
    assert_eq!(heads.collect::<Vec<_>>(), ["minimize", "mvoe", "error", "wait", "move", "move", "together"]);
    assert_eq!(back.entries.len(), 1);
    assert!(matches!(wiring.entries.as_slice(), [WiringEntry::Error(_), WiringEntry::Wire(_)]));
}

#[test]
fn no_rule_of_the_grammar_is_shown() {
    let texts = ENTRIES.iter().map(|(entry, ..)| format!("task t on bot {{\n  {entry}\n}}\n"));
    let texts = texts.chain(FILES.iter().map(|(text, ..)| (*text).to_owned())).chain([ELEVEN.to_owned()]);
    let rules: Vec<String> =
        Rule::all_rules().iter().map(|rule| format!("{rule:?}")).filter(|name| name.contains('_')).collect();
    for text in texts {
        for finding in read(&text).1 {
            let words = [finding.title.clone(), finding.help.clone().unwrap_or_default()];
            let labels = finding.labels.iter().map(|label| label.text.clone());
            for words in words.into_iter().chain(labels) {
                assert!(!words.is_empty() && !rules.iter().any(|rule| words.contains(rule.as_str())), "{finding:?}");
            }
            assert!(
                finding.title.starts_with(|c: char| !c.is_uppercase()) && !finding.title.ends_with('.'),
                "{finding:?}"
            );
        }
    }
}

#[test]
fn the_name_of_a_broken_declaration_is_kept() {
    let (tree, _) = read("task go o bot { wait 1 s }\nlet a = 3 4\nrobot x : y { }\n");
    let names: Vec<_> = tree.broken_names.iter().map(|name| name.text.as_str()).collect();
    assert_eq!(names, ["go", "a", "x"]);
}
