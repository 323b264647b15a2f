//! Every form of the language, parsed as intended.

use super::*;

/// A file with every form.
pub(super) const EVERYTHING: &str = r#"//! Every form.
//! Twice.
use std.dimibot
use std.electrode_array as ea
use "bench.twz" as lab

/// The pitch.
///
/// In two parts.
let pitch = 70 um / 2 + lab.gap[0]
let spots = [(11, 7), (13, 7),
  (3, 20),  // the last
]
let far = -2^2 * abs(pitch) <= 3 N*m, let flag = true

device bot : dimibot.femto_st {       // start from the published robot
  left:  5
  /// Five as well.
  right: 5, stroke: 35 um
  simultaneous: safe,
}
device copy : bot
device fleet : microrobots.bed {
  robots: table {
    robot | snap_down [V] | speed [um/s]

    D1    | 92            | 200   // first
    D2    | -5 mV         | pose(1, 2, 3)
  }
  margin: 5 V
}

scene bench {
  obstacle bead : disc { radius: 0.8 um } at (4.0 um, 2.5 um)
  /// A point.
  obstacle dust at (12, 7)
  part m1
}
scene dusty : bench {
  for i, p in spots { obstacle d[i] at p }
  for x in 0..2 { for y in 0..2 { obstacle e[x, y] at (x, y) } }
  obstacle fixed : cells { from: (20, 20), to: (23, 23) }
  obstacle rim  : polygon { points: [(9 um, 9 um), (12 um, 9 um),
                                     (9 um, 12 um)] }
}

task go(goal: cell, limit: time) on bot in lab.dusty {
  minimize distance
  require time <= limit * 2
  using astar { weight: 2, bound: none }
  precision: 0.25 um
  start at 0b10001_00010
  move to goal via (3, 9)
  apply state 2 for 3 s
  rotate bead by 80 deg about z
  visit [(1, 2), spots[0]]
  together { move m1 to (26, 31), move m[2] to (5, 3) }
  assemble {
    D3 to pose(1800 um, 1500 um, 90 deg)
    for i in 0..3 { D[i] to pose(i * 1 um, 1620 um, 270 deg) }
  }
  wait 10 ms
}
program errand { for p in spots { run go(p + (1, 1), 200 ms) }, wait 5 ms }
program day(n: number) { together { run errand, run swap }, run go((0, 0), 1 s) }
wiring bot {
  for i in 0..5 { bl[i].set -> "Dev1/port0/line{2*i}", bl[i].reset -> "Dev1/{{p}/line{2*i + 1}" }
  br0.set ->
    "Dev1"
}
"#;

#[test]
fn every_form_is_sound() {
    let tree = sound(EVERYTHING);
    assert_eq!(tree.items.len(), 16);
    assert_eq!(tree.doc.as_deref(), Some("Every form.\nTwice."));
    assert!(sound(&EVERYTHING.replace('\n', "\r\n")).items.len() == 16);
    sound(EVERYTHING.trim_end());
    sound(&format!("\u{feff}{EVERYTHING}"));
}

/// A value as text, fully bracketed.
fn shown(expr: &Expr) -> String {
    let list = |values: &[Expr]| values.iter().map(shown).collect::<Vec<_>>().join(", ");
    match &expr.kind {
        ExprKind::Number(number) => number.clone(),
        ExprKind::Quantity { number, unit } => format!("{number}_{}", unit.text),
        ExprKind::Word(word) => format!("word {word}"),
        ExprKind::Text(text) => text
            .parts
            .iter()
            .map(|part| match part {
                TextPart::Plain(plain) => plain.clone(),
                TextPart::Hole(value) => format!("<{}>", shown(value)),
            })
            .collect(),
        ExprKind::Bool(value) => value.to_string(),
        ExprKind::Path(path) => shown_path(path),
        ExprKind::Tuple(values) => format!("({})", list(values)),
        ExprKind::List(values) => format!("[{}]", list(values)),
        ExprKind::Range { from, to } => format!("{{{} .. {}}}", shown(from), shown(to)),
        ExprKind::Negative(value) => format!("{{-{}}}", shown(value)),
        ExprKind::Binary { left, operator, right, .. } => {
            format!("{{{} {} {}}}", shown(left), operator.symbol(), shown(right))
        }
        ExprKind::Call { function, arguments } => format!("{}({})", shown_path(function), list(arguments)),
        ExprKind::With { base, fields } => {
            let fields = fields.iter().map(|field| format!("{}: {}", field.name.text, shown(&field.value)));
            format!("{} {{ {} }}", shown_path(base), fields.collect::<Vec<_>>().join(", "))
        }
        ExprKind::Table(table) => format!("table of {} by {}", table.rows.len(), table.columns.len()),
        ExprKind::Error => "error".to_owned(),
    }
}

fn shown_path(path: &Path) -> String {
    let segment = |segment: &IndexedName| {
        let indices: Vec<_> = segment.indices.iter().map(shown).collect();
        if indices.is_empty() {
            segment.name.text.clone()
        } else {
            format!("{}[{}]", segment.name.text, indices.join(", "))
        }
    };
    path.segments.iter().map(segment).collect::<Vec<_>>().join(".")
}

#[test]
fn values_bind_as_written() {
    let cases = [
        ("35", "35"),
        ("10_000", "10000"),
        ("1e-3", "1e-3"),
        ("5 m", "5_m"),
        ("80um", "80_um"),
        ("35 µm", "35_µm"),
        ("5 %", "5_%"),
        ("35 um/s", "35_um/s"),
        ("3 N*m", "3_N*m"),
        ("2 s^-1", "2_s^-1"),
        ("70 um / 2 s", "{70_um / 2_s}"),
        ("6 um / s", "{6_um / s}"),
        ("6 um /s", "{6_um / s}"),
        ("5 um*2", "{5_um * 2}"),
        ("n * 1 um", "{n * 1_um}"),
        ("2^3^4", "{2 ^ {3 ^ 4}}"),
        ("-2^2", "{-{2 ^ 2}}"),
        ("2^-1 * 3", "{{2 ^ {-1}} * 3}"),
        ("- -a", "{-{-a}}"),
        ("-a * b", "{{-a} * b}"),
        ("a - b - c", "{{a - b} - c}"),
        ("a + b * c / d", "{a + {{b * c} / d}}"),
        ("a + 1 <= b * 2", "{{a + 1} <= {b * 2}}"),
        ("a == b != c", "{{a == b} != c}"),
        ("0..4", "{0 .. 4}"),
        ("1..n+1", "{1 .. {n + 1}}"),
        ("(a)", "a"),
        ("(a + b) * c", "{{a + b} * c}"),
        ("(1, 2)", "(1, 2)"),
        ("(1 um, 2, 3,)", "(1_um, 2, 3)"),
        ("[]", "[]"),
        ("[\n  1,\n  2\n]", "[1, 2]"),
        ("[1, [2], (3, 4)]", "[1, [2], (3, 4)]"),
        ("a.b[i, 2].c", "a.b[i, 2].c"),
        ("f()", "f()"),
        ("lab.f(1, a[2])", "lab.f(1, a[2])"),
        ("disc { radius: 2 um, to: (1, 2) }", "disc { radius: 2_um, to: (1, 2) }"),
        ("lab.disc { }", "lab.disc {  }"),
        ("0b10001_00010", "word 10001_00010"),
        ("true", "true"),
        ("truest", "truest"),
        ("\"a{{b{2*i}}\"", "a{b<{2 * i}>}"),
        ("\"\"", ""),
        ("1 +\n  // why\n  2", "{1 + 2}"),
        ("\n  // why\n  2 um", "2_um"),
        ("table {\n a | b [um]\n 1 | -2\n}", "table of 1 by 2"),
        ("table {\n a\n 1\n -2\n}", "table of 2 by 1"),
    ];
    for (written, meant) in cases {
        let tree = sound(&format!("let x = {written}\n"));
        let [Item::Let(item)] = tree.items.as_slice() else { panic!("{written}") };
        assert_eq!(shown(&item.value), meant, "{written}");
        let mut sink = Sink::default();
        let value = parse_value(FileId(0), written, &mut sink).map(|value| shown(&value));
        assert_eq!(value.as_deref(), Some(meant), "{written}");
    }
}

/// A step as text: head, indices, noun, object, phrases, and whether it has a block.
fn shown_step(step: &Step) -> String {
    let mut text = step.head.text.clone();
    step.indices.iter().for_each(|index| text.push_str(&format!("[{}]", shown(index))));
    step.noun.iter().for_each(|noun| text.push_str(&format!(" noun:{}", noun.text)));
    step.object.iter().for_each(|object| text.push_str(&format!(" object:{}", shown(object))));
    for phrase in &step.phrases {
        text.push_str(&format!(" {}:{}", phrase.preposition.text, shown(&phrase.value)));
    }
    if let Some(block) = &step.block {
        text.push_str(&format!(" block of {}", block.len()));
    }
    text
}

#[test]
fn steps_have_their_parts() {
    let cases = [
        ("move to (19, 28)", "move to:(19, 28)"),
        ("move m1 to (1, 2) via (3, 4)", "move object:m1 to:(1, 2) via:(3, 4)"),
        ("move m[i] to a", "move object:m[i] to:a"),
        ("apply state 2 for 3 s", "apply noun:state object:2 for:3_s"),
        ("apply state n for 3 s", "apply noun:state object:n for:3_s"),
        ("start at 0b1_0", "start at:word 1_0"),
        ("minimize distance", "minimize object:distance"),
        ("require time <= 400 ms", "require object:{time <= 400_ms}"),
        ("require 2 * energy < 3 mJ", "require object:{{2 * energy} < 3_mJ}"),
        ("using astar", "using object:astar"),
        ("using astar { weight: 2 }", "using object:astar { weight: 2 }"),
        ("together { run A, run B }", "together block of 2"),
        ("together { }", "together block of 0"),
        ("assemble fast { D3 to x }", "assemble object:fast block of 1"),
        ("D[i] to pose(1, 2, 3)", "D[i] to:pose(1, 2, 3)"),
        ("visit [a, b]", "visit object:[a, b]"),
        ("visit (1, 2)", "visit object:(1, 2)"),
        ("wait 10 ms", "wait object:10_ms"),
        ("wait n * 1 ms", "wait object:{n * 1_ms}"),
        ("rotate bead by -80 deg about z", "rotate object:bead by:{-80_deg} about:z"),
        ("orient bead to euler(1 deg, 2 deg, 3 deg)", "orient object:bead to:euler(1_deg, 2_deg, 3_deg)"),
        ("run go((0, 0), 1 s)", "run object:go((0, 0), 1_s)"),
        ("move 3 to (1, 2)", "move object:3 to:(1, 2)"),
        ("home", "home"),
    ];
    for (written, meant) in cases {
        let tree = sound(&format!("task t on b {{ {written} }}\n"));
        let [Item::Task(task)] = tree.items.as_slice() else { panic!("{written}") };
        let [Entry::Step(step)] = task.entries.as_slice() else { panic!("{written}: {:#?}", task.entries) };
        assert_eq!(shown_step(step), meant, "{written}");
    }
}

#[test]
fn a_loop_takes_its_braces_for_itself() {
    let tree = sound("task t on b { for p in list { home }\n for i, p in lab.list[0] { home, home } }\n");
    let [Item::Task(task)] = tree.items.as_slice() else { panic!() };
    let [Entry::For(one), Entry::For(two)] = task.entries.as_slice() else { panic!("{:#?}", task.entries) };
    assert_eq!((one.counter.is_none(), shown(&one.over), one.entries.len()), (true, "list".to_owned(), 1));
    assert_eq!((two.counter.is_some(), shown(&two.over), two.entries.len()), (true, "lab.list[0]".to_owned(), 2));
}

#[test]
fn docs_go_to_what_follows() {
    let tree = sound(EVERYTHING);
    let docs: Vec<_> = tree
        .items
        .iter()
        .filter_map(|item| match item {
            Item::Let(item) => item.doc.clone(),
            Item::Device(item) | Item::Instrument(item) | Item::Output(item) => {
                item.fields.iter().find_map(|field| field.doc.clone())
            }
            Item::Scene(item) => item.entries.iter().find_map(|entry| match entry {
                SceneEntry::Object(object) => object.doc.clone(),
                SceneEntry::For(_) | SceneEntry::Error(_) => None,
            }),
            Item::Use(_) | Item::Task(_) | Item::Program(_) | Item::Wiring(_) | Item::Error(_) => None,
        })
        .collect();
    assert_eq!(docs, ["The pitch.\n\nIn two parts.", "Five as well.", "A point."]);
}

#[test]
fn a_value_alone_may_be_refused() {
    for (text, code) in [("", "E0102"), ("80 um um", "E0102"), ("80um;", "E0104"), ("$", "E0118"), ("(1, 2", "E0114")] {
        let mut sink = Sink::default();
        assert!(parse_value(FileId(0), text, &mut sink).is_none(), "{text}");
        let codes: Vec<_> = sink.sorted().iter().map(|finding| finding.code.name()).collect();
        assert_eq!(codes, [code], "{text}");
    }
}
