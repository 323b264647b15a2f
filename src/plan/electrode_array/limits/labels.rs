//! The Pareto front of plans of a few parts in all figures. Used for limits that a search for one figure does not keep.
//!
//! Problem: an instance on a small board, and limits on steps, sum of costs and moves. Method: a label-setting search
//! over joint positions, as in multicriteria shortest paths (E. Q. V. Martins, "On a multicriteria shortest path
//! problem", European Journal of Operational Research 16, 1984): a joint position keeps all its non-dominated partial
//! plans. As in [`crate::plan::electrode_array::joint`], a position records for each agent whether it has arrived for
//! good. Where a figure must reach a least value, partial plans below that value are only compared with partial plans
//! of the same value in it.
//!
//! Guaranteed: for each plan within the limits the answer contains one that has no more of any figure, and as much of
//! each up to its least value. Cost: one step of the meter is one joint move; it fits joint spaces of some ten thousand
//! positions.

use crate::plan::electrode_array::board::{CellIndex, Instance, Paths};
use crate::plan::electrode_array::exact::tables::{ExactTables, FAR, StagedCell};
use crate::plan::electrode_array::joint::states::States;
use crate::plan::electrode_array::joint::trim;
use crate::plan::search::Meter;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Steps, sum of costs and moves of a plan.
pub type BoardFigures = [u64; 3];

/// Joint spaces with more positions than this are not searched.
const MOST_POSITIONS: u64 = 1 << 17;

/// Most labels.
const MOST_LABELS: usize = 1 << 21;

/// Limits on a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanLimits {
    /// Upper limit of each figure.
    pub most: BoardFigures,
    /// Lower limit of each figure; a larger value has no benefit.
    pub least: BoardFigures,
}

/// The non-dominated plans within the limits; `None` if the budget or the memory does not suffice, or the joint space
/// is too large.
pub fn front(instance: &Instance, limits: PlanLimits, meter: &mut Meter) -> Option<Vec<(Paths, BoardFigures)>> {
    let tables = ExactTables::new(instance).ok()?;
    let sizes = (0..tables.agents()).map(|agent| tables.reaching(agent));
    let positions = sizes.into_iter().try_fold(1u64, |product, size| product.checked_mul(size));
    positions.filter(|positions| *positions <= MOST_POSITIONS)?;
    let mut search = BoardLabelSearch {
        tables: &tables,
        limits,
        states: States::new(tables.agents()),
        labels: vec![],
        known: vec![],
        open: BinaryHeap::new(),
        ends: vec![],
    };
    search.run(meter)?;
    Some(search.ends.iter().map(|label| (search.paths(*label), search.labels[*label as usize].figures)).collect())
}

/// One agent's part of a joint position: its node, and whether it has arrived for good.
type LabelWord = u32;

const ARRIVED: LabelWord = 1;

/// A label without a predecessor.
const NONE: u32 = u32::MAX;

/// A partial plan to a joint position.
#[derive(Clone, Copy)]
struct BoardLabel {
    state: u32,
    before: u32,
    figures: BoardFigures,
    is_worse: bool,
}

struct BoardLabelSearch<'a> {
    tables: &'a ExactTables<'a>,
    limits: PlanLimits,
    states: States,
    labels: Vec<BoardLabel>,
    /// For each state, its non-dominated labels.
    known: Vec<Vec<u32>>,
    /// Open list, by lower bounds on the figures.
    open: BinaryHeap<Reverse<(BoardFigures, u32)>>,
    /// The labels of complete plans.
    ends: Vec<u32>,
}

impl BoardLabelSearch<'_> {
    fn run(&mut self, meter: &mut Meter) -> Option<()> {
        let starts: Vec<LabelWord> = (0..self.tables.agents()).map(|agent| self.tables.start(agent) * 2).collect();
        for words in self.arrivals(starts, None) {
            self.enter(&words, [0; 3], NONE);
        }
        while let Some(Reverse((ahead, label))) = self.open.pop() {
            let BoardLabel { state, is_worse, figures, .. } = self.labels[label as usize];
            if is_worse || self.is_matched(&ahead) {
                continue;
            }
            let words = self.states.words(state).to_vec();
            if words.iter().all(|word| word & ARRIVED != 0) {
                self.ends.push(label);
                continue;
            }
            for next in self.moves(&words) {
                meter.step()?;
                let moved = words.iter().zip(&next).filter(|(from, to)| self.cell(**from) != self.cell(**to)).count();
                let under_way = words.iter().filter(|word| **word & ARRIVED == 0).count();
                let figures = [figures[0] + 1, figures[1] + under_way as u64, figures[2] + moved as u64];
                for arrived in self.arrivals(next, Some(&words)) {
                    self.enter(&arrived, figures, label);
                }
            }
            (self.labels.len() <= MOST_LABELS && !self.states.is_full()).then_some(())?;
        }
        Some(())
    }

    fn cell(&self, word: LabelWord) -> CellIndex {
        self.tables.cell(word >> 1)
    }

    /// The position in each variant of which agents, among those just arrived at their goals, have arrived for good.
    fn arrivals(&self, words: Vec<LabelWord>, before: Option<&[LabelWord]>) -> Vec<Vec<LabelWord>> {
        let mut variants = vec![words];
        for agent in 0..self.tables.agents() {
            let word = variants[0][agent] & !ARRIVED;
            let was_there = before.is_some_and(|before| before[agent] >> 1 == word >> 1);
            if word >> 1 != self.tables.goal(agent) || was_there {
                continue;
            }
            let arrived: Vec<Vec<LabelWord>> = variants
                .iter()
                .map(|variant| {
                    let mut variant = variant.clone();
                    variant[agent] |= ARRIVED;
                    variant
                })
                .collect();
            if self.tables.is_absorbed(agent) {
                variants = arrived;
            } else {
                variants.extend(arrived);
            }
        }
        variants
    }

    /// Keeps a label unless it breaks a limit or is dominated.
    fn enter(&mut self, words: &[LabelWord], figures: BoardFigures, before: u32) {
        let Some(ahead) = self.ahead(words, figures) else { return };
        if ahead.iter().zip(&self.limits.most).any(|(figure, most)| figure > most) {
            return;
        }
        let state = match self.states.insert(words, 0, NONE) {
            Some(state) => {
                self.known.push(vec![]);
                state
            }
            None => match self.states.find_known(words) {
                Some(state) => state,
                None => return,
            },
        };
        let (limits, labels) = (self.limits, &mut self.labels);
        let known = &mut self.known[state as usize];
        if known.iter().any(|other| limits.covers(&labels[*other as usize].figures, &figures)) {
            return;
        }
        known.retain(|other| {
            let is_worse = limits.covers(&figures, &labels[*other as usize].figures);
            labels[*other as usize].is_worse |= is_worse;
            !is_worse
        });
        let label = labels.len() as u32;
        known.push(label);
        labels.push(BoardLabel { state, before, figures, is_worse: false });
        self.open.push(Reverse((ahead, label)));
    }

    /// Whether a known complete plan dominates everything with these figures.
    fn is_matched(&self, ahead: &BoardFigures) -> bool {
        let reaches = ahead.iter().zip(&self.limits.least).all(|(figure, least)| figure >= least);
        reaches && self.ends.iter().any(|end| self.limits.covers(&self.labels[*end as usize].figures, ahead))
    }

    /// Lower bounds on the figures of a complete plan; `None` if an agent cannot reach its goal.
    fn ahead(&self, words: &[LabelWord], figures: BoardFigures) -> Option<BoardFigures> {
        let (mut largest, mut sum) = (0, 0);
        for (agent, word) in words.iter().enumerate() {
            let distance = match self.tables.distance(agent, word >> 1) {
                FAR => return None,
                // An agent on its goal that has not arrived for good must leave it and come back: 2 steps.
                0 if word & ARRIVED == 0 => 2,
                distance => u64::from(distance),
            };
            largest = largest.max(distance);
            sum += distance;
        }
        Some([figures[0] + largest, figures[1] + sum, figures[2] + sum])
    }

    /// The joint positions one step later, before anyone arrives for good.
    fn moves(&self, from: &[LabelWord]) -> Vec<Vec<LabelWord>> {
        let mut heads: Vec<Vec<LabelWord>> = vec![vec![]];
        for (agent, word) in from.iter().enumerate() {
            let next: Vec<LabelWord> = match word & ARRIVED {
                0 => self.tables.next(agent, word >> 1).map(|node: StagedCell| node * 2).collect(),
                _ => vec![*word],
            };
            let longer = heads.iter().flat_map(|head| next.iter().map(move |to| (head, *to)));
            heads = longer
                .filter(|(head, to)| self.fits(from, head, *to))
                .map(|(head, to)| head.iter().copied().chain([to]).collect())
                .collect();
        }
        heads
    }

    /// Whether the next agent's move is compatible with those of the agents before it.
    fn fits(&self, from: &[LabelWord], head: &[LabelWord], to: LabelWord) -> bool {
        let agent = head.len();
        let own = [from[agent], to];
        head.iter().enumerate().all(|(other, other_to)| {
            let near = |at: LabelWord, other_at: LabelWord| {
                self.tables.too_near(agent, self.cell(at), other, self.cell(other_at))
            };
            let cells = |step: [LabelWord; 2]| step.map(|word| self.cell(word));
            !near(own[1], *other_to)
                && !near(own[1], from[other])
                && !near(own[0], *other_to)
                && !self.tables.clash(cells(own), cells([from[other], *other_to]))
        })
    }

    fn paths(&self, mut label: u32) -> Paths {
        let mut paths: Paths = vec![vec![]; self.tables.agents()];
        while label != NONE {
            let BoardLabel { state, before, .. } = self.labels[label as usize];
            for (path, word) in paths.iter_mut().zip(self.states.words(state)) {
                path.push(self.cell(*word));
            }
            label = before;
        }
        for path in &mut paths {
            path.reverse();
            trim(path);
        }
        paths
    }
}

impl PlanLimits {
    /// Dominance: no more of any figure, and as much of each up to its least value.
    pub fn covers(&self, figures: &BoardFigures, others: &BoardFigures) -> bool {
        (0..figures.len()).all(|figure| {
            let least = self.least[figure];
            figures[figure] <= others[figure] && figures[figure].min(least) == others[figure].min(least)
        })
    }
}
