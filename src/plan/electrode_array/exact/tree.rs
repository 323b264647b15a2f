//! Conflict-based search for a group of agents under the separation rule.
//!
//! A node of the constraint tree holds constraints on each agent alone ([`AgentConstraint`]), all its least-cost paths
//! ([`MultiValueDecisionDiagram`]) and one of them, chosen so that few paths clash. Where two clash, the node is split so that
//! every plan that meets its constraints meets those of at least one child (Sharon, Stern, Felner, Sturtevant, "Conflict-based
//! search for optimal multi-agent pathfinding", Artificial Intelligence 219, 2015; boxes for large agents: Li, Surynek, Felner, Ma,
//! Kumar, Koenig, "Multi-agent path finding for large agents", AAAI 2019). Pairs without any compatible least-cost paths (cardinal
//! conflicts) are split by their costs instead, and raise the bound of the node ([`cover`](super::cover)).

use super::constraint::{AgentConstraint, OutOfSteps, least_cost};
use super::cover::{Edge, least_rise};
use super::joint_mdd::{self, JointMddAnswer};
use super::mdd::MultiValueDecisionDiagram;
use super::pair::{CompatiblePairs, PairSide};
use super::split::{self, ConstraintBranch, Party, clashes};
use super::tables::ExactTables;
use crate::plan::electrode_array::board::{CellIndex, Paths};
use crate::plan::search::Meter;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

/// Task of a search.
#[derive(Clone, Copy)]
pub struct ConstraintTreeTask<'a> {
    pub tables: &'a ExactTables<'a>,
    /// The agents; members are indices into this.
    pub group: &'a [usize],
    /// No arrival counts before this instant.
    pub least: u32,
    /// Latest arrival of all agents, or `ALWAYS`.
    pub most: u32,
    /// Only sums of costs below this matter.
    pub ceiling: u64,
    /// Known lower bound on the sum of costs.
    pub floor: u64,
    /// Paths of agents outside the group, which are avoided where that costs nothing.
    pub outside: &'a [(usize, &'a [CellIndex])],
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TreeAnswer {
    /// Paths of least sum of costs; no agent's cost counts less than `least`.
    Found { paths: Paths, cost: u64 },
    /// Proven: no plan has a sum of costs below the ceiling.
    Nothing,
    /// The budget ran out; `bound` is a lower bound on the sum of costs.
    GaveUp { bound: u64 },
}

/// Joint cost increases of a pair are computed up to this.
const MOST_RISE: u32 = 2;

/// Longest wait that is tried for one agent of a pair before the other's cost rises too.
const FARTHEST_WAIT: u32 = 8;

/// Clashes of a pair that are compared for the best split.
const CLASHES_WEIGHED: usize = 6;

/// Limit on all compatibility tables together: about 8 bytes times this.
const MOST_TABLE_WORDS: usize = 1 << 22;

/// Diagrams at raised costs that are cached.
const MOST_WAITS: usize = 256;

/// Nodes of layers per budget step when a path is chosen.
const NODES_A_STEP: u64 = 4;

/// Positions per budget step when two paths are compared.
const POSITIONS_A_STEP: u64 = 16;

/// Rounds in which the paths of a node are chosen again.
const POLISHING_ROUNDS: usize = 2;

/// Runs the search; one step of the budget is one expanded node of an agent's own search or of its layers.
pub fn search(task: ConstraintTreeTask, meter: &mut Meter) -> TreeAnswer {
    let mut tree = ConstraintTree {
        task,
        meter,
        nodes: vec![],
        open: BinaryHeap::new(),
        rises: FxHashMap::default(),
        waits: FxHashMap::default(),
        pair_tables: FxHashMap::default(),
        pair_table_words: 0,
        joint_mdd_answers: FxHashMap::default(),
        ids: 0,
    };
    match tree.run() {
        Ok(end) => end,
        Err(OutOfSteps) => TreeAnswer::GaveUp { bound: tree.bound() },
    }
}

/// Plan of one agent in a tree node.
struct AgentPlan {
    /// Unique number of the plan.
    id: u32,
    constraint: AgentConstraint,
    mdd: Rc<MultiValueDecisionDiagram>,
}

#[derive(Clone)]
struct ConstraintNode {
    plans: Vec<Rc<AgentPlan>>,
    paths: Vec<Rc<Vec<CellIndex>>>,
    /// Pairs of members whose paths clash, the smaller first.
    clashing: Vec<[usize; 2]>,
    /// Lower bound on the sum of costs of all plans that meet the constraints.
    bound: u64,
}

struct ConstraintTree<'a, 'm> {
    task: ConstraintTreeTask<'a>,
    meter: &'m mut Meter,
    nodes: Vec<Option<ConstraintNode>>,
    /// Open list, ordered by bound, then number of clashes, then newest first.
    open: BinaryHeap<Reverse<(u64, usize, Reverse<usize>)>>,
    /// By the ids of two plans: least increase of their joint cost.
    rises: FxHashMap<[u32; 2], u32>,
    /// By plan id and cost increase: the diagram at the raised cost.
    waits: FxHashMap<(u32, u32), Rc<MultiValueDecisionDiagram>>,
    /// By the ids of two plans: their compatibility table.
    pair_tables: FxHashMap<[u32; 2], Rc<CompatiblePairs>>,
    pair_table_words: usize,
    /// By the ids of some plans: whether they are incompatible, or unknown.
    joint_mdd_answers: FxHashMap<Vec<u32>, JointMddAnswer>,
    ids: u32,
}

impl ConstraintTree<'_, '_> {
    fn run(&mut self) -> Result<TreeAnswer, OutOfSteps> {
        let Some(root) = self.root()? else { return Ok(TreeAnswer::Nothing) };
        self.push(root);
        while let Some(Reverse((bound, _, Reverse(index)))) = self.open.peek().copied() {
            if bound >= self.task.ceiling {
                return Ok(TreeAnswer::Nothing);
            }
            // The node stays in the queue until it is processed, so that its bound counts if the budget ends here.
            let Some(mut node) = self.nodes[index].clone() else { unreachable!("an open node is stored") };
            if node.clashing.is_empty() {
                let cost = node.plans.iter().map(|plan| u64::from(plan.mdd.cost())).sum();
                return Ok(TreeAnswer::Found { paths: node.paths.iter().map(|path| path.to_vec()).collect(), cost });
            }
            let successors = self.successors(&mut node)?;
            self.open.pop();
            self.nodes[index] = None;
            successors.into_iter().for_each(|successor| self.push(successor));
        }
        Ok(TreeAnswer::Nothing)
    }

    fn bound(&self) -> u64 {
        self.open.peek().map_or(self.task.floor, |Reverse((bound, _, _))| *bound)
    }

    fn push(&mut self, node: ConstraintNode) {
        if node.bound < self.task.ceiling {
            self.open.push(Reverse((node.bound, node.clashing.len(), Reverse(self.nodes.len()))));
            self.nodes.push(Some(node));
        }
    }

    fn root(&mut self) -> Result<Option<ConstraintNode>, OutOfSteps> {
        let mut node = ConstraintNode { plans: vec![], paths: vec![], clashing: vec![], bound: 0 };
        for member in 0..self.task.group.len() {
            let constraint = AgentConstraint { bans: vec![], least: self.task.least, most: self.task.most };
            let Some(plan) = self.plan(member, constraint)? else { return Ok(None) };
            let path = self.best_path(&node, member, &plan.mdd);
            node.bound += u64::from(plan.mdd.cost());
            node.plans.push(plan);
            node.paths.push(Rc::new(path));
            self.find_clashes(&mut node, member);
        }
        node.bound = node.bound.max(self.task.floor);
        self.polish(&mut node);
        Ok(Some(node))
    }

    fn plan(&mut self, member: usize, constraint: AgentConstraint) -> Result<Option<Rc<AgentPlan>>, OutOfSteps> {
        let (tables, agent) = (self.task.tables, self.task.group[member]);
        let Some(cost) = least_cost(tables, agent, &constraint, self.meter)? else { return Ok(None) };
        let mdd = Rc::new(MultiValueDecisionDiagram::new(tables, agent, &constraint, cost, self.meter)?);
        self.ids += 1;
        Ok(Some(Rc::new(AgentPlan { id: self.ids, constraint, mdd })))
    }

    /// A least-cost path of a member with few clashes.
    fn best_path(&mut self, node: &ConstraintNode, member: usize, mdd: &MultiValueDecisionDiagram) -> Vec<CellIndex> {
        let others = self.others(node, member);
        let positions = others.len() as u64 * u64::from(mdd.cost());
        let path = mdd.best_path(self.task.tables, self.task.group[member], &others);
        self.meter.charge(mdd.size() as u64 / NODES_A_STEP + positions / POSITIONS_A_STEP + 1);
        path
    }

    /// The paths of all members but one, and of the outsiders.
    fn others<'n>(&'n self, node: &'n ConstraintNode, member: usize) -> Vec<(usize, &'n [CellIndex])> {
        let inside = node.paths.iter().enumerate().filter(|(other, _)| *other != member);
        let inside = inside.map(|(other, path)| (self.task.group[other], path.as_slice()));
        inside.chain(self.task.outside.iter().copied()).collect()
    }

    /// Updates the clashing pairs of one member.
    fn find_clashes(&mut self, node: &mut ConstraintNode, member: usize) {
        self.meter.charge((node.paths.len() * node.paths[member].len()) as u64 / POSITIONS_A_STEP + 1);
        node.clashing.retain(|pair| !pair.contains(&member));
        for other in (0..node.paths.len()).filter(|other| *other != member) {
            let pair = [member.min(other), member.max(other)];
            let agents = pair.map(|member| self.task.group[member]);
            let paths = pair.map(|member| node.paths[member].as_slice());
            if clashes(self.task.tables, agents, paths).next().is_some() {
                node.clashing.push(pair);
            }
        }
        node.clashing.sort_unstable();
    }

    /// Chooses other paths of the same cost while that reduces the clashes.
    fn polish(&mut self, node: &mut ConstraintNode) {
        for _ in 0..POLISHING_ROUNDS {
            let before = node.clashing.len();
            let members: Vec<usize> =
                (0..node.plans.len()).filter(|member| node.clashing.iter().any(|pair| pair.contains(member))).collect();
            for member in members {
                let path = self.best_path(node, member, &node.plans[member].mdd);
                if path == *node.paths[member] {
                    continue;
                }
                let known = (node.paths[member].clone(), node.clashing.clone());
                node.paths[member] = Rc::new(path);
                self.find_clashes(node, member);
                if node.clashing.len() >= known.1.len() {
                    (node.paths[member], node.clashing) = known;
                }
            }
            if node.clashing.is_empty() || node.clashing.len() == before {
                return;
            }
        }
    }

    /// The bound of a node, raised by the cost increases of its clashing pairs.
    fn raised(&mut self, node: &ConstraintNode) -> Result<u64, OutOfSteps> {
        let sum: u64 = node.plans.iter().map(|plan| u64::from(plan.mdd.cost())).sum();
        let mut edges = vec![];
        for pair in &node.clashing {
            edges.push(Edge { ends: *pair, weight: self.rise(node, *pair)? });
        }
        Ok(node.bound.max(sum + u64::from(least_rise(&edges))))
    }

    /// Least increase of the joint cost of a pair, up to one more than [`MOST_RISE`].
    fn rise(&mut self, node: &ConstraintNode, pair: [usize; 2]) -> Result<u32, OutOfSteps> {
        let key = pair.map(|member| node.plans[member].id);
        if let Some(rise) = self.rises.get(&key) {
            return Ok(*rise);
        }
        let mut rise = 0;
        while rise <= MOST_RISE && !self.some_division_goes(node, pair, rise)? {
            rise += 1;
        }
        self.rises.insert(key, rise);
        Ok(rise)
    }

    fn some_division_goes(&mut self, node: &ConstraintNode, pair: [usize; 2], rise: u32) -> Result<bool, OutOfSteps> {
        for first in 0..=rise {
            if self.goes(node, pair, [first, rise - first])? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a pair has compatible paths at costs raised by `rises`.
    fn goes(&mut self, node: &ConstraintNode, pair: [usize; 2], rises: [u32; 2]) -> Result<bool, OutOfSteps> {
        let one = self.longer(node, pair[0], rises[0])?;
        let other = self.longer(node, pair[1], rises[1])?;
        let (Some(one), Some(other)) = (one, other) else { return Ok(false) };
        if rises == [0, 0] {
            return Ok(self.table(node, pair).allows_start());
        }
        let [first, second] =
            [(pair[0], &one), (pair[1], &other)].map(|(member, mdd)| PairSide { agent: self.task.group[member], mdd });
        Ok(CompatiblePairs::new(self.task.tables, first, second, self.meter).allows_start())
    }

    /// The compatibility table of a pair, the smaller member first.
    fn table(&mut self, node: &ConstraintNode, pair: [usize; 2]) -> Rc<CompatiblePairs> {
        let plans = pair.map(|member| &node.plans[member]);
        let key = plans.map(|plan| plan.id);
        if let Some(table) = self.pair_tables.get(&key) {
            return table.clone();
        }
        let [one, other] = pair.map(|member| PairSide { agent: self.task.group[member], mdd: &node.plans[member].mdd });
        let table = Rc::new(CompatiblePairs::new(self.task.tables, one, other, self.meter));
        if self.pair_table_words > MOST_TABLE_WORDS {
            self.pair_tables.clear();
            self.pair_table_words = 0;
        }
        self.pair_table_words += table.words();
        self.pair_tables.insert(key, table.clone());
        table
    }

    /// The paths of a member at a cost raised by `rise`; `None` if its constraints forbid that cost.
    fn longer(
        &mut self,
        node: &ConstraintNode,
        member: usize,
        rise: u32,
    ) -> Result<Option<Rc<MultiValueDecisionDiagram>>, OutOfSteps> {
        let plan = &node.plans[member];
        let cost = plan.mdd.cost() + rise;
        if rise == 0 || cost > plan.constraint.most {
            return Ok((rise == 0).then(|| plan.mdd.clone()));
        }
        if let Some(mdd) = self.waits.get(&(plan.id, rise)) {
            return Ok(Some(mdd.clone()));
        }
        let mdd = Rc::new(MultiValueDecisionDiagram::new(
            self.task.tables, self.task.group[member], &plan.constraint, cost, self.meter,
        )?);
        if self.waits.len() >= MOST_WAITS {
            self.waits.clear();
        }
        self.waits.insert((plan.id, rise), mdd.clone());
        Ok(Some(mdd))
    }

    /// The replacement of a node whose paths clash: itself with a higher bound or fewer clashes, or its children.
    fn successors(&mut self, node: &mut ConstraintNode) -> Result<Vec<ConstraintNode>, OutOfSteps> {
        let raised = self.raised(node)?;
        if raised > node.bound {
            node.bound = raised;
            return Ok(vec![node.clone()]);
        }
        let Some(pair) = self.worst_pair(node)? else { return self.joint_mdd_successors(node) };
        let branches = self.split_by_cost(node, pair)?;
        self.children(node, branches.into())
    }

    /// The children of a node, one per branch.
    fn children(
        &mut self,
        node: &ConstraintNode,
        branches: Vec<ConstraintBranch>,
    ) -> Result<Vec<ConstraintNode>, OutOfSteps> {
        let mut children = vec![];
        for branch in branches {
            children.extend(self.child(node, branch)?);
        }
        Ok(children)
    }

    /// The clashing pair with the greatest cost increase; `None` if no pair's costs rise.
    fn worst_pair(&mut self, node: &ConstraintNode) -> Result<Option<[usize; 2]>, OutOfSteps> {
        let mut worst = (0, None);
        for pair in &node.clashing {
            let rise = self.rise(node, *pair)?;
            if rise > worst.0 {
                worst = (rise, Some(*pair));
            }
        }
        Ok(worst.1)
    }

    /// Successors of a node in which every clashing pair is compatible: all of its members together may be compatible
    /// too, or some larger set is not.
    fn joint_mdd_successors(&mut self, node: &mut ConstraintNode) -> Result<Vec<ConstraintNode>, OutOfSteps> {
        let mut members: Vec<usize> = node.clashing[0].to_vec();
        loop {
            members = self.clashing_with(node, members);
            match self.joint_mdd_answer(node, &members) {
                JointMddAnswer::Compatible(paths) => {
                    let clashes = node.clashing.len();
                    let mut freed = node.clone();
                    for (member, path) in members.iter().zip(paths) {
                        freed.paths[*member] = Rc::new(path);
                    }
                    members.iter().for_each(|member| self.find_clashes(&mut freed, *member));
                    if freed.clashing.len() < clashes {
                        return Ok(vec![freed]);
                    }
                    let grown = self.clashing_with(&freed, members.clone());
                    if grown.len() == members.len() {
                        break;
                    }
                    members = grown;
                }
                JointMddAnswer::Incompatible => {
                    let sum: u64 = node.plans.iter().map(|plan| u64::from(plan.mdd.cost())).sum();
                    if sum + 1 > node.bound {
                        node.bound = sum + 1;
                        return Ok(vec![node.clone()]);
                    }
                    if let Some((leaves, branches)) = self.best_box(node, &node.clashing)
                        && leaves.some_have_none()
                    {
                        return self.children(node, branches.into());
                    }
                    let members = self.fewest_incompatible(node, members);
                    let branches = split::by_costs(members.iter().map(|member| self.party(node, *member)));
                    return self.children(node, branches);
                }
                JointMddAnswer::Unknown => break,
            }
        }
        let best = self.best_box(node, &node.clashing).expect("a clashing pair has a clash");
        self.children(node, best.1.into())
    }

    /// The transitive closure of some members under clashes.
    fn clashing_with(&self, node: &ConstraintNode, mut members: Vec<usize>) -> Vec<usize> {
        loop {
            let joins = |pair: &&[usize; 2]| members.contains(&pair[0]) != members.contains(&pair[1]);
            let Some(pair) = node.clashing.iter().find(joins) else {
                members.sort_unstable();
                return members;
            };
            members.push(if members.contains(&pair[0]) { pair[1] } else { pair[0] });
        }
    }

    fn joint_mdd_answer(&mut self, node: &ConstraintNode, members: &[usize]) -> JointMddAnswer {
        let ids: Vec<u32> = members.iter().map(|member| node.plans[*member].id).collect();
        if let Some(known) = self.joint_mdd_answers.get(&ids) {
            return known.clone();
        }
        if members.len() > joint_mdd::MOST_MEMBERS {
            return JointMddAnswer::Unknown;
        }
        let asked: Vec<joint_mdd::Member> = members
            .iter()
            .map(|member| joint_mdd::Member {
                agent: self.task.group[*member],
                mdd: node.plans[*member].mdd.clone(),
                path: &node.paths[*member],
            })
            .collect();
        let found = joint_mdd::search(self.task.tables, &asked, self.meter);
        if !matches!(found, JointMddAnswer::Compatible(_)) {
            self.joint_mdd_answers.insert(ids, found.clone());
        }
        found
    }

    /// Drops members one by one while the rest is still incompatible.
    fn fewest_incompatible(&mut self, node: &ConstraintNode, mut members: Vec<usize>) -> Vec<usize> {
        let mut place = 0;
        while place < members.len() && members.len() > 2 {
            let mut fewer = members.clone();
            fewer.remove(place);
            if self.joint_mdd_answer(node, &fewer) == JointMddAnswer::Incompatible {
                members = fewer;
            } else {
                place += 1;
            }
        }
        members
    }

    fn split_by_cost(&mut self, node: &ConstraintNode, pair: [usize; 2]) -> Result<[ConstraintBranch; 2], OutOfSteps> {
        let parties = self.parties(node, pair);
        let at_goal = self.clashes_of(node, pair).find_map(|clash| split::at_goal(self.task.tables, parties, clash));
        if let Some(branches) = at_goal {
            return Ok(branches);
        }
        let alone = [self.wait_alone(node, pair, 0)?, self.wait_alone(node, pair, 1)?];
        let longer = usize::from(alone[1] > alone[0]);
        let (first, second) = (parties[longer], parties[1 - longer]);
        Ok(split::by_cost(first, second, first.mdd.cost() + alone[longer]))
    }

    /// The least cost increase of one agent of a pair alone at which the two are compatible, up to one more than
    /// [`FARTHEST_WAIT`]. A higher cost allows all the shorter paths too, so compatibility is monotone and bisection is
    /// valid.
    fn wait_alone(&mut self, node: &ConstraintNode, pair: [usize; 2], side: usize) -> Result<u32, OutOfSteps> {
        let plan = &node.plans[pair[side]];
        let farthest = FARTHEST_WAIT.min(plan.constraint.most - plan.mdd.cost());
        let (mut fails, mut goes) = (0, farthest + 1);
        while goes - fails > 1 {
            // The greatest increase first: if that fails, no other needs a try.
            let middle = if goes > farthest { farthest } else { fails.midpoint(goes) };
            let rises = if side == 0 { [middle, 0] } else { [0, middle] };
            if self.goes(node, pair, rises)? {
                goes = middle;
            } else {
                fails = middle;
            }
        }
        Ok(goes)
    }

    /// The box that leaves the fewest paths to the agents, over all clashes considered of some clashing pairs.
    fn best_box(&self, node: &ConstraintNode, pairs: &[[usize; 2]]) -> Option<(split::Leaves, [ConstraintBranch; 2])> {
        pairs.iter().flat_map(|pair| self.box_splits(node, *pair)).min_by_key(|(leaves, _)| *leaves)
    }

    fn box_splits(&self, node: &ConstraintNode, pair: [usize; 2]) -> Vec<(split::Leaves, [ConstraintBranch; 2])> {
        let parties = self.parties(node, pair);
        let weighed = self.clashes_of(node, pair).take(CLASHES_WEIGHED);
        weighed.map(|clash| split::by_box(self.task.tables, parties, clash)).collect()
    }

    fn clashes_of<'n>(&'n self, node: &'n ConstraintNode, pair: [usize; 2]) -> impl Iterator<Item = split::Clash> + 'n {
        clashes(
            self.task.tables,
            pair.map(|member| self.task.group[member]),
            pair.map(|member| node.paths[member].as_slice()),
        )
    }

    fn parties<'n>(&self, node: &'n ConstraintNode, pair: [usize; 2]) -> [Party<'n>; 2] {
        pair.map(|member| self.party(node, member))
    }

    fn party<'n>(&self, node: &'n ConstraintNode, member: usize) -> Party<'n> {
        let plan = &node.plans[member];
        Party { member, agent: self.task.group[member], constraint: &plan.constraint, mdd: &plan.mdd }
    }

    /// A node with some constraints replaced; `None` if one of them cannot be met.
    fn child(&mut self, node: &ConstraintNode, branch: ConstraintBranch) -> Result<Option<ConstraintNode>, OutOfSteps> {
        let mut child = node.clone();
        for (member, constraint) in branch {
            let Some(plan) = self.plan(member, constraint)? else { return Ok(None) };
            child.plans[member] = plan;
            let path = self.best_path(&child, member, &child.plans[member].mdd);
            child.paths[member] = Rc::new(path);
            self.find_clashes(&mut child, member);
        }
        let sum = child.plans.iter().map(|plan| u64::from(plan.mdd.cost())).sum();
        child.bound = child.bound.max(sum);
        if child.bound < self.task.ceiling {
            self.polish(&mut child);
        }
        Ok(Some(child))
    }
}
