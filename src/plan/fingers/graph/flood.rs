//! Floods: all nodes from which the goals are reached (or that the start reaches), by the least number of reconfigurations.
//!
//! A layer is closed when nothing more is reached by rolling and by going on to the neighbouring leg; each placement or removal
//! leads into the next layer. All angles of a chain are dealt with at once, as bits of a mask.

use super::course::{Course, Sheet};
use super::layout::{Chain, Spot, wrapped};
use super::strands::{Mask, Strand, both, except, has, single, spread};
use rustc_hash::FxHashMap;

/// Which way edges are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From the start.
    Onward,
    /// From the goals.
    Back,
}

/// A part of a chain, newly reached.
type Piece<const N: usize> = (Chain, Mask<N>);

/// In `Field::first`: look the layers up in `Field::pieces`.
const SEVERAL: u8 = u8::MAX;

/// Layers from here on are counted as this one, which keeps every bound a bound.
const LAST: u8 = SEVERAL - 1;

/// What is reached of a leg.
#[derive(Debug)]
struct Field<const N: usize> {
    /// The angles of each chain that are reached.
    seen: Vec<Mask<N>>,
    /// The layer of each chain's first piece.
    first: Vec<u8>,
    /// The layers of all pieces, of chains with several.
    pieces: FxHashMap<usize, Vec<(Mask<N>, u8)>>,
    now: Vec<Piece<N>>,
    next: Vec<Piece<N>>,
}

/// A flood that goes on when asked.
#[derive(Debug)]
pub struct Flood<'a, const N: usize> {
    course: &'a Course,
    direction: Direction,
    fields: Vec<Field<N>>,
    /// The last closed layer.
    layer: u32,
    ended: bool,
}

impl<'a, const N: usize> Flood<'a, N> {
    /// A flood with layer 0, the sources and what rolls to or from them, closed.
    pub fn from(course: &'a Course, direction: Direction, sources: impl Iterator<Item = Spot>) -> Self {
        let field = |sheet: &Sheet| {
            let chains = course.sets.chains(sheet.contacts) as usize;
            Field {
                seen: vec![[0; N]; chains],
                first: vec![0; chains],
                pieces: FxHashMap::default(),
                now: Vec::new(),
                next: Vec::new(),
            }
        };
        let fields = course.sheets.iter().map(field).collect();
        let mut flood = Flood { course, direction, fields, layer: 0, ended: false };
        for source in sources {
            flood.fields[source.leg].meet(course, source.leg, source.chain, single(source.angle), 0);
        }
        flood.turn();
        flood
    }

    /// The last closed layer.
    pub fn layer(&self) -> u32 {
        self.layer
    }

    /// Whether nothing more can be reached.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// The layer of a node that is reached.
    #[inline]
    pub fn layer_of(&self, spot: Spot) -> Option<u32> {
        let field = &self.fields[spot.leg];
        let chain = self.course.sets.index(self.course.sheets[spot.leg].contacts, spot.chain);
        if !has(&field.seen[chain], spot.angle) {
            return None;
        }
        match field.first[chain] {
            SEVERAL => field.pieces[&chain].iter().find(|(mask, _)| has(mask, spot.angle)).map(|(_, layer)| u32::from(*layer)),
            layer => Some(u32::from(layer)),
        }
    }

    /// Floods one layer more, unless it has ended.
    pub fn deepen(&mut self) {
        if self.ended {
            return;
        }
        self.layer += 1;
        for leg in 0..self.fields.len() {
            self.reconfigure(leg);
        }
        self.turn();
    }

    /// Closes the layer that was begun in `next`.
    fn turn(&mut self) {
        for field in &mut self.fields {
            field.now.clear();
            std::mem::swap(&mut field.now, &mut field.next);
        }
        let legs = self.fields.len();
        for step in 1..legs {
            let (from, to) = match self.direction {
                Direction::Onward => (step - 1, step),
                Direction::Back => (legs - step, legs - step - 1),
            };
            self.hand_on(from, to);
        }
        self.ended = self.fields.iter().all(|field| field.now.is_empty());
    }

    /// Takes the new nodes at a leg's border to the neighbouring leg.
    fn hand_on(&mut self, from: usize, to: usize) {
        let course = self.course;
        let border = match self.direction {
            Direction::Onward => course.sheets[from].end,
            Direction::Back => course.sheets[from].start,
        };
        let pieces = std::mem::take(&mut self.fields[from].now);
        for (chain, _) in pieces.iter().filter(|(_, mask)| has(mask, border)) {
            let spot = Spot { leg: from, angle: border, chain: *chain };
            let beyond = match self.direction {
                Direction::Onward => course.next(spot),
                Direction::Back => course.previous(spot),
            };
            if let Some(beyond) = beyond {
                let field = &mut self.fields[to];
                std::mem::swap(&mut field.now, &mut field.next);
                field.meet(course, to, beyond.chain, single(beyond.angle), self.layer);
                std::mem::swap(&mut field.now, &mut field.next);
            }
        }
        self.fields[from].now = pieces;
    }

    /// Reaches all that one reconfiguration of a leg's newest pieces leads to.
    fn reconfigure(&mut self, leg: usize) {
        let course = self.course;
        let strands = &course.sheets[leg].strands;
        let (to_three, to_two) = match self.direction {
            Direction::Onward => (&strands.place, &strands.leave),
            Direction::Back => (&strands.leave, &strands.place),
        };
        let pieces = std::mem::take(&mut self.fields[leg].now);
        let field = &mut self.fields[leg];
        for (chain, mask) in &pieces {
            if course.sets.is_pair(chain.set) {
                field.widen(course, leg, (*chain, *mask), to_three, self.layer);
            } else {
                field.narrow(course, leg, (*chain, *mask), to_two, self.layer);
            }
        }
        self.fields[leg].now = pieces;
    }

    /// Whether a newest piece lies at the start of the route.
    pub fn arrives(&self) -> bool {
        let start = self.course.sheets[0].start;
        self.fields[0].now.iter().any(|(_, mask)| has(mask, start))
    }

    /// The angles of a leg at which anything is reached.
    pub fn angles(&self, leg: usize) -> Mask<N> {
        let either = |a: Mask<N>, b: &Mask<N>| std::array::from_fn(|at| a[at] | b[at]);
        self.fields[leg].seen.iter().fold([0; N], either)
    }

    /// How many nodes of a leg at an angle are reached.
    pub fn count(&self, leg: usize, angle: usize) -> u64 {
        self.fields[leg].seen.iter().filter(|mask| has(mask, angle)).count() as u64
    }
}

impl<const N: usize> Field<N> {
    /// From a pair to all triples with a finger more.
    fn widen(&mut self, course: &Course, leg: usize, (chain, mask): Piece<N>, bits: &Strand, layer: u32) {
        let sheet = &course.sheets[leg];
        let [p, q, _] = chain.phases;
        let head = sheet.strands.head(p);
        let row = sheet.strands.triple(head, [p, q, p]);
        for two in 0..sheet.contacts {
            let shared = both(bits.window(row + two, head.bit), mask);
            if shared == [0; N] {
                continue;
            }
            let third = wrapped(usize::from(p) + two, sheet.contacts) as u16;
            for (set, place) in course.sets.wider(chain.set) {
                let chain = Chain { set: *set, phases: inserted([p, q], third, *place) };
                self.meet(course, leg, chain, shared, layer);
            }
        }
    }

    /// From a triple to all pairs with a finger less.
    fn narrow(&mut self, course: &Course, leg: usize, (chain, mask): Piece<N>, bits: &Strand, layer: u32) {
        let strands = &course.sheets[leg].strands;
        for place in 0..3 {
            let ([p, q], third) = removed(chain.phases, place);
            let head = strands.head(p);
            let shared = both(bits.window(strands.triple(head, [p, q, third]), head.bit), mask);
            if shared != [0; N] {
                let set = course.sets.without(chain.set, place);
                self.meet(course, leg, Chain { set, phases: [p, q, 0] }, shared, layer);
            }
        }
    }

    /// Takes nodes of a chain, and all to which they roll, into the next pieces, if they are new.
    #[inline]
    fn meet(&mut self, course: &Course, leg: usize, chain: Chain, nodes: Mask<N>, layer: u32) {
        let sheet = &course.sheets[leg];
        let index = course.sets.index(sheet.contacts, chain);
        let before = self.seen[index];
        let fresh = except(nodes, before);
        if fresh == [0; N] {
            return;
        }
        let [p, q, _] = chain.phases;
        let rolls = if course.sets.is_pair(chain.set) {
            sheet.strands.rolls_two([p, q], sheet.angles)
        } else {
            sheet.strands.rolls_three(chain.phases, sheet.angles)
        };
        let piece = spread(fresh, rolls);
        self.seen[index] = std::array::from_fn(|at| before[at] | piece[at]);
        self.next.push((chain, piece));
        let layer = layer.min(u32::from(LAST)) as u8;
        if before == [0; N] {
            self.first[index] = layer;
        } else if self.first[index] == SEVERAL || self.first[index] != layer {
            let first = (before, self.first[index]);
            self.pieces.entry(index).or_insert_with(|| vec![first]).push((piece, layer));
            self.first[index] = SEVERAL;
        }
    }
}

/// The phases of a triple: those of a pair, with a third at a place.
#[inline]
pub fn inserted([p, q]: [u16; 2], third: u16, place: usize) -> [u16; 3] {
    match place {
        0 => [third, p, q],
        1 => [p, third, q],
        _ => [p, q, third],
    }
}

/// The phases of a pair, and the third that was at a place.
#[inline]
pub fn removed([a, b, c]: [u16; 3], place: usize) -> ([u16; 2], u16) {
    match place {
        0 => ([b, c], a),
        1 => ([a, c], b),
        _ => ([a, b], c),
    }
}
