//! Checks the path of a stage against the stage's travel, greatest speed and acceleration.
//!
//! A path of straight lines has speed jumps where two lines meet. A stage rounds such a corner, and a controller that
//! samples the path in time cuts it. Both deviations together must stay within half of the hand's tolerance; planned
//! paths use the other half.

use super::wired_channel::WiredChannel;
use crate::claims::Claims;
use crate::device::instrument::{Direction, InstrumentFacts, Link, QUOTIENT_ROOM, StageLimits, corner_cut_um};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::{Actuation, ChannelUnit, SpeedJump};

/// The first limit of a stage that its channel exceeds, if the channel is one of positions; `all` are the wired
/// channels of the schedule.
pub fn beyond_stage(wired: &WiredChannel, all: &[WiredChannel], claims: &Claims) -> Option<Diagnostic> {
    let stage = FollowingStage { wired, all };
    match wired.channel.unit {
        ChannelUnit::Volt => None,
        ChannelUnit::Micrometre => {
            let period_s = match &wired.instrument.facts {
                InstrumentFacts::StageController(facts) => 1.0 / facts.rate_hz,
                InstrumentFacts::MachineController(facts) => 1.0 / facts.rate_hz,
                // The sampling of voltages is chosen where they are written.
                InstrumentFacts::WaveformGenerator(_)
                | InstrumentFacts::DataAcquisition(_)
                | InstrumentFacts::ElectrodeDriver(_) => 0.0,
            };
            let finding = stage.beyond_travel().or_else(|| stage.too_fast());
            finding.or_else(|| stage.turns_too_sharply(spare_um(claims, &wired.channel.device)?, period_s))
        }
    }
}

/// Allowed deviation of a stage from a device's path, in micrometres: half of the smallest tolerance of the device's
/// tasks.
fn spare_um(claims: &Claims, device: &str) -> Option<f64> {
    Some(claims.tolerance_um(device)? / 2.0)
}

/// A channel of positions, and the stage that follows it.
struct FollowingStage<'a> {
    wired: &'a WiredChannel<'a>,
    all: &'a [WiredChannel<'a>],
}

fn speed(um_per_s: f64) -> Quantity {
    Quantity::new(um_per_s / 1e6, Dimension::SPEED)
}

fn acceleration(um_per_s2: f64) -> Quantity {
    Quantity::new(um_per_s2 / 1e6, Dimension::ACCELERATION)
}

fn seconds(s: f64) -> Quantity {
    Quantity::new(s, Dimension::TIME)
}

impl FollowingStage<'_> {
    fn finding(&self, title: String, at_wire: String, step: u32) -> Diagnostic {
        self.wired.finding(Code::E0624, title, at_wire, step)
    }

    /// The stages on the same wire, this one included: they share any change of the wire.
    fn of_wire(&self) -> impl Iterator<Item = &WiredChannel<'_>> {
        self.all.iter().filter(|other| other.drive.span == self.wired.drive.span)
    }

    /// A position beyond the travel of the stage.
    fn beyond_travel(&self) -> Option<Diagnostic> {
        let Link::Axis { origin_um, direction, least_um, most_um } = self.wired.drive.link else { return None };
        let places = || self.wired.actuations.iter().flat_map(|one| [one.from, one.to].map(|value| (value, *one)));
        let beyond_um = |value: f64| {
            let own_um = self.wired.drive.link.at_output(value);
            (least_um - own_um).max(own_um - most_um)
        };
        let furthest = places().reduce(|best, next| if beyond_um(next.0) > beyond_um(best.0) { next } else { best });
        let (value, actuation) = furthest.filter(|(value, _)| beyond_um(*value) > 0.0)?;
        let (name, at, own) = (
            &self.wired.channel.name,
            Quantity::length_um(value),
            Quantity::length_um(self.wired.drive.link.at_output(value)),
        );
        let [least, most] = [least_um, most_um].map(Quantity::length_um);
        let title = format!("`{name}` at {at} is {own} on its stage, which travels from {least} to {most}");
        let at_wire = format!("`origin` of {}", Quantity::length_um(origin_um));
        let ways_um: Vec<[f64; 2]> = self.of_wire().filter_map(ends_um).collect();
        let help = origin_help(&ways_um, ends_um(self.wired)?, [least_um, most_um], direction);
        Some(self.finding(title, at_wire, actuation.step).help(help))
    }

    /// A speed beyond the greatest speed of the stage.
    fn too_fast(&self) -> Option<Diagnostic> {
        let most = self.wired.drive.limits.speed_um_per_s?;
        let size = |one: &&Actuation| one.speed_um_per_s().abs();
        let fastest = self
            .wired
            .actuations
            .iter()
            .copied()
            .reduce(|best, next| if size(&next) > size(&best) { next } else { best });
        let actuation = fastest.filter(|one| size(one) > most * QUOTIENT_ROOM)?;
        let asked = size(&actuation);
        let title = format!(
            "`{}` moves at {}, but its stage reaches at most {}",
            self.wired.channel.name,
            speed(asked),
            speed(most)
        );
        let shares = self.of_wire().filter_map(|stage| {
            let fastest = stage.actuations.iter().map(|one| one.speed_um_per_s().abs()).fold(0.0, f64::max);
            Some(stage.drive.limits.speed_um_per_s? / fastest)
        });
        let share = shares.fold(most / asked, f64::min);
        Some(self.finding(title, format!("`speed` of {}", speed(most)), actuation.step).help(slower(share)))
    }

    /// A corner at which the stage deviates too far from its path, for controller points `period_s` apart.
    fn turns_too_sharply(&self, spare_um: f64, period_s: f64) -> Option<Diagnostic> {
        let (limits, schedule) = (self.wired.drive.limits, self.wired.schedule);
        let share = |jump: &SpeedJump| slowed(limits, jump, period_s, spare_um);
        let jumps = schedule.speed_jumps(self.wired.index).into_iter();
        let jump = jumps.reduce(|worst, next| if share(&next) < share(&worst) { next } else { worst })?;
        if share(&jump) * QUOTIENT_ROOM >= 1.0 {
            return None;
        }
        let (name, change) = (&self.wired.channel.name, speed(jump.change_um_per_s));
        let takes_s = limits.acceleration_um_per_s2.map_or(0.0, |most| jump.change_um_per_s / most);
        let room_s = jump.room_ns as f64 / 1e9;
        let rounding_um = limits.corner_rounding_um(jump.change_um_per_s);
        let title = if takes_s > room_s {
            let [room, takes] = [room_s, takes_s].map(seconds);
            format!(
                "`{name}` changes its speed by {change} and keeps it for {room}, but its stage takes {takes} for the change"
            )
        } else {
            let off = Quantity::length_um(rounding_um + corner_cut_um(jump.change_um_per_s, period_s));
            format!("`{name}` changes its speed by {change}; its stage is {off} off its path there")
        };
        let by_stage = limits.acceleration_um_per_s2.map(|most| {
            format!(
                "{} off because of its `acceleration` of {}; ",
                Quantity::length_um(rounding_um),
                acceleration(most)
            )
        });
        let by_places = Some(format!("positions {} apart; ", seconds(period_s))).filter(|_| period_s > 0.0);
        let at_wire: String = by_stage.into_iter().chain(by_places).collect();
        let at_wire = format!("{at_wire}half of the tolerance is {}", Quantity::length_um(spare_um));
        let shares = self.of_wire().flat_map(|stage| {
            let jumps = schedule.speed_jumps(stage.index).into_iter();
            jumps.map(move |jump| slowed(stage.drive.limits, &jump, period_s, spare_um)).collect::<Vec<f64>>()
        });
        Some(self.finding(title, at_wire, jump.step).help(slower(shares.fold(share(&jump), f64::min))))
    }
}

/// The least and the greatest value of a path; `None` if there are no actuations.
fn ends_um(wired: &WiredChannel) -> Option<[f64; 2]> {
    let values = wired.actuations.iter().flat_map(|one| [one.from, one.to]);
    values.fold(None, |ends, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([value.min(low), value.max(high)])
    })
}

/// Advice for speeds that are too high: `share` of them is not.
fn slower(share: f64) -> String {
    match (share * 100.0).floor() {
        percent if percent >= 1.0 => format!("lower the speeds of the device to {percent} % of their values"),
        _ => "use another stage or controller: this one cannot follow even 1 % of the speeds".to_owned(),
    }
}

/// The share of its speed at which a stage can follow a corner: the deviation then stays within `spare_um` (a
/// quadratic equation), and the change fits into the time for it, which grows while the change gets shorter. Above 1
/// if it can follow at full speed.
fn slowed(limits: StageLimits, jump: &SpeedJump, period_s: f64, spare_um: f64) -> f64 {
    let (rounding, cut) =
        (limits.corner_rounding_um(jump.change_um_per_s), corner_cut_um(jump.change_um_per_s, period_s));
    let within = match rounding > 0.0 {
        true => ((cut * cut + 4.0 * rounding * spare_um).sqrt() - cut) / (2.0 * rounding),
        false => spare_um / cut,
    };
    let takes_ns = limits.acceleration_um_per_s2.map_or(0.0, |most| jump.change_um_per_s / most * 1e9);
    within.min((jump.room_ns as f64 / takes_ns).sqrt())
}

/// Advice on the origin, such that all paths, each given by its two ends, fit into the travel, or else such that the
/// path `own_um` does.
fn origin_help(ways_um: &[[f64; 2]], own_um: [f64; 2], travel_um: [f64; 2], direction: Direction) -> String {
    let widest = |[low, high]: [f64; 2], way: &[f64; 2]| [low.min(way[0]), high.max(way[1])];
    let all_um = ways_um.iter().fold(own_um, widest);
    let way = Quantity::length_um(own_um[1] - own_um[0]);
    match (origin_within(all_um, travel_um, direction), origin_within(own_um, travel_um, direction)) {
        (Some(origin_um), _) => format!("move position 0 on the stage: write `origin: {origin_um} um`"),
        (None, Some(origin_um)) => format!(
            "no `origin` fits all stages of this wire: give each channel a wire of its own, this one with `origin: {origin_um} um`"
        ),
        (None, None) => {
            format!("the motion spans {way}: use a stage that travels as far, or keep the hand in a smaller space")
        }
    }
}

/// The middle of the origins with which a path fits into a travel; `None` if there are none.
fn origin_within([low_um, high_um]: [f64; 2], [least_um, most_um]: [f64; 2], direction: Direction) -> Option<f64> {
    let [low_um, high_um] = match direction {
        Direction::Forward => [low_um, high_um],
        Direction::Backward => [-high_um, -low_um],
    };
    let [first_um, last_um] = [least_um - low_um, most_um - high_um];
    if first_um > last_um {
        return None;
    }
    let middle_um = (first_um + last_um) / 2.0;
    let round_um = middle_um.round();
    let nanometres_um = (middle_um * 1e3).round() / 1e3;
    Some(if (first_um..=last_um).contains(&round_um) { round_um } else { nanometres_um })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_where_the_whole_way_has_room() {
        let help = |ends_um, direction| origin_help(&[ends_um], ends_um, [0.0, 100.0], direction);
        assert!(help([-30.0, 50.0], Direction::Forward).ends_with("`origin: 40 um`"));
        assert!(help([-30.0, 50.0], Direction::Backward).ends_with("`origin: 60 um`"));
        assert!(
            help([-0.1, 99.7], Direction::Forward).ends_with("`origin: 0.2 um`"),
            "{}",
            help([-0.1, 99.7], Direction::Forward)
        );
        assert!(help([-30.0, 71.0], Direction::Forward).starts_with("the motion spans 101 um"));
        let beside =
            |other_um| origin_help(&[[-30.0, 50.0], other_um], [-30.0, 50.0], [0.0, 100.0], Direction::Forward);
        assert!(beside([-45.0, 20.0]).ends_with("`origin: 48 um`"), "{}", beside([-45.0, 20.0]));
        assert!(beside([20.0, 90.0]).starts_with("no `origin` fits all"), "{}", beside([20.0, 90.0]));
    }

    #[test]
    fn a_speed_that_is_advised_is_slow_enough() {
        let limits = StageLimits { speed_um_per_s: None, acceleration_um_per_s2: Some(500.0) };
        for (change_um_per_s, period_s) in [(20.0, 0.0), (20.0, 1e-3), (300.0, 1e-3), (300.0, 5e-5)] {
            let jump = SpeedJump { t_ns: 0, change_um_per_s, room_ns: u64::MAX, step: 0 };
            let share = slowed(limits, &jump, period_s, 0.025);
            let off_um = |share: f64| {
                limits.corner_rounding_um(share * change_um_per_s) + corner_cut_um(share * change_um_per_s, period_s)
            };
            assert!((off_um(share) - 0.025).abs() < 1e-12, "{share}");
        }
    }
}
