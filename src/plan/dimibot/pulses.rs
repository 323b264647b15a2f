//! Several modules in one pulse: the fewest pulses from one cell to another.
//!
//! Problem: a set of modules may switch in one pulse if the closed rectangle between the cell before and the cell after (their
//! bitwise AND and OR) touches no obstacle, since all orders of switching and all mixtures of partial strokes stay within it and
//! reach each of its points. Find the shortest sequence of such pulses. Method: up to [`TABLE_MODULES`] modules in all,
//! breadth-first search with rectangle queries from a summed-area table; above, a path of single flips is compressed, and sequences
//! of increasing length are sought by branch and bound on the bits of the intermediate cells, highest bits first: known high bits
//! fix an inner part of every rectangle, which must be free. Guaranteed: optimal where `cost() == bound`; always so for small
//! robots. Cost: 4^N rectangle queries for small robots; else at most [`TRIES`] per length. One step of the budget is one rectangle
//! query.

use super::field::LatticeField;
use super::labels::LabelFront;
use super::lattice::{Lattice, LatticeCell, ModulePulse, Side, SwitchWeights};
use super::outcome::{DimibotAnswer, FlipPath, Proof};
use super::shortest::{outside, shortest};
use super::tally::{MotionTally, add_to_front};
use crate::plan::search::{GaveUp, Meter, SearchBudget};
use rustc_hash::FxHashMap;

/// Most modules (left and right together) for which the search runs over all cells.
const TABLE_MODULES: u32 = 12;
/// Rectangle queries spent on finding or refuting a sequence of one length.
const TRIES: u64 = 1 << 18;
/// Longest sequence sought by branch and bound: in a longer one a node would have at least 4^4 children.
const MAX_SEARCHED_LENGTH: usize = 4;

/// A sequence of pulses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PulseTrain {
    /// Pulses in their order; none is empty.
    pub pulses: Vec<ModulePulse>,
    /// Lower bound on the number of pulses; equal to [`PulseTrain::cost`] when the train is proven optimal.
    pub bound: u64,
    /// Rectangles examined.
    pub expanded: u64,
}

impl PulseTrain {
    /// The number of pulses.
    pub fn cost(&self) -> u64 {
        self.pulses.len() as u64
    }
}

/// Whether all modules that differ between the two cells may switch in one pulse.
pub fn pulse_is_safe(field: &LatticeField, from: LatticeCell, to: LatticeCell) -> bool {
    field.rectangle_free([from.x & to.x, from.x | to.x], [from.y & to.y, from.y | to.y])
}

/// A train with few pulses from `start` to `goal`, and its bound.
pub fn pulses(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    budget: SearchBudget,
) -> DimibotAnswer<PulseTrain> {
    let mut meter = Meter::new(budget);
    if let Some(proof) = refused(field, start, goal) {
        return DimibotAnswer::impossible(proof, 0);
    }
    let modules = field.lattice().modules;
    if pulse_is_safe(field, start, goal) {
        let cells = if start == goal { vec![start] } else { vec![start, goal] };
        meter.charge(1);
        return found(&cells, cells.len() as u64 - 1, &meter);
    }
    match modules[0] + modules[1] <= TABLE_MODULES {
        true => exhaustive(field, start, goal, &mut meter),
        false => by_length(field, start, goal, &mut meter),
    }
}

fn refused(field: &LatticeField, start: LatticeCell, goal: LatticeCell) -> Option<Proof> {
    let covered = |cell: LatticeCell| !field.rectangle_free([cell.x; 2], [cell.y; 2]);
    outside(field, start, goal)
        .or_else(|| covered(start).then_some(Proof::StartCovered))
        .or_else(|| covered(goal).then_some(Proof::GoalCovered))
}

fn found(cells: &[LatticeCell], bound: u64, meter: &Meter) -> DimibotAnswer<PulseTrain> {
    let pulses = cells.windows(2).map(|pair| between(pair[0], pair[1])).collect();
    DimibotAnswer::Found(PulseTrain { pulses, bound, expanded: meter.spent() })
}

/// Summed-area table of the slots (cells and gaps) that an obstacle touches.
struct BlockedPrefixSums {
    width: usize,
    sums: Vec<u32>,
}

impl BlockedPrefixSums {
    fn new(field: &LatticeField) -> Self {
        let slots = Side::BOTH.map(|side| 2 * field.lattice().last(side) + 1);
        let width = slots[0] as usize + 1;
        let mut sums = vec![0; width * (slots[1] as usize + 1)];
        for sy in 0..slots[1] {
            for sx in 0..slots[0] {
                let touched = !field.rectangle_free([sx / 2, sx.div_ceil(2)], [sy / 2, sy.div_ceil(2)]);
                let at = (sy as usize + 1) * width + sx as usize + 1;
                sums[at] = u32::from(touched) + sums[at - 1] + sums[at - width] - sums[at - width - 1];
            }
        }
        BlockedPrefixSums { width, sums }
    }

    fn safe(&self, a: LatticeCell, b: LatticeCell) -> bool {
        let [x0, x1] = [a.x & b.x, a.x | b.x].map(|v| 2 * v as usize);
        let [y0, y1] = [a.y & b.y, a.y | b.y].map(|v| 2 * v as usize * self.width);
        let (right, top) = (x1 + 1, y1 + self.width);
        self.sums[top + right] + self.sums[y0 + x0] == self.sums[top + x0] + self.sums[y0 + right]
    }
}

/// A cell not yet reached, and the best entry to it from the current layer: distance, switches, position of the previous cell.
type Unseen = (LatticeCell, Option<(u64, u64, usize)>);

/// Breadth-first search; among the trains with the fewest pulses the shortest, and among those one with the fewest switches.
fn exhaustive(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    meter: &mut Meter,
) -> DimibotAnswer<PulseTrain> {
    let table = BlockedPrefixSums::new(field);
    let mut unseen: Vec<Unseen> =
        all_cells(field.lattice()).filter(|cell| *cell != start).map(|cell| (cell, None)).collect();
    // Cells in the order of discovery, each with the position of the previous cell.
    let mut seen = vec![(start, 0)];
    let mut figures = vec![(0, 0)];
    let mut layer = 0..1;
    let mut count = 0;
    while !layer.is_empty() {
        for at in layer.clone() {
            if meter.left().steps < unseen.len() as u64 {
                return DimibotAnswer::GaveUp(meter.gave_up(count + 1));
            }
            meter.charge(unseen.len() as u64);
            for (to, best) in &mut unseen {
                if table.safe(seen[at].0, *to) {
                    let pulse = MotionTally::of(field.lattice(), between(seen[at].0, *to));
                    let way = (figures[at].0 + pulse.distance, figures[at].1 + pulse.switches, at);
                    *best = Some(best.map_or(way, |best| best.min(way)));
                }
            }
        }
        layer = seen.len()..seen.len();
        unseen.retain(|(cell, best)| {
            let Some((distance, switches, before)) = *best else { return true };
            seen.push((*cell, before));
            figures.push((distance, switches));
            false
        });
        layer.end = seen.len();
        count += 1;
        if let Some(at) = layer.clone().find(|at| seen[*at].0 == goal) {
            return found(&trail(&seen, at), count, meter);
        }
    }
    let cells = seen.len() as u64;
    DimibotAnswer::impossible(Proof::StartShut { cells }, meter.spent())
}

fn all_cells(lattice: &Lattice) -> impl Iterator<Item = LatticeCell> + use<> {
    let (columns, rows) = (lattice.last(Side::Left), lattice.last(Side::Right));
    (0..=columns).flat_map(move |x| (0..=rows).map(move |y| LatticeCell::new(x, y)))
}

fn between(a: LatticeCell, b: LatticeCell) -> ModulePulse {
    ModulePulse { left: a.x ^ b.x, right: a.y ^ b.y }
}

/// Whether a robot is small enough for exhaustive search: then [`pulses`] is exact in all figures of a train, and
/// [`front`] is complete.
pub(super) const fn is_small(lattice: &Lattice) -> bool {
    lattice.modules[0] + lattice.modules[1] <= TABLE_MODULES
}

/// A partial train to a cell in [`front`], with the position of its predecessor.
struct PulseLabel {
    cell: LatticeCell,
    tally: MotionTally,
    before: usize,
}

/// The Pareto front of trains from `start` to `goal` within the limits, in distance, switches and pulses. For a small
/// robot all cells are searched, one layer per number of pulses; the front is then complete unless the budget ran out.
/// For a larger robot only the known trains are returned.
pub(super) fn front(
    field: &LatticeField,
    [start, goal]: [LatticeCell; 2],
    limits: MotionTally,
    known: Vec<(MotionTally, Vec<ModulePulse>)>,
    meter: &mut Meter,
) -> LabelFront<Vec<ModulePulse>> {
    let mut ways = Vec::new();
    for (tally, pulses) in known {
        add_to_front(&mut ways, tally, pulses);
    }
    let is_complete = is_small(field.lattice()) && by_layers(field, [start, goal], limits, &mut ways, meter);
    ways.retain(|(tally, _)| tally.is_within(limits));
    LabelFront { ways, is_complete }
}

fn by_layers(
    field: &LatticeField,
    [start, goal]: [LatticeCell; 2],
    limits: MotionTally,
    ways: &mut Vec<(MotionTally, Vec<ModulePulse>)>,
    meter: &mut Meter,
) -> bool {
    let (lattice, table) = (field.lattice(), BlockedPrefixSums::new(field));
    let cells: Vec<LatticeCell> = all_cells(lattice).collect();
    let mut labels = vec![PulseLabel { cell: start, tally: MotionTally::default(), before: 0 }];
    let mut of_cell: FxHashMap<LatticeCell, Vec<(MotionTally, ())>> =
        FxHashMap::from_iter([(start, vec![(MotionTally::default(), ())])]);
    let mut layer = 0..1;
    while !layer.is_empty() {
        for at in layer.clone() {
            let (from, so_far) = (labels[at].cell, labels[at].tally);
            for to in cells.iter().copied().filter(|to| *to != from) {
                if meter.step().is_none() {
                    return false;
                }
                let tally = so_far.plus(MotionTally::of(lattice, between(from, to)));
                let rest =
                    if to == goal { MotionTally::default() } else { MotionTally::of(lattice, between(to, goal)) };
                let ahead = tally.plus(rest);
                let is_useless = !ahead.is_within(limits) || ways.iter().any(|(known, _)| known.is_within(ahead));
                if is_useless || !table.safe(from, to) {
                    continue;
                }
                if !add_to_front(of_cell.entry(to).or_default(), tally, ()) {
                    continue;
                }
                labels.push(PulseLabel { cell: to, tally, before: at });
                if to == goal {
                    let steps: Vec<(LatticeCell, usize)> =
                        labels.iter().map(|label| (label.cell, label.before)).collect();
                    let cells = trail(&steps, labels.len() - 1);
                    add_to_front(ways, tally, cells.windows(2).map(|pair| between(pair[0], pair[1])).collect());
                }
            }
        }
        layer = layer.end..labels.len();
    }
    true
}

fn trail(seen: &[(LatticeCell, usize)], mut at: usize) -> Vec<LatticeCell> {
    let mut cells = vec![seen[at].0];
    while at != 0 {
        at = seen[at].1;
        cells.push(seen[at].0);
    }
    cells.reverse();
    cells
}

fn by_length(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    meter: &mut Meter,
) -> DimibotAnswer<PulseTrain> {
    let weights = SwitchWeights::switches(field.lattice());
    let path = match shortest(field, start, goal, &weights, meter.left()) {
        DimibotAnswer::Found(path) => path,
        DimibotAnswer::Impossible(proof) => return DimibotAnswer::Impossible(proof),
        // A single pulse was ruled out, so the bound is two.
        DimibotAnswer::GaveUp(report) => return DimibotAnswer::GaveUp(GaveUp { bound: 2, ..report }),
    };
    meter.charge_metered(path.expanded);
    let best = compress(field, start, &path, meter);
    for length in 2..best.len() - 1 {
        let tries = TRIES.min(meter.left().steps);
        if length > MAX_SEARCHED_LENGTH || tries == 0 {
            return found(&best, length as u64, meter);
        }
        let mut search = PulseBranchAndBound::new(field, start, goal, length, Meter::new(SearchBudget::of(tries)));
        let answer = search.branch(0);
        meter.charge_metered(search.meter.spent());
        match answer {
            PulseBranch::Found(cells) => return found(&cells, length as u64, meter),
            PulseBranch::None => {}
            PulseBranch::OutOfBudget => return found(&best, length as u64, meter),
        }
    }
    found(&best, best.len() as u64 - 1, meter)
}

/// The train with the fewest pulses that visits only cells of the path, in its order.
fn compress(field: &LatticeField, start: LatticeCell, path: &FlipPath, meter: &mut Meter) -> Vec<LatticeCell> {
    let mut cells = vec![start];
    for flip in &path.flips {
        cells.extend(cells.last().map(|cell| cell.after(*flip)));
    }
    // For each cell, the fewest pulses to it and the previous cell.
    let mut best = vec![(0, 0); cells.len()];
    for to in 1..cells.len() {
        best[to] = (best[to - 1].0 + 1, to - 1);
        for from in (0..to - 1).rev() {
            if best[from].0 + 1 >= best[to].0 {
                continue;
            }
            meter.charge(1);
            if pulse_is_safe(field, cells[from], cells[to]) {
                best[to] = (best[from].0 + 1, from);
            }
        }
    }
    let link = |k: usize| (cells[k], best[k].1);
    trail(&(0..cells.len()).map(link).collect::<Vec<_>>(), cells.len() - 1)
}

/// Branch and bound on the intermediate cells of a sequence of fixed length.
struct PulseBranchAndBound<'a> {
    field: &'a LatticeField,
    /// All cells of the sequence; for those between the ends only the decided high bits are set.
    cells: Vec<LatticeCell>,
    meter: Meter,
}

enum PulseBranch {
    Found(Vec<LatticeCell>),
    None,
    OutOfBudget,
}

impl<'a> PulseBranchAndBound<'a> {
    fn new(field: &'a LatticeField, start: LatticeCell, goal: LatticeCell, length: usize, meter: Meter) -> Self {
        let mut cells = vec![LatticeCell::new(0, 0); length + 1];
        cells[0] = start;
        cells[length] = goal;
        PulseBranchAndBound { field, cells, meter }
    }

    /// Bits not yet decided after `depth` decisions, by side.
    fn open(&self, depth: u32) -> [u32; 2] {
        self.field.lattice().modules.map(|n| (1 << n.saturating_sub(depth)) - 1)
    }

    /// Decides the `depth`-th highest bits of all intermediate cells. The recursion is as deep as the number of modules
    /// of the larger side, 20 at most.
    fn branch(&mut self, depth: u32) -> PulseBranch {
        let open = self.open(depth);
        // A rectangle blocked by its decided bits alone is blocked for every choice of the open ones: prune.
        for pulse in 1..self.cells.len() {
            match self.inner_is_free(pulse, open) {
                Some(true) => {}
                Some(false) => return PulseBranch::None,
                None => return PulseBranch::OutOfBudget,
            }
        }
        if let Some(cells) = self.completed(open) {
            return PulseBranch::Found(cells);
        }
        if open == [0, 0] {
            return PulseBranch::None;
        }
        let between = self.cells.len() as u32 - 2;
        let decided = self.cells.clone();
        let bits = [open[0] & !(open[0] >> 1), open[1] & !(open[1] >> 1)];
        for choice in 0..1_u32 << (2 * between) {
            self.cells.clone_from(&decided);
            if !self.choose(choice, bits) {
                continue;
            }
            match self.branch(depth + 1) {
                PulseBranch::None => {}
                ended @ (PulseBranch::Found(_) | PulseBranch::OutOfBudget) => return ended,
            }
        }
        self.cells = decided;
        PulseBranch::None
    }

    /// Sets the next bits; choice 0 repeats the start's bits in every cell. `false` if the choice differs from an
    /// earlier one only in bits that the robot does not have.
    fn choose(&mut self, mut choice: u32, bits: [u32; 2]) -> bool {
        let last = self.cells.len() - 1;
        let start = self.cells[0];
        for cell in &mut self.cells[1..last] {
            if (choice & 1 != 0 && bits[0] == 0) || (choice & 2 != 0 && bits[1] == 0) {
                return false;
            }
            let turned = |k: u32| if choice >> k & 1 == 0 { 0 } else { u32::MAX };
            cell.x |= bits[0] & (start.x ^ turned(0));
            cell.y |= bits[1] & (start.y ^ turned(1));
            choice >>= 2;
        }
        true
    }

    /// Whether the part of the rectangle that the decided bits fix is free. The open bits of the ends are known, those of the cells
    /// between are not.
    fn inner_is_free(&mut self, pulse: usize, open: [u32; 2]) -> Option<bool> {
        let ends = [pulse - 1, pulse].map(|k| (self.cells[k].pair(), k == 0 || k == self.cells.len() - 1));
        let mut ranges = [[0; 2]; 2];
        for k in 0..2 {
            // Intersection over all choices of the unknown bits: ones make the AND highest, zeros make the OR lowest.
            let value = |fill: u32| ends.map(|(at, known)| if known { at[k] } else { at[k] & !open[k] | fill });
            let (high, low) = (value(open[k]), value(0));
            ranges[k] = [high[0] & high[1], low[0] | low[1]];
            if ranges[k][0] > ranges[k][1] {
                return Some(true);
            }
        }
        self.meter.step()?;
        Some(self.field.rectangle_free(ranges[0], ranges[1]))
    }

    /// The decided bits completed with the start's or the goal's low bits, if the sequence is free.
    fn completed(&mut self, open: [u32; 2]) -> Option<Vec<LatticeCell>> {
        let last = self.cells.len() - 1;
        let (start, goal) = (self.cells[0], self.cells[last]);
        let fills = [[start.x, start.y], [goal.x, goal.y], [start.x, goal.y], [goal.x, start.y]];
        for fill in fills {
            let mut cells = self.cells.clone();
            for cell in &mut cells[1..last] {
                cell.x = cell.x & !open[0] | fill[0] & open[0];
                cell.y = cell.y & !open[1] | fill[1] & open[1];
            }
            self.meter.charge(1);
            if cells.windows(2).all(|pair| pulse_is_safe(self.field, pair[0], pair[1])) {
                return Some(cells);
            }
            if open == [0, 0] {
                break;
            }
        }
        None
    }
}
