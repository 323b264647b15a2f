//! Small cases of hands that brute force can search, with their programs.

/// Number of fingers of every hand.
pub const FINGERS: usize = 3;

/// Displacement of the part by a translation.
pub const TRANSLATED_UM: [f64; 3] = [1.0, -2.0, 0.5];

/// A hand, an ellipsoidal part, and a task of turns.
#[derive(Debug, Clone)]
pub struct Case {
    pub tip_radius_um: f64,
    pub steps_per_turn: i32,
    pub adhesion: bool,
    pub friction: f64,
    pub removal_safety: f64,
    pub clearance_um: f64,
    pub gaiting_cost_deg: f64,
    pub pull_off_un: f64,
    pub max_force_un: f64,
    pub torsion_um: f64,
    pub reserve: f64,
    pub semi_um: [f64; 3],
    pub load_un: [f64; 3],
    pub steps: Vec<Step>,
    /// Tolerance of the turns.
    pub precision_deg: u32,
    pub rolling_um_per_s: f64,
    pub approach_um_per_s: f64,
    pub retract_um: f64,
}

/// A step of a task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// A turn about z (`true`) or y, in nominal steps.
    Turn(bool, i32),
    /// `grasp … at`: contacts, from 1, in the plane of the next turn, or of the last one.
    Grasp([u32; FINGERS]),
    /// An orientation given by turns about z, y and z, in degrees.
    Orient([i32; 3]),
    Translate,
    Release,
}

impl Case {
    /// The program of the case.
    pub fn text(&self) -> String {
        let [a, b, c] = self.semi_um;
        let [x, y, z] = self.load_un;
        let by_um = TRANSLATED_UM;
        let step_deg = 360 / self.steps_per_turn;
        let step = |step: &Step| match step {
            Step::Turn(is_about_z, turn) => {
                format!("  rotate bead by {} deg about {}\n", turn * step_deg, if *is_about_z { "z" } else { "y" })
            }
            Step::Grasp([one, two, three]) => format!("  grasp bead at ({one}, {two}, {three})\n"),
            Step::Orient([a, b, c]) => format!("  orient bead to euler({a} deg, {b} deg, {c} deg)\n"),
            Step::Translate => format!("  translate bead by ({} um, {} um, {} um)\n", by_um[0], by_um[1], by_um[2]),
            Step::Release => "  release\n".to_owned(),
        };
        let steps: String = self.steps.iter().map(step).collect();
        let load = if self.load_un == [0.0; 3] { String::new() } else { format!("  load: ({x} uN, {y} uN, {z} uN)\n") };
        format!(
            "use std.fingers as f\ndevice hand : f.three_fingers {{ tip_radius: {} um, step: {step_deg} deg, adhesion: {}, \
             friction: {}, removal_safety: {}, clearance: {} um, gaiting_cost: {} deg, pull_off: {} uN, max_force: {} uN, \
             torsion: {} um, rolling_reserve: {}, rolling_speed: {} um/s, approach_speed: {} um/s, retract: {} um, \
             support: 90 uN, range: (900 um, 900 um, 900 um) }}\n\
             scene cell {{ part bead : ellipsoid {{ axes: ({a} um, {b} um, {c} um) }} }}\n\
             task flip on hand in cell {{\n  precision: {} deg\n{load}{steps}}}\n",
            self.tip_radius_um,
            self.adhesion,
            self.friction,
            self.removal_safety,
            self.clearance_um,
            self.gaiting_cost_deg,
            self.pull_off_un,
            self.max_force_un,
            self.torsion_um,
            self.reserve,
            self.rolling_um_per_s,
            self.approach_um_per_s,
            self.retract_um,
            self.precision_deg,
        )
    }
}
