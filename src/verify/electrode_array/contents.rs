//! What droplets contain at the end of each run of a board, from the operations that it and the runs before it have done.
//!
//! A droplet is a volume and the shares of its fluids: what merges is averaged by volume, what splits is halved. Shares are compared with a
//! tolerance for the rounding of these means.

use crate::claims::electrode_array::{
    BoardPart, DropletContent, DropletShare, ElectrodeArrayAction, ElectrodeArrayOrder,
};
use crate::claims::{Claims, Job, Relation};
use crate::source::Span;
use crate::verify::evidence::Tally;
use crate::verify::rule::Rule;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Difference of two shares, or of two volumes of one droplet, that is rounding.
const TOLERANCE: f64 = 1e-9;

/// A droplet in the end, or when it was last on the board.
#[derive(Debug, Clone, Default)]
pub(crate) struct DropletAfter<'c> {
    /// In droplets as reservoirs dispense them.
    pub volume: f64,
    /// The part of its volume, from 0 to 1, by the names of the fluids.
    pub shares: BTreeMap<&'c str, f64>,
}

impl<'c> DropletAfter<'c> {
    fn of(fluid: &'c str) -> DropletAfter<'c> {
        DropletAfter { volume: 1.0, shares: BTreeMap::from([(fluid, 1.0)]) }
    }

    fn merged(&self, other: &DropletAfter<'c>) -> DropletAfter<'c> {
        let volume = self.volume + other.volume;
        let mut shares = BTreeMap::new();
        for droplet in [self, other] {
            for (fluid, share) in &droplet.shares {
                *shares.entry(*fluid).or_insert(0.0) += share * droplet.volume / volume;
            }
        }
        DropletAfter { volume, shares }
    }
}

/// A condition on droplets that is not kept: where the program asks for it, and what is wrong.
pub(super) struct BrokenContent {
    pub span: Span,
    pub title: String,
}

/// What is wrong with the droplets of all runs of a device, where this is its last one.
pub(super) fn broken(claims: &Claims, job: &Job, tally: &Tally) -> Vec<BrokenContent> {
    let own = claims.jobs.iter().filter(|other| other.device == job.device);
    if !own.clone().next_back().is_some_and(|last| std::ptr::eq(last, job)) {
        return Vec::new();
    }
    let mut board = BoardDroplets::default();
    let mut found = Vec::new();
    for order in own.filter_map(|job| ElectrodeArrayOrder::of(&job.order)) {
        board.put(order);
        tally.asked(Rule::Requirement, order.contents.len() + limited(order));
        found.extend(operated(order, &mut board.droplets));
        found.extend(order.contents.iter().filter_map(|content| other_than(content, order, &board.droplets)));
    }
    found
}

/// Number of operations after which the device limits the volume of a droplet.
fn limited(order: &ElectrodeArrayOrder) -> usize {
    if order.facts.least_volume.is_none() && order.facts.most_volume.is_none() {
        return 0;
    }
    let operations = order.steps.iter().map(|step| match &step.action {
        ElectrodeArrayAction::Wait(_) => 0,
        ElectrodeArrayAction::Move(moves) => moves.len(),
        ElectrodeArrayAction::Assay(operations) => operations.len(),
    });
    operations.sum()
}

/// The droplets of a device, in the course of its runs.
#[derive(Default)]
struct BoardDroplets<'c> {
    droplets: BTreeMap<&'c str, DropletAfter<'c>>,
    /// The parts of the last run.
    known: Option<&'c Arc<Vec<BoardPart>>>,
}

impl<'c> BoardDroplets<'c> {
    /// Enters what the scene of a run puts on the board; runs in one scene share its parts.
    fn put(&mut self, order: &'c ElectrodeArrayOrder) {
        if !self.known.replace(&order.parts).is_some_and(|known| Arc::ptr_eq(known, &order.parts)) {
            for part in order.parts.iter().filter(|part| part.cell.is_some()) {
                self.droplets.entry(&part.name).or_insert_with(|| DropletAfter::of(&part.name));
            }
        }
    }
}

/// The fluids of each droplet before a run, by the runs of its device before it.
pub(super) fn fluids_before<'c>(claims: &'c Claims, job: &Job) -> BTreeMap<&'c str, BTreeSet<&'c str>> {
    let droplets = droplets_before(claims, &job.device, Some(job)).into_iter();
    droplets.map(|(name, droplet)| (name, droplet.shares.into_keys().collect())).collect()
}

/// The droplets of a device after all of its runs, by their names.
pub(crate) fn droplets_after<'c>(claims: &'c Claims, device: &str) -> BTreeMap<&'c str, DropletAfter<'c>> {
    droplets_before(claims, device, None)
}

/// The droplets of a device before one of its runs, or after all of them.
fn droplets_before<'c>(claims: &'c Claims, device: &str, end: Option<&Job>) -> BTreeMap<&'c str, DropletAfter<'c>> {
    let mut board = BoardDroplets::default();
    for job in claims.jobs.iter().filter(|job| job.device == device) {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else { continue };
        board.put(order);
        if end.is_some_and(|end| std::ptr::eq(job, end)) {
            break;
        }
        operated(order, &mut board.droplets);
    }
    board.droplets
}

/// What is wrong with a droplet at the end of a run.
fn other_than(
    content: &DropletContent,
    order: &ElectrodeArrayOrder,
    droplets: &BTreeMap<&str, DropletAfter>,
) -> Option<BrokenContent> {
    let name = order.parts.get(content.part)?.name.as_str();
    let Some(droplet) = droplets.get(name) else {
        return Some(BrokenContent { span: content.span, title: format!("`{name}` is never on the board") });
    };
    let (reached, what) = match &content.share {
        DropletShare::Volume => (droplet.volume, "volume"),
        DropletShare::Fluid(fluid) => (droplet.shares.get(fluid.as_str()).copied().unwrap_or(0.0), fluid.as_str()),
    };
    let over = reached - content.limit;
    let is_kept = match content.relation {
        Relation::Less => over < -TOLERANCE,
        Relation::AtMost => over <= TOLERANCE,
        Relation::Equal => over.abs() <= TOLERANCE,
        Relation::AtLeast => over >= -TOLERANCE,
        Relation::More => over > TOLERANCE,
    };
    let title = || format!("`{name}` has {reached} of `{what}`, which breaks its limit {}", content.limit);
    (!is_kept).then(|| BrokenContent { span: content.span, title: title() })
}

/// Does what the steps of an order do to droplets; those that get too large or too small for the device.
fn operated<'c>(
    order: &'c ElectrodeArrayOrder,
    droplets: &mut BTreeMap<&'c str, DropletAfter<'c>>,
) -> Vec<BrokenContent> {
    let name = |part: usize| order.parts.get(part).map_or("", |part| part.name.as_str());
    let merges = |droplets: &BTreeMap<&'c str, DropletAfter<'c>>, [part, with]: [usize; 2]| {
        let both = [part, with].map(|part| droplets.get(name(part)).cloned().unwrap_or_default());
        both[0].merged(&both[1])
    };
    let mut found = Vec::new();
    let mut put =
        |droplets: &mut BTreeMap<&'c str, DropletAfter<'c>>, part: usize, droplet: DropletAfter<'c>, span: Span| {
            found.extend(out_of_limits(order, name(part), droplet.volume, span));
            droplets.insert(name(part), droplet);
        };
    for step in &order.steps {
        match &step.action {
            ElectrodeArrayAction::Wait(_) => {}
            ElectrodeArrayAction::Move(moves) => {
                for (one, with) in moves.iter().filter_map(|one| Some((one, one.with?))) {
                    let merged = merges(droplets, [one.part, with]);
                    put(droplets, one.part, merged, one.span);
                }
            }
            ElectrodeArrayAction::Assay(operations) => {
                for operation in operations {
                    let (part, span) = (operation.part, operation.span);
                    if let (true, Some(fluid)) = (operation.comes, &operation.fluid) {
                        put(droplets, part, DropletAfter::of(fluid), span);
                    }
                    if let Some(with) = operation.with {
                        let merged = merges(droplets, [part, with]);
                        put(droplets, part, merged, span);
                    }
                    if let Some(half) = operation.splits {
                        let whole = droplets.get(name(part)).cloned().unwrap_or_default();
                        let halved = DropletAfter { volume: whole.volume / 2.0, ..whole };
                        put(droplets, part, halved.clone(), span);
                        put(droplets, half.part, halved, span);
                    }
                }
            }
        }
    }
    found
}

fn out_of_limits(order: &ElectrodeArrayOrder, part: &str, volume: f64, span: Span) -> Option<BrokenContent> {
    let (least, most) = (order.facts.least_volume.unwrap_or(0.0), order.facts.most_volume.unwrap_or(f64::INFINITY));
    let title = || format!("`{part}` has a volume of {volume}, the device moves {least} to {most}");
    let is_kept = (least - TOLERANCE..=most + TOLERANCE).contains(&volume);
    (!is_kept).then(|| BrokenContent { span, title: title() })
}
