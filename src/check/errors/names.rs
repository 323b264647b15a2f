//! Names: E02xx.

use super::{either, listed, with_article};
use crate::check::imports::FileFault;
use crate::check::scope::{Declaration, DeclarationSort, path_text};
use crate::check::value::ObjectName;
use crate::device::shape::ShapeForm;
use crate::device::{Assay, Together, Vocabulary, condition_of_any_kind};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::Unit;
use crate::source::Span;
use crate::stdlib;
use crate::syntax::functions::{function_names, is_function};
use crate::syntax::tree::{Field, Ident, Path};
use std::collections::BTreeSet;

pub fn unknown_name(span: Span, name: &str, sort: DeclarationSort, near: Option<&str>) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0201, format!("no {} is named `{name}`", sort.name()))
        .label(span, if name.contains('.') { "not declared in that file" } else { "not declared in this file" });
    match near {
        Some(near) => diagnostic.near(near),
        None => diagnostic.help_if(match sort {
            _ if name.contains('.') => None,
            DeclarationSort::Let if is_function(name) => {
                Some(format!("arguments go in round brackets: write `{name}(…)`"))
            }
            DeclarationSort::Let if matches!(name, "pi" | "Pi" | "PI") => {
                Some("angles have units: write `180 deg`, or `3.14159265 rad`".to_owned())
            }
            DeclarationSort::Let if Unit::parse(name).is_ok() => {
                Some(format!("a unit follows a number: write `1 {name}`"))
            }
            DeclarationSort::Let => {
                Some(format!("define it at the top of a file, `let {name} = …`, or make it a parameter of a task"))
            }
            DeclarationSort::Device => {
                Some(format!("declare it: `device {name} : KIND {{ … }}`; `tweeze devices` lists the kinds"))
            }
            DeclarationSort::Instrument => {
                Some(format!("declare it: `instrument {name} : FAMILY {{ … }}`; `tweeze devices` lists the families"))
            }
            DeclarationSort::Output => Some(format!(
                "declare it: `output {name} : digital` for `set`, or `output {name} : trigger {{ duration: 5 ms }}` for `pulse`"
            )),
            DeclarationSort::Scene if matches!(name, "None" | "none" | "null" | "nothing" | "empty") => {
                Some(format!("leave `in {name}` out: without it there are no obstacles"))
            }
            DeclarationSort::Scene => Some(format!("declare it: `scene {name} {{ … }}`")),
            DeclarationSort::Task => Some(format!("declare it: `task {name} on DEVICE {{ … }}`")),
            DeclarationSort::Program => Some(format!("declare it: `program {name} {{ … }}`")),
        }),
    }
}

/// The name of an object of a scene where a value belongs.
pub fn object_for_place(span: Span, noun: &str, declared: &Ident) -> Diagnostic {
    let name = &declared.text;
    Diagnostic::new(Code::E0201, format!("`{name}` is {} of a scene, not a value", with_article(noun)))
        .label(span, "a value belongs here")
        .label_elsewhere(declared.span, span, "declared here")
        .help("an object's name does not stand for its position: write the cell or the place, as `(10, 6)`")
}

/// Help that lists what a used file declares; `None` if that is nothing.
pub fn declared_there<'a>(names: impl Iterator<Item = &'a str>) -> Option<String> {
    let names: Vec<&str> = names.take(MAX_LISTED).collect();
    (!names.is_empty()).then(|| format!("it declares {}", listed(names.into_iter())))
}

/// Most names that a help lists.
const MAX_LISTED: usize = 12;

pub fn unknown_function(span: Span, name: &str, near: Option<&str>) -> Diagnostic {
    let near = match name {
        "len" | "length" | "numel" | "size" => Some("count"),
        "fabs" => Some("abs"),
        "sind" | "cosd" => None,
        _ => near,
    };
    let known = match name {
        "range" | "linspace" | "arange" => "a range is `0..4`: 0, 1, 2, 3".to_owned(),
        "sind" => "write `sin` and the unit of the angle, as in `sin(30 deg)`".to_owned(),
        "cosd" => "write `cos` and the unit of the angle, as in `cos(60 deg)`".to_owned(),
        _ => format!("the functions are {}", listed(function_names())),
    };
    Diagnostic::new(Code::E0201, format!("no function is named `{name}`"))
        .label(span, "not a function")
        .near_or(near, known)
}

/// `s(1)`, as other languages write an index.
pub fn index_in_round_brackets(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0201, format!("`{name}` is a value, not a function"))
        .label(span, "followed by round brackets")
        .help(format!("write an index in `[ ]`, counted from 0: the first element is `{name}[0]`"))
}

pub fn unknown_shape(span: Span, name: &str, near: Option<&str>) -> Diagnostic {
    let known = format!("the shapes are {}", listed(ShapeForm::ALL.iter().map(|form| form.name())));
    Diagnostic::new(Code::E0201, format!("no shape is named `{name}`"))
        .label(span, "neither a shape nor a value of this file")
        .near_or(shape_synonym(name).or(near), known)
}

/// The shape for a synonym that other programs use.
fn shape_synonym(name: &str) -> Option<&'static str> {
    Some(match name.to_lowercase().as_str() {
        "circle" | "round" | "dot" => "disc",
        "rect" | "rectangle" | "square" | "bar" | "cuboid" => "box",
        "sphere" | "ball" | "bead" => "ellipsoid",
        "line" | "rod" | "stick" | "segment" => "capsule",
        "poly" | "triangle" | "points" => "polygon",
        "stl" | "file" | "model" => "mesh",
        _ => return None,
    })
}

/// A file's name alone, where one of the names in the file belongs.
pub fn file_for_value(span: Span, name: &str, used: Span, sort: DeclarationSort) -> Diagnostic {
    Diagnostic::new(Code::E0206, format!("`{name}` is an imported file, but {} is expected here", sort.describe()))
        .label(span, format!("{} is expected here", sort.describe()))
        .label(used, "imported here")
        .help(format!("name one from that file, as in `{name}.…`"))
}

/// A base that is neither a declaration of the sort nor one of its kinds or families.
pub fn unknown_base(span: Span, name: &str, sort: DeclarationSort, near: Option<&str>, roots: &[&str]) -> Diagnostic {
    let (kinds, title) = match sort {
        DeclarationSort::Instrument => {
            ("families", format!("no instrument or family of instruments is named `{name}`"))
        }
        DeclarationSort::Output => ("sorts", format!("no output or sort of outputs is named `{name}`")),
        DeclarationSort::Let
        | DeclarationSort::Device
        | DeclarationSort::Scene
        | DeclarationSort::Task
        | DeclarationSort::Program => ("kinds", format!("no device or device kind is named `{name}`")),
    };
    let known = format!("the {kinds} are {}; `tweeze devices` lists what they offer", listed(roots.iter().copied()));
    Diagnostic::new(Code::E0201, title).label(span, "not declared in this file").near_or(near, known)
}

/// A used file under the name that it would have without its `as`.
pub fn file_used_as(path: &Path, alias: &str, used: Span) -> Diagnostic {
    let words: Vec<&str> = path.segments.iter().skip(1).map(|segment| segment.name.text.as_str()).collect();
    let file = &path.segments[0];
    Diagnostic::new(Code::E0201, format!("no file is imported as `{}`", file.name.text))
        .label(file.span, "not the name of a `use`")
        .label(used, format!("imported as `{alias}`"))
        .help(format!("write `{alias}.{}`", words.join(".")))
        .with_fix_here(alias)
}

/// A name before a dot that no `use` gives, in a path to something of a sort.
pub fn unknown_file(path: &Path, sort: DeclarationSort, near: Option<&str>) -> Diagnostic {
    let file = &path.segments[0];
    let (span, alias) = (file.span, &file.name.text);
    let word = path.segments.get(1).map(|word| word.name.text.as_str());
    let keyword = if sort == DeclarationSort::Let { "let" } else { sort.name() };
    let file = match (stdlib::file(alias), word.and_then(|word| stdlib::declaring(keyword, word))) {
        (Some(_), _) => format!("use std.{alias}"),
        (None, Some(file)) => format!("use std.{file} as {alias}"),
        (None, None) => format!("use \"{alias}.twz\""),
    };
    let mend = format!("the name before a dot must be an imported file: write `{file}` at the top");
    Diagnostic::new(Code::E0201, format!("no file is imported as `{alias}`"))
        .label(span, "not the name of a `use`")
        .near_or(near, mend)
}

pub fn shape_without_fields(span: Span, form: ShapeForm) -> Diagnostic {
    let fields: Vec<String> = form.fields().iter().map(|field| format!("{}: …", field.name)).collect();
    Diagnostic::new(Code::E0401, format!("`{}` lacks its fields", form.name())).label(span, "how large?").help(format!(
        "write `{} {{ {} }}`",
        form.name(),
        fields.join(", ")
    ))
}

pub fn declared_twice(name: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0202, format!("`{name}` is declared twice"))
        .label(span, "declared again here")
        .label(earlier, "first declared here")
        .help("a name may be declared only once in a file, inner blocks included")
}

pub fn reserved_name(name: &Ident, reserved_as: &str) -> Diagnostic {
    Diagnostic::new(Code::E0203, format!("`{}` is reserved: it names {reserved_as}", name.text))
        .label(name.span, "cannot be declared")
        .help(format!("choose another name, as `my_{}`", name.text))
}

/// `chain` are the files that led here, the program's own first.
pub fn unusable_file(span: Span, path: &str, fault: &FileFault, chain: &[String]) -> Diagnostic {
    let (why, help) = match (fault, chain) {
        (FileFault::NoSurface(why), _) => return super::bad_mesh(span, path, why),
        (FileFault::NotText(why), _) => (why, "save it as text in UTF-8".to_owned()),
        (FileFault::LongMesh(why), _) => {
            (why, "write the solid with fewer triangles: about 100,000 reach this length".to_owned())
        }
        (FileFault::Unread(why), [_, _, ..]) => (why, format!("it is used by {}", chain.join(" → "))),
        (FileFault::Unread(why), [_] | []) => (why, "the path is relative to the folder of this file".to_owned()),
    };
    Diagnostic::new(Code::E0204, format!("`{path}` cannot be used: {why}")).label(span, "used here").help(help)
}

/// `use "std.dimibot"`, `use "dimibot.twz"`: a file of the library in quotes.
pub fn library_in_quotes(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0204, "a file of the standard library is named in quotes")
        .label(span, "quotes are for the path of a file of your own")
        .help(format!("write `use std.{name}`"))
        .with_fix_here(format!("std.{name}"))
}

pub fn unknown_library(span: Span, name: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let finding =
        Diagnostic::new(Code::E0204, format!("the standard library has no `{name}`")).label(span, "used here");
    if let Some(file) = name.strip_suffix(".twz") {
        if known.contains(&file) {
            return finding.help(format!("write `use {file}`: its files have no extension")).with_fix_here(file);
        }
        return finding
            .help(format!("write `use \"{name}\"` for a file of your own"))
            .with_fix_here(format!("\"{name}\""));
    }
    finding.near_or(near, format!("the standard library has {}", listed(known.iter().copied())))
}

pub fn braces_in_use(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0204, "the file name of a `use` contains braces")
        .label(span, "not known before the file is read")
        .help("write the file name in full: `use \"bench.twz\"`")
}

pub fn file_without_name(span: Span, path: &str, stem: &str) -> Diagnostic {
    let name: String = stem.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '_' }).collect();
    Diagnostic::new(Code::E0110, format!("`{stem}` is not a valid name, and the `use` gives no other"))
        .label(span, "a name is needed here")
        .help(format!("give it a name: `use \"{path}\" as my_{name}`"))
}

pub fn reserved_file_name(span: Span, name: &str, reserved_as: &str) -> Diagnostic {
    Diagnostic::new(Code::E0203, format!("`{name}` is reserved: it names {reserved_as}"))
        .label(span, "cannot name a file")
        .help(format!("give the file another name: `as my_{name}`"))
}

/// `uses` are the other `use`s of the cycle in order, each with the file that it names.
pub fn import_cycle(span: Span, name: &str, uses: &[(Span, &str)]) -> Diagnostic {
    let names = uses.iter().map(|(_, name)| *name);
    let chain: Vec<&str> = std::iter::once(name).chain(names).chain([name]).collect();
    let diagnostic = Diagnostic::new(Code::E0205, format!("`{name}` imports itself: {}", chain.join(" → ")))
        .label(span, "this closes the cycle");
    let labelled = uses
        .iter()
        .fold(diagnostic, |diagnostic, (span, name)| diagnostic.label(*span, format!("`{name}` is imported here")));
    labelled.help("move what the files share into a file that imports none of them")
}

pub fn too_many_files(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0204, format!("more than {limit} files are used")).label(span, "one too many")
}

pub fn wrong_sort(path: &Path, found: Declaration, wanted: &str) -> Diagnostic {
    let name = path_text(path);
    Diagnostic::new(Code::E0206, format!("`{name}` is {}, but {wanted} is expected here", found.sort.describe()))
        .label(path.span, format!("{wanted} is expected here"))
        .label(found.span, "declared here")
}

pub fn indexed_name(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0206, "a declared name is expected here, without an index")
        .label(span, "devices, scenes, tasks and programs have no indices")
        .help("declare it under a name of its own")
}

/// `at` is where the value is used in its own evaluation.
pub fn defined_by_itself(name: &str, declared: Span, at: Span) -> Diagnostic {
    Diagnostic::new(Code::E0207, format!("`{name}` is defined in terms of itself"))
        .label(at, format!("this needs `{name}` again"))
        .label_elsewhere(declared, at, format!("`{name}` is declared here"))
        .help("break the cycle: define one of its members without the others")
}

pub fn too_deep(span: Span, what: &str, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0207, format!("{what} are nested more than {limit} deep"))
        .label(span, "one too many")
        .help("use fewer levels")
}

pub fn unknown_verb(span: Span, verb: &str, vocabulary: &Vocabulary, near: Option<&str>) -> Diagnostic {
    let besides_words = match (vocabulary.together, vocabulary.assay) {
        (Together::Yes, Assay::Yes) => ["wait", "prompt", "pulse", "set", "together", "assay"].as_slice(),
        (Together::Yes, Assay::No) => ["wait", "prompt", "pulse", "set", "together"].as_slice(),
        (Together::No(_), _) => ["wait", "prompt", "pulse", "set"].as_slice(),
    };
    let kind = with_article(vocabulary.name);
    // A verb may have several forms.
    let mut known: Vec<&str> = vocabulary.verbs.iter().map(|verb| verb.name).collect();
    known.dedup();
    let besides = besides_words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    let list = match vocabulary.nouns.iter().any(|noun| noun.name == verb) {
        true => format!("declare objects in a scene, `scene bench {{ {verb} … }}`, and run the task `in bench`"),
        false => format!("{kind} can {}; also available are {besides} and the settings", listed(known.iter().copied())),
    };
    let own = known.iter().chain(besides_words).copied().find(|own| own.eq_ignore_ascii_case(verb));
    // The word itself is no suggestion: it exists, but in another form.
    let near = own.or_else(|| verb_synonym(verb, vocabulary)).or(near).filter(|near| *near != verb);
    Diagnostic::new(Code::E0208, format!("{kind} cannot `{verb}`")).label(span, "not a step").near_or(near, list)
}

/// The verb of the kind for a synonym that other programs use.
fn verb_synonym(name: &str, vocabulary: &Vocabulary) -> Option<&'static str> {
    let ours: &[&'static str] = match name.to_lowercase().as_str() {
        "go" | "goto" | "mv" | "travel" | "carry" | "bring" | "send" | "transport" => &["move", "drive", "translate"],
        "shift" | "lift" => &["translate", "move"],
        "turn" | "spin" | "roll" => &["rotate"],
        "align" | "tilt" => &["orient"],
        "grab" | "grip" | "pick" | "take" | "clamp" | "pinch" => &["grasp"],
        "drop" | "ungrasp" | "put" | "place" | "deposit" => &["release"],
        "dispose" | "remove" | "trash" | "dump" | "eject" => &["discard"],
        "combine" | "join" | "fuse" => &["merge"],
        "halve" | "divide" | "cut" | "aliquot" => &["split"],
        "stir" | "shake" | "agitate" | "homogenize" | "homogenise" => &["mix"],
        "detect" | "read" | "measure" | "heat" | "store" | "stay" | "rest" | "keep" | "react" => &["incubate"],
        "hold" => &["incubate", "grasp"],
        "sleep" | "pause" | "delay" => return Some("wait"),
        "begin" if vocabulary.state.is_some() => return Some("start"),
        "parallel" | "simultaneously" | "concurrently" if vocabulary.together == Together::Yes => {
            return Some("together");
        }
        "trigger" | "fire" | "flash" | "snap" => return Some("pulse"),
        "optimize" | "optimise" => return Some("minimize"),
        "tour" | "scan" | "traverse" => &["visit"],
        "dock" => &["assemble"],
        _ => return None,
    };
    ours.iter().copied().find(|ours| vocabulary.verb(ours).is_some())
}

/// `precision 0.25 um`.
pub fn setting_without_colon(name: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0119, format!("`:` is missing after `{}`", name.text))
        .label(name.span, "a setting takes `:` before its value")
        .help(format!("write `{}: …`", name.text))
        .with_fix(name.span.after(), ":")
}

/// `start (1, 1)`.
pub fn start_without_at(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0509, "`start` lacks `at`")
        .label(span, "`at` belongs after this")
        .help("write `start at (3, 3)`")
        .with_fix(span.after(), " at")
}

/// A setting of a task that was written as a field.
pub fn setting_with_colon(name: &Ident) -> Diagnostic {
    let example = match name.text.as_str() {
        "require" => "require time <= 400 ms",
        "using" => "using staged_astar",
        "wait" => "wait 10 ms",
        "start" => "start at (3, 3)",
        word => condition_of_any_kind(word).map_or("minimize time", |condition| condition.example),
    };
    Diagnostic::new(Code::E0119, format!("`{}` takes no `:`", name.text))
        .label(name.span, "a setting, not a field")
        .help(format!("remove the colon, as in `{example}`"))
}

pub fn maximized(span: Span, vocabulary: &Vocabulary) -> Diagnostic {
    let known: Vec<&str> = vocabulary.objectives.iter().map(|objective| objective.name).collect();
    let known = either(&known);
    Diagnostic::new(Code::E0208, "plans are minimized, not maximized")
        .label(span, "not a setting")
        .help(format!("write `minimize` with {known}; `require` sets a limit, as in `require time >= 400 ms`"))
}

pub fn second_objective(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0208, "a task takes only one objective")
        .label(span, "a second objective")
        .help("limit the others, as in `require energy <= 2 mJ`; ties are broken by the other figures anyway")
}

pub fn then_before_step(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0208, "`then` is not a word of the language")
        .label(span, "not a verb")
        .help("leave it out: steps follow each other in the order in which they are written")
}

pub fn unknown_field(name: &Ident, owner: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = match known {
        [] => "it has no fields".to_owned(),
        known => format!("it has {}", listed(known.iter().copied())),
    };
    let own = match name.text.as_str() {
        "voltage" => Some("potential"),
        "cols" | "width" => Some("columns"),
        "height" => Some("rows"),
        _ => None,
    };
    Diagnostic::new(Code::E0209, format!("{owner} has no field `{}`", name.text))
        .label(name.span, "unknown field")
        .near_or(own.filter(|own| known.contains(own)).or(near), list)
}

/// A width and a height where a size is expected.
pub fn extents(width: &Field, height: &Field, owner: &str) -> Diagnostic {
    let before_width = Span { end: width.value.span.start, ..width.name.span };
    let before_height = Span { end: height.value.span.start, ..width.value.span.after() };
    Diagnostic::new(Code::E0209, format!("{owner} has no fields `width` and `height`"))
        .label(width.name.span, "unknown field")
        .label(height.name.span, "unknown field")
        .help("write both as `size: (width, height)`")
        .with_fix(before_width, "size: (")
        .with_fix(before_height, ", ")
        .with_fix(height.value.span.after(), ")")
}

pub fn unknown_noun(span: Span, noun: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let known: BTreeSet<&str> = known.iter().copied().collect();
    let own = noun_synonym(noun).filter(|own| known.contains(own));
    let list = format!("a scene may hold {}", listed(known));
    Diagnostic::new(Code::E0210, format!("no object of a scene is called `{noun}`"))
        .label(span, "not a noun of this device")
        .near_or(own.or(near), list)
}

/// The noun for a synonym that other programs use.
fn noun_synonym(noun: &str) -> Option<&'static str> {
    Some(match noun.to_lowercase().as_str() {
        "droplet" | "drop" | "sample" | "bead" | "particle" | "micropart" | "object" => "part",
        "microrobot" | "bot" => "robot",
        "wall" | "block" | "barrier" => "obstacle",
        "port" | "source" | "inlet" | "supply" => "reservoir",
        "sensor" | "reader" | "camera" => "detector",
        _ => return None,
    })
}

pub fn unused(span: Span, sort: DeclarationSort, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0201, format!("{} `{name}` is never used", sort.name()))
        .label(span, "declared here")
        .help("use it or remove it")
}

pub fn unused_file(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0202, format!("nothing from file `{name}` is used"))
        .label(span, "imported here")
        .help("remove the `use`")
}

pub fn never_run(span: Span, sort: DeclarationSort, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0502, format!("{} `{name}` is never run", sort.name()))
        .label(span, "no program runs it")
        .help(format!("add `run {name}` to a program, or build it alone with `--task {name}`"))
}

pub fn never_run_with_parameters(span: Span, sort: DeclarationSort, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0502, format!("{} `{name}` has parameters and is never run", sort.name()))
        .label(span, "no program runs it with arguments")
        .help(format!("add a program: `program all {{ run {name}(…) }}`"))
}

/// An object of a scene where one of another noun belongs.
pub fn object_of_other_noun(span: Span, name: &str, noun: &str, found: (&str, Span)) -> Diagnostic {
    let title = format!("`{name}` is {}, but {} is expected here", with_article(found.0), with_article(noun));
    Diagnostic::new(Code::E0211, title)
        .label(span, format!("not {}", with_article(noun)))
        .label(found.1, format!("declared here as {}", with_article(found.0)))
        .help(match (found.0, noun) {
            ("obstacle", "part" | "robot") => format!("if it can be moved, declare it as `{noun} {name} at …`"),
            _ => format!("name {}, declared in the scene as `{noun} NAME at …`", with_article(noun)),
        })
}

pub fn unknown_object(span: Span, object: &ObjectName, near: Option<&str>, scene: Option<Span>) -> Diagnostic {
    let ObjectName { noun, name, word } = object;
    let title = match scene {
        Some(_) => format!("the scene of this task has no {noun} `{name}`"),
        None => format!("this task has no scene, and so no {noun} `{name}`"),
    };
    let diagnostic = Diagnostic::new(Code::E0211, title).label(span, "no such object");
    match (near, scene) {
        (Some(near), _) => diagnostic.near_object(name, *word, near),
        (None, Some(_)) => {
            let at = if *noun == "robot" { "pose(0 um, 0 um, 90 deg)" } else { "(5, 3)" };
            diagnostic.help(format!("declare it in the scene: `{noun} {name} at {at}`"))
        }
        (None, None) => diagnostic.help("name the scene of the task, as in `task swap on plate in tray`"),
    }
}

pub fn too_many_objects(span: Span, noun: &str, count: usize, most: usize) -> Diagnostic {
    Diagnostic::new(Code::E0522, format!("{count} {noun}s in a scene; at most {most} are allowed"))
        .label(span, "one too many")
        .help(match noun {
            "obstacle" => "combine them into blocks, as in `obstacle wall : cells { from: (20, 20), to: (23, 23) }`",
            _ => "divide the work among several boards",
        })
}
