//! The functions of the language: their names and parameters.

/// A function of the language.
#[derive(Debug, Clone, Copy)]
pub struct FunctionForm {
    pub name: &'static str,
    /// Parameter names; `…` means that the one before it may be repeated.
    pub parameters: &'static [&'static str],
    pub doc: &'static str,
}

const fn function(name: &'static str, parameters: &'static [&'static str], doc: &'static str) -> FunctionForm {
    FunctionForm { name, parameters, doc }
}

/// The functions of the language.
pub const FUNCTIONS: &[FunctionForm] = &[
    function("abs", &["value"], "the absolute value"),
    function("min", &["value", "…"], "the least of several values of one dimension, or of a list"),
    function("max", &["value", "…"], "the greatest of several values of one dimension, or of a list"),
    function("round", &["number"], "the nearest whole number; halves round away from 0"),
    function("floor", &["number"], "the greatest whole number that is not above it"),
    function("sqrt", &["value"], "the square root, of its dimension too: `sqrt(4 um^2)` is `2 um`"),
    function("sin", &["angle"], "the sine of an angle, as `sin(30 deg)`"),
    function("cos", &["angle"], "the cosine of an angle, as `cos(60 deg)`"),
    function("atan2", &["y", "x"], "the angle of the direction (x, y), from -180 deg to 180 deg"),
    function("count", &["list"], "the number of elements of a list or a range, or of rows of a table"),
    function("pose", &["x", "y", "heading"], "a place with a heading, counter-clockwise from +x; 0 deg if omitted"),
    function(
        "euler",
        &["first", "second", "third"],
        "an orientation: turns about z, y and z, each about the part's own axis",
    ),
    function("quaternion", &["w", "x", "y", "z"], "an orientation as a quaternion of length 1"),
];

/// Call form of a function, such as `atan2(y, x)`.
pub fn function_form(name: &str) -> Option<String> {
    let form = FUNCTIONS.iter().find(|form| form.name == name)?;
    Some(format!("{name}({})", form.parameters.join(", ")))
}

/// Whether a function has this name.
pub fn is_function(name: &str) -> bool {
    function_names().any(|function| function == name)
}

/// The names of the functions.
pub fn function_names() -> impl Iterator<Item = &'static str> + Clone {
    FUNCTIONS.iter().map(|form| form.name)
}
