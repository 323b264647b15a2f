//! What the droplets of a board contain, from one operation to the next: exact, since volumes are only added and halved.

use super::errors;
use crate::claims::Job;
use crate::claims::electrode_array::{
    AssayOperation, BoardPart, DropletContent, DropletShare, ElectrodeArrayOrder, Fluids,
};
use crate::device::electrode_array::droplets;
use crate::diagnostic::Diagnostic;
use crate::quantity::fraction;
use crate::source::Span;
use std::collections::BTreeMap;

/// Most fluids of a droplet that a message names.
const SHOWN: usize = 4;

/// What a droplet contains, in droplets as they are dispensed, by the names of the fluids.
#[derive(Debug, Clone, Default)]
struct Liquid {
    amounts: BTreeMap<String, f64>,
    /// The operation that made it what it is.
    since: Option<Span>,
}

impl Liquid {
    fn of(fluid: &str) -> Liquid {
        Liquid { amounts: BTreeMap::from([(fluid.to_owned(), 1.0)]), since: None }
    }

    fn volume(&self) -> f64 {
        self.amounts.values().sum()
    }

    /// A figure of it, exactly.
    fn share(&self, share: &DropletShare) -> f64 {
        match share {
            DropletShare::Volume => self.volume(),
            DropletShare::Fluid(fluid) => self.amounts.get(fluid).copied().unwrap_or(0.0) / self.volume(),
        }
    }

    /// `1/4 dye, 3/4 buffer; 2 droplets`
    fn text(&self) -> String {
        let volume = self.volume();
        let part = |(fluid, amount): (&String, &f64)| format!("{} {fluid}", fraction(amount / volume));
        let parts: Vec<String> = self.amounts.iter().map(part).collect();
        let more = if parts.len() > SHOWN { ", …" } else { "" };
        let shown = parts.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        format!("{shown}{more}; {}", droplets(volume))
    }
}

/// The droplets of a board, by their names; those that are gone are remembered as they were last.
#[derive(Debug, Default)]
pub struct BoardLiquids {
    liquids: BTreeMap<String, Liquid>,
}

impl BoardLiquids {
    /// Enters what a scene puts on the board.
    pub fn put(&mut self, parts: &[BoardPart]) {
        for part in parts.iter().filter(|part| part.cell.is_some()) {
            self.liquids.entry(part.name.clone()).or_insert_with(|| Liquid::of(&part.name));
        }
    }

    /// For each part of an order the fluids that it contains before the task, if it is on the board, or was.
    pub fn before(&self, order: &ElectrodeArrayOrder) -> Vec<Fluids> {
        let of_part = |part: &BoardPart| {
            let liquid = self.liquids.get(&part.name);
            liquid.map(|liquid| liquid.amounts.keys().cloned().collect()).unwrap_or_default()
        };
        order.parts.iter().map(of_part).collect()
    }

    /// Two droplets become one; the first is what it was, if the device can carry it.
    pub fn merge(
        &mut self,
        (job, order): (&Job, &ElectrodeArrayOrder),
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
        let wrong = || errors::volume_out_of_limits(span, (name, volume), &job.device, (most, true));
        (volume > most).then(wrong)
    }

    /// What an operation makes of its droplets; an error if one of them is too small or too large.
    pub fn operate(
        &mut self,
        (job, order): (&Job, &ElectrodeArrayOrder),
        operation: &AssayOperation,
    ) -> Option<Diagnostic> {
        let name = |part: usize| order.parts[part].name.as_str();
        if let Some(fluid) = &operation.fluid {
            self.liquids.insert(name(operation.part).to_owned(), Liquid::of(fluid));
        }
        if let Some(with) = operation.with {
            return self.merge((job, order), [operation.part, with], operation.span);
        }
        let half = operation.splits?;
        let liquid = self.liquids.get_mut(name(operation.part))?;
        liquid.amounts.values_mut().for_each(|amount| *amount /= 2.0);
        liquid.since = Some(operation.span);
        let (halved, volume) = (liquid.clone(), liquid.volume());
        self.liquids.insert(name(half.part).to_owned(), halved);
        let least = order.facts.least_volume?;
        let of = (name(half.part), volume);
        (volume < least).then(|| errors::volume_out_of_limits(operation.span, of, &job.device, (least, false)))
    }

    /// The contents that a task requires and that are others at its end, each with where the program asks for it.
    pub fn judge(&self, order: &ElectrodeArrayOrder) -> Vec<(Span, Diagnostic)> {
        let wrong = |content: &DropletContent| {
            let name = order.parts[content.part].name.as_str();
            let Some(liquid) = self.liquids.get(name) else { return Some(errors::never_there(content, name)) };
            let reached = liquid.share(&content.share);
            let is_kept = content.relation.holds(reached, content.limit, 0.0);
            (!is_kept).then(|| errors::other_content(content, name, (reached, &liquid.text()), liquid.since))
        };
        order.contents.iter().filter_map(|content| Some((content.span, wrong(content)?))).collect()
    }
}
