//! Contents of the droplets of a board, from one operation to the next. They are exact, since volumes are only added
//! and halved.

use super::errors;
use crate::claims::Job;
use crate::claims::electrode_array::{
    AssayOperation, BoardPart, DropletContent, DropletShare, ElectrodeArrayAction, ElectrodeArrayOrder, Fluids,
};
use crate::device::electrode_array::droplets;
use crate::diagnostic::{Diagnostic, Sink};
use crate::quantity::fraction;
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};

/// Relative tolerance for equal contents, for the rounding of fractions: `1 - 1 / 7` is 6/7.
const SAME_CONTENT: f64 = 1e-12;

/// Most fluids of a droplet that a message lists.
const SHOWN: usize = 4;

/// Contents of a droplet by fluid name, in units of one droplet as dispensed.
#[derive(Debug, Clone, Default)]
struct Liquid {
    amounts: BTreeMap<String, f64>,
    /// The operation that last changed the contents.
    since: Option<Span>,
}

impl Liquid {
    fn of(fluid: &str) -> Liquid {
        Liquid { amounts: BTreeMap::from([(fluid.to_owned(), 1.0)]), since: None }
    }

    fn volume(&self) -> f64 {
        self.amounts.values().sum()
    }

    /// The volume, or the share of a fluid; exact.
    fn share(&self, share: &DropletShare) -> f64 {
        match share {
            DropletShare::Volume => self.volume(),
            DropletShare::Fluid(fluid) => self.amounts.get(fluid).copied().unwrap_or(0.0) / self.volume(),
        }
    }

    /// Text for messages, such as `1/4 dye, 3/4 buffer; 2 droplets`.
    fn text(&self) -> String {
        let volume = self.volume();
        let part = |(fluid, amount): (&String, &f64)| format!("{} {fluid}", fraction(amount / volume));
        let parts: Vec<String> = self.amounts.iter().map(part).collect();
        let more = if parts.len() > SHOWN { ", …" } else { "" };
        let shown = parts.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        format!("{shown}{more}; {}", droplets(volume))
    }
}

/// Warns where merging makes a droplet so wide that it touches another one on the board across the separation, on
/// devices that do not state the largest droplet that they carry. In a gap of constant height the width grows with the
/// square root of the volume.
pub fn warn_of_wide_droplets(jobs: &[Job], sink: &mut Sink) {
    // For each device its liquids, and the parts with liquid on the board.
    let mut boards: BTreeMap<&str, (BoardLiquids, BTreeSet<&str>)> = BTreeMap::new();
    for job in jobs {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else { continue };
        let (board, present) = boards.entry(&job.device).or_default();
        let name = |part: usize| order.parts[part].name.as_str();
        let new: Vec<&str> =
            (0..order.parts.len()).map(name).filter(|part| !board.liquids.contains_key(*part)).collect();
        board.put(&order.parts);
        present.extend(new.into_iter().filter(|part| board.volume(part) > 0.0));
        for change in order.steps.iter().flat_map(|step| changes(&step.action)) {
            // Violations of the device's limits were already reported.
            board.change(job, order, &change);
            present.extend(change.filled().map(name).filter(|part| board.volume(part) > 0.0));
            for part in change.gone() {
                present.remove(name(part));
            }
            if let (Some(_), None) = (change.with(), order.facts.most_volume) {
                let part = name(change.part);
                let others = present.iter().copied().filter(|other| *other != part);
                let widest = others.max_by(|one, other| board.volume(one).total_cmp(&board.volume(other)));
                let half_width = |part: &str| order.facts.layout.half_width_pitches * board.volume(part).sqrt();
                let apart = order.facts.separation.apart();
                let wide = widest.filter(|other| half_width(part) + half_width(other) > f64::from(apart));
                if let Some(other) = wide {
                    let droplets = [part, other].map(|part| (part, board.volume(part), half_width(part)));
                    sink.push(errors::wide_droplets(change.span, droplets, &job.device, apart));
                }
            }
        }
    }
}

/// The effect of a step on the liquid of a part.
pub struct LiquidChange<'o> {
    pub span: Span,
    part: usize,
    cause: LiquidCause<'o>,
}

enum LiquidCause<'o> {
    Operation(&'o AssayOperation),
    /// Merge with another part.
    Merge(usize),
}

impl LiquidChange<'_> {
    /// The part with which it merges.
    fn with(&self) -> Option<usize> {
        match self.cause {
            LiquidCause::Operation(operation) => operation.with,
            LiquidCause::Merge(with) => Some(with),
        }
    }

    /// The parts that may have liquid from then on.
    fn filled(&self) -> impl Iterator<Item = usize> {
        let half = match self.cause {
            LiquidCause::Operation(operation) => operation.splits.map(|half| half.part),
            LiquidCause::Merge(_) => None,
        };
        std::iter::once(self.part).chain(half)
    }

    /// The parts that leave the board by this change.
    fn gone(&self) -> impl Iterator<Item = usize> {
        let leaves = match self.cause {
            LiquidCause::Operation(operation) => operation.leaves,
            LiquidCause::Merge(_) => false,
        };
        self.with().into_iter().chain(leaves.then_some(self.part))
    }
}

/// The effects of a step on the liquids of parts, in the order of its operations.
pub fn changes(action: &ElectrodeArrayAction) -> Vec<LiquidChange<'_>> {
    match action {
        ElectrodeArrayAction::Wait(_) => Vec::new(),
        ElectrodeArrayAction::Move(moves) => {
            let merged = moves.iter().filter_map(|one| Some((one, LiquidCause::Merge(one.with?))));
            merged.map(|(one, cause)| LiquidChange { span: one.span, part: one.part, cause }).collect()
        }
        ElectrodeArrayAction::Assay(all) => all
            .iter()
            .map(|one| LiquidChange { span: one.span, part: one.part, cause: LiquidCause::Operation(one) })
            .collect(),
    }
}

/// Liquids of the droplets of a board by name; those of gone droplets are kept in their last state.
#[derive(Debug, Default)]
pub struct BoardLiquids {
    liquids: BTreeMap<String, Liquid>,
}

impl BoardLiquids {
    /// Adds the parts that a scene puts on the board.
    pub fn put(&mut self, parts: &[BoardPart]) {
        for part in parts.iter().filter(|part| part.cell.is_some()) {
            self.liquids.entry(part.name.clone()).or_insert_with(|| Liquid::of(&part.name));
        }
    }

    /// For each part of an order, the fluids that it contains before the task; empty if it has never been on the board.
    pub fn before(&self, order: &ElectrodeArrayOrder) -> Vec<Fluids> {
        let of_part = |part: &BoardPart| {
            let liquid = self.liquids.get(&part.name);
            liquid.map(|liquid| liquid.amounts.keys().cloned().collect()).unwrap_or_default()
        };
        order.parts.iter().map(of_part).collect()
    }

    /// Applies a change; an error if a droplet becomes too small or too large.
    pub fn change(&mut self, job: &Job, order: &ElectrodeArrayOrder, change: &LiquidChange) -> Option<Diagnostic> {
        match change.cause {
            LiquidCause::Operation(operation) => self.operate(job, order, operation),
            LiquidCause::Merge(with) => self.merge(job, order, [change.part, with], change.span),
        }
    }

    /// In units of one droplet as dispensed; 0 before the droplet is on the board.
    fn volume(&self, name: &str) -> f64 {
        self.liquids.get(name).map_or(0.0, Liquid::volume)
    }

    /// Merges two droplets into the first; an error if the device cannot carry the result.
    fn merge(
        &mut self,
        job: &Job,
        order: &ElectrodeArrayOrder,
        [part, with]: [usize; 2],
        span: Span,
    ) -> Option<Diagnostic> {
        let [name, other] = [part, with].map(|part| order.parts[part].name.as_str());
        let added = self.liquids.get(other)?.amounts.clone();
        let liquid = self.liquids.get_mut(name)?;
        for (fluid, amount) in added {
            *liquid.amounts.entry(fluid).or_insert(0.0) += amount;
        }
        liquid.since = Some(span);
        let (volume, most) = (liquid.volume(), order.facts.most_volume?);
        let wrong = || errors::volume_out_of_limits(span, name, volume, &job.device, most, true);
        (volume > most).then(wrong)
    }

    fn operate(&mut self, job: &Job, order: &ElectrodeArrayOrder, operation: &AssayOperation) -> Option<Diagnostic> {
        let name = |part: usize| order.parts[part].name.as_str();
        if let Some(fluid) = &operation.fluid {
            self.liquids.insert(name(operation.part).to_owned(), Liquid::of(fluid));
        }
        if let Some(with) = operation.with {
            return self.merge(job, order, [operation.part, with], operation.span);
        }
        let half = operation.splits?;
        let liquid = self.liquids.get_mut(name(operation.part))?;
        liquid.amounts.values_mut().for_each(|amount| *amount /= 2.0);
        liquid.since = Some(operation.span);
        let (halved, volume) = (liquid.clone(), liquid.volume());
        self.liquids.insert(name(half.part).to_owned(), halved);
        let least = order.facts.least_volume?;
        let wrong = || errors::volume_out_of_limits(operation.span, name(half.part), volume, &job.device, least, false);
        (volume < least).then(wrong)
    }

    /// Required contents that are not met at the end of a task, each with the place in the source of the requirement.
    pub fn judge(&self, order: &ElectrodeArrayOrder) -> Vec<(Span, Diagnostic)> {
        let wrong = |content: &DropletContent| {
            let name = order.parts[content.part].name.as_str();
            let Some(liquid) = self.liquids.get(name) else { return Some(errors::never_there(content, name)) };
            let reached = liquid.share(&content.share);
            let is_kept = content.relation.holds(reached, content.limit, SAME_CONTENT * content.limit.abs());
            (!is_kept).then(|| errors::other_content(content, name, reached, &liquid.text(), liquid.since))
        };
        order.contents.iter().filter_map(|content| Some((content.span, wrong(content)?))).collect()
    }
}
