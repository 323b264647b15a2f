//! Stage controllers: for each controller of the program the places of its axes, and a program that plays them.
//!
//! `<name>.<controller>.stages.csv` has a row for each point at which a stage may turn: its number from 0, and the
//! place of each stage then, in micrometres of its own travel. Between two rows all stages move on straight lines;
//! points are spaced by the period that the first line names. If a path turns between two points, both are rows, and
//! the path is cut by [`corner_cut_um`] at the most. `<name>.stages.py` plays the rows: on PI controllers as straight
//! segments of wave tables, on a SmarAct MCS2 as a stream of places. At the end, on an error and on Ctrl-C stages stay
//! where they are.
//!
//! The period is the shortest for which the tables of the controller hold the schedule: a whole number of its own
//! periods, and no longer than the tolerance of the hand allows. Corners are cut by no more than what the acceleration
//! of the stage leaves of half of the tolerance.
//!
//! A schedule that waits for inputs or people has a file for each part, `<name>.<controller>.1.stages.csv` and so on.

use super::csv::one_line;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::hold_parts::played;
use super::sampling::SAMPLE_UM;
use super::wired::WiredInstrument;
use super::{Format, Signals};
use crate::claims::Claims;
use crate::device::instrument::{
    Family, InstrumentFacts, Link, StageControllerFacts, StageProtocol, Start, corner_cut_um, number_after,
};
use crate::schedule::Schedule;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The sender, with an empty list of controllers at the marker.
const SENDER: &str = include_str!("send.py");

/// Estimated bytes of a row without its places, and of a place.
const ROW_BYTES: u64 = 8;
const PLACE_BYTES: u64 = 12;

/// Places are rounded to picometres.
const PARTS_OF_UM: f64 = 1e6;

/// The files, each with its ending.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::Jump`], [`EmitError::Unsupported`], [`EmitError::TooLongForTable`],
/// [`EmitError::TooLarge`].
pub(super) fn write(schedule: &Schedule, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    played(schedule, Format::Stages, Family::StageController, "controllers", SENDER, |wired, number| {
        let InstrumentFacts::StageController(facts) = &wired.instrument.facts else { return Ok(None) };
        let controller = StageTables::new(wired, facts, claims)?;
        let ending = format!("{}{number}.stages.csv", wired.name);
        Ok(Some((controller.listing(&ending), (ending, controller.text()?.into_bytes()))))
    })
}

/// A controller with the paths of its axes.
struct StageTables<'a> {
    wired: &'a WiredInstrument<'a>,
    facts: &'a StageControllerFacts,
    signals: Signals<'a>,
    /// The channel of each wired axis, by its number.
    axes: BTreeMap<u32, usize>,
    /// Number of controller periods between two points.
    every: u64,
}

impl<'a> StageTables<'a> {
    fn new(
        wired: &'a WiredInstrument<'a>,
        facts: &'a StageControllerFacts,
        claims: &Claims,
    ) -> Result<StageTables<'a>, EmitError> {
        refuse_several(wired, facts)?;
        let signals = Signals::new(&wired.schedule);
        EmitError::refuse_jumps(Format::Stages, &signals)?;
        let numbers = wired.drives.iter().map(|drive| number_after("axis", &drive.output));
        let axes = numbers.enumerate().filter_map(|(channel, number)| Some((number?, channel))).collect();
        let mut controller = StageTables { wired, facts, signals, axes, every: 1 };
        if let Some(most_points) = facts.most_points.map(u64::from) {
            let points = controller.last_point();
            controller.every = points.div_ceil(most_points).max(1);
            let most = controller.most_periods(claims);
            if controller.every > most {
                controller.every = most;
                let (points, period_ns) = (controller.last_point(), controller.period_ns());
                let instrument = wired.name.to_owned();
                return Err(EmitError::TooLongForTable { instrument, points, limit: most_points, period_ns });
            }
        }
        Ok(controller)
    }

    /// The most periods between two points such that no corner is cut too far; at least 1, which was checked before.
    fn most_periods(&self, claims: &Claims) -> u64 {
        let period_s = 1.0 / self.facts.rate_hz;
        let of_axis = |channel: &usize| {
            let schedule = self.signals.schedule;
            let spare_um = claims.tolerance_um(&schedule.channels[*channel].device).unwrap_or(SAMPLE_UM) / 2.0;
            let limits = self.wired.drives[*channel].limits;
            let most = |change: f64| (spare_um - limits.corner_rounding_um(change)) / corner_cut_um(change, period_s);
            schedule
                .speed_jumps(*channel)
                .into_iter()
                .map(|jump| most(jump.change_um_per_s))
                .fold(f64::INFINITY, f64::min)
        };
        self.axes.values().map(of_axis).fold(f64::INFINITY, f64::min).max(1.0) as u64
    }

    /// Time from one point to the next, in nanoseconds.
    fn period_ns(&self) -> f64 {
        self.every as f64 * 1e9 / self.facts.rate_hz
    }

    /// The number of the point at the end of the schedule, or the first after it.
    fn last_point(&self) -> u64 {
        self.point(self.signals.schedule.duration_ns)[1].max(1)
    }

    /// The last point at or before an instant, and the first at or after it.
    fn point(&self, t_ns: u64) -> [u64; 2] {
        let points = t_ns as f64 / self.period_ns();
        // The quotient is whole up to rounding.
        let whole = points.round();
        let is_whole = (points - whole).abs() <= points * 1e-12;
        if is_whole { [whole as u64; 2] } else { [points.floor() as u64, points.ceil() as u64] }
    }

    /// Position of the stage of a channel at a point, in micrometres of its own travel.
    fn place_um(&self, channel: usize, point: u64) -> f64 {
        let t_ns = ((point as f64 * self.period_ns()).round() as u64).min(self.signals.schedule.duration_ns);
        let place_um = self.wired.drives[channel].link.at_output(self.signals.value(channel, t_ns));
        (place_um * PARTS_OF_UM).round() / PARTS_OF_UM
    }

    fn text(&self) -> Result<String, EmitError> {
        let schedule = self.signals.schedule;
        let turns = self.signals.breaks(self.axes.values().copied());
        // Values held by a wait extend beyond the end of the part before it.
        let turns = turns.into_iter().filter(|t_ns| *t_ns <= schedule.duration_ns);
        let mut points: BTreeSet<u64> = turns.flat_map(|t_ns| self.point(t_ns)).collect();
        points.extend([0, self.last_point()]);
        let bytes = points.len() as u64 * (ROW_BYTES + self.axes.len() as u64 * PLACE_BYTES);
        EmitError::refuse_size(Format::Stages, bytes, MAX_TEXT_BYTES)?;
        let mut text = format!(
            "# {} on {}: stages move straight from row to row; points are {} ns apart\n",
            one_line(&schedule.name),
            one_line(self.wired.name),
            self.period_ns()
        );
        for (number, channel) in &self.axes {
            let Link::Axis { origin_um, direction, .. } = self.wired.drives[*channel].link else { continue };
            let name = one_line(&schedule.channels[*channel].name);
            let _ = writeln!(text, "# axis{number} is {name}, whose 0 is at {origin_um} um, {}", direction.name());
        }
        text.push_str("point");
        self.axes.keys().for_each(|number| text.push_str(&format!(",axis{number} [um]")));
        text.push('\n');
        for point in points {
            let _ = write!(text, "{point}");
            for channel in self.axes.values() {
                let _ = write!(text, ",{}", self.place_um(*channel, point));
            }
            text.push('\n');
        }
        Ok(text)
    }

    /// Data for the sender.
    fn listing(&self, ending: &str) -> serde_json::Value {
        let travels: Vec<[f64; 2]> = self
            .axes
            .values()
            .filter_map(|channel| match self.wired.drives[*channel].link {
                Link::Axis { least_um, most_um, .. } => Some([least_um, most_um]),
                Link::Amplifier { .. } | Link::StageDriver { .. } | Link::Switch { .. } => None,
            })
            .collect();
        json!({
            "name": self.wired.name,
            "model": self.wired.instrument.model,
            "protocol": self.facts.protocol.name(),
            "file": format!("{}.{ending}", self.signals.schedule.name),
            "axes": self.axes.keys().collect::<Vec<_>>(),
            "travels_um": travels,
            "rate_hz": self.facts.rate_hz,
            "every": self.every,
            "points": self.last_point(),
            "waits_for_trigger": self.facts.start == Start::Trigger,
            "leads": self.wired.leads,
        })
    }
}

/// An error for a controller that cannot start together with other instruments.
fn refuse_several(wired: &WiredInstrument, facts: &StageControllerFacts) -> Result<(), EmitError> {
    let is_alone = wired.is_alone && facts.start == Start::Sender;
    match facts.protocol {
        StageProtocol::Mcs2 if !is_alone => Err(EmitError::Unsupported {
            format: Format::Stages,
            what: format!(
                "`{}` with other instruments: its streams start once enough of them has been sent",
                wired.name
            ),
            help: "wire all channels of the program to it, without `start: trigger`".to_owned(),
        }),
        StageProtocol::Mcs2 | StageProtocol::Gcs => Ok(()),
    }
}

#[cfg(test)]
pub(super) mod tests;
