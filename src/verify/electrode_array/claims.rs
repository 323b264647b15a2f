//! Assumptions of the replay about the claims of an electrode array.
//!
//! Input: an order. Output: nothing, or the reason why no run can be checked against it. Claims of the checker always
//! pass.

use super::super::InvalidClaims;
use super::broadcast::JudgedChannels;
use crate::claims::electrode_array::{
    AssayOperation, BoardZone, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObstacleBody,
    ElectrodeArrayOrder, ElectrodeArrayStop, OperationLag, ZoneSort, ZoneStay,
};
use crate::device::electrode_array::{
    ElectrodeArrayFacts, ElectrodeCell, Electrodes, Hold, MAX_DISPENSE_FRAMES, MAX_PARTS, MAX_PLACED_PARTS, MAX_PLACES,
    MAX_SHARING, MAX_SIDE, MAX_STAY_STEPS, MAX_STAY_STEPS_OF_PART, MAX_ZONES, ReservoirPads, Separation,
};
use std::collections::{BTreeMap, BTreeSet};

/// The largest separation, in electrodes.
const MAX_SEPARATION: u32 = MAX_SIDE;

/// Checks the assumptions of all rules.
///
/// # Errors
/// If no schedule can be checked against the claims.
pub(super) fn check_claims(order: &ElectrodeArrayOrder) -> Result<(), InvalidClaims> {
    facts(&order.facts)?;
    parts(order)?;
    obstacles(order)?;
    zones(order)?;
    demand(
        order.contents.iter().all(|content| content.part < order.parts.len()),
        "ask for a part that they do not have",
    )?;
    let moving = || order.steps.iter().filter(|step| !matches!(step.action, ElectrodeArrayAction::Wait(_)));
    let is_assay = |action: &ElectrodeArrayAction| matches!(action, ElectrodeArrayAction::Assay(_));
    let in_one_assay = moving().count() <= 1 && moving().all(|step| is_assay(&step.action));
    demand(order.contamination.is_unheeded() || in_one_assay, "avoid traces across several steps")?;
    order.steps.iter().try_for_each(|step| match &step.action {
        ElectrodeArrayAction::Move(moves) => goals(order, moves),
        ElectrodeArrayAction::Assay(operations) => self::operations(order, operations),
        ElectrodeArrayAction::Wait(_) => Ok(()),
    })
}

fn invalid(why: &str) -> InvalidClaims {
    InvalidClaims(format!("the claims of an electrode array {why}"))
}

fn demand(holds: bool, why: &str) -> Result<(), InvalidClaims> {
    if holds { Ok(()) } else { Err(invalid(why)) }
}

fn facts(facts: &ElectrodeArrayFacts) -> Result<(), InvalidClaims> {
    let sides = 1..=MAX_SIDE;
    demand(sides.contains(&facts.columns) && sides.contains(&facts.rows), "have no electrode, or too many")?;
    let numbers = [facts.radius_um, facts.pitch_ratio, facts.potential_v, facts.layout.half_width_pitches];
    demand(numbers.iter().all(|number| number.is_finite()), "have a field that is not finite")?;
    demand(facts.potential_v > 0.0, "have a potential that is not above 0")?;
    demand(facts.step_ns > 0, "have a step of zero duration")?;
    demand(
        (0.0..=f64::from(MAX_SIDE)).contains(&facts.layout.half_width_pitches),
        "have a body with a size out of range",
    )?;
    demand(facts.clearance >= 1, "have a clearance below 1")?;
    let volumes = [facts.least_volume, facts.most_volume];
    demand(volumes.iter().flatten().all(|volume| volume.is_finite()), "have a volume that is not finite")?;
    demand(facts.mixer.iter().all(|side| (2..=MAX_SIDE).contains(side)), "have a mixing loop out of range")?;
    if let Some(map) = &facts.map {
        let places = facts.columns as usize * facts.rows as usize;
        let fits = map.columns == facts.columns && [0, places].contains(&map.channels.len());
        demand(fits, "have a map of another board")?;
        let sharing = JudgedChannels::new(facts).electrodes();
        let is_alone = facts.layout.electrodes == Electrodes::Single || sharing == 0;
        demand(is_alone, "share channels on a board of microparts")?;
        demand(sharing <= MAX_SHARING, "let too many electrodes share channels")?;
    }
    facts.reservoirs.as_ref().map_or(Ok(()), |pads| reservoirs(pads, facts))?;
    match facts.separation {
        Separation::Apart(cells) => demand((1..=MAX_SEPARATION).contains(&cells), "have a separation out of range"),
        Separation::AsPublished => Ok(()),
    }
}

/// Frames are whole steps of the board; each sequence begins with a pad of its own and ends with the outlet on.
fn reservoirs(pads: &ReservoirPads, facts: &ElectrodeArrayFacts) -> Result<(), InvalidClaims> {
    let is_whole = pads.frame_ns > 0 && pads.frame_ns.is_multiple_of(facts.step_ns);
    demand(is_whole, "have reservoir frames that are not whole steps of the board")?;
    let mut outlets = BTreeSet::new();
    let mut owners: BTreeMap<u32, usize> = BTreeMap::new();
    for (nth, sequence) in pads.sequences.iter().enumerate() {
        let outlet = sequence.outlet.pair().map(i64::from);
        demand(
            is_on_board(facts, outlet) && outlets.insert(sequence.outlet),
            "have an outlet off the board, or two outlets at one electrode",
        )?;
        let begins = sequence.frames.first().is_some_and(|first| !first.pads.is_empty());
        let ends = sequence.frames.last().is_some_and(|last| last.outlet);
        demand(
            begins && ends && sequence.frames.len() <= MAX_DISPENSE_FRAMES,
            "have frames that dispense no droplet, or too many frames",
        )?;
        let mut pads = sequence.frames.iter().flat_map(|frame| &frame.pads);
        demand(pads.all(|pad| *owners.entry(*pad).or_insert(nth) == nth), "give one pad to two reservoirs")?;
    }
    Ok(())
}

fn parts(order: &ElectrodeArrayOrder) -> Result<(), InvalidClaims> {
    let placed = order.parts.iter().filter(|part| part.cell.is_some()).count();
    demand(placed <= MAX_PLACED_PARTS && order.parts.len() <= MAX_PARTS, "have too many parts")?;
    let names: BTreeSet<&str> = order.parts.iter().map(|part| part.name.as_str()).collect();
    demand(names.len() == order.parts.len(), "have two parts with the same name")?;
    let electrodes = |cell: ElectrodeCell| {
        let offsets = order.facts.layout.electrodes.offsets().iter();
        offsets.map(move |[columns, rows]| [i64::from(cell.column) + columns, i64::from(cell.row) + rows])
    };
    let is_over = |cell: ElectrodeCell| electrodes(cell).all(|place| is_on_board(&order.facts, place));
    let is_over_board = order.parts.iter().filter_map(|part| part.cell).all(is_over);
    demand(is_over_board, "have a part whose electrodes are not all on the board")
}

/// Whether there is an electrode at a column and a row.
fn is_on_board(facts: &ElectrodeArrayFacts, [column, row]: [i64; 2]) -> bool {
    let is_place = (1..=i64::from(facts.columns)).contains(&column) && (1..=i64::from(facts.rows)).contains(&row);
    let is_gap = |channels: &[Option<u32>]| {
        let place = (row - 1) * i64::from(facts.columns) + column - 1;
        channels.get(place as usize).is_some_and(Option::is_none)
    };
    is_place && !facts.map.as_ref().is_some_and(|map| is_gap(&map.channels))
}

fn obstacles(order: &ElectrodeArrayOrder) -> Result<(), InvalidClaims> {
    let is_block = |body: &ElectrodeArrayObstacleBody| match body {
        ElectrodeArrayObstacleBody::Electrodes { from, to } => from.column <= to.column && from.row <= to.row,
        ElectrodeArrayObstacleBody::Fixed(_) => true,
    };
    demand(order.obstacles.iter().all(|obstacle| is_block(&obstacle.body)), "have an obstacle without electrodes")
}

/// Zones lie on the board. Stays in heaters, and only those, have a temperature, which is the same for all stays in
/// one heater.
fn zones(order: &ElectrodeArrayOrder) -> Result<(), InvalidClaims> {
    let is_block = |zone: &BoardZone| {
        let [low, high] = [zone.from, zone.to].map(ElectrodeCell::pair);
        (1..=high[0]).contains(&low[0])
            && (1..=high[1]).contains(&low[1])
            && high[0] <= order.facts.columns
            && high[1] <= order.facts.rows
    };
    demand(order.zones.len() <= ZoneSort::ALL.len() * MAX_ZONES, "have too many zones")?;
    demand(order.zones.iter().all(is_block), "have a zone without electrodes, or off the board")?;
    let limits = [order.facts.least_temperature_k, order.facts.most_temperature_k];
    demand(limits.iter().flatten().all(|limit| limit.is_finite()), "have a temperature that is not finite")?;
    let mut temperatures: BTreeMap<usize, u64> = BTreeMap::new();
    for step in &order.steps {
        let ElectrodeArrayAction::Assay(operations) = &step.action else { continue };
        for ZoneStay { zone, temperature_k } in operations.iter().flat_map(AssayOperation::zone_stays) {
            let is_heater = order.zones.get(zone).is_some_and(|zone| zone.sort == ZoneSort::Heater);
            demand(is_heater == temperature_k.is_some(), "heat where there is no heater, or without a temperature")?;
            let Some(asked_k) = temperature_k else { continue };
            demand(asked_k.is_finite() && asked_k > 0.0, "have a temperature that is not above 0 K")?;
            let known = *temperatures.entry(zone).or_insert(asked_k.to_bits());
            demand(known == asked_k.to_bits(), "give a heater two temperatures")?;
        }
    }
    Ok(())
}

/// Several places are alternatives for the single stop of an operation, which does the same at each.
fn among(order: &ElectrodeArrayOrder, operation: &AssayOperation) -> Result<(), InvalidClaims> {
    let cells: Vec<ElectrodeCell> = operation.among.iter().map(|place| place.stop.cell).collect();
    let distinct: BTreeSet<[u32; 2]> = cells.iter().map(|cell| cell.pair()).collect();
    let is_choice = (2..=MAX_PLACES).contains(&cells.len()) && distinct.len() == cells.len();
    let is_first = operation.stops.len() == 1 && operation.stops[0].cell == cells[0];
    demand(is_choice && is_first, "choose among too few or too many places, or name one place twice")?;
    let is_plain = !operation.comes && operation.splits.is_none();
    demand(is_plain, "choose the place of a part that is dispensed or split")?;
    for place in &operation.among {
        stops(order, std::slice::from_ref(&place.stop))?;
        demand(
            place.zone.is_some() == operation.zone.is_some(),
            "choose between a place in a zone and one outside of zones",
        )?;
    }
    let sort = |stay: ZoneStay| order.zones.get(stay.zone).map(|zone| zone.sort);
    let sorts: BTreeSet<Option<ZoneSort>> = operation.zone_stays().map(sort).collect();
    demand(sorts.len() <= 1, "choose among zones of different sorts")
}

/// An operation in a zone does nothing but stay there.
fn in_zone(order: &ElectrodeArrayOrder, operation: &AssayOperation, stay: ZoneStay) -> Result<(), InvalidClaims> {
    demand(stay.zone < order.zones.len(), "name a zone that they do not have")?;
    let is_plain = operation.with.is_none() && operation.splits.is_none() && !operation.mixes;
    let is_there = !operation.comes && !operation.leaves && operation.stops.len() == 1 && operation.stay_ns > 0;
    demand(is_plain && is_there, "combine a stay in a zone with another operation, or make it last no time")
}

fn operations(order: &ElectrodeArrayOrder, operations: &[AssayOperation]) -> Result<(), InvalidClaims> {
    let channels = JudgedChannels::new(&order.facts);
    let mut gone = BTreeSet::new();
    let (mut stays, mut stays_of) = (0u64, BTreeMap::new());
    for (nth, operation) in operations.iter().enumerate() {
        let is_earlier = |lag: &OperationLag| !lag.of.is_empty() && lag.of.iter().all(|of| *of < nth);
        demand(
            operation.within.as_ref().is_none_or(is_earlier),
            "limit a delay after operations that are not earlier ones",
        )?;
        for part in operation.all_parts() {
            demand(part < order.parts.len(), "move a part that they do not have")?;
            demand(!gone.contains(&part), "move a part that is already gone")?;
        }
        if !operation.among.is_empty() {
            among(order, operation)?;
        }
        for stay in operation.zone_stays() {
            in_zone(order, operation, stay)?;
        }
        if operation.mixes || operation.splits.is_some() {
            mix_or_split(order, operation)?;
        }
        stops(order, &operation.stops)?;
        let stay = operation.stay_steps(&order.facts);
        stays = stays.saturating_add(stay);
        let own: &mut u64 = stays_of.entry(operation.part).or_default();
        *own = own.saturating_add(stay);
        demand(*own <= MAX_STAY_STEPS_OF_PART, "let a part stay for too many steps")?;
        if let Some(with) = operation.with {
            demand(with != operation.part, "merge a part with itself")?;
            demand(operation.stops.len() == 1 && operation.stay_ns == 0, "merge parts that have other stops")?;
            demand(order.facts.layout.electrodes == Electrodes::Single, "merge parts that are not droplets")?;
            gone.insert(with);
        }
        if operation.comes {
            let is_plain = operation.with.is_none() && operation.stops.len() == 1 && !operation.leaves;
            demand(
                is_plain && operation.stay_ns > 0,
                "combine dispensing with another operation, or make it last no time",
            )?;
            let is_held = order.facts.hold == Hold::On && order.facts.layout.electrodes == Electrodes::Single;
            demand(is_held, "dispense parts that are not droplets, or not held")?;
            let outlet = operation.stops.first().map(|stop| stop.cell);
            let is_own = outlet.is_none_or(|outlet| !channels.is_shared(outlet));
            demand(is_own, "dispense a part where a shared channel switches the electrode")?;
            let sequence =
                order.facts.reservoirs.as_ref().zip(outlet).and_then(|(pads, outlet)| Some((pads, pads.at(outlet)?)));
            let is_whole = sequence.is_none_or(|(pads, sequence)| {
                operation.stay_ns == pads.frame_ns.saturating_mul(sequence.frames.len() as u64)
            });
            demand(is_whole, "dispense a part in a time other than that of its frames")?;
        }
        if operation.leaves {
            let is_plain = operation.with.is_none() && operation.stops.len() == 1 && operation.stay_ns == 0;
            demand(is_plain, "combine the leaving of a part with another operation")?;
            gone.insert(operation.part);
        }
    }
    demand(stays <= MAX_STAY_STEPS, "stay for too many steps")
}

/// A droplet is mixed for some time, or it is split and its halves go to opposite sides.
fn mix_or_split(order: &ElectrodeArrayOrder, operation: &AssayOperation) -> Result<(), InvalidClaims> {
    let is_plain = operation.with.is_none() && !operation.comes && !operation.leaves;
    let is_droplet = order.facts.layout.electrodes == Electrodes::Single;
    demand(
        is_plain && is_droplet,
        "mix or split a part that is not a droplet, or combine that with another operation",
    )?;
    let Some(half) = operation.splits else {
        return demand(operation.stay_ns > 0, "mix a droplet in no time");
    };
    demand(!operation.mixes && operation.stay_ns == 0, "combine a split with mixing or a stay")?;
    demand(half.part != operation.part, "split a droplet from itself")?;
    let [centre, goes] = operation.stops.as_slice() else { return Err(invalid("split a droplet at no cell")) };
    let place = |cell: ElectrodeCell| cell.pair().map(i64::from);
    demand(is_on_board(&order.facts, place(half.cell)), "name a cell that the board does not have")?;
    let (at, goes, comes) = (place(centre.cell), place(goes.cell), place(half.cell));
    let is_opposite = (0..2).all(|axis| goes[axis] + comes[axis] == 2 * at[axis]);
    let is_beside = (0..2).map(|axis| (goes[axis] - at[axis]).abs()).sum::<i64>() == 1;
    demand(is_opposite && is_beside, "split a droplet to cells that are not on opposite sides of it")?;
    let is_held = order.facts.hold == Hold::On && super::bodies::needed(&order.facts) <= 2;
    demand(is_held, "split a droplet that is not held, or into two that are too close")
}

fn stops(order: &ElectrodeArrayOrder, stops: &[ElectrodeArrayStop]) -> Result<(), InvalidClaims> {
    let known = stops.iter().all(|stop| is_on_board(&order.facts, stop.cell.pair().map(i64::from)));
    demand(known, "name a cell that the board does not have")
}

fn goals(order: &ElectrodeArrayOrder, moves: &[ElectrodeArrayMove]) -> Result<(), InvalidClaims> {
    let mut met = BTreeSet::new();
    let mut shared = BTreeSet::new();
    for action in moves {
        if action.team.is_some() {
            let is_plain = action.stops.len() == 1 && action.with.is_none();
            demand(is_plain, "let a part of a team do more than go to a goal")?;
            let is_new = action.stops.iter().all(|stop| shared.insert((stop.cell.column, stop.cell.row)));
            demand(is_new, "give a team one goal twice")?;
        }
        let all = std::iter::once(action.part).chain(action.with);
        for part in all {
            demand(part < order.parts.len(), "move a part that they do not have")?;
            demand(met.insert(part), "move a part twice in one step")?;
        }
        demand(!action.stops.is_empty(), "move a part without a goal")?;
        stops(order, &action.stops)?;
        if action.with.is_some() {
            demand(action.stops.len() == 1, "merge parts that have other stops")?;
            demand(order.facts.layout.electrodes == Electrodes::Single, "merge parts that are not droplets")?;
        }
    }
    Ok(())
}
