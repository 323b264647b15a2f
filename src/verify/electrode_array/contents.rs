//! Contents of the droplets at the end of each run of a board, from the operations of this run and of those before it.
//!
//! A droplet is a volume and the fractions of its fluids: a merge averages the fractions by volume, a split halves the
//! volume. Fractions are compared with a tolerance for the rounding of these means.

use crate::claims::electrode_array::{
    BoardPart, DropletContent, DropletShare, ElectrodeArrayAction, ElectrodeArrayOrder,
};
use crate::claims::{Claims, Job, Relation};
use crate::source::Span;
use crate::verify::evidence::Tally;
use crate::verify::rule::Rule;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Rounding tolerance between two fractions, or two volumes, of a droplet.
const TOLERANCE: f64 = 1e-9;

/// A droplet at the end, or when it was last on the board.
#[derive(Debug, Clone, Default)]
pub(crate) struct DropletAfter<'c> {
    /// In units of one dispensed droplet.
    pub volume: f64,
    /// The fraction of each fluid, from 0 to 1, by the fluid's name.
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

/// A broken condition on a droplet: its place in the program, and the title of the violation.
pub(super) struct BrokenContent {
    pub span: Span,
    pub title: String,
}

/// Broken conditions on the droplets of all runs of a device; empty unless `job` is the device's last run.
pub(super) fn broken(claims: &Claims, job: &Job, tally: &Tally) -> Vec<BrokenContent> {
    let own = claims.jobs.iter().filter(|other| other.device == job.device);
    if !own.clone().next_back().is_some_and(|last| std::ptr::eq(last, job)) {
        return Vec::new();
    }
    let mut board = BoardDroplets::default();
    let mut found = Vec::new();
    for order in own.filter_map(|job| ElectrodeArrayOrder::of(&job.order)) {
        board.put(order);
        tally.count_checks(Rule::Requirement, order.contents.len() + limited(order));
        found.extend(operated(order, &mut board.droplets));
        found.extend(order.contents.iter().filter_map(|content| other_than(content, order, &board.droplets)));
    }
    found
}

/// Number of operations whose droplet volume the device limits.
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

/// The droplets of a device, updated run by run.
#[derive(Default)]
struct BoardDroplets<'c> {
    droplets: BTreeMap<&'c str, DropletAfter<'c>>,
    /// The parts of the last run.
    known: Option<&'c Arc<Vec<BoardPart>>>,
}

impl<'c> BoardDroplets<'c> {
    /// Adds the droplets that the scene of a run puts on the board; runs in one scene share its parts.
    fn put(&mut self, order: &'c ElectrodeArrayOrder) {
        if !self.known.replace(&order.parts).is_some_and(|known| Arc::ptr_eq(known, &order.parts)) {
            for part in order.parts.iter().filter(|part| part.cell.is_some()) {
                self.droplets.entry(&part.name).or_insert_with(|| DropletAfter::of(&part.name));
            }
        }
    }
}

/// The fluids in each droplet before a run, from the earlier runs of its device.
pub(super) fn fluids_before<'c>(claims: &'c Claims, job: &Job) -> BTreeMap<&'c str, BTreeSet<&'c str>> {
    let droplets = droplets_before(claims, &job.device, Some(job)).into_iter();
    droplets.map(|(name, droplet)| (name, droplet.shares.into_keys().collect())).collect()
}

/// The droplets of a device after all of its runs, by name.
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

/// The broken condition on a droplet at the end of a run, if it is broken.
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
    let title = || {
        let required = format!("{} {}", content.relation.sign(), content.limit);
        format!("`{name}` has {what} {reached}; the program requires {required}")
    };
    (!is_kept).then(|| BrokenContent { span: content.span, title: title() })
}

/// Applies the steps of an order to the droplets. Returns the droplets that become too large or too small for the
/// device.
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
    let title = || format!("`{part}` has a volume of {volume}; the device moves {least} to {most}");
    let is_kept = (least - TOLERANCE..=most + TOLERANCE).contains(&volume);
    (!is_kept).then(|| BrokenContent { span, title: title() })
}
