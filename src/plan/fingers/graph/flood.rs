//! Floods: breadth-first distances, in reconfigurations, from the goals (or from the start) to all nodes.
//!
//! Only pairs are stored: between two pairs lies one triple, which rolls. All angles of a chain are handled at once, as bits of a
//! mask, so a flood examines each of the pairs' C(F,2)·c² chains once for each third contact. The layer of a triple is derived on
//! demand from those of the pairs it becomes.

use super::Regrasp;
use super::course::{PreparedLeg, PreparedRoute};
use super::layout::{GraspChain, NodeSpot, inserted, removed, wrapped};
use super::strands::{AngleMask, below, both, except, has, single, spread};
use rustc_hash::FxHashMap;

/// Direction in which edges are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From the start.
    Onward,
    /// From the goals.
    Back,
}

/// A newly reached part of a chain of pairs.
#[derive(Debug, Clone, Copy)]
struct FloodPiece<const N: usize> {
    leg: usize,
    chain: GraspChain,
    mask: AngleMask<N>,
}

/// Value of `ReachedPairs::first` for a chain with several layers, which are in `ReachedPairs::pieces`.
const SEVERAL: u8 = u8::MAX;

/// Looks charged for one triple: its angles are spread, and the bits of three pairs are read. Measured for masks of one
/// word.
pub const TRIPLE_LOOKS: u64 = 8;

/// Highest layer; later ones count as this one, which keeps every bound admissible.
const LAST: u32 = SEVERAL as u32 - 1;

/// The reached pairs of a leg.
#[derive(Debug)]
struct ReachedPairs<const N: usize> {
    /// For each chain, the angles that are nodes but not reached.
    open: Vec<AngleMask<N>>,
    /// For each set, member and phase: the number of chains that have angles in `open`.
    left: Vec<u16>,
    /// The layer of each chain's first piece.
    first: Vec<u8>,
    /// The layers of all pieces of chains that have several.
    pieces: FxHashMap<usize, Vec<(AngleMask<N>, u8)>>,
    /// All angles at which anything is reached.
    angles: AngleMask<N>,
    /// Whether triples continue into the neighbouring leg: the next one, or the previous one if the flood runs against
    /// the edges.
    hands_on: bool,
}

/// A resumable flood.
#[derive(Debug)]
pub struct GraspFlood<'a, const N: usize> {
    course: &'a PreparedRoute,
    direction: Direction,
    fields: Vec<ReachedPairs<N>>,
    /// The pieces of the next layer to be expanded, and of the two after it.
    fronts: [Vec<FloodPiece<N>>; 3],
    /// The next layer to be expanded: all pairs up to the layer after it are known.
    layer: u32,
    /// Whether the newest pieces touch the start of the route.
    arrives: bool,
    /// Whether all sources are known.
    is_seeded: bool,
}

impl<'a, const N: usize> GraspFlood<'a, N> {
    /// A flood from sources, which also reaches the pairs next to them.
    pub fn from(course: &'a PreparedRoute, direction: Direction, sources: &[NodeSpot]) -> Self {
        let mut flood = GraspFlood::dry(course, direction);
        let (pairs, triples): (Vec<&NodeSpot>, Vec<&NodeSpot>) =
            sources.iter().partition(|spot| course.sets.is_pair(spot.chain.set));
        for spot in pairs {
            flood.meet(spot.leg, spot.chain, single(spot.angle), 0);
        }
        for spot in triples {
            if direction == Direction::Back && !flood.fields[spot.leg].hands_on && !flood.is_news(spot) {
                continue;
            }
            let rolls = course.legs[spot.leg].rolls_three(spot.chain.phases);
            flood.part(spot.leg, spot.chain, spread(single(spot.angle), rolls), 1);
        }
        flood
    }

    /// A flood from all nodes of a leg at an angle. They are enumerated and never listed, since there may be tens of
    /// millions.
    pub fn from_all(course: &'a PreparedRoute, direction: Direction, leg: usize, angle: usize) -> Self {
        let mut flood = GraspFlood::dry(course, direction);
        let prepared = &course.legs[leg];
        let contacts = prepared.contacts;
        let phases = || (0..contacts as u16).flat_map(|p| (0..contacts as u16).map(move |q| (p, q)));
        let sets = || (0..course.sets.len() as u8).partition::<Vec<u8>, _>(|set| course.sets.is_pair(*set));
        let (pairs, triples) = sets();
        for (set, (p, q)) in pairs.iter().flat_map(|set| phases().map(move |both| (*set, both))) {
            if has(&prepared.nodes_of_two::<N>([p, q]), angle) {
                flood.meet(leg, GraspChain { set, phases: [p, q, 0] }, single(angle), 0);
            }
        }
        for (set, (p, q)) in triples.iter().flat_map(|set| phases().map(move |both| (*set, both))) {
            let chain = |third: u16| GraspChain { set, phases: [p, q, third] };
            let goes_over = flood.fields[leg].hands_on || flood.wants_angles(leg);
            course.looks.take(1);
            if course.looks.are_spent() {
                flood.is_seeded = false;
                return flood;
            }
            if !goes_over && !flood.has_open(leg, chain(0), 2) {
                continue;
            }
            course.looks.take(contacts as u64);
            for third in 0..contacts as u16 {
                let spot = NodeSpot { leg, angle, chain: chain(third) };
                if prepared.holds(angle, &course.contacts(spot)) && (goes_over || flood.is_news(&spot)) {
                    let rolls = prepared.rolls_three(spot.chain.phases);
                    flood.part(leg, spot.chain, spread(single(angle), rolls), 1);
                }
            }
        }
        flood
    }

    /// A flood without sources.
    fn dry(course: &'a PreparedRoute, direction: Direction) -> Self {
        let chains = |leg: usize| course.sets.pairs() * course.legs[leg].contacts.pow(2) * N;
        course.looks.take((0..course.legs.len()).map(chains).sum::<usize>() as u64);
        let fields = (0..course.legs.len()).map(|leg| ReachedPairs::of(course, leg, direction)).collect();
        let fronts = [Vec::new(), Vec::new(), Vec::new()];
        GraspFlood { course, direction, fields, fronts, layer: 0, arrives: false, is_seeded: true }
    }

    /// Whether nothing more can be reached.
    pub fn ended(&self) -> bool {
        self.is_seeded && self.fronts.iter().all(Vec::is_empty)
    }

    /// Whether the flood cannot continue because the looks ran out.
    pub fn stopped(&self) -> bool {
        self.course.looks.are_spent()
    }

    /// Whether a pair at the start of the route was reached.
    pub fn arrives(&self) -> bool {
        self.arrives
    }

    /// The angles of a leg at which anything is reached.
    pub fn angles(&self, leg: usize) -> AngleMask<N> {
        self.fields[leg].angles
    }

    /// Lower bound on the layer of a node whose layer is not known.
    pub fn floor(&self, spot: NodeSpot) -> u32 {
        if !self.is_seeded {
            return 0;
        }
        let beyond = if self.course.sets.is_pair(spot.chain.set) { 2 } else { 3 };
        (self.layer + beyond).min(LAST)
    }

    /// Expands one more layer: from its pairs over triples to the pairs of the layer after the next.
    ///
    /// If the looks run out, everything not reached counts as being in the layer that was expanded.
    pub fn deepen(&mut self) {
        if self.stopped() {
            return;
        }
        let pieces = std::mem::take(&mut self.fronts[0]);
        for (at, piece) in pieces.iter().enumerate() {
            if self.stopped() {
                self.fronts[0] = pieces[at..].to_vec();
                return;
            }
            self.widen(piece);
        }
        self.fronts.rotate_left(1);
        self.layer += 1;
    }

    /// The layer of a node, if known. Triples are known only in floods from the goals.
    #[inline]
    pub fn layer_of(&self, spot: NodeSpot) -> Option<u32> {
        if self.course.sets.is_pair(spot.chain.set) {
            let chain = self.course.pair_index(spot.leg, spot.chain);
            self.fields[spot.leg].least(chain, single(spot.angle))
        } else {
            self.layer_of_three(spot)
        }
    }

    fn layer_of_three(&self, mut spot: NodeSpot) -> Option<u32> {
        let course = self.course;
        let mut least: Option<u32> = None;
        loop {
            let prepared = &course.legs[spot.leg];
            let segment: AngleMask<N> = spread(single(spot.angle), prepared.rolls_three(spot.chain.phases));
            for place in 0..3 {
                let ([p, q], third) = removed(spot.chain.phases, place);
                let head = prepared.strands.head(p);
                let leaving = prepared.strands.leave.window(prepared.strands.triple(head, [p, q, third]), head.bit);
                let chain = GraspChain { set: course.sets.without(spot.chain.set, place), phases: [p, q, 0] };
                let layer = self.fields[spot.leg].least(course.pair_index(spot.leg, chain), both(leaving, segment));
                least = least.into_iter().chain(layer.map(|layer| layer + 1)).min();
            }
            let border = NodeSpot { angle: prepared.end, ..spot };
            if !has(&segment, prepared.end) {
                return least;
            }
            if course.is_goal(border) {
                return Some(0);
            }
            match course.next(border) {
                Some(next) => spot = next,
                None => return least,
            }
        }
    }

    /// Expands a pair over all triples that add a finger.
    fn widen(&mut self, piece: &FloodPiece<N>) {
        let course = self.course;
        let (leg, [p, q, _]) = (piece.leg, piece.chain.phases);
        let prepared = &course.legs[leg];
        let strands = &prepared.strands;
        let bits = match self.direction {
            Direction::Onward => &strands.place,
            Direction::Back => &strands.leave,
        };
        let head = strands.head(p);
        let row = strands.triple(head, [p, q, p]);
        let layer = self.layer + 2;
        let wants_angles = self.wants_angles(leg);
        for (set, place) in course.sets.wider(piece.chain.set) {
            let chain = |third: u16| GraspChain { set: *set, phases: inserted([p, q], third, *place) };
            let goes_over = self.fields[leg].hands_on || wants_angles;
            // A triple whose pairs are all known adds nothing, unless it continues into the next leg or its angles are needed.
            if !goes_over && !self.has_open(leg, chain(0), *place) {
                continue;
            }
            let pairs = [0, 1, 2].map(|place| course.pair_steps(leg, chain, place));
            course.looks.take((prepared.contacts * N) as u64);
            // Cyclic distance from the first contact of the pair to the third; the triples' strands are ordered by it.
            for two in 0..prepared.contacts {
                let third = wrapped(usize::from(p) + two, prepared.contacts);
                let field = &self.fields[leg];
                let open = pairs.iter().any(|(from, step)| field.open[from + third * step] != [0; N]);
                if !open && !goes_over {
                    continue;
                }
                let coming = both(bits.window(row + two, head.bit), piece.mask);
                if coming != [0; N] {
                    let rolls = prepared.rolling(strands.roll_triple.window(row + two, head.bit));
                    self.part(leg, chain(third as u16), spread(coming, rolls), layer);
                }
            }
        }
    }

    /// Whether the angles that triples reach are needed: only in a flood from the start, until all angles are reached.
    fn wants_angles(&self, leg: usize) -> bool {
        let all = below([u64::MAX; N], self.course.legs[leg].angles);
        self.direction == Direction::Onward && self.fields[leg].angles != all
    }

    /// Whether a triple leads to a pair with open angles.
    fn is_news(&self, spot: &NodeSpot) -> bool {
        (0..3).any(|place| {
            let ([p, q], _) = removed(spot.chain.phases, place);
            let pair = GraspChain { set: self.course.sets.without(spot.chain.set, place), phases: [p, q, 0] };
            self.fields[spot.leg].open[self.course.pair_index(spot.leg, pair)] != [0; N]
        })
    }

    /// Whether any of the triples that differ in the phase at `place` leads to a pair with open angles.
    fn has_open(&self, leg: usize, triple: GraspChain, place: usize) -> bool {
        let (course, field) = (self.course, &self.fields[leg]);
        let ([p, q], _) = removed(triple.phases, place);
        let pair = GraspChain { set: course.sets.without(triple.set, place), phases: [p, q, 0] };
        field.open[course.pair_index(leg, pair)] != [0; N]
            || (0..3).filter(|without| *without != place).any(|without| {
                let fixed = 3 - without - place;
                let member = if fixed > without { fixed - 1 } else { fixed };
                let set = usize::from(course.sets.without(triple.set, without));
                let phase = usize::from(triple.phases[fixed]);
                field.left[(set * 2 + member) * course.legs[leg].contacts + phase] > 0
            })
    }

    /// Reaches all pairs with one finger less from a part of a triple's chain, and continues into the neighbouring leg
    /// if the part touches the border.
    fn part(&mut self, mut leg: usize, mut chain: GraspChain, mut mask: AngleMask<N>, layer: u32) {
        let course = self.course;
        loop {
            course.looks.take(TRIPLE_LOOKS * N as u64);
            let strands = &course.legs[leg].strands;
            let bits = match self.direction {
                Direction::Onward => &strands.leave,
                Direction::Back => &strands.place,
            };
            let angles = &mut self.fields[leg].angles;
            *angles = std::array::from_fn(|at| angles[at] | mask[at]);
            for place in 0..3 {
                let ([p, q], third) = removed(chain.phases, place);
                let head = strands.head(p);
                let going = both(bits.window(strands.triple(head, [p, q, third]), head.bit), mask);
                let pair = GraspChain { set: course.sets.without(chain.set, place), phases: [p, q, 0] };
                self.meet(leg, pair, going, layer);
            }
            let beyond = if self.fields[leg].hands_on { self.beyond(leg, chain, mask) } else { None };
            let Some(spot) = beyond else { return };
            (leg, chain) = (spot.leg, spot.chain);
            mask = spread(single(spot.angle), course.legs[leg].rolls_three(chain.phases));
        }
    }

    /// Adds the new angles of a pair's chain, and all angles to which they roll, to a layer.
    fn meet(&mut self, mut leg: usize, mut chain: GraspChain, mut nodes: AngleMask<N>, layer: u32) {
        let course = self.course;
        loop {
            let index = course.pair_index(leg, chain);
            let field = &mut self.fields[leg];
            let fresh = both(nodes, field.open[index]);
            if fresh == [0; N] {
                return;
            }
            let [p, q, _] = chain.phases;
            let mask = spread(fresh, course.legs[leg].rolls_two([p, q]));
            field.take(index, mask, course.legs[leg].nodes_of_two([p, q]), layer);
            if field.open[index] == [0; N] {
                field.close(chain, course.legs[leg].contacts);
            }
            self.fronts[(layer - self.layer) as usize].push(FloodPiece { leg, chain, mask });
            self.arrives |= leg == 0 && has(&mask, course.legs[0].start);
            let Some(spot) = self.beyond(leg, chain, mask) else { return };
            (leg, chain, nodes) = (spot.leg, spot.chain, single(spot.angle));
        }
    }

    /// Continuation of a chain in the neighbouring leg, if a part of it touches the border.
    fn beyond(&self, leg: usize, chain: GraspChain, mask: AngleMask<N>) -> Option<NodeSpot> {
        let prepared = &self.course.legs[leg];
        let angle = match self.direction {
            Direction::Onward => prepared.end,
            Direction::Back => prepared.start,
        };
        if !has(&mask, angle) {
            return None;
        }
        match self.direction {
            Direction::Onward => self.course.next(NodeSpot { leg, angle, chain }),
            Direction::Back => self.course.previous(NodeSpot { leg, angle, chain }),
        }
    }
}

impl<const N: usize> ReachedPairs<N> {
    fn of(course: &PreparedRoute, leg: usize, direction: Direction) -> Self {
        let prepared: &PreparedLeg = &course.legs[leg];
        let border = match direction {
            Direction::Onward => course.legs.get(leg + 1),
            Direction::Back => (leg > 0).then_some(prepared),
        };
        let count = course.sets.pairs() * prepared.contacts.pow(2);
        let node = |index: usize| {
            let phases =
                [index / prepared.contacts % prepared.contacts, index % prepared.contacts].map(|phase| phase as u16);
            prepared.nodes_of_two(phases)
        };
        let open: Vec<AngleMask<N>> = (0..count).map(node).collect();
        let mut left = vec![0; course.sets.pairs() * 2 * prepared.contacts];
        for index in (0..count).filter(|index| open[*index] != [0; N]) {
            let [first, second] = members(course.sets.chain(prepared.contacts, index), prepared.contacts);
            left[first] += 1;
            left[second] += 1;
        }
        ReachedPairs {
            open,
            left,
            first: vec![0; count],
            pieces: FxHashMap::default(),
            angles: [0; N],
            hands_on: border.is_some_and(|prepared| prepared.entry == Regrasp::Same),
        }
    }

    /// The least layer among some angles of a chain.
    #[inline]
    fn least(&self, index: usize, angles: AngleMask<N>) -> Option<u32> {
        let reached = except(angles, self.open[index]);
        if reached == [0; N] {
            return None;
        }
        match self.first[index] {
            SEVERAL => {
                let touched = self.pieces[&index].iter().filter(|(mask, _)| both(*mask, reached) != [0; N]);
                touched.map(|(_, layer)| u32::from(*layer)).min()
            }
            layer => Some(u32::from(layer)),
        }
    }

    /// Updates the counts after all angles of a chain have been reached.
    fn close(&mut self, chain: GraspChain, contacts: usize) {
        for member in members(chain, contacts) {
            self.left[member] -= 1;
        }
    }

    /// Marks a part of a chain as reached.
    fn take(&mut self, index: usize, mask: AngleMask<N>, nodes: AngleMask<N>, layer: u32) {
        let before = except(nodes, self.open[index]);
        self.open[index] = except(self.open[index], mask);
        self.angles = std::array::from_fn(|at| self.angles[at] | mask[at]);
        let layer = layer.min(LAST) as u8;
        if before == [0; N] {
            self.first[index] = layer;
        } else if self.first[index] != layer {
            let first = (before, self.first[index]);
            self.pieces.entry(index).or_insert_with(|| vec![first]).push((mask, layer));
            self.first[index] = SEVERAL;
        }
    }
}

/// Indices of a pair's two members and phases in the counts.
fn members(pair: GraspChain, contacts: usize) -> [usize; 2] {
    let set = usize::from(pair.set) * 2;
    [set * contacts + usize::from(pair.phases[0]), (set + 1) * contacts + usize::from(pair.phases[1])]
}
