//! Encoding of nodes: sets of fingers, phases instead of contacts, and both packed into a number.
//!
//! A phase is (contact + angle) modulo the number of contacts, angles counted from the lowest of the leg. Rolling leaves the phases
//! of all holding fingers unchanged, so nodes that differ only in the angle form a chain.

/// The sets of two or three fingers, pairs first, each kind in lexicographic order.
#[derive(Debug, Clone)]
pub struct Sets {
    members: Vec<Vec<usize>>,
    /// For each pair, the triples with one more finger, and the place of that finger.
    wider: Vec<Vec<(u8, usize)>>,
    /// For each triple, the pairs without the finger at each place.
    narrower: Vec<Vec<u8>>,
    pairs: usize,
}

impl Sets {
    /// The sets of a hand with `fingers` fingers.
    pub fn of(fingers: usize) -> Self {
        let mut members: Vec<Vec<usize>> = Vec::new();
        for a in 0..fingers {
            members.extend((a + 1..fingers).map(|b| vec![a, b]));
        }
        let pairs = members.len();
        for at in 0..pairs {
            let pair = members[at].clone();
            members.extend((pair[1] + 1..fingers).map(|c| vec![pair[0], pair[1], c]));
        }
        members[pairs..].sort();
        let find = |fingers: &[usize]| members.iter().position(|set| set == fingers).map(|at| at as u8);
        let without = |set: &[usize], place: usize| find(&[&set[..place], &set[place + 1..]].concat());
        let narrower: Vec<Vec<u8>> =
            members.iter().map(|set| (0..set.len()).filter_map(|place| without(set, place)).collect()).collect();
        let grown = |pair: usize| {
            let triples = pairs..members.len();
            let places = triples
                .flat_map(|triple| narrower[triple].iter().enumerate().map(move |(place, set)| (triple, place, *set)));
            places
                .filter(|(_, _, set)| usize::from(*set) == pair)
                .map(|(triple, place, _)| (triple as u8, place))
                .collect()
        };
        let wider = (0..pairs).map(grown).collect();
        Sets { members, wider, narrower, pairs }
    }

    /// Number of sets.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// The fingers of a set, ascending.
    pub fn members(&self, set: u8) -> &[usize] {
        &self.members[usize::from(set)]
    }

    /// Whether a set has two fingers.
    #[inline]
    pub fn is_pair(&self, set: u8) -> bool {
        usize::from(set) < self.pairs
    }

    /// Number of pairs.
    pub fn pairs(&self) -> usize {
        self.pairs
    }

    /// The set of these fingers.
    pub fn find(&self, fingers: &[usize]) -> Option<u8> {
        self.members.iter().position(|set| set == fingers).map(|at| at as u8)
    }

    /// The triples that a pair becomes with one more finger, and the place of that finger.
    #[inline]
    pub fn wider(&self, pair: u8) -> &[(u8, usize)] {
        &self.wider[usize::from(pair)]
    }

    /// A triple without the finger at a place.
    #[inline]
    pub fn without(&self, triple: u8, place: usize) -> u8 {
        self.narrower[usize::from(triple)][place]
    }

    /// Number of chains of a leg with `contacts` contacts.
    pub fn chains(&self, contacts: usize) -> u64 {
        let contacts = contacts as u64;
        self.pairs as u64 * contacts.pow(2) + (self.len() - self.pairs) as u64 * contacts.pow(3)
    }

    /// The index of a chain, below [`Sets::chains`].
    #[inline]
    pub fn index(&self, contacts: usize, chain: GraspChain) -> usize {
        let [a, b, c] = chain.phases.map(usize::from);
        let set = usize::from(chain.set);
        if set < self.pairs {
            (set * contacts + a) * contacts + b
        } else {
            self.pairs * contacts * contacts + (((set - self.pairs) * contacts + a) * contacts + b) * contacts + c
        }
    }
}

impl Sets {
    /// The chain of an index.
    pub fn chain(&self, contacts: usize, index: usize) -> GraspChain {
        let (pairs, digit) =
            (self.pairs * contacts * contacts, |power: u32, at: usize| at / contacts.pow(power) % contacts);
        if index < pairs {
            let set = (index / contacts.pow(2)) as u8;
            return GraspChain { set, phases: [digit(1, index) as u16, digit(0, index) as u16, 0] };
        }
        let at = index - pairs;
        let set = (self.pairs + at / contacts.pow(3)) as u8;
        GraspChain { set, phases: [2, 1, 0].map(|power| digit(power, at) as u16) }
    }
}

/// Grasps of one set of fingers that roll into one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraspChain {
    pub set: u8,
    /// Phase of each member of the set; 0 for the third of a pair.
    pub phases: [u16; 3],
}

/// A node of the grasp graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeSpot {
    pub leg: usize,
    /// Counted from the lowest angle of the leg.
    pub angle: usize,
    pub chain: GraspChain,
}

/// Bits of a phase in a packed spot.
const DIGIT: u32 = 9;

/// Bits of an angle in a packed spot.
const ANGLE: u32 = 11;

/// Limit on the contacts of a leg.
pub const MAX_DIGIT: usize = 1 << DIGIT;

/// Words of a mask of all angles that a leg may have: three revolutions of at most 360 steps make 1081.
pub const MAX_WORDS: usize = 17;

/// Limit on the angles of a leg.
pub const MAX_ANGLES: usize = 64 * MAX_WORDS;

/// Limit on the legs of a route.
pub const MAX_LEGS: usize = 1 << 16;

impl NodeSpot {
    /// Packs the node into one number; numbers of earlier legs are smaller.
    #[inline]
    pub fn pack(self) -> u64 {
        let [a, b, c] = self.chain.phases.map(u64::from);
        let chain = (((u64::from(self.chain.set) << DIGIT | a) << DIGIT) | b) << DIGIT | c;
        ((self.leg as u64) << (6 + 3 * DIGIT) | chain) << ANGLE | self.angle as u64
    }

    /// The node of a packed number.
    #[inline]
    pub fn unpack(number: u64) -> Self {
        let angle = number as usize & ((1 << ANGLE) - 1);
        let chain = number >> ANGLE;
        let phases = [2, 1, 0].map(|place| (chain >> (place * DIGIT)) as u16 & (MAX_DIGIT as u16 - 1));
        let set = (chain >> (3 * DIGIT)) as u8 & 63;
        NodeSpot { leg: (chain >> (3 * DIGIT + 6)) as usize, angle, chain: GraspChain { set, phases } }
    }
}

/// Reduces a number in `0..2 * contacts` modulo `contacts`.
#[inline]
pub fn wrapped(number: usize, contacts: usize) -> usize {
    if number >= contacts { number - contacts } else { number }
}

/// The difference of two phases, modulo the number of contacts.
#[inline]
pub fn ahead(of: u16, phase: u16, contacts: usize) -> usize {
    wrapped(usize::from(phase) + contacts - usize::from(of), contacts)
}

/// The phases of a triple: those of a pair, with a third inserted at a place.
#[inline]
pub fn inserted([p, q]: [u16; 2], third: u16, place: usize) -> [u16; 3] {
    match place {
        0 => [third, p, q],
        1 => [p, third, q],
        _ => [p, q, third],
    }
}

/// The phases of a pair, and the third one that was at a place.
#[inline]
pub fn removed([a, b, c]: [u16; 3], place: usize) -> ([u16; 2], u16) {
    match place {
        0 => ([b, c], a),
        1 => ([a, c], b),
        _ => ([a, b], c),
    }
}
