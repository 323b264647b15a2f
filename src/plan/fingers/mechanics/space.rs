//! Equilibrium in space: forces across the plane of the contacts, and torques out of it.
//!
//! A contact bears a force across the plane by friction, and a torque about its normal up to `torsion` times its pressing and
//! adhesive force: the soft finger of Murray, Li and Sastry (A Mathematical Introduction to Robotic Manipulation, 1994, section
//! 5.2). Its friction serves both tangential directions: the magnitudes of the two tangential forces add up to at most friction
//! times the pressing and adhesive force, a pyramid within the cone.
//!
//! Two fingers leave two unknowns, the force along the chord between them and the split of the torque about it; one is eliminated
//! (Fourier and Motzkin), which leaves intervals of the other. Three are first tested without torsion, where the out-of-plane
//! forces are those of a lever, and without the out-of-plane load; only what both leave open takes a linear program.

use super::load::{Across, GripDemand, Wrench};
use super::model::GripModel;
use super::pair::{ForceCone, LineForce, dot};
use super::simplex;
use super::{Contact, TOLERANCE};

/// Magnitude below which a number counts as zero, up to rounding.
const NOTHING: f64 = 1e-12;

/// Two fingers and their out-of-plane load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lever {
    touch: [Contact; 2],
    along: [f64; 2],
    length_um: f64,
    /// Out-of-plane forces and torques about the inward normals, each with its slope in the free share.
    across_un: [[f64; 2]; 2],
    torque_un_um: [[f64; 2]; 2],
    /// Torque about the chord that no finger bears.
    pub left_over_un_um: f64,
}

impl Lever {
    /// `torsion_um` is 0 where tips bear no torque. `None` for two contacts at the same place.
    pub fn of(touch: [&Contact; 2], across: &Across, torsion_um: f64) -> Option<Lever> {
        let [a, b] = touch.map(|contact| contact.point_um);
        let run_um = [b[0] - a[0], b[1] - a[1]];
        let length_um = dot(run_um, run_um).sqrt();
        if length_um == 0.0 {
            return None;
        }
        let along = run_um.map(|part| part / length_um);
        let beside = [-along[1], along[0]];
        let about_a =
            [across.torque_un_um[0] - across.force_un * a[1], across.torque_un_um[1] + across.force_un * a[0]];
        let (wanted, crosswise) = (dot(about_a, along), dot(about_a, beside));
        // Torques are taken about the inward normals.
        let [cosines, sines] = [along, beside].map(|axis| touch.map(|contact| -dot(contact.normal, axis)));
        let square = dot(cosines, cosines);
        let bears = torsion_um > 0.0 && square > NOTHING * NOTHING;
        let torque_un_um = match bears {
            true => [0, 1].map(|k| {
                let other = if k == 0 { -cosines[1] } else { cosines[0] };
                [wanted * cosines[k] / square, other / square.sqrt()]
            }),
            false => [[0.0; 2]; 2],
        };
        let second = [0, 1].map(|part| {
            let turned = torque_un_um[0][part] * sines[0] + torque_un_um[1][part] * sines[1];
            (turned - if part == 0 { crosswise } else { 0.0 }) / length_um
        });
        let across_un = [[across.force_un - second[0], -second[1]], second];
        let left_over_un_um = if bears { 0.0 } else { wanted.abs() };
        Some(Lever { touch: touch.map(|contact| *contact), along, length_um, across_un, torque_un_um, left_over_un_um })
    }

    /// Largest share of the torques about both normals that acts about the chord.
    pub fn leverage(&self) -> f64 {
        self.touch.iter().map(|contact| dot(contact.normal, self.along).abs()).sum()
    }

    /// Contact force that each finger needs for friction and torsion under the out-of-plane load, if they share the torque about
    /// the chord in proportion to their leverage.
    fn withheld_un(&self, grip: &GripModel) -> [f64; 2] {
        [0, 1].map(|k| {
            let torque_un_um = self.torque_un_um[k][0].abs();
            let by_torsion_un = if torque_un_um > 0.0 { torque_un_um / grip.torsion_um } else { 0.0 };
            (self.across_un[k][0].abs() / grip.friction).max(by_torsion_un)
        })
    }

    /// Whether the two can exert a wrench in the plane in addition to the out-of-plane load.
    fn bears(&self, grip: &GripModel, wrench: &Wrench, slack_un: f64) -> bool {
        if self.left_over_un_um > slack_un * grip.arm_um {
            return false;
        }
        let mut rows = WrenchRows { all: [WrenchRow::NONE; 14], count: 0 };
        let [x_um, y_um] = self.touch[0].point_um;
        let [fx_un, fy_un] = wrench.force_un;
        let moment_un_um = wrench.moment_un_um - (x_um * fy_un - y_um * fx_un);
        let beside = [-self.along[1], self.along[0]];
        let of_second = [0, 1].map(|k| beside[k] * moment_un_um / self.length_um);
        let of_first = [0, 1].map(|k| wrench.force_un[k] - of_second[k]);
        for (k, (force_un, sign)) in [(of_first, -1.0), (of_second, 1.0)].into_iter().enumerate() {
            let inward = self.touch[k].normal.map(|part| -part);
            let tangent = [-inward[1], inward[0]];
            // Each as a constant, and its slope in the force along the chord.
            let [normal, tangential] =
                [inward, tangent].map(|axis| [dot(force_un, axis), sign * dot(self.along, axis)]);
            let (across, torque) = (self.across_un[k], self.torque_un_um[k]);
            for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                rows.push(WrenchRow {
                    chord: one * tangential[1] - grip.friction * normal[1],
                    share: other * across[1],
                    bound: grip.friction * (normal[0] + grip.sticking_un) - one * tangential[0] - other * across[0]
                        + slack_un,
                });
            }
            rows.push(WrenchRow { chord: normal[1], share: 0.0, bound: grip.max_force_un - normal[0] + slack_un });
            for sign in [1.0, -1.0] {
                rows.push(WrenchRow {
                    chord: -grip.torsion_um * normal[1],
                    share: sign * torque[1],
                    bound: grip.torsion_um * (normal[0] + grip.sticking_un) - sign * torque[0] + slack_un * grip.arm_um,
                });
            }
        }
        rows.meet()
    }
}

/// `chord · s + share · t <= bound`.
#[derive(Debug, Clone, Copy)]
struct WrenchRow {
    chord: f64,
    share: f64,
    bound: f64,
}

impl WrenchRow {
    const NONE: WrenchRow = WrenchRow { chord: 0.0, share: 0.0, bound: 0.0 };
}

struct WrenchRows {
    all: [WrenchRow; 14],
    count: usize,
}

impl WrenchRows {
    fn push(&mut self, row: WrenchRow) {
        self.all[self.count] = row;
        self.count += 1;
    }

    /// Whether some s and t satisfy all rows.
    fn meet(&self) -> bool {
        let rows = &self.all[..self.count];
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut keep = |share: f64, bound: f64| {
            if share > NOTHING {
                high = high.min(bound / share);
            } else if share < -NOTHING {
                low = low.max(bound / share);
            } else {
                return bound >= 0.0;
            }
            low <= high
        };
        for row in rows {
            if row.chord.abs() <= NOTHING {
                if !keep(row.share, row.bound) {
                    return false;
                }
                continue;
            }
            for other in rows.iter().filter(|other| row.chord < -NOTHING && other.chord > NOTHING) {
                let (rise, fall) = (other.chord, -row.chord);
                if !keep(rise * row.share + fall * other.share, rise * row.bound + fall * other.bound) {
                    return false;
                }
            }
        }
        true
    }
}

/// Two fingers under a load with an out-of-plane component, prepared for queries about wrenches of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpatialBearing {
    lever: Lever,
    /// Without the out-of-plane load: a necessary condition.
    most: LineForce,
    /// With the contact force that the out-of-plane load needs held back: a sufficient condition.
    least: LineForce,
    slack_un: f64,
}

impl SpatialBearing {
    /// `None` for two contacts at the same place.
    pub fn of(grip: &GripModel, touch: [&Contact; 2], across: &Across, slack_un: f64) -> Option<SpatialBearing> {
        let lever = Lever::of(touch, across, grip.torsion_um)?;
        let [a, b] = touch.map(|contact| grip.pressing(contact, 0.0));
        let most = LineForce::between(&a, &b, grip.arm_um, slack_un);
        let withheld_un = lever.withheld_un(grip);
        let [a, b] = [0, 1].map(|k| grip.pressing(touch[k], withheld_un[k]));
        let least = LineForce::between(&a, &b, grip.arm_um, 0.0);
        Some(SpatialBearing { lever, most, least, slack_un })
    }

    /// Whether the two can exert a wrench in the plane in addition to the out-of-plane load.
    pub fn bears(&self, grip: &GripModel, wrench: &Wrench) -> bool {
        let is_balanced = self.lever.left_over_un_um <= self.slack_un * grip.arm_um;
        is_balanced
            && self.most.bears(wrench)
            && (self.least.bears(wrench) || self.lever.bears(grip, wrench, self.slack_un))
    }
}

/// Whether three fingers can exert a wrench in the plane in addition to the out-of-plane load.
pub(super) fn three_bear(
    grip: &GripModel,
    touch: [&Contact; 3],
    across: &Across,
    wrench: &Wrench,
    slack_un: f64,
) -> bool {
    let bear = |withheld_un: [f64; 3], slack_un: f64| {
        let [a, b, c]: [ForceCone; 3] = [0, 1, 2].map(|k| grip.pressing(touch[k], withheld_un[k]));
        LineForce::between(&a, &b, grip.arm_um, slack_un).takes(&c, &GripDemand::Exert(*wrench))
    };
    if !bear([0.0; 3], slack_un) {
        return false;
    }
    if let Some(across_un) = levers(touch, across, grip.arm_um) {
        if bear(across_un.map(|force_un| force_un.abs() / grip.friction), slack_un) {
            return true;
        }
        if grip.torsion_um == 0.0 {
            return false;
        }
    }
    simplex::are_kept(program(grip, touch, across, wrench), slack_un)
}

/// Out-of-plane forces of three fingers that bear no torque; `None` for contacts on one line.
fn levers(touch: [&Contact; 3], across: &Across, arm_um: f64) -> Option<[f64; 3]> {
    let [a, b, c] = touch.map(|contact| contact.point_um);
    let from_a = |[x, y]: [f64; 2]| [x - a[0], y - a[1]];
    let (b, c) = (from_a(b), from_a(c));
    let twice_area = b[0] * c[1] - b[1] * c[0];
    if twice_area.abs() <= TOLERANCE * arm_um * arm_um {
        return None;
    }
    // Point of action, relative to the first contact, of a single force equivalent to the load.
    let x = -(across.torque_un_um[1] + across.force_un * a[0]);
    let y = across.torque_un_um[0] - across.force_un * a[1];
    let of_b = (x * c[1] - y * c[0]) / twice_area;
    let of_c = (b[0] * y - b[1] * x) / twice_area;
    Some([across.force_un - of_b - of_c, of_b, of_c])
}

/// The linear program of three fingers: for each its normal, tangential and out-of-plane force, and its torque as a force at the
/// arm.
fn program(grip: &GripModel, touch: [&Contact; 3], across: &Across, wrench: &Wrench) -> simplex::Conditions {
    let mut conditions = simplex::Conditions::none();
    let sums = [wrench.force_un[0], wrench.force_un[1], wrench.moment_un_um / grip.arm_um, across.force_un];
    let torques = across.torque_un_um.map(|torque| torque / grip.arm_um);
    for (row, sum) in sums.into_iter().chain(torques).enumerate() {
        conditions.equalities[row][simplex::VARIABLES] = sum;
    }
    let turns = grip.torsion_um / grip.arm_um;
    for (k, contact) in touch.into_iter().enumerate() {
        let inward = contact.normal.map(|part| -part);
        let tangent = [-inward[1], inward[0]];
        let [x, y] = contact.point_um.map(|part| part / grip.arm_um);
        let moment = |force: [f64; 2]| x * force[1] - y * force[0];
        let columns = [
            [inward[0], inward[1], moment(inward), 0.0, 0.0, 0.0],
            [tangent[0], tangent[1], moment(tangent), 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0, y, -x],
            [0.0, 0.0, 0.0, 0.0, inward[0], inward[1]],
        ];
        for (part, column) in columns.into_iter().enumerate() {
            for (row, share) in column.into_iter().enumerate() {
                conditions.equalities[row][4 * k + part] = share;
            }
        }
        let mut at_most = |parts: [f64; 4], bound: f64| conditions.push(4 * k, parts, bound);
        for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            at_most([-grip.friction, one, other, 0.0], grip.friction * grip.sticking_un);
        }
        at_most([1.0, 0.0, 0.0, 0.0], grip.max_force_un);
        for sign in [1.0, -1.0] {
            at_most([-turns, 0.0, 0.0, sign], turns * grip.sticking_un);
        }
    }
    conditions
}
