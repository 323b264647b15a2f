//! A route made ready: its legs with their strands, and how nodes of one leg go on in the next.

use super::flood::removed;
use super::layout::{GraspChain, MAX_DIGIT, MAX_LEGS, NodeSpot, Sets, wrapped};
use super::strands::{AngleMask, Strands, below};
use super::{Grasp, GraspRequest, MAX_NODES, Regrasp, TurnLeg};
use crate::device::fingers::MAX_FINGERS;
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::mechanics::Lazy;
use crate::plan::fingers::tables::{ContactBits, Tables};
use std::rc::Rc;
use std::sync::Arc;

/// A leg made ready.
#[derive(Debug)]
pub struct Sheet {
    pub tables: Arc<Tables>,
    pub strands: Rc<Strands>,
    pub contacts: usize,
    /// How many there are.
    pub angles: usize,
    /// Where it begins and ends, counted from its lowest angle.
    pub start: usize,
    pub end: usize,
    /// How it follows the one before; [`Entry::Same`] for the first.
    pub entry: Regrasp,
    pub pin: Option<Grasp>,
    /// See [`Leg::lazy`].
    pub lazy: Option<Rc<Lazy>>,
    /// The leg's lowest angle.
    lowest: i32,
}

/// A route made ready.
#[derive(Debug)]
pub struct PreparedRoute {
    pub sets: Rc<Sets>,
    pub sheets: Vec<Sheet>,
    /// The most reconfigurations, if they are limited.
    pub most_gaits: Option<u32>,
    pub looks: Rc<LooksBudget>,
}

/// The routes of a request made ready, or the nodes of one that has too many. Legs with the same tables share their strands.
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
            request.within.looks.take((tables.contacts.pow(3) / 64 * tables.layers.len()) as u64);
            let made = Rc::new(Strands::of(tables, angles(tables)));
            known.push((tables.clone(), made.clone()));
            made
        }
    };
    let course = |route: &Vec<TurnLeg>| {
        let sheets = route.iter().map(|leg| sheet(leg, strands(&leg.tables))).collect();
        PreparedRoute {
            sets: sets.clone(),
            sheets,
            most_gaits: request.within.gaits,
            looks: Rc::clone(&request.within.looks),
        }
    };
    Ok(request.routes.iter().map(course).collect())
}

/// The nodes of a route, or more than are allowed where its legs are beyond what can be numbered.
fn nodes(sets: &Sets, route: &[TurnLeg]) -> u64 {
    let leg = |leg: &TurnLeg| {
        let fits = leg.tables.contacts <= MAX_DIGIT && leg.angles() <= MAX_DIGIT;
        if fits { sets.chains(leg.tables.contacts) * leg.angles() as u64 } else { u64::MAX }
    };
    if route.len() > MAX_LEGS { u64::MAX } else { route.iter().map(leg).fold(0, u64::saturating_add) }
}

fn sheet(leg: &TurnLeg, strands: Rc<Strands>) -> Sheet {
    Sheet {
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

impl Sheet {
    /// Where three fingers may roll on, from each angle to the next.
    #[inline]
    pub fn rolls_three<const N: usize>(&self, phases: [u16; 3]) -> AngleMask<N> {
        let head = self.strands.head(phases[0]);
        self.rolling(self.strands.roll_triple.window(self.strands.triple(head, phases), head.bit))
    }

    /// Where two fingers may.
    #[inline]
    pub fn rolls_two<const N: usize>(&self, phases: [u16; 2]) -> AngleMask<N> {
        let head = self.strands.head(phases[0]);
        self.rolling(self.strands.roll_pair.window(self.strands.pair(head, phases), head.bit))
    }

    /// A window of rolling steps cut off at the last angle, from which nothing rolls on.
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

    /// The contact of a phase.
    #[inline]
    pub fn contact(&self, angle: usize, phase: u16) -> usize {
        wrapped(usize::from(phase) + self.contacts - angle % self.contacts, self.contacts)
    }

    /// The phase of a contact.
    #[inline]
    pub fn phase(&self, angle: usize, contact: usize) -> u16 {
        wrapped(contact + angle % self.contacts, self.contacts) as u16
    }

    /// Whether contacts that hold without a load do so with it.
    #[inline]
    fn bears(&self, angle: usize, contacts: &[usize]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.holds(self.lowest + angle as i32, contacts))
    }

    /// Whether contacts that would roll on from an angle without a load do so with it.
    #[inline]
    pub fn bears_on(&self, angle: usize, contacts: &[usize]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.rolls(self.lowest + angle as i32, contacts))
    }

    /// Whether the finger on the last of three contacts may leave under the load.
    #[inline]
    pub fn lets_go(&self, angle: usize, [i, j, k]: [usize; 3]) -> bool {
        self.lazy.as_ref().is_none_or(|lazy| lazy.leaves(self.lowest + angle as i32, [i, j], k))
    }

    /// Whether contacts hold at an angle, as far as the tables know: two of them, or all three.
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
    /// The number of a pair's chain among those of its leg.
    #[inline]
    pub fn pair_index(&self, leg: usize, chain: GraspChain) -> usize {
        self.sets.index(self.sheets[leg].contacts, chain)
    }

    /// The number of the pair that is left at a place of a triple, as a number for phase 0 of its last member and a step for each more.
    pub fn pair_steps(&self, leg: usize, triple: impl Fn(u16) -> GraspChain, place: usize) -> (usize, usize) {
        let index = |third: u16| {
            let chain = triple(third);
            let ([p, q], _) = removed(chain.phases, place);
            self.pair_index(leg, GraspChain { set: self.sets.without(chain.set, place), phases: [p, q, 0] })
        };
        (index(0), index(1) - index(0))
    }

    /// The contacts of a node, of each member of its set.
    pub fn contacts(&self, spot: NodeSpot) -> [usize; 3] {
        spot.chain.phases.map(|phase| self.sheets[spot.leg].contact(spot.angle, phase))
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

    /// The node of a set of fingers on contacts; `None` where they do not hold.
    #[inline]
    pub fn spot(&self, leg: usize, angle: usize, set: u8, contacts: &[usize]) -> Option<NodeSpot> {
        let sheet = &self.sheets[leg];
        let mut phases = [0; 3];
        for (phase, contact) in phases.iter_mut().zip(contacts) {
            *phase = sheet.phase(angle, *contact);
        }
        let holds = sheet.holds(angle, contacts) && sheet.bears(angle, contacts);
        holds.then_some(NodeSpot { leg, angle, chain: GraspChain { set, phases } })
    }

    /// The node of a grasp; `None` where it does not hold, or is no grasp of this hand on this section.
    pub fn place(&self, leg: usize, angle: usize, grasp: &Grasp) -> Option<NodeSpot> {
        let fingers: Vec<usize> = (0..grasp.0.len()).filter(|finger| grasp.0[*finger] != 0).collect();
        let contacts: Vec<usize> = fingers.iter().filter_map(|finger| grasp.contact(*finger)).collect();
        let set = self.sets.find(&fingers)?;
        let fits = contacts.iter().all(|contact| *contact < self.sheets[leg].contacts);
        if fits { self.spot(leg, angle, set, &contacts) } else { None }
    }

    /// Whether a leg may end with a node at its end, as far as its pinned grasp goes.
    fn may_end(&self, spot: NodeSpot) -> bool {
        self.sheets[spot.leg].pin.is_none_or(|pin| self.grasp(spot) == pin)
    }

    /// The nodes with which a leg may end, where they are few; `None` where any grasp will do.
    pub fn few_ends(&self, leg: usize) -> Option<Vec<NodeSpot>> {
        let sheet = &self.sheets[leg];
        if let Some(pin) = &sheet.pin {
            return Some(self.place(leg, sheet.end, pin).into_iter().collect());
        }
        let Regrasp::Across { old, .. } = self.sheets.get(leg + 1)?.entry else { return None };
        let turned = [old, [old[1], old[0]]];
        let pairs = (0..self.sets.len() as u8).filter(|set| self.sets.is_pair(*set));
        let ends = pairs.flat_map(|set| turned.map(|contacts| self.spot(leg, sheet.end, set, &contacts)));
        Some(ends.flatten().collect())
    }

    /// Whether a node of the tables holds under the load.
    pub fn holds(&self, spot: NodeSpot) -> bool {
        let (contacts, count) = self.held(spot);
        self.sheets[spot.leg].bears(spot.angle, &contacts[..count])
    }

    /// The contacts that the fingers of a node hold.
    #[inline]
    pub fn held(&self, spot: NodeSpot) -> ([usize; 3], usize) {
        (self.contacts(spot), if self.sets.is_pair(spot.chain.set) { 2 } else { 3 })
    }

    /// How many nodes there are at an angle of a leg, as far as the tables know.
    pub fn count(&self, leg: usize, angle: usize) -> u64 {
        let layer = self.sheets[leg].tables.layer(angle);
        let ones = |bits: &ContactBits| bits.words().iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
        let pairs = self.sets.pairs() as u64;
        pairs * ones(&layer.pair) + (self.sets.len() as u64 - pairs) * ones(&layer.triple)
    }

    /// Whether a node is an end of the route.
    #[inline]
    pub fn is_goal(&self, spot: NodeSpot) -> bool {
        spot.leg + 1 == self.sheets.len() && spot.angle == self.sheets[spot.leg].end && self.may_end(spot)
    }

    /// The node with which the next leg begins where this one ends.
    pub fn next(&self, spot: NodeSpot) -> Option<NodeSpot> {
        let next = self.sheets.get(spot.leg + 1)?;
        if spot.angle != self.sheets[spot.leg].end || !self.may_end(spot) {
            return None;
        }
        let contacts = self.contacts(spot);
        let set = spot.chain.set;
        match next.entry {
            Regrasp::Same => self.kept(set, contacts, (spot.leg + 1, next.start)),
            Regrasp::Across { old, new } => self.crossed(set, contacts, [old, new], (spot.leg + 1, next.start)),
        }
    }

    /// The node with which the leg before ended where this one begins.
    pub fn previous(&self, spot: NodeSpot) -> Option<NodeSpot> {
        let sheet = &self.sheets[spot.leg];
        let leg = spot.leg.checked_sub(1)?;
        if spot.angle != sheet.start {
            return None;
        }
        let (contacts, set, to) = (self.contacts(spot), spot.chain.set, (leg, self.sheets[leg].end));
        let found = match sheet.entry {
            Regrasp::Same => self.kept(set, contacts, to),
            Regrasp::Across { old, new } => self.crossed(set, contacts, [new, old], to),
        };
        found.filter(|spot| self.may_end(*spot))
    }

    /// The same grasp in another leg.
    fn kept(&self, set: u8, contacts: [usize; 3], (leg, angle): (usize, usize)) -> Option<NodeSpot> {
        let contacts = &contacts[..self.sets.members(set).len()];
        let fits = contacts.iter().all(|contact| *contact < self.sheets[leg].contacts);
        if fits { self.spot(leg, angle, set, contacts) } else { None }
    }

    /// Two fingers on contacts of one section, on those of the other.
    fn crossed(
        &self,
        set: u8,
        contacts: [usize; 3],
        [from, to]: [[usize; 2]; 2],
        (leg, angle): (usize, usize),
    ) -> Option<NodeSpot> {
        let [i, j, _] = contacts;
        let turned = if [i, j] == from { to } else { [to[1], to[0]] };
        let is_there = self.sets.is_pair(set) && ([i, j] == from || [j, i] == from);
        if is_there { self.spot(leg, angle, set, &turned) } else { None }
    }
}
