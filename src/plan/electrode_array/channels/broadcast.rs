//! Shared channels: how the electrodes that a step of one agent switches on act on that agent and on others.
//!
//! On a pin-constrained board a channel switches several electrodes. A step of an agent, that is, a move or a rest that
//! is held, needs the electrode of the cell at its end; all other working electrodes of that channel are on with it. An
//! electrode acts on an agent that stands on it or on one of the eight cells around it, before or after the step. A
//! step is possible if no electrode that is on acts on its agent except the one at its end. Two steps are compatible if
//! the same holds for both agents with the electrodes of both steps on. So there is one predicate for a single step
//! ([`SharedChannels::tears_apart`]) and one for a pair ([`SharedChannels::clash`]), and no other is needed for any
//! number of agents. Valid for droplets only; the separation, at least 2, takes care of the electrodes at the ends
//! themselves. Cost: at most eighteen cells around a step are read.

use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Hold};
use fixedbitset::FixedBitSet;
use std::sync::Arc;

/// The flat index of an electrode, equal to that of its cell.
type ElectrodeIndex = u32;

/// Cells of an agent before and after a step of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AgentStep {
    pub from: ElectrodeIndex,
    pub to: ElectrodeIndex,
}

impl AgentStep {
    /// A step in which the agent stays.
    pub fn rest(at: ElectrodeIndex) -> AgentStep {
        AgentStep { from: at, to: at }
    }
}

/// A step whose agent may be split: `split_electrode` is the second electrode that acts on it on purpose, besides the
/// one at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PulledStep {
    pub step: AgentStep,
    pub split_electrode: Option<ElectrodeIndex>,
}

/// The shared channels of a board, and their restrictions by parts that do not move.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedChannels {
    width: u32,
    /// By cell, the number of its shared channel, from 0; `None` where an electrode has a channel of its own or does
    /// not work.
    numbers: Arc<Vec<Option<u32>>>,
    /// Whether the electrode under a resting agent is on.
    is_held: bool,
    /// Cells of fixed parts, which must not be pulled at all.
    stuck: Vec<ElectrodeIndex>,
    /// By channel: whether it must stay off, since it acts on a part that is stuck or that stays.
    barred: FixedBitSet,
    /// By channel: whether it is always on, since it holds a part that stays.
    held: FixedBitSet,
    /// Whether a channel is both held and barred, so that no step is possible on the board.
    is_board_torn: bool,
}

impl SharedChannels {
    /// The channels of a board with stuck parts; `None` where each electrode has a channel of its own.
    pub fn of(facts: &ElectrodeArrayFacts, stuck: impl Iterator<Item = ElectrodeCell>) -> Option<SharedChannels> {
        let map = facts.map.as_ref().filter(|map| map.is_shared())?;
        let flat = |cell: ElectrodeCell| (cell.row - 1) * facts.columns + cell.column - 1;
        let mut numbers = vec![None; facts.columns as usize * facts.rows as usize];
        let shared = map.by_channel().into_values().filter(|cells| cells.len() > 1);
        for (number, cells) in (0..).zip(shared) {
            for cell in cells.into_iter().filter(|cell| map.works(*cell)) {
                numbers[flat(cell) as usize] = Some(number);
            }
        }
        let stuck = stuck.map(flat).collect();
        Some(SharedChannels { stuck, ..SharedChannels::new(facts.columns, numbers, facts.hold) }.with_standing(&[]))
    }

    /// The channels of a board with `width` columns; `numbers` has the shared channel of each cell.
    pub fn new(width: u32, numbers: Vec<Option<u32>>, hold: Hold) -> SharedChannels {
        let channels = numbers.iter().flatten().max().map_or(0, |most| *most as usize + 1);
        SharedChannels {
            width,
            numbers: Arc::new(numbers),
            is_held: hold == Hold::On,
            stuck: Vec::new(),
            barred: FixedBitSet::with_capacity(channels),
            held: FixedBitSet::with_capacity(channels),
            is_board_torn: false,
        }
    }

    /// The same channels with parts that stay at some cells.
    #[must_use]
    pub fn with_standing(&self, standing: &[ElectrodeIndex]) -> SharedChannels {
        let mut same = self.clone();
        same.barred.clear();
        same.held.clear();
        for at in standing.iter().filter(|_| self.is_held) {
            self.number(*at).into_iter().for_each(|own| same.held.insert(own));
        }
        let beside = |at: ElectrodeIndex| self.reach(at).filter(move |cell| *cell != at);
        let near = standing.iter().flat_map(|at| beside(*at)).chain(self.stuck.iter().flat_map(|at| self.reach(*at)));
        near.filter_map(|cell| self.number(cell)).for_each(|number| same.barred.insert(number));
        same.is_board_torn = same.held.intersection(&same.barred).next().is_some();
        same
    }

    /// Whether parts can rest together at some cells while nothing else moves.
    pub fn may_rest(&self, cells: &[ElectrodeIndex]) -> bool {
        !self.with_standing(cells).is_board_torn
    }

    fn number(&self, cell: ElectrodeIndex) -> Option<usize> {
        self.numbers.get(cell as usize).copied().flatten().map(|number| number as usize)
    }

    /// The electrodes that act on an agent at a cell.
    fn reach(&self, at: ElectrodeIndex) -> impl Iterator<Item = ElectrodeIndex> + use<> {
        let (column, row, width) = (at % self.width, at / self.width, self.width);
        let height = self.numbers.len() as u32 / width;
        let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
        let rows = row.saturating_sub(1)..=(row + 1).min(height - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// Whether channels that are on act on an agent in a step, other than by the electrode at its end and those in
    /// `exempt`.
    fn acts(&self, step: AgentStep, exempt: [Option<ElectrodeIndex>; 2], is_on: impl Fn(usize) -> bool) -> bool {
        let mut reach = self.reach(step.from).chain(self.reach(step.to));
        reach.any(|cell| cell != step.to && !exempt.contains(&Some(cell)) && self.number(cell).is_some_and(&is_on))
    }

    /// The shared channel that a step switches on.
    fn on_in(&self, step: AgentStep) -> Option<usize> {
        let is_on = self.is_held || step.from != step.to;
        self.number(step.to).filter(|_| is_on)
    }

    /// Whether a step is impossible even for an agent alone.
    pub fn tears_apart(&self, step: AgentStep) -> bool {
        self.tears_apart_pulled(PulledStep { step, split_electrode: None })
    }

    /// The same for an agent that may be split.
    pub fn tears_apart_pulled(&self, pulled: PulledStep) -> bool {
        let PulledStep { step, split_electrode } = pulled;
        let own = self.on_in(step);
        self.is_board_torn
            || own.is_some_and(|own| self.barred.contains(own))
            || self.acts(step, [split_electrode, None], |number| Some(number) == own || self.held.contains(number))
    }

    /// Whether two simultaneous steps exclude each other: an electrode that is on for one acts on the agent of the
    /// other.
    pub fn clash(&self, one: AgentStep, other: AgentStep) -> bool {
        let [one, other] = [one, other].map(|step| PulledStep { step, split_electrode: None });
        self.clash_pulled(one, other)
    }

    /// The same for agents that may be split.
    pub fn clash_pulled(&self, one: PulledStep, other: PulledStep) -> bool {
        let disturbs = |one: AgentStep, other: PulledStep| {
            let own = self.on_in(one);
            // The separation keeps the first agent's own electrode away from the other agent.
            own.is_some() && self.acts(other.step, [Some(one.to), other.split_electrode], |number| Some(number) == own)
        };
        disturbs(one.step, other) || disturbs(other.step, one)
    }

    /// Whether all of some steps are possible at the same time.
    pub fn go_together(&self, steps: &[PulledStep]) -> bool {
        let is_possible = |nth: usize| {
            let is_clear = |other: &PulledStep| !self.clash_pulled(steps[nth], *other);
            !self.tears_apart_pulled(steps[nth]) && steps[..nth].iter().all(is_clear)
        };
        (0..steps.len()).all(is_possible)
    }
}
