//! Motion of the part and the tips of a hand.
//!
//! The tips are where the schedule has them. The recorded states give the part's pose after each change of the grasp
//! and each rolled step; between two of them the part moves steadily while a holding finger does. The number of moments
//! is bounded for every plan.

use crate::claims::fingers::{FingersOrder, Section};
use crate::device::fingers::{AXES, Plane, finger_axis};
use crate::emit::Signals;
use crate::emit::motion;
use crate::geometry::outline::Curve;
use crate::schedule::fingers::FingersState;
use crate::schedule::{PlanRecord, State};
use crate::verify::Verified;

/// Greatest distance of a tip between two moments, unless there would be too many.
const STEP_UM: f64 = 1.0;

/// Approximate limit of moments, besides those at which some tip changes direction.
pub const MAX_MOMENTS: usize = 20_000;

/// Corners of the polygon that approximates an outline.
const CORNERS: u32 = 128;

/// Motion of a hand in all plans.
pub struct HandMotion<'a> {
    pub fingers: usize,
    stages: FingerChannels,
    /// In order of time.
    pub plans: Vec<HandPlanMotion<'a>>,
}

/// Motion of a hand in one plan.
pub struct HandPlanMotion<'a> {
    pub order: &'a FingersOrder,
    pub start_ns: u64,
    /// In order of time.
    pub grasps: Vec<RecordedGrasp<'a>>,
    /// After each grasp but the last, start and end of the motion of the holding fingers.
    pub motions: Vec<Option<[u64; 2]>>,
    /// In order of time; the first one is that of the first state.
    pub moments: Vec<HandMoment>,
}

/// The grasp of a recorded state.
pub struct RecordedGrasp<'a> {
    pub t_ns: u64,
    pub state: &'a State,
    /// The contact of each finger; 0 for a free one.
    pub contacts: &'a [u32],
    pub angle_index: i64,
    pub plane: Plane,
    pub part: PartPose,
}

/// Pose of the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartPose {
    pub position_um: [f64; 3],
    /// A unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
}

/// Positions of part and tips at an instant.
pub struct HandMoment {
    pub t_ns: u64,
    pub part: PartPose,
    /// The middle of each tip.
    pub tips_um: Vec<[f64; 3]>,
}

/// Channels of each finger, in the order of the axes.
type FingerChannels = Vec<[usize; 3]>;

impl<'a> HandMotion<'a> {
    /// Motion of a device; empty for one of another kind.
    pub fn new(verified: &'a Verified, signals: &Signals, device: &str) -> Self {
        let jobs = motion::jobs(verified, device).into_iter();
        let plans = jobs.filter_map(|(job, plan)| HandPlanMotion::new(FingersOrder::of(&job.order)?, plan));
        let mut plans: Vec<HandPlanMotion> = plans.collect();
        let fingers = plans.first().map_or(0, |plan| plan.order.facts.fingers as usize);
        let stages = stages(signals, device, fingers);
        let breaks: Vec<u64> = signals.breaks(stages.iter().flatten().copied()).into_iter().collect();
        let stretches: Vec<Vec<[u64; 2]>> = plans.iter().map(|plan| plan.stretches(&breaks)).collect();
        let wanted = stretches.iter().flatten().map(|stretch| wanted(signals, &stages, *stretch)).sum::<f64>();
        let share = (MAX_MOMENTS as f64 / wanted.max(1.0)).min(1.0);
        for (plan, stretches) in plans.iter_mut().zip(&stretches) {
            let pairs = plan.grasps.windows(2);
            plan.motions = pairs.map(|pair| holding_motion(signals, &stages, &pair[0], pair[1].t_ns)).collect();
            plan.moments = plan.moments(signals, &stages, stretches, share);
        }
        // Before the first task everything stands where it begins.
        if let Some(first) = plans.first_mut().and_then(|plan| plan.moments.first_mut()) {
            first.t_ns = 0;
        }
        HandMotion { fingers, stages, plans }
    }

    /// Positions at an instant, with the plan and the index of its current grasp.
    pub fn at(&self, signals: &Signals, t_ns: u64) -> Option<(&HandPlanMotion<'a>, usize, HandMoment)> {
        let begun = self.plans.iter().rfind(|plan| plan.start_ns <= t_ns);
        let plan = begun.or_else(|| self.plans.first()).filter(|plan| !plan.grasps.is_empty())?;
        let after = plan.grasps.partition_point(|grasp| grasp.t_ns <= t_ns);
        let tips_um = self.stages.iter().map(|stage| tip_um(signals, stage, t_ns)).collect();
        Some((plan, after.saturating_sub(1), HandMoment { t_ns, part: plan.part_at(t_ns), tips_um }))
    }

    /// The name of the part.
    pub fn part(&self) -> Option<&'a str> {
        self.plans.first().map(|plan| plan.order.part.name.as_str())
    }
}

/// The channels of a device by finger and axis.
fn stages(signals: &Signals, device: &str, fingers: usize) -> FingerChannels {
    let mut stages = vec![[None; AXES.len()]; fingers];
    for (index, channel) in signals.schedule.channels.iter().enumerate().filter(|(_, one)| one.device == device) {
        let name = channel.name.strip_prefix(device).and_then(|name| name.strip_prefix('.'));
        if let Some((finger, axis)) = name.and_then(finger_axis).filter(|(finger, _)| *finger < fingers) {
            stages[finger][axis] = Some(index);
        }
    }
    let every = "the schedule lists every channel of a hand";
    stages.into_iter().map(|axes| axes.map(|channel| channel.expect(every))).collect()
}

fn tip_um(signals: &Signals, stage: &[usize; 3], t_ns: u64) -> [f64; 3] {
    stage.map(|channel| signals.value(channel, t_ns))
}

/// Desired number of parts of an interval in which all tips move straight.
fn wanted(signals: &Signals, stages: &FingerChannels, [start_ns, end_ns]: [u64; 2]) -> f64 {
    let way = |stage: &[usize; 3]| {
        let ends = [start_ns, end_ns].map(|t_ns| tip_um(signals, stage, t_ns));
        ends[0].iter().zip(ends[1]).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
    };
    (stages.iter().map(way).fold(0.0, f64::max) / STEP_UM).ceil()
}

impl<'a> HandPlanMotion<'a> {
    fn new(order: &'a FingersOrder, plan: &'a PlanRecord) -> Option<Self> {
        let mut grasps = Vec::with_capacity(plan.states.len());
        for timed in &plan.states {
            let State::Fingers(FingersState { grasp, angle_index, plane, position_um, orientation, .. }) = &timed.state
            else {
                return None;
            };
            grasps.push(RecordedGrasp {
                t_ns: timed.t_ns,
                state: &timed.state,
                contacts: grasp,
                angle_index: *angle_index,
                plane: *plane,
                part: PartPose { position_um: *position_um, orientation: *orientation },
            });
        }
        Some(HandPlanMotion { order, start_ns: plan.start_ns, grasps, motions: Vec::new(), moments: Vec::new() })
    }

    /// Intervals between instants at which a tip may change direction or a state is recorded.
    fn stretches(&self, breaks: &[u64]) -> Vec<[u64; 2]> {
        let (Some(first), Some(last)) = (self.grasps.first(), self.grasps.last()) else { return Vec::new() };
        let (start_ns, end_ns) = (first.t_ns, last.t_ns);
        let within = breaks.iter().copied().filter(|t_ns| (start_ns..=end_ns).contains(t_ns));
        let mut instants: Vec<u64> = within.chain(self.grasps.iter().map(|grasp| grasp.t_ns)).collect();
        instants.sort_unstable();
        instants.dedup();
        instants.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// The moments of a plan: the ends of all intervals, and a share of the desired ones between them.
    fn moments(
        &self,
        signals: &Signals,
        stages: &FingerChannels,
        stretches: &[[u64; 2]],
        share: f64,
    ) -> Vec<HandMoment> {
        let moment = |t_ns: u64| HandMoment {
            t_ns,
            part: self.part_at(t_ns),
            tips_um: stages.iter().map(|stage| tip_um(signals, stage, t_ns)).collect(),
        };
        let mut moments: Vec<HandMoment> = self.grasps.first().map(|first| moment(first.t_ns)).into_iter().collect();
        for &[start_ns, end_ns] in stretches {
            let length_ns = end_ns - start_ns;
            let parts = (wanted(signals, stages, [start_ns, end_ns]) * share) as u64;
            let parts = parts.clamp(1, length_ns);
            let inner = |part: u64| start_ns + (u128::from(length_ns) * u128::from(part) / u128::from(parts)) as u64;
            moments.extend((1..=parts).map(|part| moment(inner(part))));
        }
        moments
    }

    /// The pose of the part at an instant.
    fn part_at(&self, t_ns: u64) -> PartPose {
        let after = self.grasps.partition_point(|grasp| grasp.t_ns <= t_ns);
        let index = after.saturating_sub(1);
        let here = self.grasps[index].part;
        let next = self.grasps.get(index + 1).zip(self.motions.get(index).copied().flatten());
        match next {
            Some((next, [start_ns, end_ns])) if t_ns > start_ns => {
                let share = (t_ns.min(end_ns) - start_ns) as f64 / (end_ns - start_ns) as f64;
                between(&here, &next.part, share)
            }
            Some(_) | None => here,
        }
    }
}

/// Start and end of the motion of the holding fingers after a grasp, until an instant.
fn holding_motion(signals: &Signals, stages: &FingerChannels, grasp: &RecordedGrasp, end_ns: u64) -> Option<[u64; 2]> {
    let holding = stages.iter().zip(grasp.contacts).filter(|(_, contact)| **contact > 0);
    let channels = holding.flat_map(|(stage, _)| stage);
    let ramps = channels.flat_map(|channel| {
        let list = signals.of(*channel);
        let first = list.partition_point(|actuation| actuation.start_ns < grasp.t_ns);
        list[first..].iter().take_while(|ramp| ramp.end_ns() <= end_ns).filter(|ramp| ramp.from != ramp.to)
    });
    let ends = ramps.map(|ramp| [ramp.start_ns, ramp.end_ns()]);
    ends.reduce(|[first, last], [start_ns, end_ns]| [first.min(start_ns), last.max(end_ns)])
}

/// Interpolates between two poses. Orientations follow the chord, which for the few degrees of a step is as good as the
/// arc and needs no sine.
fn between(one: &PartPose, other: &PartPose, share: f64) -> PartPose {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let [x, y, z] = [0, 1, 2].map(|axis| mix(one.position_um[axis], other.position_um[axis]));
    // A quaternion and its negative are the same rotation; the nearer one is used.
    let along: f64 = one.orientation.iter().zip(other.orientation).map(|(a, b)| a * b).sum();
    let sign = if along < 0.0 { -1.0 } else { 1.0 };
    let turn = [0, 1, 2, 3].map(|part| mix(one.orientation[part], sign * other.orientation[part]));
    let norm = turn.iter().map(|part| part * part).sum::<f64>().sqrt();
    let orientation = if norm > 0.0 { turn.map(|part| part / norm) } else { one.orientation };
    PartPose { position_um: [x, y, z], orientation }
}

/// An outline as a polygon, in section coordinates; empty if the outline is invalid.
pub fn corners(section: &Section) -> Vec<[f64; 2]> {
    let Ok(curve) = Curve::of(&section.outline) else { return Vec::new() };
    let part_um = curve.perimeter_um() / f64::from(CORNERS);
    (0..CORNERS).map(|corner| curve.point_at(f64::from(corner) * part_um).point_um).collect()
}
