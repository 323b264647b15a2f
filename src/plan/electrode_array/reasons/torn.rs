//! Reasons why a step has no plan on a board with shared channels.

use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeMap};
use crate::diagnostic::Diagnostic;
use crate::plan::electrode_array::assay::NoAssayPlan;
use crate::plan::electrode_array::board::{BoardAnswer, BoardObjective, Instance};
use crate::plan::electrode_array::errands::AssaySite;
use crate::plan::electrode_array::places::arranged::{self, NoArrangement};
use crate::plan::electrode_array::portfolio;
use crate::plan::electrode_array::stage::{self, BoardGround, BoardStage};
use crate::plan::errors;
use crate::plan::search::{Meter, SearchAnswer, SearchBudget};
use crate::source::Span;

/// Budget of the search for a plan in which each electrode has a channel of its own.
const OWN_BUDGET: u64 = 2_000_000;

/// Reports an agent that shared channels keep from a stop.
pub fn torn(order: &ElectrodeArrayOrder, stage: &BoardStage, agent: usize, stop: usize) -> Diagnostic {
    let (actor, asked) = (&stage.agents[agent], &stage.instance.agents[agent]);
    let from = if stop == 0 { asked.start } else { asked.stops[stop - 1] };
    let [from, to] = [from, asked.stops[stop]].map(|cell| stage::cell(order, cell).to_string());
    let (name, span) = actor.named(order);
    errors::torn_by_channels(errors::StepEnds { step: span, from: &from, to: &to }, name)
}

/// Reports agents that would have a plan if each electrode had a channel of its own; `None` if none is found.
pub fn excluded(order: &ElectrodeArrayOrder, step: Span, stage: &BoardStage, agents: &[usize]) -> Option<Diagnostic> {
    stage.instance.board.channels()?;
    let Instance { board, separation, agents: all, merges } = stage.instance.clone();
    let place = |agent: &usize| agents.iter().position(|own| own == agent);
    let merges = merges.iter().filter_map(|[one, other]| Some([place(one)?, place(other)?])).collect();
    let own = agents.iter().map(|agent| all[*agent].clone()).collect();
    let unshared = Instance { board: board.unshared(), separation, agents: own, merges };
    let answer = portfolio::solve(&unshared, BoardObjective::Makespan, None, SearchBudget::of(OWN_BUDGET));
    let parts: Vec<(&str, Span)> = agents.iter().map(|agent| stage.agents[*agent].named(order)).collect();
    matches!(answer, BoardAnswer::Found(_)).then(|| errors::excluded_by_channels(step, &parts))
}

/// Whether operations that exclude one another would have a plan if each electrode had a channel of its own; false if
/// none is found.
pub fn excludes_operations(site: &AssaySite, none: &NoArrangement) -> bool {
    let NoAssayPlan::Excluded { .. } = none.why else { return false };
    let Some(map) = site.order.facts.map.as_ref().filter(|map| map.is_shared()) else { return false };
    let unshared = map.channels.iter().zip(0..).map(|(channel, place)| channel.map(|_| place));
    let map = ElectrodeMap { channels: unshared.collect(), ..(**map).clone() };
    let facts = ElectrodeArrayFacts { map: Some(map.into()), ..site.order.facts.clone() };
    let order = ElectrodeArrayOrder { facts, ..site.order.clone() };
    let ground = BoardGround::new(&order);
    let site = AssaySite { order: &order, ground: &ground, cells: site.cells };
    let meter = &mut Meter::new(SearchBudget::of(OWN_BUDGET));
    matches!(arranged::solve(&site, &none.operations, BoardObjective::Makespan, meter), SearchAnswer::Found(_))
}

/// Reports parts that cannot rest together: through shared channels, the electrodes that hold them switch others on.
pub fn restless(order: &ElectrodeArrayOrder, stage: &BoardStage, step: Span) -> Option<Diagnostic> {
    let channels = stage.instance.board.channels()?;
    let agents = stage.instance.agents.iter().zip(&stage.agents);
    let agents = agents.map(|(agent, actor)| (order.parts[actor.part].name.as_str(), agent.start));
    let all: Vec<(&str, u32)> = agents.chain(stage.standing_parts(order)).collect();
    if channels.may_rest(&all.iter().map(|(_, cell)| *cell).collect::<Vec<_>>()) {
        return None;
    }
    let pairs = all.iter().enumerate().flat_map(|(nth, one)| all[..=nth].iter().map(move |other| [*one, *other]));
    let [one, other] = pairs.into_iter().find(|[one, other]| !channels.may_rest(&[one.1, other.1]))?;
    let at = |cell: u32| stage::cell(order, cell).to_string();
    Some(errors::restless_by_channels(step, [(one.0, at(one.1)), (other.0, at(other.1))]))
}
