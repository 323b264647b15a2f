//! Claims of a task on an electrode array.

use super::{KindOrder, Order, Relation, ValueOrigin};
use crate::device::Kind;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Hold};
pub use crate::device::electrode_array::{ElectrodeArrayMethod, ElectrodeArrayObjective, ZoneSort};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A task of an electrode array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayOrder {
    pub facts: ElectrodeArrayFacts,
    /// Shared by all tasks of one device in one scene, like the parts.
    pub obstacles: Arc<Vec<ElectrodeArrayObstacle>>,
    /// The parts of the scene, in the order of writing. All tasks of one device in one schedule have parts of the same names.
    pub parts: Arc<Vec<BoardPart>>,
    /// The heaters, detectors and magnets of the scene, in the order of writing; no two of one sort share an electrode.
    #[serde(default, skip_serializing_if = "has_no_zones")]
    pub zones: Arc<Vec<BoardZone>>,
    pub objective: ElectrodeArrayObjective,
    pub planner: ElectrodeArrayPlanner,
    /// Whether parts without a goal may move.
    pub bystanders: Bystanders,
    /// What droplets must contain when they were last on the board.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contents: Vec<DropletContent>,
    #[serde(default, skip_serializing_if = "Contamination::is_unheeded")]
    pub contamination: Contamination,
    pub steps: Vec<ElectrodeArrayStep>,
}

fn has_no_zones(zones: &Arc<Vec<BoardZone>>) -> bool {
    zones.is_empty()
}

impl KindOrder for ElectrodeArrayOrder {
    fn kind(&self) -> Kind {
        Kind::ElectrodeArray
    }

    fn operation_spans(&self, nth: usize) -> Vec<Span> {
        match self.steps.get(nth).map(|step| &step.action) {
            Some(ElectrodeArrayAction::Assay(operations)) => {
                operations.iter().map(|operation| operation.span).collect()
            }
            Some(ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_)) | None => Vec::new(),
        }
    }

    fn holds_in_runs_only(&self) -> bool {
        self.facts.hold == Hold::On
    }
}

impl ElectrodeArrayOrder {
    /// A job's order, if it is one of this kind.
    pub fn of(order: &Order) -> Option<&ElectrodeArrayOrder> {
        if let Order::ElectrodeArray(order) = order { Some(order) } else { None }
    }

    /// The names of the parts that its steps act on.
    pub fn acting_parts(&self) -> BTreeSet<&str> {
        let mut acting: BTreeSet<usize> = BTreeSet::new();
        for step in &self.steps {
            match &step.action {
                ElectrodeArrayAction::Move(moves) => {
                    acting.extend(moves.iter().flat_map(ElectrodeArrayMove::parts));
                }
                ElectrodeArrayAction::Assay(operations) => {
                    acting.extend(operations.iter().flat_map(AssayOperation::all_parts));
                }
                ElectrodeArrayAction::Wait(_) => {}
            }
        }
        acting.into_iter().map(|part| self.parts[part].name.as_str()).collect()
    }
}

/// What a droplet must contain. Every part that the scene puts on the board, and every reservoir, is a fluid of its own by its name; a droplet
/// that is put or dispensed there is one of it, two that merge are added up, and a split makes two halves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DropletContent {
    /// Index of the order's parts.
    pub part: usize,
    pub share: DropletShare,
    pub relation: Relation,
    /// In droplets for a volume, else from 0 to 1.
    pub limit: f64,
    #[serde(skip)]
    pub span: Span,
}

/// Fluids of which droplets leave traces on electrodes that must not get into others. A droplet leaves all that it contains on every electrode
/// to which it comes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Contamination {
    pub avoided: Vec<AvoidedTrace>,
    /// Fluids by their names: a droplet of nothing but these takes away what was left on the electrodes to which it comes, and takes no
    /// harm.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub washes: Vec<String>,
    /// For each part the fluids that it contains before the task; none if it is not on the board by then.
    #[serde(skip)]
    pub before: Vec<Fluids>,
    /// How wash droplets come by themselves, if they do; those are among the operations then.
    #[serde(skip)]
    pub course: Option<Box<WashCourse>>,
}

/// Where wash droplets come from, and where they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct WashCourse {
    /// The reservoir's name, and so that of the fluid.
    pub fluid: String,
    pub outlet: ElectrodeCell,
    /// Time in which one is dispensed, in nanoseconds.
    pub dispense_ns: u64,
    pub exit: ElectrodeArrayStop,
    pub span: Span,
}

/// The names of the fluids that a droplet contains.
pub type Fluids = BTreeSet<String>;

impl Contamination {
    /// Whether a droplet of some fluids must not come to what one of others has left.
    pub fn does_harm(&self, left: &Fluids, comes: &Fluids) -> bool {
        let (is_left, is_own) = (|fluid: &String| left.contains(fluid), |fluid: &String| comes.contains(fluid));
        self.avoided.iter().any(|trace| is_left(&trace.of) && is_own(&trace.within) && !is_own(&trace.of))
    }

    /// Whether a droplet takes away what others have left.
    pub fn is_wash(&self, fluids: &Fluids) -> bool {
        !fluids.is_empty() && fluids.iter().all(|fluid| self.washes.contains(fluid))
    }

    /// Whether nothing is avoided.
    pub fn is_unheeded(&self) -> bool {
        self.avoided.is_empty()
    }
}

/// No droplet that contains one fluid and not another comes onto an electrode with traces of that other one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AvoidedTrace {
    pub of: String,
    pub within: String,
    #[serde(skip)]
    pub span: Span,
}

/// A figure of what a droplet contains.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DropletShare {
    /// In droplets as they are dispensed.
    Volume,
    /// The part of its volume that is this fluid.
    Fluid(String),
}

/// How the plan is searched.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ElectrodeArrayPlanner {
    pub method: ElectrodeArrayMethod,
    /// States that the search of one step of the task may expand.
    pub expansions: u64,
}

/// Whether parts without a goal may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bystanders {
    /// They do not move.
    Stay,
    /// They may step aside, and come back before the step of the task ends.
    Yield,
}

/// Something that no part may come near.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayObstacle {
    /// The name in the scene.
    pub name: String,
    pub body: ElectrodeArrayObstacleBody,
    #[serde(skip)]
    pub span: Span,
}

/// The extent of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElectrodeArrayObstacleBody {
    /// Electrodes, corners included; `from` is the lower corner in both axes. Centres keep the clearance of the facts from each.
    Electrodes { from: ElectrodeCell, to: ElectrodeCell },
    /// A part that is stuck with its centre there. Centres keep the separation of the facts from it.
    Fixed(ElectrodeCell),
}

/// A part that the board carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardPart {
    /// The name in the scene.
    pub name: String,
    /// Where it stands before the device's first task; `None` for a droplet that a reservoir dispenses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<ElectrodeCell>,
    #[serde(skip)]
    pub span: Span,
}

/// What lies under or over some electrodes: a block, corners included; `from` is the lower corner in both axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardZone {
    /// The name in the scene.
    pub name: String,
    pub sort: ZoneSort,
    pub from: ElectrodeCell,
    pub to: ElectrodeCell,
    #[serde(skip)]
    pub span: Span,
}

impl ElectrodeArrayAction {
    /// The operations of an assay; none of another step.
    pub fn operations(&self) -> &[AssayOperation] {
        match self {
            ElectrodeArrayAction::Assay(operations) => operations,
            ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => &[],
        }
    }
}

impl BoardZone {
    /// Whether an electrode is one of its own.
    pub fn holds(&self, cell: ElectrodeCell) -> bool {
        (self.from.column..=self.to.column).contains(&cell.column) && (self.from.row..=self.to.row).contains(&cell.row)
    }

    /// The cell for which its name stands: in the middle, or left of it and below where none is.
    pub fn middle(&self) -> ElectrodeCell {
        let between = |low: u32, high: u32| low + high.saturating_sub(low) / 2;
        ElectrodeCell::new(between(self.from.column, self.to.column), between(self.from.row, self.to.row))
    }
}

/// In which zone a part stays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ZoneStay {
    /// Index of the order's zones.
    pub zone: usize,
    /// Of a heater; the same wherever the program names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<f64>,
}

impl BoardPart {
    /// The name before its index: `m` of `m3`, which is `m[3]`, and of `m3_12`; `None` for a part without an index.
    pub fn family(&self) -> Option<&str> {
        let before = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let mut own = before(&self.name);
        if own == self.name.len() {
            return None;
        }
        while let Some(outer) = self.name[..own].strip_suffix('_').map(before).filter(|outer| outer + 1 < own) {
            own = outer;
        }
        Some(&self.name[..own]).filter(|family| !family.is_empty())
    }
}

/// One step of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayStep {
    pub action: ElectrodeArrayAction,
    #[serde(skip)]
    pub span: Span,
}

/// Action of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElectrodeArrayAction {
    /// Parts to their goals at the same time; the step ends when the last one has arrived.
    Move(Vec<ElectrodeArrayMove>),
    /// Operations of which those of one part follow each other in this order; what different parts do depends on nothing but where they
    /// merge. The step ends when all are done.
    Assay(Vec<AssayOperation>),
    /// Nothing moves for this time, in nanoseconds.
    Wait(u64),
}

/// Action of one part in a step, or of two that become one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayMove {
    /// Index of the order's parts.
    pub part: usize,
    /// The part that it merges with at its goal: from then on that one is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; the last one is its goal. One stop where parts merge.
    pub stops: Vec<ElectrodeArrayStop>,
    /// The number of its team in the step. The moves of a team, each of one stop, share their goals: at each ends one of its parts, whichever
    /// the plan chooses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub team: Option<usize>,
    #[serde(skip)]
    pub span: Span,
}

impl ElectrodeArrayMove {
    /// A move of one part that is in no team.
    pub fn alone(part: usize, stops: Vec<ElectrodeArrayStop>, span: Span) -> ElectrodeArrayMove {
        ElectrodeArrayMove { part, with: None, stops, team: None, span }
    }

    /// The parts that it takes from their cells.
    pub fn parts(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.part), self.with].into_iter().flatten()
    }

    /// Where it ends, if it is in no team.
    pub fn goal(&self) -> &ElectrodeArrayStop {
        self.stops.last().expect("the checker gives every move a goal")
    }
}

/// A cell to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayStop {
    pub cell: ElectrodeCell,
    #[serde(skip)]
    pub span: Span,
    /// Where it was given, if a name stands in the step.
    #[serde(skip)]
    pub origin: Option<ValueOrigin>,
}

/// What one part of an assay does, or two that become one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AssayOperation {
    /// Index of the order's parts.
    pub part: usize,
    /// The part that it merges with at its stop: from then on that one is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; one where parts merge. None: it stays where its last operation left it.
    pub stops: Vec<ElectrodeArrayStop>,
    /// The places of which the plan chooses its one stop, at least two; until then that is the first of them. None where the program names
    /// the stop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub among: Vec<OperationPlace>,
    /// The least time for which it stays at the last stop, or is mixed there, in nanoseconds.
    pub stay_ns: u64,
    /// The heater, detector or magnet in which it stays meanwhile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<ZoneStay>,
    /// Whether it is moved round the mixing loop meanwhile whose corner the last stop is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixes: bool,
    /// The droplet that comes out of it on the way from the first of its two stops to the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub splits: Option<SplitDroplet>,
    /// Whether it comes onto the board at its one stop, the outlet of a reservoir, which dispenses it while it stays.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub comes: bool,
    /// The name of that reservoir, and so of the fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
    /// Whether it leaves the board at the last stop and is gone from then on.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leaves: bool,
    /// Indices of earlier operations of the assay that are done before it stays at the last stop, merges, is mixed, is split, comes or
    /// leaves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<usize>,
    /// How soon after others it begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<OperationLag>,
    #[serde(skip)]
    pub span: Span,
}

/// A place at which an operation may take place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperationPlace {
    pub stop: ElectrodeArrayStop,
    /// Index of the order's zones, for what takes place in one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<usize>,
}

/// The longest time from the end of some operations to the beginning of another one: the instant from which on it stays, is mixed or is
/// dispensed, the beginning of the step in which it is split, or that at which it merges, leaves or is at its last stop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperationLag {
    /// Indices of earlier operations of the assay, at least one; the time counts from the last of them on.
    pub of: Vec<usize>,
    /// In nanoseconds.
    pub most_ns: u64,
    #[serde(skip)]
    pub span: Span,
}

/// A droplet that another one gives off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SplitDroplet {
    /// Index of the order's parts; not on the board before.
    pub part: usize,
    /// Where it comes: beside the cell at which the other one splits, opposite to where that one goes.
    pub cell: ElectrodeCell,
}

impl SplitDroplet {
    /// Where it comes by its operation.
    pub fn stop(&self, operation: &AssayOperation) -> ElectrodeArrayStop {
        ElectrodeArrayStop { cell: self.cell, span: operation.span, origin: None }
    }
}

impl AssayOperation {
    /// An operation that stays for no time, and after which its part is still there.
    pub fn passing(part: usize, stops: Vec<ElectrodeArrayStop>, span: Span) -> AssayOperation {
        AssayOperation {
            part,
            with: None,
            stops,
            among: Vec::new(),
            stay_ns: 0,
            zone: None,
            mixes: false,
            splits: None,
            comes: false,
            fluid: None,
            leaves: false,
            after: Vec::new(),
            within: None,
            span,
        }
    }

    /// It at one of the places of which the plan chooses, by its index among them.
    pub fn at_place(&self, place: usize) -> AssayOperation {
        let Some(OperationPlace { stop, zone }) = self.among.get(place) else { return self.clone() };
        let zone = zone.and_then(|zone| Some(ZoneStay { zone, ..self.zone? }));
        AssayOperation { stops: vec![stop.clone()], among: Vec::new(), zone, ..self.clone() }
    }

    /// It at that of its places which is a cell, if there is one.
    pub fn at_cell(&self, cell: [u32; 2]) -> Option<AssayOperation> {
        let place = self.among.iter().position(|place| place.stop.cell.pair() == cell)?;
        Some(self.at_place(place))
    }

    /// The parts that some operations of an assay leave where the plan chooses, with those that bring them there.
    pub fn left_open(operations: &[AssayOperation]) -> BTreeMap<usize, &AssayOperation> {
        let mut open = BTreeMap::new();
        for operation in operations {
            if !operation.stops.is_empty() {
                open.remove(&operation.part);
            }
            if !operation.among.is_empty() {
                open.insert(operation.part, operation);
            }
            if let Some(gone) = operation.gone() {
                open.remove(&gone);
            }
        }
        open
    }

    /// The zones in which its part may stay: several where the plan chooses.
    pub fn zone_stays(&self) -> impl Iterator<Item = ZoneStay> + '_ {
        let others = self.among.iter().skip(1).filter_map(|place| place.zone);
        self.zone.into_iter().flat_map(move |stay| {
            std::iter::once(stay).chain(others.clone().map(move |zone| ZoneStay { zone, ..stay }))
        })
    }

    /// What its part contains, of all parts, as soon as it begins.
    pub fn begin_fluids(&self, fluids: &mut [Fluids]) {
        if let Some(fluid) = &self.fluid {
            fluids[self.part] = Fluids::from([fluid.clone()]);
        }
    }

    /// What its parts contain, of all parts, once it is done; of two that merge, both are all that either was.
    pub fn end_fluids(&self, fluids: &mut [Fluids]) {
        if let Some(with) = self.with {
            let both: Fluids = fluids[self.part].union(&fluids[with]).cloned().collect();
            (fluids[self.part], fluids[with]) = (both.clone(), both);
        }
        if let Some(half) = self.splits {
            fluids[half.part] = fluids[self.part].clone();
        }
    }

    /// The parts that it needs.
    pub fn parts(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.part), self.with].into_iter().flatten()
    }

    /// The parts that it needs, and the one that it makes of them.
    pub fn all_parts(&self) -> impl Iterator<Item = usize> + use<> {
        self.parts().chain(self.splits.map(|droplet| droplet.part))
    }

    /// The part that is on the board since it, and where it comes.
    pub fn new_part(&self) -> Option<(usize, ElectrodeCell)> {
        match (self.splits, self.stops.first()) {
            (Some(droplet), _) => Some((droplet.part, droplet.cell)),
            (None, Some(outlet)) if self.comes => Some((self.part, outlet.cell)),
            (None, _) => None,
        }
    }

    /// The steps of the board for which its part stays at the last stop, or is mixed there.
    pub fn stay_steps(&self, facts: &ElectrodeArrayFacts) -> u64 {
        if self.mixes { facts.mixing_steps(self.stay_ns) } else { self.stay_ns.div_ceil(facts.step_ns) }
    }

    /// The part that is gone when it is done.
    pub fn gone(&self) -> Option<usize> {
        self.with.or(self.leaves.then_some(self.part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_is_a_number_or_several() {
        let family = |name: &str| {
            let part = BoardPart { name: name.to_owned(), cell: None, span: Span::default() };
            part.family().unwrap_or("none").to_owned()
        };
        let names = ["m0", "m12", "m1_2", "m1_2_30", "m", "m_", "m_1", "a1b", "a1_b", "x_y3"];
        assert_eq!(names.map(family), ["m", "m", "m", "m", "none", "none", "m_", "none", "none", "x_y"]);
    }
}
