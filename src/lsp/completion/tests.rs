//! Completions at positions of programs.

use super::*;
use crate::check::imports::FileFault;
use crate::device::Vocabulary;
use crate::lsp::words;
use crate::syntax::is_word;
use std::collections::BTreeSet;

/// A library with one file beside every program.
struct Beside;

impl Library for Beside {
    fn read(&self, _: &str, path: &str) -> Result<(String, String), FileFault> {
        let text = "use std.dimibot\nuse \"bench.twz\" as own\ndevice picker : dimibot.femto_st\nscene fibre { obstacle thread at (3 um, 4 um) }\n";
        if path == "bench.twz" { Ok((path.to_owned(), text.to_owned())) } else { Err("there is none".into()) }
    }
}

/// The completions at the mark `|`.
fn at(text: &str) -> Vec<String> {
    let at = text.find('|').expect("a mark");
    let shown = completions(&text.replacen('|', "", 1), at, &Beside);
    shown.into_iter().map(|item| item.label).collect()
}

const HEAD: &str = "use std.dimibot\nuse std.electrode_array as ea\ndevice bot : dimibot.femto_st\ndevice chip : ea.droplet_chip\n\
    output lamp : digital\nscene s { reservoir dye at (1, 2), part drop : ea.droplet, heater oven at (3, 3) }\n";

#[test]
fn what_is_offered_fits_the_place() {
    let in_task = |entry: &str| at(&format!("{HEAD}task go(goal: cell) on chip in s {{\n  {entry}|\n}}"));
    let cases: &[(Vec<String>, &[&str], &[&str])] = &[
        (at("use std.|"), &["dimibot", "instruments"], &["use"]),
        (at(&format!("{HEAD}dev|")), &["device", "task"], &["move", "bot"]),
        (at(&format!("{HEAD}device a : |")), &["bot", "dimibot", "ea", "microrobots"], &["lamp", "device"]),
        (at(&format!("{HEAD}device a : ea.|")), &["droplet_chip", "opendrop_v4"], &["droplet", "dimibot"]),
        (at(&format!("{HEAD}device a : bot {{ |")), &["left", "tip_radius"], &["columns", "lamp", "move"]),
        (at(&format!("{HEAD}task a on |")), &["bot", "chip"], &["lamp", "s"]),
        (at(&format!("{HEAD}task a on bot in |")), &["s"], &["bot"]),
        (at(&format!("{HEAD}scene t {{ |")), &["obstacle", "heater"], &["disc"]),
        (at(&format!("{HEAD}scene t {{ part p : |")), &["layout", "ea"], &["part"]),
        (
            at(&format!("{HEAD}task a on bot {{ |")),
            &["move", "visit", "precision", "start"],
            &["dispense", "assay", "bot"],
        ),
        (at(&format!("{HEAD}task a on bot {{ minimize |")), &["distance", "switches"], &["makespan", "bot"]),
        (in_task("minimize "), &["makespan"], &["distance"]),
        (in_task("dispense "), &["drop"], &["dye", "oven"]),
        (in_task("dispense drop "), &["from", "after"], &["to", "dye"]),
        (in_task("dispense drop from "), &["dye"], &["drop", "from"]),
        (in_task("heat drop at "), &["oven"], &["dye", "drop"]),
        (in_task("heat drop at oven "), &["to", "for"], &["at"]),
        (in_task("heat drop at oven to 95 "), &["degC", "for"], &["um"]),
        (in_task("move drop to "), &["goal", "max"], &["lamp", "dispense"]),
        (in_task("set "), &["lamp"], &["drop"]),
        (in_task("set lamp to "), &["high", "low"], &["lamp"]),
        (in_task("require "), &["steps", "drop"], &["distance"]),
        (in_task("wait 5 "), &["ms", "s"], &["um"]),
        (in_task("for i in 0..3 { mix drop for 2 s\n move drop to (i, "), &["i", "goal"], &["to"]),
        (in_task("using "), &[], &["move"]),
        (at(&format!("{HEAD}task go on bot {{ move to (1, 2) }}\nprogram p {{ run |")), &["go"], &["bot"]),
        (at("use \"bench.twz\" as lab\ntask a on |"), &["lab"], &["picker"]),
        (at("use \"bench.twz\" as lab\ntask a on lab.|"), &["picker"], &["fibre", "lab"]),
        (at("use \"bench.twz\" as lab\ntask a on lab.picker in lab.|"), &["fibre"], &["picker"]),
        (at("use \"bench.twz\" as lab\ntask a on lab.picker in lab.fibre { |"), &["visit"], &["dispense"]),
        (at("use \"bench.twz\"\ntask a on bench.|"), &["picker"], &["fibre"]),
        (at("use \"bench.twz\" as lab\ntask a on lab.own.|"), &[], &["picker"]),
        (at("task a(g: |"), &["cell", "time"], &["on"]),
        (at("// a |"), &[], &["device"]),
    ];
    for (number, (shown, wanted, unwanted)) in cases.iter().enumerate() {
        assert!(wanted.iter().all(|word| shown.iter().any(|known| known == word)), "{number}: {wanted:?} in {shown:?}");
        assert!(
            !unwanted.iter().any(|word| shown.iter().any(|known| known == word)),
            "{number}: {unwanted:?} in {shown:?}"
        );
    }
}

/// The words common to all programs.
fn words_of_the_language() -> BTreeSet<&'static str> {
    let vocabularies: Vec<&Vocabulary> = Kind::ALL.iter().map(|kind| kind.vocabulary()).collect();
    let known = words::known_words(&vocabularies, true).into_iter().map(|known| known.word);
    let common = DECLARATIONS.iter().chain(&COMMON_STEPS).map(|known| known.0);
    known.chain(common).chain(["to", "from", "via", "with", "among", "after", "within", "in", "on"]).collect()
}

/// The names that a program itself declares anywhere.
fn own_names(text: &str) -> BTreeSet<&str> {
    let words = text.split(|c| !is_word(c)).filter(|word| !word.is_empty()).collect::<Vec<_>>();
    let nouns: Vec<&str> = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().nouns).map(|noun| noun.name).collect();
    let declares = |word: &str| {
        nouns.contains(&word)
            || ["let", "device", "scene", "task", "program", "instrument", "output", "as", "use", "std"].contains(&word)
    };
    words.windows(2).filter(|pair| declares(pair[0])).map(|pair| pair[1]).collect()
}

/// Wherever an example contains a word of the language, completion offers it there.
#[test]
fn examples_can_be_written_by_it() {
    let language = words_of_the_language();
    for file in std::fs::read_dir("examples").expect("a folder").flatten() {
        let Ok(text) = std::fs::read_to_string(file.path()) else { continue };
        let own = own_names(&text);
        for (begin, _) in text.char_indices().filter(|(at, c)| is_word(*c) && !text[..*at].ends_with(is_word)) {
            let word = text[begin..].split(|c| !is_word(c)).next().expect("a word");
            if CursorPlace::behind(&text[..begin]).is_none() || !language.contains(word) || own.contains(word) {
                continue;
            }
            let line = text[..begin].lines().last().unwrap_or_default();
            assert!(
                completions(&text, begin, &Beside).iter().any(|item| item.label == word),
                "{}: {line}{word}",
                file.path().display()
            );
        }
    }
}
