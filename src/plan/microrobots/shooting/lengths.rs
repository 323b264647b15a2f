//! Lengths of legs that bring every robot to its goal (Levenberg–Marquardt).
//!
//! Problem: given the control states of the legs and the leg after which each robot rests, find lengths of at least
//! `least_um` with which every robot ends at its goal, and whose sum is small. Method: a length is `least_um` + u², and
//! the squares of the misses and `weight` × u² are minimised together. So every root u is allowed, and legs that do not
//! help become short. With a weight of 0 a solution nearby is found. A robot misses its goal by its distance along x and
//! y, and by the angle times its turning radius; angles are compared up to full circles. Each step solves a system with
//! three equations for each robot. Guaranteed: the sum of squares does not grow. Not guaranteed: that it becomes 0.
//! Cost: legs × robots sines, and 9 × legs × robots² multiplications for each step.

use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Damping at the beginning, its limits, and the factors by which it changes after a better and after a worse step.
const DAMPING: f64 = 1.0;
const LEAST_DAMPING: f64 = 1e-9;
const MOST_DAMPING: f64 = 1e9;
const EASED: f64 = 0.25;
const RAISED: f64 = 4.0;

/// How a solution is sought.
#[derive(Debug, Clone, Copy)]
pub struct SolverTerms {
    /// Weight of a micrometre of length against the square of a miss by 1 µm.
    pub weight: f64,
    /// Most steps.
    pub steps: usize,
    /// A step that lowers the sum of squares by less than this share of it is the last one.
    pub least_gain: f64,
}

/// A robot that follows the legs.
#[derive(Debug, Clone)]
pub struct ShotRobot {
    /// Turning radius, negative if it turns clockwise.
    pub curve_um: f64,
    /// Its path in a leg of length 1.
    pub pace: f64,
    pub start: Pose,
    /// Legs that it follows, then it rests.
    pub ends: usize,
    pub goal: Pose,
}

impl ShotRobot {
    /// Pose after a leg of this length.
    fn moved(&self, from: FacingPose, arm: Arm, length_um: f64) -> FacingPose {
        let way_um = self.pace * length_um;
        let FacingPose { pose, facing: [cos, sin] } = from;
        match arm {
            Arm::Up => {
                let pose = Pose { x_um: pose.x_um + way_um * cos, y_um: pose.y_um + way_um * sin, ..pose };
                FacingPose { pose, ..from }
            }
            Arm::Down => {
                let mut next = FacingPose::of(Pose { heading_rad: pose.heading_rad + way_um / self.curve_um, ..pose });
                next.pose.x_um += self.curve_um * (next.facing[1] - sin);
                next.pose.y_um -= self.curve_um * (next.facing[0] - cos);
                next
            }
        }
    }

    /// Change of the place `at` that it reaches later, for each micrometre by which a leg that begins at a pose is
    /// longer.
    fn slope(&self, begin: FacingPose, arm: Arm, at: Pose) -> [f64; 2] {
        let FacingPose { pose: begin, facing: [cos, sin] } = begin;
        match arm {
            Arm::Up => [self.pace * cos, self.pace * sin],
            Arm::Down => {
                let turn = self.pace / self.curve_um;
                let centre_um = [begin.x_um - self.curve_um * sin, begin.y_um + self.curve_um * cos];
                [-turn * (at.y_um - centre_um[1]), turn * (at.x_um - centre_um[0])]
            }
        }
    }
}

/// A pose with the cosine and the sine of its heading.
#[derive(Debug, Clone, Copy)]
struct FacingPose {
    pose: Pose,
    facing: [f64; 2],
}

impl FacingPose {
    fn of(pose: Pose) -> FacingPose {
        let (sin, cos) = pose.heading_rad.sine_cosine();
        FacingPose { pose, facing: [cos, sin] }
    }
}

/// The request.
#[derive(Debug, Clone)]
pub struct LegLengths {
    pub robots: Vec<ShotRobot>,
    /// By leg, then by robot.
    pub arms: Vec<Arm>,
    /// By leg.
    pub least_um: Vec<f64>,
}

/// Residuals and their slopes.
struct Linearised {
    residuals: DVector<f64>,
    /// By leg, then by residual.
    slopes: Vec<f64>,
    /// Poses before each leg, by robot, then by leg.
    poses: Vec<FacingPose>,
}

impl LegLengths {
    fn legs(&self) -> usize {
        self.least_um.len()
    }

    fn arm(&self, leg: usize, robot: usize) -> Arm {
        self.arms[leg * self.robots.len() + robot]
    }

    /// Improves the roots; returns the greatest miss in micrometres.
    pub fn solve(&self, roots: &mut [f64], terms: SolverTerms) -> f64 {
        let SolverTerms { weight, steps, least_gain } = terms;
        let rows = self.robots.len() * 3;
        let blank = || Linearised {
            residuals: DVector::zeros(rows),
            slopes: vec![0.0; rows * self.legs()],
            poses: vec![FacingPose::of(Pose::at(0.0, 0.0)); (self.legs() + 1) * self.robots.len()],
        };
        let (mut now, mut next) = (blank(), blank());
        self.linearise(roots, &mut now);
        let mut cost = cost(&now, roots, weight);
        let mut damping = DAMPING;
        let mut tried = roots.to_vec();
        for _ in 0..steps {
            let before = cost;
            for (leg, root) in roots.iter().enumerate() {
                now.slopes[leg * rows..(leg + 1) * rows].iter_mut().for_each(|slope| *slope *= 2.0 * root);
            }
            let square = square(&now.slopes, rows);
            while damping < MOST_DAMPING {
                if step(&now, &square, roots, [weight, damping], &mut tried).is_some() {
                    self.linearise(&tried, &mut next);
                    let found = self::cost(&next, &tried, weight);
                    if found < cost {
                        cost = found;
                        break;
                    }
                }
                damping *= RAISED;
            }
            if damping >= MOST_DAMPING {
                break;
            }
            roots.copy_from_slice(&tried);
            std::mem::swap(&mut now, &mut next);
            damping = (damping * EASED).max(LEAST_DAMPING);
            if before - cost < least_gain * before {
                break;
            }
        }
        now.residuals.amax()
    }

    /// Poses of the robots before each leg, and after the last one: by robot, then by leg.
    fn follow(&self, roots: &[f64], poses: &mut [FacingPose]) {
        let legs = self.legs();
        for (index, robot) in self.robots.iter().enumerate() {
            let way = &mut poses[index * (legs + 1)..(index + 1) * (legs + 1)];
            way[0] = FacingPose::of(robot.start);
            for leg in 0..legs {
                let length_um = self.least_um[leg] + roots[leg] * roots[leg];
                way[leg + 1] =
                    if leg < robot.ends { robot.moved(way[leg], self.arm(leg, index), length_um) } else { way[leg] };
            }
        }
    }

    fn linearise(&self, roots: &[f64], out: &mut Linearised) {
        let legs = self.legs();
        self.follow(roots, &mut out.poses);
        out.slopes.fill(0.0);
        let rows = out.residuals.len();
        let mut row = 0;
        for (index, robot) in self.robots.iter().enumerate() {
            let goal = robot.goal;
            let way = &out.poses[index * (legs + 1)..(index + 1) * (legs + 1)];
            let at = way[legs].pose;
            out.residuals[row] = at.x_um - goal.x_um;
            out.residuals[row + 1] = at.y_um - goal.y_um;
            out.residuals[row + 2] = robot.curve_um * wrapped_rad(at.heading_rad - goal.heading_rad);
            for (leg, begin) in way.iter().enumerate().take(robot.ends.min(legs)) {
                let arm = self.arm(leg, index);
                let [x, y] = robot.slope(*begin, arm, at);
                let turn = if arm == Arm::Down { robot.pace } else { 0.0 };
                out.slopes[leg * rows + row..leg * rows + row + 3].copy_from_slice(&[x, y, turn]);
            }
            row += 3;
        }
    }
}

fn cost(at: &Linearised, roots: &[f64], weight: f64) -> f64 {
    at.residuals.norm_squared() + weight * roots.iter().map(|root| root * root).sum::<f64>()
}

/// The slopes times their transpose.
fn square(slopes: &[f64], rows: usize) -> DMatrix<f64> {
    let mut square = DMatrix::zeros(rows, rows);
    for of_leg in slopes.chunks_exact(rows) {
        for (slope, column) in of_leg.iter().zip(square.as_mut_slice().chunks_exact_mut(rows)) {
            if *slope != 0.0 {
                column.iter_mut().zip(of_leg).for_each(|(sum, other)| *sum += slope * other);
            }
        }
    }
    square
}

/// Writes the damped step from the roots; `None` if the system is not positive definite.
///
/// With slopes J, residuals r, and δ = weight + damping, the step is -(JᵀJ + δ)⁻¹(Jᵀr + weight u), which is
/// -(weight/δ) u - Jᵀ(JJᵀ + δ)⁻¹(r - (weight/δ) J u).
fn step(
    now: &Linearised,
    square: &DMatrix<f64>,
    roots: &[f64],
    [weight, damping]: [f64; 2],
    tried: &mut [f64],
) -> Option<()> {
    let rows = now.residuals.len();
    let strength = weight + damping;
    let pull = weight / strength;
    let mut matrix = square.clone();
    (0..rows).for_each(|row| matrix[(row, row)] += strength);
    let mut right = now.residuals.clone();
    for (slopes, root) in now.slopes.chunks_exact(rows).zip(roots) {
        right.iter_mut().zip(slopes).for_each(|(right, slope)| *right -= pull * root * slope);
    }
    Cholesky::new(matrix)?.solve_mut(&mut right);
    for (leg, next) in tried.iter_mut().enumerate() {
        let slopes = &now.slopes[leg * rows..(leg + 1) * rows];
        let along: f64 = slopes.iter().zip(right.iter()).map(|(slope, right)| slope * right).sum();
        *next = roots[leg] - pull * roots[leg] - along;
    }
    Some(())
}
