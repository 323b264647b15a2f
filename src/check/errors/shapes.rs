//! Shapes, curves and orientations.

use crate::check::value::Value;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::digits;
use crate::source::Span;

pub fn no_angle(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0307, format!("`euler` needs three angles, but this is {}", found.describe_fully()))
        .label(span, found.describe())
        .help("write `euler(80 deg, 220 deg, 100 deg)`: turns about z, y and z, each about the part's own axis")
}

pub fn no_unit_quaternion(span: Span, numbers: [f64; 4], norm: f64) -> Diagnostic {
    let title = format!("the length of the quaternion is {}, but must be 1", digits(norm));
    let diagnostic = Diagnostic::new(Code::E0307, title).label(span, "no orientation");
    if norm == 0.0 || !norm.is_finite() {
        return diagnostic.help("write w, x, y and z: `quaternion(1, 0, 0, 0)` turns nothing");
    }
    let unit: Vec<String> = numbers.iter().map(|number| format!("{:.6}", number / norm)).collect();
    diagnostic.help(format!("divided by its length it is `quaternion({})`", unit.join(", ")))
}

pub fn angle_name_taken(span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0202, "`t` is declared twice: a curve has its own")
        .label(span, "in a curve, the angle that goes once round")
        .label(earlier, "declared here")
        .help("give the other one another name")
}

pub fn mesh_file_not_plain(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0553, "the name of a mesh file must be a string in quotes in the mesh's own declaration")
        .label(span, "not a plain string")
        .help("write the name itself, in a `let` or in a scene: `mesh { file: \"bead.stl\", unit: 1 um }`")
}

pub fn board_file_not_plain(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0430, "the name of a file of electrodes must be a string in quotes in the device itself")
        .label(span, "not a plain string")
        .help("write the name itself: `map: \"board.json\"`")
}

/// A file that does not describe a board.
pub fn bad_board(span: Span, path: &str, why: &str) -> Diagnostic {
    Diagnostic::new(Code::E0430, format!("`{path}` {why}")).label(span, "used here").help(
        "use a board definition of PurpleDrop, the electrodes.json of OpenDrop's program, or a device file of MicroDrop; write other boards \
         out as `channels`",
    )
}

/// A mesh file that is not a closed surface.
pub fn bad_mesh(span: Span, path: &str, why: &str) -> Diagnostic {
    Diagnostic::new(Code::E0553, format!("`{path}` {why}"))
        .label(span, "used here")
        .help("export the file again from a solid: one closed surface around its origin, as text or binary STL; triangles meet where their corners are equal to the last digit")
}
