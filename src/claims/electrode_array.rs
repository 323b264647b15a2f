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
    /// The parts of the scene, in source order. All tasks of one device in one schedule have parts of the same names.
    pub parts: Arc<Vec<BoardPart>>,
    /// The heaters, detectors and magnets of the scene, in source order; no two of one sort share an electrode.
    #[serde(default, skip_serializing_if = "has_no_zones")]
    pub zones: Arc<Vec<BoardZone>>,
    pub objective: ElectrodeArrayObjective,
    pub planner: ElectrodeArrayPlanner,
    /// Whether parts without a goal may move.
    pub bystanders: Bystanders,
    /// Required contents of droplets, checked when they were last on the board.
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

/// A requirement on the content of a droplet. Every part that the scene puts on the board, and every reservoir, is a
/// fluid of its own, of the same name. A droplet that is put on the board or dispensed consists of that fluid; a
/// merge adds up contents, and a split makes two halves of the same content.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DropletContent {
    /// Index into the order's parts.
    pub part: usize,
    pub share: DropletShare,
    pub relation: Relation,
    /// In droplets for a volume, otherwise a fraction from 0 to 1.
    pub limit: f64,
    #[serde(skip)]
    pub span: Span,
}

/// Contamination rules: which fluids' traces on electrodes must not get into which droplets. A droplet leaves traces
/// of all its fluids on every electrode that it visits.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Contamination {
    pub avoided: Vec<AvoidedTrace>,
    /// Names of the wash fluids: a droplet that contains only these removes the traces on the electrodes that it
    /// visits, and cannot be contaminated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub washes: Vec<String>,
    /// For each part, the fluids that it contains before the task; empty if it is not on the board then.
    #[serde(skip)]
    pub before: Vec<Fluids>,
    /// Source and exit of wash droplets, if the compiler adds them; they are then among the operations.
    #[serde(skip)]
    pub course: Option<Box<WashCourse>>,
}

/// Where wash droplets come from and where they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct WashCourse {
    /// The name of the reservoir, and thus of the fluid.
    pub fluid: String,
    pub outlet: ElectrodeCell,
    /// Time in which a wash droplet is dispensed, in nanoseconds.
    pub dispense_ns: u64,
    pub exit: ElectrodeArrayStop,
    pub span: Span,
}

/// The names of the fluids that a droplet contains.
pub type Fluids = BTreeSet<String>;

impl Contamination {
    /// Whether a droplet of these fluids must not enter an electrode with these traces.
    pub fn contaminates(&self, traces: &Fluids, droplet: &Fluids) -> bool {
        let (is_left, is_own) = (|fluid: &String| traces.contains(fluid), |fluid: &String| droplet.contains(fluid));
        self.avoided.iter().any(|trace| is_left(&trace.of) && is_own(&trace.within) && !is_own(&trace.of))
    }

    /// Whether a droplet of these fluids removes traces.
    pub fn is_wash(&self, fluids: &Fluids) -> bool {
        !fluids.is_empty() && fluids.iter().all(|fluid| self.washes.contains(fluid))
    }

    /// Whether there is no rule.
    pub fn is_unheeded(&self) -> bool {
        self.avoided.is_empty()
    }
}

/// A rule: no droplet that contains the fluid `within`, but not the fluid `of`, enters an electrode with traces of
/// `of`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AvoidedTrace {
    pub of: String,
    pub within: String,
    #[serde(skip)]
    pub span: Span,
}

/// A measure of a droplet's content.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DropletShare {
    /// In units of a dispensed droplet.
    Volume,
    /// The volume fraction of this fluid.
    Fluid(String),
}

/// Search method and budget.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ElectrodeArrayPlanner {
    pub method: ElectrodeArrayMethod,
    /// Most states that the search of one step of the task may expand.
    pub expansions: u64,
}

/// Whether parts without a goal may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bystanders {
    /// They do not move.
    Stay,
    /// They may step aside, but return before the step of the task ends.
    Yield,
}

/// An obstacle that no part may come near.
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
    /// Electrodes, corners included; `from` is the lower corner on both axes. Part centres keep the clearance of the
    /// facts from each of them.
    Electrodes { from: ElectrodeCell, to: ElectrodeCell },
    /// A part that is stuck with its centre there. Part centres keep the separation of the facts from it.
    Fixed(ElectrodeCell),
}

/// A part that the board carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardPart {
    /// The name in the scene.
    pub name: String,
    /// Its cell before the device's first task; `None` for a droplet that a reservoir dispenses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<ElectrodeCell>,
    #[serde(skip)]
    pub span: Span,
}

/// A zone: what is under or over a block of electrodes, corners included; `from` is the lower corner on both axes.
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
    /// The operations of an assay; empty for other steps.
    pub fn operations(&self) -> &[AssayOperation] {
        match self {
            ElectrodeArrayAction::Assay(operations) => operations,
            ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => &[],
        }
    }
}

impl BoardZone {
    /// Whether an electrode belongs to it.
    pub fn contains(&self, cell: ElectrodeCell) -> bool {
        (self.from.column..=self.to.column).contains(&cell.column) && (self.from.row..=self.to.row).contains(&cell.row)
    }

    /// The cell that its name stands for: the middle one, rounded towards the left and below.
    pub fn middle(&self) -> ElectrodeCell {
        let between = |low: u32, high: u32| low + high.saturating_sub(low) / 2;
        ElectrodeCell::new(between(self.from.column, self.to.column), between(self.from.row, self.to.row))
    }
}

/// The zone in which a part stays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ZoneStay {
    /// Index into the order's zones.
    pub zone: usize,
    /// Temperature of a heater; the same wherever the program names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<f64>,
}

impl BoardPart {
    /// The name without its index: `m` of `m3`, which is `m[3]`, and of `m3_12`; `None` for a part without an index.
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
    /// Moves parts to their goals at the same time; the step ends when the last one has arrived.
    Move(Vec<ElectrodeArrayMove>),
    /// Operations; those of one part are performed in this order. Operations of different parts are independent,
    /// except where parts merge or one is declared to come after another. The step ends when all are done.
    Assay(Vec<AssayOperation>),
    /// Nothing moves for this time, in nanoseconds.
    Wait(u64),
}

/// The move of one part in a step, or of two that merge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayMove {
    /// Index into the order's parts.
    pub part: usize,
    /// The part that it merges with at its goal; from then on that part is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; the last one is its goal. A single stop if parts merge.
    pub stops: Vec<ElectrodeArrayStop>,
    /// The number of its team in the step. The moves of a team, each of one stop, share their goals: one of the parts
    /// ends at each goal, and the plan chooses which.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub team: Option<usize>,
    #[serde(skip)]
    pub span: Span,
}

impl ElectrodeArrayMove {
    /// A move of one part that belongs to no team.
    pub fn alone(part: usize, stops: Vec<ElectrodeArrayStop>, span: Span) -> ElectrodeArrayMove {
        ElectrodeArrayMove { part, with: None, stops, team: None, span }
    }

    /// The parts that it moves.
    pub fn parts(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.part), self.with].into_iter().flatten()
    }

    /// Its goal, for a move that belongs to no team.
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
    /// The definition of the cell, if the step refers to it by name.
    #[serde(skip)]
    pub origin: Option<ValueOrigin>,
}

/// An operation of one part of an assay, or of two that merge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AssayOperation {
    /// Index into the order's parts.
    pub part: usize,
    /// The part that it merges with at its stop; from then on that part is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; a single one if parts merge. Empty if it stays where its last operation left it.
    pub stops: Vec<ElectrodeArrayStop>,
    /// The candidate places for its single stop, at least two, of which the plan chooses one; until then the stop is
    /// the first of them. Empty if the program names the stop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub among: Vec<OperationPlace>,
    /// Least time for which it stays at the last stop, or is mixed there, in nanoseconds.
    pub stay_ns: u64,
    /// The heater, detector or magnet in which it stays during that time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<ZoneStay>,
    /// Whether it is moved around the mixing loop during that time; the last stop is the loop's corner.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixes: bool,
    /// The droplet that is split off on the way from the first of its two stops to the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub splits: Option<SplitDroplet>,
    /// Whether a reservoir dispenses it while it stays: it enters the board at its single stop, the outlet.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub comes: bool,
    /// The name of that reservoir, and thus of the fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
    /// Whether it leaves the board at the last stop, for good.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leaves: bool,
    /// Indices of earlier operations of the assay that must be done before it stays at the last stop, merges, is
    /// mixed, is split, is dispensed or leaves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<usize>,
    /// Time limit for its beginning after other operations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<OperationLag>,
    #[serde(skip)]
    pub span: Span,
}

/// A candidate place for an operation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperationPlace {
    pub stop: ElectrodeArrayStop,
    /// Index into the order's zones, if the operation takes place in one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<usize>,
}

/// The longest time from the end of some operations to the beginning of another. The beginning is the instant at
/// which it starts to stay, to be mixed or to be dispensed, the beginning of the step in which it is split, or the
/// instant at which it merges, leaves or is at its last stop.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperationLag {
    /// Indices of earlier operations of the assay, at least one; the time counts from the end of the last of them.
    pub of: Vec<usize>,
    /// In nanoseconds.
    pub most_ns: u64,
    #[serde(skip)]
    pub span: Span,
}

/// A droplet that is split off another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SplitDroplet {
    /// Index into the order's parts; not on the board before.
    pub part: usize,
    /// The cell where it appears: beside the cell of the split, opposite to the direction in which the other droplet
    /// goes.
    pub cell: ElectrodeCell,
}

impl SplitDroplet {
    /// The stop at which its operation puts it.
    pub fn stop(&self, operation: &AssayOperation) -> ElectrodeArrayStop {
        ElectrodeArrayStop { cell: self.cell, span: operation.span, origin: None }
    }
}

impl AssayOperation {
    /// An operation without a stay, after which its part is still on the board.
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

    /// The operation with its candidate place fixed, by the place's index.
    pub fn at_place(&self, place: usize) -> AssayOperation {
        let Some(OperationPlace { stop, zone }) = self.among.get(place) else { return self.clone() };
        let zone = zone.and_then(|zone| Some(ZoneStay { zone, ..self.zone? }));
        AssayOperation { stops: vec![stop.clone()], among: Vec::new(), zone, ..self.clone() }
    }

    /// The operation with its candidate place fixed to this cell; `None` if the cell is not a candidate.
    pub fn at_cell(&self, cell: [u32; 2]) -> Option<AssayOperation> {
        let place = self.among.iter().position(|place| place.stop.cell.pair() == cell)?;
        Some(self.at_place(place))
    }

    /// The parts whose place after some operations of an assay is the plan's choice, each with the operation that
    /// brings it there.
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

    /// The zones in which its part may stay: several if the plan chooses.
    pub fn zone_stays(&self) -> impl Iterator<Item = ZoneStay> + '_ {
        let others = self.among.iter().skip(1).filter_map(|place| place.zone);
        self.zone.into_iter().flat_map(move |stay| {
            std::iter::once(stay).chain(others.clone().map(move |zone| ZoneStay { zone, ..stay }))
        })
    }

    /// Updates the fluids of all parts for the beginning of the operation.
    pub fn begin_fluids(&self, fluids: &mut [Fluids]) {
        if let Some(fluid) = &self.fluid {
            fluids[self.part] = Fluids::from([fluid.clone()]);
        }
    }

    /// Updates the fluids of all parts for its end. After a merge, both parts have the fluids of both.
    pub fn end_fluids(&self, fluids: &mut [Fluids]) {
        if let Some(with) = self.with {
            let both: Fluids = fluids[self.part].union(&fluids[with]).cloned().collect();
            (fluids[self.part], fluids[with]) = (both.clone(), both);
        }
        if let Some(half) = self.splits {
            fluids[half.part] = fluids[self.part].clone();
        }
    }

    /// The parts that it requires.
    pub fn parts(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.part), self.with].into_iter().flatten()
    }

    /// The parts that it requires, and the part that it creates.
    pub fn all_parts(&self) -> impl Iterator<Item = usize> + use<> {
        self.parts().chain(self.splits.map(|droplet| droplet.part))
    }

    /// The part that it brings onto the board, and its cell.
    pub fn new_part(&self) -> Option<(usize, ElectrodeCell)> {
        match (self.splits, self.stops.first()) {
            (Some(droplet), _) => Some((droplet.part, droplet.cell)),
            (None, Some(outlet)) if self.comes => Some((self.part, outlet.cell)),
            (None, _) => None,
        }
    }

    /// Number of steps of the board for which its part stays at the last stop, or is mixed there.
    pub fn stay_steps(&self, facts: &ElectrodeArrayFacts) -> u64 {
        if self.mixes { facts.mixing_steps(self.stay_ns) } else { self.stay_ns.div_ceil(facts.step_ns) }
    }

    /// The part that is gone after it.
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
