//! Report of plans for electrode arrays.

use super::{Note, ReportTopic, ReportedDevice, ReportedOrder, ReportedRun, length};
use crate::claims::Claims;
use crate::claims::electrode_array::{BoardZone, ElectrodeArrayOrder};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::State;
use std::collections::{BTreeMap, BTreeSet};

impl ReportedOrder for ElectrodeArrayOrder {
    /// The droplets that cross a heater outside their own heating operation.
    fn notes(&self, run: &ReportedRun) -> Vec<Note> {
        let temperatures_k = temperatures_k(self);
        let heaters = temperatures_k.iter().filter_map(|(zone, k)| Some((self.zones.get(*zone)?, *k)));
        let crossings = heaters.flat_map(|(heater, k)| crossings(self, run, heater, k));
        crossings.map(|text| (ReportTopic::Crosses, text)).collect()
    }
}

/// The heaters in use, by zone index, each with its temperature in kelvin.
fn temperatures_k(order: &ElectrodeArrayOrder) -> BTreeMap<usize, f64> {
    let operations = order.steps.iter().flat_map(|step| step.action.operations());
    operations.flat_map(|one| one.zone_stays()).filter_map(|stay| Some((stay.zone, stay.temperature_k?))).collect()
}

/// A line for each droplet that is over a heater while no operation heats it there: temperature, total time and first
/// instant.
fn crossings(order: &ElectrodeArrayOrder, run: &ReportedRun, heater: &BoardZone, k: f64) -> Vec<String> {
    let mut heated: BTreeMap<&str, Vec<[u64; 2]>> = BTreeMap::new();
    for (asked, step) in order.steps.iter().zip(&run.steps) {
        for (_, on) in
            asked.action.operations().iter().zip(&step.operations).filter(|(operation, _)| operation.zone.is_some())
        {
            on.parts.iter().for_each(|part| heated.entry(part).or_default().push([on.arrival_ns, on.end_ns()]));
        }
    }
    let mut lines = Vec::new();
    for part in parts_of(run) {
        let is_heated = |[from, to]: [u64; 2]| {
            let own = heated.get(part).into_iter().flatten();
            own.into_iter().any(|[begin, end]| from <= *end && *begin <= to)
        };
        let stays: Vec<[u64; 2]> = stays(run, part, heater).into_iter().filter(|stay| !is_heated(*stay)).collect();
        let Some([first_ns, _]) = stays.first() else { continue };
        let lasts_ns: u64 = stays.iter().map(|[from, to]| to - from).sum();
        let [lasts, since] = [lasts_ns, *first_ns].map(Quantity::time_ns);
        let temperature = Quantity::new(k, Dimension::TEMPERATURE);
        lines.push(format!(
            "`{part}` is over heater `{}` at {temperature} for {lasts} on its way, first at {since}",
            heater.name
        ));
    }
    lines
}

fn parts_of<'r>(run: &'r ReportedRun) -> BTreeSet<&'r str> {
    let states = run.plan.states.iter().filter_map(|timed| match &timed.state {
        State::ElectrodeArray(state) => Some(state.parts.iter().map(|(name, _)| name)),
        State::Dimibot(_) | State::Microrobots(_) | State::Fingers(_) => None,
    });
    states.flatten().collect()
}

/// Intervals in which a part is on electrodes of a zone without a break.
fn stays(run: &ReportedRun, part: &str, zone: &BoardZone) -> Vec<[u64; 2]> {
    let ends = run.plan.states.iter().skip(1).map(|timed| timed.t_ns);
    let ends = ends.chain([run.plan.end_ns()]);
    let mut stays: Vec<[u64; 2]> = Vec::new();
    for (timed, end_ns) in run.plan.states.iter().zip(ends) {
        let State::ElectrodeArray(state) = &timed.state else { continue };
        let is_there =
            state.parts.get(part).is_some_and(|[column, row]| zone.contains(ElectrodeCell::new(column, row)));
        match stays.last_mut() {
            _ if !is_there => {}
            Some(last) if last[1] == timed.t_ns => last[1] = end_ns,
            Some(_) | None => stays.push([timed.t_ns, end_ns]),
        }
    }
    stays
}

impl ReportedDevice for ElectrodeArrayFacts {
    fn describe(&self, name: &str, _claims: &[Claims]) -> String {
        let (columns, rows, pitch) = (self.columns, self.rows, length(self.pitch_um()));
        format!("{name}: electrode_array, {columns} x {rows} electrodes {pitch} apart\n")
    }
}
