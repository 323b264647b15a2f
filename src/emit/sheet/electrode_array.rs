//! Droplet boards on the sheet: reservoirs and droplets to load, operations by time, and the final state.

use super::{Sheet, SheetRow, holds, time};
use crate::claims::Job;
use crate::claims::electrode_array::{
    AssayOperation, BoardZone, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop,
    ZoneSort, ZoneStay,
};
use crate::device::electrode_array::{ElectrodeCell, Electrodes, droplets};
use crate::emit::electrode_array::motion::at_chosen_places;
use crate::quantity::{Dimension, Quantity, fraction};
use crate::schedule::PartCells;
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{Schedule, ScheduledOperation, ScheduledStep, State, TimedState};
use crate::verify::Verified;
use crate::verify::electrode_array::{DropletAfter, droplets_after};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// A board with its runs in order.
pub(super) struct SheetBoard<'v> {
    device: &'v str,
    schedule: &'v Schedule,
    /// By plan index.
    runs: Vec<(usize, Cow<'v, ElectrodeArrayOrder>)>,
    /// Contents of its droplets at the end, or when they were last on the board.
    droplets: BTreeMap<&'v str, DropletAfter<'v>>,
    /// Whether steps switch outputs of the bench.
    has_outputs: bool,
}

/// The boards of a schedule that carry droplets.
pub(super) fn boards(verified: &Verified) -> Vec<SheetBoard<'_>> {
    let mut boards: Vec<SheetBoard> = Vec::new();
    for (plan, job) in verified.claims().jobs.iter().enumerate() {
        let Some(order) = order_of_droplets(job) else { continue };
        let steps = verified.schedule().steps.iter().filter(|step| step.plan as usize == plan);
        let order = at_chosen_places(order, steps);
        match boards.iter_mut().find(|board| board.device == job.device) {
            Some(board) => board.runs.push((plan, order)),
            None => boards.push(SheetBoard {
                device: &job.device,
                schedule: verified.schedule(),
                runs: vec![(plan, order)],
                droplets: droplets_after(verified.claims(), &job.device),
                has_outputs: !verified.claims().outputs.is_empty(),
            }),
        }
    }
    boards
}

fn order_of_droplets(job: &Job) -> Option<&ElectrodeArrayOrder> {
    ElectrodeArrayOrder::of(&job.order).filter(|order| order.facts.layout.electrodes == Electrodes::Single)
}

/// Events and waits on all boards, by time.
pub(super) fn run(verified: &Verified, boards: &[SheetBoard]) -> Vec<[String; 4]> {
    let mut rows: Vec<SheetRow> = holds::rows(verified).collect();
    for board in boards {
        let device = board.device;
        rows.extend(board.rows().chain(board.gaps()).map(|(times, text)| SheetRow {
            times,
            end: time(times[1]),
            device,
            text,
        }));
    }
    rows.sort_by_key(|row| row.times);
    rows.into_iter().map(|row| [time(row.times[0]), row.end, row.device.to_owned(), row.text]).collect()
}

impl SheetBoard<'_> {
    /// Writes what to load before the run.
    pub(super) fn load(&self, sheet: &mut Sheet) {
        sheet.line(&format!("\n## Load `{}`", self.device));
        let mut rows: Vec<[String; 4]> = Vec::new();
        for (fluid, (cell, count)) in self.reservoirs() {
            rows.push(row(format!("reservoir `{fluid}`"), format!("outlet {cell}"), droplets(count as f64)));
        }
        for (name, (zone, stay)) in self.zones() {
            let place = match zone.from == zone.to {
                true => format!("electrode {}", zone.from),
                false => format!("electrodes {} to {}", zone.from, zone.to),
            };
            let needed = stay.temperature_k.map_or("on".to_owned(), temperature);
            // Only the bench knows which zone an output acts on.
            let needed = match zone.sort {
                ZoneSort::Heater | ZoneSort::Magnet if self.has_outputs => {
                    format!("{needed}, unless an output switches it")
                }
                ZoneSort::Heater | ZoneSort::Magnet | ZoneSort::Detector => needed,
            };
            rows.push(row(format!("{} `{name}`", zone.sort.name()), place, needed));
        }
        let mut placed = BTreeSet::new();
        for part in self.runs.iter().flat_map(|(_, order)| order.parts.iter()) {
            if let Some(cell) = part.cell.filter(|_| placed.insert(&part.name)) {
                rows.push(row(format!("droplet `{}`", part.name), format!("electrode {cell}"), droplets(1.0)));
            }
        }
        sheet.table(["", "what", "where", "needed"], rows);
        for (_, order) in &self.runs {
            let contamination = &order.contamination;
            for fluid in contamination.avoided.iter().map(|trace| &trace.of).collect::<BTreeSet<_>>() {
                let others = contamination.avoided.iter().filter(|trace| trace.of == *fluid);
                let others: Vec<String> = others.map(|trace| format!("`{}`", trace.within)).collect();
                sheet.paragraph(&format!("No traces of `{fluid}` come into {}.", others.join(", ")));
            }
        }
    }

    /// The reservoirs in use, with their outlets and the number of droplets that they dispense.
    fn reservoirs(&self) -> BTreeMap<&str, (ElectrodeCell, usize)> {
        let mut reservoirs = BTreeMap::new();
        for operation in self.runs.iter().flat_map(|(_, order)| operations_of(order)) {
            if let (Some(fluid), Some(outlet)) = (&operation.fluid, operation.stops.first()) {
                reservoirs.entry(fluid.as_str()).or_insert((outlet.cell, 0)).1 += 1;
            }
        }
        reservoirs
    }

    /// The heaters, detectors and magnets in use, each with a stay there.
    fn zones(&self) -> BTreeMap<&str, (&BoardZone, ZoneStay)> {
        let mut zones = BTreeMap::new();
        for (_, order) in &self.runs {
            for stay in operations_of(order).filter_map(|operation| operation.zone) {
                zones.extend(order.zones.get(stay.zone).map(|zone| (zone.name.as_str(), (zone, stay))));
            }
        }
        zones
    }

    /// The intervals between runs, in which all electrodes are off.
    fn gaps(&self) -> impl Iterator<Item = ([u64; 2], String)> {
        let plans = self.runs.iter().filter_map(|(plan, _)| self.schedule.plans.get(*plan));
        let times: Vec<[u64; 2]> = plans.map(|plan| [plan.start_ns, plan.end_ns()]).collect();
        let gaps = times.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
        let gaps: Vec<[u64; 2]> = gaps.filter(|[end, start]| end < start).collect();
        gaps.into_iter().map(|gap| (gap, "no electrode is on: nothing holds the droplets".to_owned()))
    }

    /// Events on the board with their times, except its waits for an input or a person.
    fn rows(&self) -> impl Iterator<Item = ([u64; 2], String)> {
        let holds: BTreeSet<u32> = self.schedule.holds.iter().map(|hold| hold.step).collect();
        let steps: Vec<(bool, &ScheduledStep)> =
            (0..).zip(&self.schedule.steps).map(|(index, step)| (holds.contains(&index), step)).collect();
        self.runs.iter().flat_map(move |(plan, order)| {
            let own = steps.iter().filter(|(_, step)| step.plan as usize == *plan);
            let asked = order.steps.iter().zip(own).filter(|(_, (is_hold, _))| !is_hold);
            let states = self.schedule.plans.get(*plan).map_or(&[][..], |plan| &plan.states);
            asked.flat_map(|(asked, (_, step))| rows_of(order, &asked.action, step, states)).collect::<Vec<_>>()
        })
    }

    /// Writes what is on the board at the end, and where droplets left it.
    pub(super) fn leave(&self, sheet: &mut Sheet) {
        sheet.line(&format!("\n## Afterwards on `{}`", self.device));
        let mut ports: BTreeMap<ElectrodeCell, Vec<String>> = BTreeMap::new();
        for (_, order) in &self.runs {
            for operation in operations_of(order).filter(|operation| operation.leaves) {
                let name = order.parts[operation.part].name.as_str();
                if let Some(port) = operation.stops.last() {
                    ports.entry(port.cell).or_default().push(self.content(name));
                }
            }
        }
        let mut rows: Vec<[String; 2]> = Vec::new();
        for (name, [column, row]) in self.last_state() {
            rows.push([format!("electrode ({column}, {row})"), self.content(name)]);
        }
        rows.extend(ports.into_iter().map(|(port, all)| [format!("left at {port}"), all.join("; ")]));
        sheet.table(["where", "what"], rows);
    }

    fn last_state(&self) -> impl Iterator<Item = (&str, [u32; 2])> {
        let last = self.runs.last().and_then(|(plan, _)| self.schedule.plans.get(*plan));
        let parts = match last.and_then(|plan| plan.states.last()).map(|timed| &timed.state) {
            Some(State::ElectrodeArray(ElectrodeArrayState { parts })) => Some(parts),
            _ => None,
        };
        parts.into_iter().flat_map(PartCells::iter)
    }

    /// `` `sample`, 2 droplets: 1/4 dye, 3/4 buffer ``
    fn content(&self, name: &str) -> String {
        let Some(DropletAfter { volume, shares }) = self.droplets.get(name) else { return format!("`{name}`") };
        let text = |(fluid, share): (&&str, &f64)| match shares.len() {
            1 => (*fluid).to_owned(),
            _ => format!("{} {fluid}", fraction(*share)),
        };
        let shares: Vec<String> = shares.iter().map(text).collect();
        format!("`{name}`, {}: {}", droplets(*volume), shares.join(", "))
    }
}

fn temperature(temperature_k: f64) -> String {
    Quantity::new(temperature_k, Dimension::TEMPERATURE).to_string()
}

fn row(what: String, place: String, needed: String) -> [String; 4] {
    ["☐".to_owned(), what, place, needed]
}

fn operations_of(order: &ElectrodeArrayOrder) -> impl Iterator<Item = &AssayOperation> {
    order.steps.iter().flat_map(|step| step.action.operations())
}

/// Events of a step, with the times of its operations.
fn rows_of(
    order: &ElectrodeArrayOrder,
    action: &ElectrodeArrayAction,
    step: &ScheduledStep,
    states: &[TimedState],
) -> Vec<([u64; 2], String)> {
    let all = [step.start_ns, step.end_ns()];
    match action {
        ElectrodeArrayAction::Wait(0) => vec![(all, step.text.clone())],
        ElectrodeArrayAction::Wait(_) => vec![(all, "nothing moves".to_owned())],
        ElectrodeArrayAction::Move(moves) => {
            let from = states.partition_point(|timed| timed.t_ns < step.start_ns);
            let to = states.partition_point(|timed| timed.t_ns <= step.end_ns());
            let times = |one: &ElectrodeArrayMove| match (one.with, arrival_ns(order, one, &states[from..to])) {
                (Some(_), Some(met_ns)) => [met_ns; 2],
                (None, Some(arrival_ns)) => [step.start_ns, arrival_ns],
                (_, None) => all,
            };
            moves.iter().map(|one| (times(one), moved(order, one))).collect()
        }
        ElectrodeArrayAction::Assay(operations) => {
            let timed = operations.iter().zip(&step.operations);
            timed
                .map(|(operation, on)| {
                    let stay_ns = on.end_ns() - on.arrival_ns;
                    ([begins_ns(operation, on), on.end_ns()], done(order, operation, stay_ns))
                })
                .collect()
        }
    }
}

/// The instant from which a droplet is at its goal or has merged; `None` if the states do not tell.
fn arrival_ns(order: &ElectrodeArrayOrder, one: &ElectrodeArrayMove, states: &[TimedState]) -> Option<u64> {
    let goal = one.goal().cell;
    // For a team, whichever part is there at the end.
    let at_goal =
        states.last()?.state.cells()?.iter().find(|(_, [column, row])| ElectrodeCell::new(*column, *row) == goal);
    let (name, merged) = match one.with {
        Some(with) => (order.parts.get(with)?.name.as_str(), true),
        None => (at_goal?.0, false),
    };
    let arrived = |timed: &&TimedState| match timed.state.cells().and_then(|cells| cells.get(name)) {
        Some([column, row]) => !merged && ElectrodeCell::new(column, row) == goal,
        None => merged,
    };
    states.iter().rev().take_while(arrived).last().map(|timed| timed.t_ns)
}

/// Start of an operation: when its droplets are at its place or, if they only move, when they are free to go.
fn begins_ns(operation: &AssayOperation, on: &ScheduledOperation) -> u64 {
    let only_goes = operation.with.is_none() && operation.splits.is_none() && on.end_ns() == on.arrival_ns;
    if only_goes { on.start_ns } else { on.arrival_ns }
}

fn name(order: &ElectrodeArrayOrder, part: usize) -> String {
    order.parts.get(part).map_or(String::new(), |part| format!("`{}`", part.name))
}

fn moved(order: &ElectrodeArrayOrder, one: &ElectrodeArrayMove) -> String {
    let (part, goal) = (name(order, one.part), one.goal().cell);
    if one.team.is_some() {
        let family = order.parts.get(one.part).and_then(|part| part.family()).unwrap_or_default();
        return format!("one of `{family}` goes to {goal}");
    }
    match one.with {
        Some(with) => format!("{part} and {} merge at {goal}", name(order, with)),
        None => {
            let by = one.stops.split_last().map_or(&[][..], |(_, by)| by);
            let by: Vec<String> = by.iter().map(|stop| stop.cell.to_string()).collect();
            let by = if by.is_empty() { String::new() } else { format!(" by way of {}", by.join(", ")) };
            format!("{part} goes to {goal}{by}")
        }
    }
}

/// An operation in words; `stay_ns` is the duration of its final stay.
fn done(order: &ElectrodeArrayOrder, operation: &AssayOperation, stay_ns: u64) -> String {
    let part = name(order, operation.part);
    let at = |stop: Option<&ElectrodeArrayStop>| stop.map_or(String::new(), |stop| format!(" at {}", stop.cell));
    let last = at(operation.stops.last());
    if let Some(with) = operation.with {
        return format!("{part} and {} merge{last}", name(order, with));
    }
    if let Some(half) = operation.splits {
        let first = at(operation.stops.first());
        return format!("{part} is split{first}: {} comes to {}", name(order, half.part), half.cell);
    }
    let stay = time(stay_ns);
    if let Some((in_zone, zone)) = operation.zone.and_then(|stay| Some((stay, order.zones.get(stay.zone)?))) {
        let name = &zone.name;
        return match zone.sort {
            ZoneSort::Heater => {
                let to = in_zone.temperature_k.map_or(String::new(), |k| format!(" to {}", temperature(k)));
                format!("{part} is heated{last} by `{name}`{to} for {stay}")
            }
            ZoneSort::Detector => format!("{part} is read{last} by `{name}` for {stay}"),
            ZoneSort::Magnet => format!("{part} is held{last} by `{name}` for {stay}"),
        };
    }
    match &operation.fluid {
        Some(fluid) if order.facts.reservoirs.is_some() => format!("reservoir `{fluid}` dispenses {part}{last}"),
        Some(fluid) => format!("{part} comes from reservoir `{fluid}`{last}, by hand where nothing dispenses it"),
        None if operation.leaves => format!("{part} leaves{last}"),
        None if operation.mixes => format!("{part} is mixed{last} for {stay}"),
        None if stay_ns > 0 => format!("{part} stays{last} for {stay}"),
        None => format!("{part} goes{}", last.replacen(" at", " to", 1)),
    }
}
