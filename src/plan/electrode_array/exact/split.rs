//! Clashes of two paths, and branching on them: sets of constraints such that every plan meets at least one of them.

use super::constraint::{ALWAYS, AgentConstraint, Ban};
use super::mdd::MultiValueDecisionDiagram;
use super::tables::{CellPlace, ExactTables};
use crate::plan::electrode_array::board::{CellIndex, position};

/// A conflict: positions of two agents at the same or neighbouring instants that are too near.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clash {
    pub cells: [CellIndex; 2],
    pub instants: [u32; 2],
}

/// All clashes of two paths in order of time, as an iterator.
pub fn clashes<'a>(
    tables: &'a ExactTables,
    agents: [usize; 2],
    paths: [&'a [CellIndex]; 2],
) -> impl Iterator<Item = Clash> + 'a {
    let end = paths[0].len().max(paths[1].len());
    let near = move |t: usize, u: usize| {
        let cells = [position(paths[0], t), position(paths[1], u)];
        let clash = Clash { cells, instants: [t as u32, u as u32] };
        tables.too_near(agents[0], cells[0], agents[1], cells[1]).then_some(clash)
    };
    (0..end).flat_map(move |t| [near(t, t), near(t, t + 1), near(t + 1, t)]).flatten()
}

/// One branch of a split: new constraints for one or two agents.
pub type ConstraintBranch = Vec<(usize, AgentConstraint)>;

/// An agent of a clash with its constraints and its paths.
#[derive(Clone, Copy)]
pub struct Party<'a> {
    /// Its index in the group.
    pub member: usize,
    pub agent: usize,
    pub constraint: &'a AgentConstraint,
    pub mdd: &'a MultiValueDecisionDiagram,
}

/// Split by cost: the second one's cost rises, or it does not and the first one's rises to `first_least`.
pub fn by_cost(first: Party, second: Party, first_least: u32) -> [ConstraintBranch; 2] {
    let second_rises = AgentConstraint { least: second.mdd.cost() + 1, ..second.constraint.clone() };
    let second_stays = AgentConstraint { most: second.mdd.cost(), ..second.constraint.clone() };
    let first_rises = AgentConstraint { least: first_least, ..first.constraint.clone() };
    [vec![(second.member, second_rises)], vec![(first.member, first_rises), (second.member, second_stays)]]
}

/// Split of several agents that are not all compatible at their costs: in each branch, the cost of one rises and the
/// costs of those before it do not.
pub fn by_costs<'a>(parties: impl Iterator<Item = Party<'a>>) -> Vec<ConstraintBranch> {
    let mut unchanged: ConstraintBranch = vec![];
    let mut branches = vec![];
    for party in parties {
        let cost = party.mdd.cost();
        let rises = AgentConstraint { least: cost + 1, ..party.constraint.clone() };
        branches.push(unchanged.iter().cloned().chain([(party.member, rises)]).collect());
        unchanged.push((party.member, AgentConstraint { most: cost, ..party.constraint.clone() }));
    }
    branches
}

/// Split where one agent stays on its goal for good while the other passes: either it arrives later, or the other keeps
/// away from then on (compare the target reasoning of Li, Harabor, Stuckey, Ma, Gange, Koenig, "Pairwise symmetry
/// reasoning for multi-agent path finding search", Artificial Intelligence 301, 2021). `None` if neither agent has
/// arrived for good.
pub fn at_goal(tables: &ExactTables, parties: [Party; 2], clash: Clash) -> Option<[ConstraintBranch; 2]> {
    let standing = (0..2).find(|side| clash.instants[*side] >= parties[*side].mdd.cost())?;
    let (still, passing) = (parties[standing], parties[1 - standing]);
    let instant = clash.instants[standing];
    let reach = tables.instance.separation as i32 - 1;
    let CellPlace { column, row } = tables.place(clash.cells[standing]);
    let later = AgentConstraint { least: instant + 1, ..still.constraint.clone() };
    let by_then = AgentConstraint { most: instant.min(still.constraint.most), ..still.constraint.clone() };
    let zone = Ban {
        columns: (column - reach, column + reach),
        rows: (row - reach, row + reach),
        from: instant.saturating_sub(1),
        until: ALWAYS,
        except: None,
    };
    Some([vec![(still.member, later)], vec![(still.member, by_then), (passing.member, with(passing.constraint, zone))]])
}

/// Split by a box as wide and as high as the separation and two instants long: any two positions in it are too near, so
/// at most one of the two agents enters it. Returns the branches, and how much of their paths the agents keep; less is
/// better.
pub fn by_box(tables: &ExactTables, parties: [Party; 2], clash: Clash) -> (Leaves, [ConstraintBranch; 2]) {
    let boxes = boxes(tables, parties, clash);
    let (leaves, ban) = boxes
        .map(|ban| (Leaves::of(tables, parties, &ban), ban))
        .min_by_key(|(leaves, _)| *leaves)
        .expect("two cells that are too near have a box in common");
    (leaves, parties.map(|party| vec![(party.member, with(party.constraint, ban))]))
}

fn with(constraint: &AgentConstraint, ban: Ban) -> AgentConstraint {
    let mut constraint = constraint.clone();
    constraint.bans.push(ban);
    constraint
}

/// The boxes that contain both positions of a clash.
fn boxes<'a>(tables: &'a ExactTables, parties: [Party; 2], clash: Clash) -> impl Iterator<Item = Ban> + 'a {
    let side = tables.instance.separation as i32 - 1;
    let [CellPlace { column: c, row: r }, CellPlace { column: d, row: s }] = clash.cells.map(|cell| tables.place(cell));
    let [t, u] = clash.instants;
    let goal = tables.cell(tables.goal(parties[0].agent));
    let except = tables.is_merged(parties[0].agent, parties[1].agent).then_some(goal);
    let first = if t == u { t.saturating_sub(1) } else { t.min(u) };
    (first..=t.min(u)).flat_map(move |from| {
        (c.max(d) - side..=c.min(d)).flat_map(move |left| {
            (r.max(s) - side..=r.min(s)).map(move |low| Ban {
                columns: (left, left + side),
                rows: (low, low + side),
                from,
                until: from + 1,
                except,
            })
        })
    })
}

/// What a box leaves of the paths of the two agents: the number of agents with any path left, and the sum of their
/// shares of nodes left, in thousandths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Leaves {
    with_ways: usize,
    share: usize,
}

impl Leaves {
    /// Whether the cost of at least one of the two rises outside the box.
    pub fn some_have_none(&self) -> bool {
        self.with_ways <= 1
    }

    fn of(tables: &ExactTables, parties: [Party; 2], ban: &Ban) -> Leaves {
        let shares = parties.map(|party| {
            let (outside, all) = party.mdd.outside(tables, ban);
            (outside * 1000).div_ceil(all)
        });
        Leaves { with_ways: shares.iter().filter(|share| **share > 0).count(), share: shares.iter().sum() }
    }
}
