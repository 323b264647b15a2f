//! The formatting rules, one by one.

use super::laws::{canonical, hold};

#[track_caller]
fn becomes(text: &str, canonical: &str) {
    assert_eq!(hold(text), canonical);
    assert_eq!(hold(canonical), canonical);
}

#[test]
fn blanks_and_commas() {
    becomes(
        "use std.dimibot\ndevice  bot:dimibot.femto_st{left:5,right : 5,}\ntask go(  ) on bot{wait(5ms),move to(1,2 , )}",
        "use std.dimibot\ndevice bot : dimibot.femto_st { left: 5, right: 5 }\ntask go() on bot { wait (5 ms), move to (1, 2) }\n",
    );
    becomes("task go on b {\n  move to (1, 1)\n\n\n,\n\n\n}\n", "task go on b {\n  move to (1, 1)\n}\n");
    becomes("device right:left{\n\n}\n", "device right : left { }\n");
    becomes("let a=-  1 um--2um\nlet b=[ ]\n", "let a = -1 um - -2 um\nlet b = []\n");
    becomes("let a = x^-2*(2 um)^2+3 um ^2\n", "let a = x^-2 * (2 um)^2 + 3 um ^ 2\n");
    becomes(
        "let a = 6 um/s\nlet b = 6 um /s\nlet c = 6um/2 s^-1\n",
        "let a = 6 um/s\nlet b = 6 um / s\nlet c = 6 um / 2 s^-1\n",
    );
    becomes(
        "task t on d {\n  for i in 0 .. n+1 { apply -1 }\n  apply state -2\n}\n",
        "task t on d {\n  for i in 0..n + 1 { apply -1 }\n  apply state - 2\n}\n",
    );
    becomes("task t on d { D[ i ,1 ] to p[0], visit[1] }\n", "task t on d { D[i, 1] to p[0], visit [1] }\n");
    becomes("\u{feff}let a = 1 µm\r\nlet b = 2 μm/s\r\n\r\n", "let a = 1 um\nlet b = 2 um/s\n");
    becomes("", "");
    becomes("\n \n", "");
}

#[test]
fn what_strings_hold_stays() {
    becomes("wiring w {  a[ 1 ].b->\"x  {2*i}  5µm // \"  }\n", "wiring w { a[1].b -> \"x  {2*i}  5µm // \" }\n");
}

#[test]
fn groups_and_comments() {
    becomes(
        "\n\n//first\n\n\n\n  let a=1 um\nlet b = [1,2,\n3,\n] //  third\n\n",
        &format!("//first\n\nlet a = 1 um\nlet b = [1, 2,\n{:<38}//  third\n", "         3]"),
    );
}

#[test]
fn blocks_over_several_lines() {
    becomes(
        "device a:b{left:5,// five\nright  :  6,/// doc\n\nhome:(1,\n2) }\n",
        "device a : b {\n  left:  5                            // five\n  right: 6\n  /// doc\n\n  home: (1,\n         2)\n}\n",
    );
    becomes(
        "scene s{obstacle a:disc{radius:1um}at(1 um,2um)\nobstacle long at pose(\n1um,\n2um,3deg)}\n",
        "scene s {\n  obstacle a    : disc { radius: 1 um } at (1 um, 2 um)\n  obstacle long at pose(\n    1 um,\n    2 um, 3 deg\n  )\n}\n",
    );
    becomes("let a =\n1 um+\n2 um\n", "let a =\n  1 um +\n  2 um\n");
    becomes(
        "let a = [1 // one\n,2 // two\n]\n",
        "let a = [1,                           // one\n         2                            // two\n        ]\n",
    );
}

#[test]
fn columns() {
    becomes(
        "device f:b{t:table{\nname|µ [V]|turning_radius[µm]// head\n\n\n// rows\nD1|1|-2\n D200 | (1+\n2) | 3\nD3|0.160mm|4}}\n",
        "device f : b {\n  t: table {\n    name | µ [V]    | turning_radius [um]    // head\n\n    // rows\n    D1   | 1        | -2\n    D200 | (1 +\n            2) | 3\n    D3   | 0.160 mm | 4\n  }\n}\n",
    );
    becomes(
        "wiring w{\na.set->\"1\"\nab.reset ->  \"2\"\n}\n",
        "wiring w {\n  a.set    -> \"1\"\n  ab.reset -> \"2\"\n}\n",
    );
    becomes(
        "device a:x{b:1}\ndevice long:x\n\ndevice c:x\n",
        "device a    : x { b: 1 }\ndevice long : x\n\ndevice c : x\n",
    );
    becomes("device a : x {\n  /// doc\n  long: 1\n  b:2\n}\n", "device a : x {\n  /// doc\n  long: 1\n  b: 2\n}\n");
}

#[test]
fn rows_of_a_list_end_in_the_same_columns() {
    becomes(
        "let a = [\n[none,3,4], // top\n[10,  -1, n+1]]\n",
        "let a = [\n  [none,  3,     4],                  // top\n  [  10, -1, n + 1]\n]\n",
    );
    becomes("let a = [\n[1,22],\n\n[333,4],\n[5,6]\n]\n", "let a = [\n  [1, 22],\n\n  [333, 4],\n  [  5, 6]\n]\n");
    // Not aligned: rows of different lengths, rows on one line, and rows with other than plain values.
    becomes("let a = [\n[1,2,3],\n[10,20]\n]\n", "let a = [\n  [1, 2, 3],\n  [10, 20]\n]\n");
    becomes("let a = [[1,2],[10,20]]\n", "let a = [[1, 2], [10, 20]]\n");
    becomes("let a = [\n[(1,2),3],\n[(10,20),30]\n]\n", "let a = [\n  [(1, 2), 3],\n  [(10, 20), 30]\n]\n");
}

#[test]
fn what_is_broken_stays_as_it_is() {
    let broken = "device  b : : x {\n left :5 }  // ?";
    let (text, errors) = canonical(&format!("let  a=1 um\n{broken}\n\n\nlet  c = 2um\n"));
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!(text, format!("let a = 1 um\n{broken}\n\nlet c = 2 um\n"));
    // An error between declarations.
    let stray = "let  a=1 um\n}\nlet  b=1 um\n";
    assert_eq!(canonical(stray).0, stray);
    let other = "what is\nthis file\nabout\nit has no\nprogram  in it\n";
    let (text, errors) = canonical(other);
    assert!(!errors.is_empty());
    assert_eq!(text, other);
}
