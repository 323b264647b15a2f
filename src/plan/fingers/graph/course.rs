//! A prepared route: its legs with their strands, and the transitions of nodes from one leg to the next.

use super::layout::{GraspChain, MAX_ANGLES, MAX_DIGIT, MAX_LEGS, NodeSpot, Sets, removed, wrapped};
use super::strands::{AngleMask, Strands, below};
use super::{Grasp, GraspRequest, MAX_NODES, Regrasp, TurnLeg};
use crate::device::fingers::MAX_FINGERS;
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::mechanics::LazyGraspEvaluator;
use crate::plan::fingers::tables::{ContactBits, Tables};
use std::rc::Rc;
use std::sync::Arc;

/// A prepared leg.
#[derive(Debug)]
pub struct PreparedLeg {
    pub tables: Arc<Tables>,
    pub strands: Rc<Strands>,
    pub contacts: usize,
    /// Number of angles.
    pub angles: usize,
    /// Start and end of the turn, counted from the leg's lowest angle.
    pub start: usize,
    pub end: usize,
    /// Transition from the leg before; [`Regrasp::Same`] for the first.
    pub entry: Regrasp,
    pub pin: Option<Grasp>,
    /// See [`TurnLeg::lazy`].
    pub lazy: Option<Rc<LazyGraspEvaluator>>,
    /// The leg's lowest angle.
    lowest: i32,
}

/// A prepared route.
#[derive(Debug)]
pub struct PreparedRoute {
    pub sets: Rc<Sets>,
    pub legs: Vec<PreparedLeg>,
    /// Limit on reconfigurations, if any.
    pub most_gaits: Option<u32>,
    pub looks: Rc<LooksBudget>,
}

/// The prepared routes of a request, or the number of nodes of one that has too many. Legs with the same tables share their
/// strands.
pub fn courses(request: &GraspRequest) -> Result<Vec<PreparedRoute>, u64> {
    let sets = Rc::new(Sets::of(request.fingers));
    let nodes = request.routes.iter().map(|route| nodes(&sets, route)).max().unwrap_or(0);
    if nodes > MAX_NODES {
        return Err(nodes);
    }
    let mut known: Vec<(Arc<Tables>, Rc<Strands>)> = Vec::new();
    let angles = |tables: &Arc<Tables>| {
        let legs = request.routes.iter().flatten().filter(|leg| Arc::ptr_eq(&leg.tables, tables));
        legs.map(TurnLeg::angles).max().unwrap_or(1)
    };
    let mut strands = |tables: &Arc<Tables>| match known.iter().find(|(other, _)| Arc::ptr_eq(other, tables)) {
        Some((_, strands)) => strands.clone(),
        None => {
            request.limits.looks.take(Strands::looks(tables));
            let made = Rc::new(Strands::of(tables, angles(tables)));
            known.push((tables.clone(), made.clone()));
            made
        }
    };
    let course = |route: &Vec<TurnLeg>| {
        let legs = route.iter().map(|leg| prepare(leg, strands(&leg.tables))).collect();
        PreparedRoute {
            sets: sets.clone(),
            legs,
            most_gaits: request.limits.gaits,
            looks: Rc::clone(&request.limits.looks),
        }
    };
    Ok(request.routes.iter().map(course).collect())
}

/// Number of nodes of a route, or a number above the limit if its legs cannot be indexed.
fn nodes(sets: &Sets, route: &[TurnLeg]) -> u64 {
    let leg = |leg: &TurnLeg| {
        let fits = leg.tables.contacts <= MAX_DIGIT && leg.angles() <= MAX_ANGLES;
        if fits { sets.chains(leg.tables.contacts) * leg.angles() as u64 } else { u64::MAX }
    };
    if route.len() > MAX_LEGS { u64::MAX } else { route.iter().map(leg).fold(0, u64::saturating_add) }
}

fn prepare(leg: &TurnLeg, strands: Rc<Strands>) -> PreparedLeg {
    PreparedLeg {
        tables: leg.tables.clone(),
        strands,
        contacts: leg.tables.contacts,
        angles: leg.angles(),
        start: -leg.lowest as usize,
        end: (leg.steps - leg.lowest) as usize,
        entry: leg.entry,
        pin: leg.end,
        lazy: leg.lazy.clone(),
        lowest: leg.lowest,
    }
}

impl PreparedLeg {
    /// Angles from which three fingers may roll to the next angle.
    #[inline]
    pub fn rolls_three<const N: usize>(&self, phases: [u16; 3]) -> AngleMask<N> {
        let head = self.strands.head(phases[0]);
        self.rolling(self.strands.roll_triple.window(self.strands.triple(head, phases), head.bit))
    }

    /// Angles from which two fingers may roll to the next angle.
    #[inline]
    pub fn rolls_two<const N: usize>(&self, phases: [u16; 2]) -> AngleMask<N> {
        let head = self.strands.head(phases[0]);
        self.rolling(self.strands.roll_pair.window(self.strands.pair(head, phases), head.bit))
    }

    /// A window of rolling steps, cut off at the last angle, from which nothing can roll further.
    #[inline]
    pub fn rolling<const N: usize>(&self, window: AngleMask<N>) -> AngleMask<N> {
        below(window, self.angles - 1)
    }

    /// The angles at which a pair's chain has nodes.
    #[inline]
    pub fn nodes_of_two<const N: usize>(&self, phases: [u16; 2]) -> AngleMask<N> {
        let head = self.strands.head(phases[0]);
        below(self.strands.hold_pair.window(self.strands.pair(head, phases), head.bit), self.angles)
    }

    /// The contact that has a phase at an angle.
    #[inline]
    pub fn contact(&self, angle: usize, phase: u16) -> usize {
        wrapped(usize::from(phase) + self.contacts - angle % self.contacts, self.contacts)
    }

    /// The phase of a contact at an angle.
    #[inline]
    pub fn phase(&self, angle: usize, contact: usize) -> u16 {
        wrapped(contact + angle % self.contacts, self.contacts) as u16
    }

    /// Whether contacts that hold without the load also hold with it.
    #[inline]
    fn bears(&self, angle: usize, contacts: &[usize]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.holds(self.lowest + angle as i32, contacts))
    }

    /// Whether contacts that roll on from an angle without the load also do so with it.
    #[inline]
    pub fn bears_on(&self, angle: usize, contacts: &[usize]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.rolls(self.lowest + angle as i32, contacts))
    }

    /// Whether the finger on the last of three contacts may leave under the load.
    #[inline]
    pub fn lets_go(&self, angle: usize, [i, j, k]: [usize; 3]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.leaves(self.lowest + angle as i32, [i, j], k))
    }

    /// Whether two or three contacts hold at an angle, according to the tables.
    #[inline]
    pub fn holds(&self, angle: usize, contacts: &[usize]) -> bool {
        let layer = self.tables.layer(angle);
        match *contacts {
            [i, j] => layer.pair.has(self.tables.two(i, j)),
            [i, j, k] => layer.triple.has(self.tables.three(i, j, k)),
            _ => false,
        }
    }
}

impl PreparedRoute {
    /// Index of a pair's chain within its leg.
    #[inline]
    pub fn pair_index(&self, leg: usize, chain: GraspChain) -> usize {
        self.sets.index(self.legs[leg].contacts, chain)
    }

    /// Index of the pair that remains without the member of a triple at `place`, as a linear function of the phase of
    /// the triple's varying member: its value for phase 0, and the increment per phase.
    pub fn pair_steps(&self, leg: usize, triple: impl Fn(u16) -> GraspChain, place: usize) -> (usize, usize) {
        let index = |third: u16| {
            let chain = triple(third);
            let ([p, q], _) = removed(chain.phases, place);
            self.pair_index(leg, GraspChain { set: self.sets.without(chain.set, place), phases: [p, q, 0] })
        };
        (index(0), index(1) - index(0))
    }

    /// The contact of each member of a node's set.
    pub fn contacts(&self, spot: NodeSpot) -> [usize; 3] {
        spot.chain.phases.map(|phase| self.legs[spot.leg].contact(spot.angle, phase))
    }

    /// The grasp of a node.
    pub fn grasp(&self, spot: NodeSpot) -> Grasp {
        let mut grasp = Grasp([0; MAX_FINGERS as usize]);
        let contacts = self.contacts(spot);
        for (finger, contact) in self.sets.members(spot.chain.set).iter().zip(contacts) {
            grasp.0[*finger] = contact as u16 + 1;
        }
        grasp
    }

    /// The node of a set of fingers on contacts; `None` if they do not hold.
    #[inline]
    pub fn spot(&self, leg: usize, angle: usize, set: u8, contacts: &[usize]) -> Option<NodeSpot> {
        let prepared = &self.legs[leg];
        let mut phases = [0; 3];
        for (phase, contact) in phases.iter_mut().zip(contacts) {
            *phase = prepared.phase(angle, *contact);
        }
        let holds = prepared.holds(angle, contacts) && prepared.bears(angle, contacts);
        holds.then_some(NodeSpot { leg, angle, chain: GraspChain { set, phases } })
    }

    /// The node of a grasp; `None` if it does not hold, or is not a grasp of this hand on this section.
    pub fn place(&self, leg: usize, angle: usize, grasp: &Grasp) -> Option<NodeSpot> {
        let fingers: Vec<usize> = (0..grasp.0.len()).filter(|finger| grasp.0[*finger] != 0).collect();
        let contacts: Vec<usize> = fingers.iter().filter_map(|finger| grasp.contact(*finger)).collect();
        let set = self.sets.find(&fingers)?;
        let fits = contacts.iter().all(|contact| *contact < self.legs[leg].contacts);
        if fits { self.spot(leg, angle, set, &contacts) } else { None }
    }

    /// Whether the leg's pinned grasp, if any, allows it to end at this node.
    fn may_end(&self, spot: NodeSpot) -> bool {
        self.legs[spot.leg].pin.is_none_or(|pin| self.grasp(spot) == pin)
    }

    /// The nodes at which a leg may end, if they are few; `None` if any grasp is allowed.
    pub fn few_ends(&self, leg: usize) -> Option<Vec<NodeSpot>> {
        let prepared = &self.legs[leg];
        if let Some(pin) = &prepared.pin {
            return Some(self.place(leg, prepared.end, pin).into_iter().collect());
        }
        let Regrasp::Across { old, .. } = self.legs.get(leg + 1)?.entry else { return None };
        let turned = [old, [old[1], old[0]]];
        let pairs = (0..self.sets.len() as u8).filter(|set| self.sets.is_pair(*set));
        let ends = pairs.flat_map(|set| turned.map(|contacts| self.spot(leg, prepared.end, set, &contacts)));
        Some(ends.flatten().collect())
    }

    /// Whether a node of the tables holds under the load.
    pub fn holds(&self, spot: NodeSpot) -> bool {
        let (contacts, count) = self.held(spot);
        self.legs[spot.leg].bears(spot.angle, &contacts[..count])
    }

    /// The contacts that the fingers of a node hold, and their number.
    #[inline]
    pub fn held(&self, spot: NodeSpot) -> ([usize; 3], usize) {
        (self.contacts(spot), if self.sets.is_pair(spot.chain.set) { 2 } else { 3 })
    }

    /// Number of nodes at an angle of a leg, according to the tables.
    pub fn count(&self, leg: usize, angle: usize) -> u64 {
        let layer = self.legs[leg].tables.layer(angle);
        let ones = |bits: &ContactBits| bits.words().iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
        let pairs = self.sets.pairs() as u64;
        pairs * ones(&layer.pair) + (self.sets.len() as u64 - pairs) * ones(&layer.triple)
    }

    /// Whether a node is a goal of the route.
    #[inline]
    pub fn is_goal(&self, spot: NodeSpot) -> bool {
        spot.leg + 1 == self.legs.len() && spot.angle == self.legs[spot.leg].end && self.may_end(spot)
    }

    /// The node at the start of the next leg that corresponds to this end of a leg.
    pub fn next(&self, spot: NodeSpot) -> Option<NodeSpot> {
        let next = self.legs.get(spot.leg + 1)?;
        if spot.angle != self.legs[spot.leg].end || !self.may_end(spot) {
            return None;
        }
        let contacts = self.contacts(spot);
        let set = spot.chain.set;
        match next.entry {
            Regrasp::Same => self.kept(set, contacts, spot.leg + 1, next.start),
            Regrasp::Across { old, new } => self.crossed(set, contacts, [old, new], spot.leg + 1, next.start),
        }
    }

    /// The node at the end of the previous leg that corresponds to this start of a leg.
    pub fn previous(&self, spot: NodeSpot) -> Option<NodeSpot> {
        let prepared = &self.legs[spot.leg];
        let leg = spot.leg.checked_sub(1)?;
        if spot.angle != prepared.start {
            return None;
        }
        let (contacts, set, angle) = (self.contacts(spot), spot.chain.set, self.legs[leg].end);
        let found = match prepared.entry {
            Regrasp::Same => self.kept(set, contacts, leg, angle),
            Regrasp::Across { old, new } => self.crossed(set, contacts, [new, old], leg, angle),
        };
        found.filter(|spot| self.may_end(*spot))
    }

    /// The same grasp in another leg.
    fn kept(&self, set: u8, contacts: [usize; 3], leg: usize, angle: usize) -> Option<NodeSpot> {
        let contacts = &contacts[..self.sets.members(set).len()];
        let fits = contacts.iter().all(|contact| *contact < self.legs[leg].contacts);
        if fits { self.spot(leg, angle, set, contacts) } else { None }
    }

    /// The node of two fingers on contacts of one section, carried over to the corresponding contacts of the other.
    fn crossed(
        &self,
        set: u8,
        contacts: [usize; 3],
        [from, to]: [[usize; 2]; 2],
        leg: usize,
        angle: usize,
    ) -> Option<NodeSpot> {
        let [i, j, _] = contacts;
        let turned = if [i, j] == from { to } else { [to[1], to[0]] };
        let is_there = self.sets.is_pair(set) && ([i, j] == from || [j, i] == from);
        if is_there { self.spot(leg, angle, set, &turned) } else { None }
    }
}
