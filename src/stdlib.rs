//! The standard library: published devices and instruments, written in the language, embedded in the binary.

const FILES: &[(&str, &str)] = &[
    ("dimibot", include_str!("../stdlib/dimibot.twz")),
    ("electrode_array", include_str!("../stdlib/electrode_array.twz")),
    ("fingers", include_str!("../stdlib/fingers.twz")),
    ("instruments", include_str!("../stdlib/instruments.twz")),
    ("microrobots", include_str!("../stdlib/microrobots.twz")),
];

/// The text of the module `std.<name>`; `None` if there is none.
pub fn file(name: &str) -> Option<&'static str> {
    FILES.iter().find(|file| file.0 == name).map(|file| file.1)
}

/// The names of its modules, without `std.`.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|file| file.0)
}

/// The only file that declares something of this sort and name, such as `device`, `opendrop_v4`.
pub fn declaring(sort: &str, name: &str) -> Option<&'static str> {
    let declares = |text: &str| {
        text.lines()
            .map(str::split_whitespace)
            .any(|mut words| words.next() == Some(sort) && words.next() == Some(name))
    };
    let mut found = FILES.iter().filter(|(_, text)| declares(text)).map(|(file, _)| *file);
    found.next().filter(|_| found.next().is_none())
}
