use super::*;
use crate::check::value::LeftOut;

const LIMITS: BoardLimits = BoardLimits { most_channel: 4095, most_side: 1000 };

fn board(text: &str) -> BoardFile {
    read("board", text, LIMITS).unwrap_or_else(|fault| panic!("the file {fault}"))
}

fn fault(text: &str) -> String {
    read("board", text, LIMITS).expect_err("no board")
}

/// Rows from the top, as a file has them.
fn rows(board: &BoardFile) -> Vec<Vec<Option<u32>>> {
    board.channels.chunks(board.columns as usize).rev().map(<[_]>::to_vec).collect()
}

#[test]
fn a_grid_of_pins_is_the_board() {
    let board = board(
        r#"{ "layout": { "grid": [[14, 15, null], [null, 3, 40], [null, null, 7]], "peripherals": [
            { "class": "reservoir", "id": 1, "electrodes": [{ "id": "A", "pin": 12 }, { "id": "B", "pin": 13 }] } ] } }"#,
    );
    assert_eq!(rows(&board), [[Some(14), Some(15), None], [None, Some(3), Some(40)], [None, None, Some(7)]]);
    assert_eq!(board.left_out.off_lattice, ["pin 12 (reservoir 1 A)", "pin 13 (reservoir 1 B)"]);
}

/// The second grid has another pitch and fewer electrodes.
#[test]
fn of_two_grids_the_larger_is_the_board() {
    let board = board(
        r#"{ "layout": { "grids": [
            { "origin": [7.5, 4.5], "pitch": 3.75, "pins": [[1, 2, 3], [4, null, 5], [6, 8, 9]] },
            { "origin": [4.375, 30.75], "pitch": 2.5, "pins": [[20, 21]] } ] } }"#,
    );
    assert_eq!(rows(&board), [[Some(1), Some(2), Some(3)], [Some(4), None, Some(5)], [Some(6), Some(8), Some(9)]]);
    assert_eq!(board.left_out.off_lattice, ["pin 20", "pin 21"]);
}

/// A list as OpenDrop's program writes it: trailing commas, a gate beside the field, two pads on one channel, a long
/// pad and one between places.
#[test]
fn a_list_of_rectangles_is_put_on_its_lattice() {
    let board = board(
        "[{\"x\":-2,\"y\":-2,\"h\":2,\"v\":2,\"e\":8,},{\"x\":-2,\"y\":0,\"h\":2,\"v\":2,\"e\":9},\n{\"x\":0,\"y\":-2,\"h\":2,\"v\":2,\"e\":16},\
         {\"x\":0,\"y\":0,\"h\":2,\"v\":2,\"e\":17},{\"x\":-4,\"y\":0,\"h\":2,\"v\":2,\"e\":0},{\"x\":-5,\"y\":-2,\"h\":2,\"v\":2,\"e\":1},\
         {\"x\":-5,\"y\":2,\"h\":2,\"v\":2,\"e\":1},{\"x\":2,\"y\":-2,\"h\":3,\"v\":2,\"e\":2},{\"x\":3,\"y\":1,\"h\":2,\"v\":2,\"e\":3,},]",
    );
    assert_eq!(rows(&board), [[None, Some(8), Some(16)], [Some(0), Some(9), Some(17)]]);
    assert_eq!(board.left_out.sharing, ["channel 1", "channel 1"]);
    assert_eq!(board.left_out.off_lattice, ["channel 2", "channel 3"]);
}

/// Electrodes with few neighbours: the nearest one of most of them lies diagonally, or farther away than a pitch.
#[test]
fn sparse_electrodes_are_put_on_their_lattice() {
    let list = |places: &[[u32; 2]]| {
        let electrode = |(channel, [x, y]): (usize, &[u32; 2])| {
            format!("{{\"x\":{},\"y\":{},\"h\":9,\"v\":9,\"e\":{channel}}}", 10 * x, 10 * y)
        };
        format!("[{}]", places.iter().enumerate().map(electrode).collect::<Vec<_>>().join(","))
    };
    let aslant = board(&list(&[[0, 0], [0, 1], [1, 3], [0, 4]]));
    assert_eq!(rows(&aslant), [[Some(0)], [Some(1)]]);
    assert_eq!(aslant.left_out.cut_off, ["channel 2", "channel 3"]);
    let apart = board(&list(&[[0, 0], [1, 0], [2, 0], [9, 0], [5, 5], [9, 5], [5, 9], [1, 9], [3, 7], [9, 9]]));
    assert_eq!(rows(&apart), [[Some(0), Some(1), Some(2)]]);
    assert_eq!(apart.left_out.cut_off.len(), 7);
}

/// Interdigitated outlines whose centres are off their places, a moved layer, and a reservoir.
#[test]
fn paths_with_channels_are_put_on_their_lattice() {
    let square = |id: &str, [x, y]: [f64; 2], channel: u32| {
        let path = format!("m {x},{y} h 1.6 v 1.63 l -1.6 0 z");
        format!("<path id=\"{id}\" d=\"{path}\" data-channels=\"{channel}\"/>")
    };
    let paths = [
        square("a", [9.22, 3.06], 57),
        square("b", [10.97, 3.0], 56),
        square("c", [12.71, 3.0], 60),
        square("d", [9.22, 4.75], 58),
        square("far", [6.2, 3.0], 52),
    ];
    let text = format!(
        "<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"><g transform=\"translate(1, -2.5)\">{}</g>\
         <path d=\"M 0 0 H 9\" id=\"outline\"/></svg>",
        paths.concat()
    );
    let board = board(&text);
    assert_eq!(rows(&board), [[Some(57), Some(56), Some(60)], [Some(58), None, None]]);
    assert_eq!(board.left_out.off_lattice, ["far"]);
}

/// Lines and columns are computed for messages alone: counted from the start of the file for each electrode, they would
/// take many minutes.
#[test]
fn a_large_picture_is_read_in_a_moment() {
    let square = |index: usize| {
        let [x, y] = [index % 100, index / 100].map(|place| place * 3);
        format!("<path d=\"m {x},{y} h 2 v 2 h -2 z\" data-channels=\"{}\"/>\n", index % 4_000)
    };
    let squares: String = (0..8_000).map(square).collect();
    let text = format!("<svg><!-- {} -->\n{squares}</svg>", "x\n".repeat(5_000_000));
    assert_eq!(board(&text).channels.iter().flatten().count(), 8_000);
}

/// A tail that overlaps its neighbours is left out, also where most distances are those to it.
#[test]
fn an_electrode_over_others_is_left_out() {
    let square = |(x, y): (f64, f64), channel: u32| {
        format!("<path id=\"p{channel}\" data-channels=\"{channel}\" d=\"M {x},{y} h 2 v 2 h -2 Z\"/>")
    };
    let squares = [((0.0, 0.0), 0), ((2.5, 0.0), 1), ((5.0, 0.0), 2), ((0.0, 2.5), 3), ((1.0, 0.0), 7)];
    let text = format!("<svg>{}</svg>", squares.map(|(at, channel)| square(at, channel)).concat());
    let board = board(&text);
    assert_eq!(rows(&board), [[Some(0), Some(1), Some(2)], [Some(3), None, None]]);
    assert_eq!(board.left_out, LeftOut { off_lattice: vec!["p7".to_owned()], ..LeftOut::default() });
}

/// Two columns with a gap between them: no droplet comes from one to the other.
#[test]
fn electrodes_of_the_lattice_that_are_cut_off_are_told_apart() {
    let board = board(r#"{ "layout": { "grid": [[1, null, 2], [3, null, 4], [5, null, null]] } }"#);
    assert_eq!(rows(&board), [[Some(1)], [Some(3)], [Some(5)]]);
    assert_eq!(board.left_out, LeftOut { cut_off: vec!["pin 2".to_owned(), "pin 4".to_owned()], ..LeftOut::default() });
}

/// What `--emit microdrop` writes is read back in `tests/binary`.
#[test]
fn outlines_of_any_words_have_bounds() {
    for (path, expected) in [
        ("M0,0L4-2.5z", Some([0.0, -2.5, 4.0, 0.0])),
        ("m 1 1 2 0 0 2", Some([1.0, 1.0, 3.0, 3.0])),
        ("M 1e1 0 a 2 2 0 0 1 4 4 Z l 1 0", Some([10.0, 0.0, 14.0, 4.0])),
        ("M 0 0 C 1 1 2 2 3 3 S 5 5 6 6 Q 1 1 2 9 T 4 4", Some([0.0, 0.0, 6.0, 9.0])),
        ("M 0 0 v 3.5.5 H 1", Some([0.0, 0.0, 1.0, 4.0])),
        ("M 0 0 H 9", None),
        ("M 0 0 L 1", None),
        ("M 0 0 L 1 1 Z 4", None),
        ("0 0 L 1 1", None),
        ("M 0 0 L 1e300 1e400", None),
        ("M 0 0 L 1e30 1", None),
        ("é 0 0", None),
        ("", None),
    ] {
        assert_eq!(paths::bounds(path), expected, "{path}");
    }
}

#[test]
fn what_is_no_board_says_where() {
    for (text, expected) in [
        (
            "{\n  \"layout\": { \"grid\": [[1, x]] } }",
            "is not a board of PurpleDrop, line 2, column 28: expected value",
        ),
        ("{}", "missing field `layout`"),
        ("{ \"layout\": 3 }", "invalid type: integer `3`, expected an object with `grid` or `grids`"),
        ("{ \"layout\": { \"grid\": [[\"a\"]] } }", "invalid type: string \"a\", expected a whole number from 0"),
        ("{ \"layout\": { \"grid\": [[-1]] } }", "invalid value: integer `-1`, expected a whole number from 0"),
        ("{ \"layout\": { \"grid\": [[1, 2], [3]] } }", "row 2 has a length of 1, but its first row has 2"),
        ("{ \"layout\": {} }", "no electrode with a channel"),
        ("[{\"x\":0,\"y\":0,\"h\":1,\"v\":1}]", "is not OpenDrop's electrodes, line 1, column 26: missing field `e`"),
        ("[{\"x\":0,\"y\":0,\"h\":0,\"v\":1,\"e\":4}]", "without an area, channel 4"),
        ("[{\"x\":0,\"y\":0,\"h\":1,\"v\":1,\"e\":5000}]", "a channel 5000"),
        ("[{\"x\":1e308,\"y\":0,\"h\":1e308,\"v\":1,\"e\":5}]", "without an area"),
        (
            "[{\"x\":0,\"y\":0,\"h\":1,\"v\":1,\"e\":5},{\"x\":7,\"y\":0,\"h\":1,\"v\":1,\"e\":5}]",
            "no electrode with a channel on a lattice",
        ),
        ("", "is empty"),
        ("\u{feff} \n", "is empty"),
        ("<svg>\n<path></svg>", "is not a picture, line 2"),
        ("<svg/>", "no electrode with a channel"),
        (
            "<svg>\n <path data-channels=\"x\" d=\"M 0 0 L 1 1\"/></svg>",
            "a channel `x`, which is not from 0 to 4095, line 2, column 2",
        ),
        ("<svg><path data-channels=\"4\" d=\"M 0 0\"/></svg>", "a path of `channel 4` that is not an outline"),
        ("<svg><path data-channels=\"4\" id=\"e\"/></svg>", "a path of `e` that is not an outline"),
        (
            "<svg><g transform=\"rotate(3)\"><path data-channels=\"4\" d=\"M 0 0 L 1 1\"/></g></svg>",
            "other than `translate`",
        ),
        ("<!DOCTYPE svg [<!ENTITY a \"b\">]><svg>&a;</svg>", "is not a picture"),
    ] {
        assert!(fault(text).contains(expected), "{text}: {}", fault(text));
    }
    let many = vec!["{\"x\":0,\"y\":0,\"h\":1,\"v\":1,\"e\":1}"; MAX_ELECTRODES + 1].join(",");
    assert!(fault(&format!("[{many}]")).contains("at most 8192"));
    let long: Vec<String> = (0..1001).map(|x| format!("{{\"x\":{x},\"y\":0,\"h\":1,\"v\":1,\"e\":{x}}}")).collect();
    assert!(fault(&format!("[{}]", long.join(","))).contains("1001 columns"));
}

/// Reading a broken text never panics, whatever is cut off or inserted.
#[test]
fn broken_texts_do_no_harm() {
    let texts = [
        r#"{ "layout": { "grid": [[14, 15], [null, 3]], "peripherals": [] } }"#,
        r#"[{"x":0,"y":0,"h":2,"v":2,"e":8,},{"x":2,"y":0,"h":2,"v":2,"e":9}]"#,
        "<svg><g transform=\"translate(1,2)\"><path id=\"é\" data-channels=\"4\" d=\"M0,0H1V1h-1z\"/></g></svg>",
    ];
    for text in texts {
        assert!(read("board", text, LIMITS).is_ok(), "{text}");
        for (at, _) in text.char_indices() {
            let _ = read("board", &text[..at], LIMITS);
            for odd in ["\"", "-", "9e999", "é", "\\", ",", "]", "<", "null", "\0"] {
                let _ = read("board", &format!("{}{odd}{}", &text[..at], &text[at..]), LIMITS);
            }
        }
    }
}
