//! The tables of a leg: one layer for all angles, or one per angle where a load makes them differ.
//!
//! Method: pairs first. A grasp of three holds if two of its fingers do, which whole words of bits decide; only the rest is checked
//! one by one, each triple once. Cost: with adhesion and without a load c² rows of c/64 words, and c³/6 looks at removals;
//! otherwise up to c³/6 looks for each instant.

use super::instant::{self, PairsInstant, pairs};
use super::load::GripDemand;
use super::model::GripModel;
use super::rows::{PairRows, retain, step};
use super::{Contacts, Load};
use crate::device::fingers::{FingersFacts, MAX_GRASPS};
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::tables::{AngleLayer, ContactBits, Tables};

/// Parts into which a rolling step is divided for the check of holding: at their borders a grasp must hold with the
/// device's reserve. A grasp that holds there but lapses in between is found by [`super::RollingChecker`] before a path is
/// accepted.
///
/// A grasp that holds at both ends of a part may lapse within it only where its equilibrium passes from one set of
/// bounds to another. Of 214,000 grasps of three that roll without adhesion, at friction 0.2 and 0.5, on ellipses up to
/// 20 to 6, a superellipse, a rectangle with sharp corners and a waisted part, 20 did, all by less than a twentieth of
/// the friction.
pub const PARTS_OF_STEP: usize = 4;

/// Parts into which a rolling step is divided for the check of room between tips: more, since the check is cheap.
/// Between two checks a distance falls short by at most the step's square times the reach over 2,000: some thousandths
/// of a micrometre.
pub const PARTS_OF_ROLLING: usize = 16;

/// Input of the tabulation.
#[derive(Debug, Clone, Copy)]
pub struct TableRequest<'a> {
    pub facts: &'a FingersFacts,
    pub contacts: Contacts<'a>,
    /// Load at angle 0 of the leg.
    pub load: Load,
    /// The lowest angle of the leg, in steps.
    pub lowest: i64,
    /// Number of angles of the leg; at least 1.
    pub angles: usize,
}

/// Reason why there are no tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoTables {
    /// They would be too large.
    TooManyGrasps { contacts: usize, layers: usize },
    /// The looks of the task are spent.
    LooksSpent,
}

/// Tabulates the grasp graph of a leg.
///
/// `reaches(i, j, k)` states whether a free finger can come to contact k, and leave it, while two others hold i and j;
/// contacts count from 0, and only i < j is queried.
///
/// # Errors
/// [`NoTables::TooManyGrasps`] where contacts and layers need more than [`MAX_GRASPS`]: four sets of them, one bit each, take 256
/// MiB.
pub fn tables(
    asked: &TableRequest,
    looks: &LooksBudget,
    reaches: &mut dyn FnMut(usize, usize, usize) -> bool,
) -> Result<Tables, NoTables> {
    let contacts = asked.contacts.number();
    let layers = if asked.load.is_across() { 1 } else { asked.angles };
    let bits = contacts.checked_pow(3).and_then(|bits| bits.checked_mul(layers));
    if bits.is_none_or(|bits| bits > MAX_GRASPS) {
        return Err(NoTables::TooManyGrasps { contacts, layers });
    }
    let grip = GripModel::of(asked.facts, asked.contacts.reach_um());
    let mut tables = Tables { contacts, layers: Vec::with_capacity(layers) };
    let mut open = None;
    for layer in 0..layers {
        let now = asked.instant(&grip, looks, layer, 0);
        let open = open.get_or_insert_with(|| ways(&now, layers, &tables, reaches));
        let layer = standing(&grip, &now, open, &tables);
        tables.layers.push(layer);
        if looks.are_spent() {
            return Err(NoTables::LooksSpent);
        }
    }
    roll(asked, &grip, looks, &mut tables);
    if grip.only_leans(&asked.load) {
        let unloaded = self::tables(&TableRequest { load: Load::NONE, ..*asked }, looks, reaches)?;
        tables.layers.iter_mut().for_each(|layer| keep(layer, &unloaded.layers[0]));
    }
    if looks.are_spent() { Err(NoTables::LooksSpent) } else { Ok(tables) }
}

// Drops the grasps that another layer does not have.
fn keep(layer: &mut AngleLayer, other: &AngleLayer) {
    layer.pair.keep(&other.pair);
    layer.triple.keep(&other.triple);
    layer.roll_pair.keep(&other.roll_pair);
    layer.roll_triple.keep(&other.roll_triple);
    // Without a load, fingers that only push may leave wherever they may be placed.
    layer.place.keep(&other.place);
    layer.leave.keep(&other.leave);
}

impl TableRequest<'_> {
    // An instant, some parts of a step after the angle of a layer.
    fn instant<'a>(&self, grip: &'a GripModel, looks: &'a LooksBudget, layer: usize, parts: usize) -> PairsInstant<'a> {
        let part_of_step = parts as f64 / PARTS_OF_STEP as f64;
        let angle_rad = ((self.lowest + layer as i64) as f64 + part_of_step) * self.contacts.step_rad();
        let contacts = self.contacts.after(part_of_step);
        PairsInstant::of(grip, contacts, self.load.after_turn(angle_rad), self.apart_um(), looks)
    }

    fn apart_um(&self) -> f64 {
        2.0 * self.contacts.tip_radius_um() + self.facts.clearance_um
    }

    // Pairs that have room throughout a step.
    fn room(&self) -> PairRows {
        let mut room = PairRows::symmetric(self.contacts.number(), |_, _| true);
        for part in 1..PARTS_OF_ROLLING {
            room.keep(&instant::room(&self.contacts.after(part as f64 / PARTS_OF_ROLLING as f64), self.apart_um()));
        }
        room
    }
}

// Contacts that a third tip can reach and leave, and at which tips have room; with a single layer, only beside pairs that hold.
fn ways(
    now: &PairsInstant,
    layers: usize,
    tables: &Tables,
    reaches: &mut dyn FnMut(usize, usize, usize) -> bool,
) -> ContactBits {
    let mut open = ContactBits::new(tables.contacts.pow(3));
    let mut row = vec![0; now.clear.width()];
    for (i, j) in pairs(if layers == 1 { &now.pair } else { &now.clear }) {
        now.beside(i, j, &mut row);
        retain(&mut row, |k| reaches(i, j, k));
        open.put_row(tables.three(i, j, 0), &row);
    }
    open
}

// A layer without its rolling steps.
fn standing(grip: &GripModel, now: &PairsInstant, open: &ContactBits, tables: &Tables) -> AngleLayer {
    let cube = || ContactBits::new(tables.contacts.pow(3));
    let mut layer = AngleLayer {
        pair: flat(&now.pair),
        triple: cube(),
        roll_pair: ContactBits::new(tables.contacts.pow(2)),
        roll_triple: cube(),
        place: cube(),
        leave: cube(),
    };
    let mut row = vec![0; now.clear.width()];
    for (i, j) in pairs(&now.clear) {
        now.beside(i, j, &mut row);
        put_both(&mut layer.triple, tables, [i, j], &row);
    }
    now.remove_unheld(&mut layer.triple, tables);
    come_and_go(grip, now, open, tables, &mut layer);
    layer
}

fn come_and_go(grip: &GripModel, now: &PairsInstant, open: &ContactBits, tables: &Tables, layer: &mut AngleLayer) {
    let demands: Vec<GripDemand> = now.contacts.iter().map(|leaves| grip.removal(leaves, &now.load)).collect();
    let mut row = vec![0; now.clear.width()];
    let mut holding = row.clone();
    for (i, j) in pairs(&now.pair) {
        open.read_row(tables.three(i, j, 0), tables.contacts, &mut row);
        layer.triple.read_row(tables.three(i, j, 0), tables.contacts, &mut holding);
        row.iter_mut().zip(&holding).for_each(|(word, holding)| *word &= holding);
        put_both(&mut layer.place, tables, [i, j], &row);
        let removals = row.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
        now.looks.take(if now.load.is_in_plane() { removals / 4 } else { 4 * removals });
        if now.looks.are_spent() {
            return;
        }
        let two = grip.two([&now.contacts[i], &now.contacts[j]], &now.load);
        retain(&mut row, |k| match demands[k] {
            GripDemand::Squeeze => true,
            GripDemand::Exert(wrench) => two.is_some_and(|two| two.bear(grip, &wrench)),
        });
        put_both(&mut layer.leave, tables, [i, j], &row);
    }
}

// Grasps that hold throughout the step from each layer to the next; the last one of several has no rolling step.
fn roll(asked: &TableRequest, grip: &GripModel, looks: &LooksBudget, tables: &mut Tables) {
    let count = tables.layers.len();
    let firm = grip.with_reserve();
    let room = asked.room();
    for at in 0..count {
        let next = if count == 1 { 0 } else { at + 1 };
        if next == count || looks.are_spent() {
            return;
        }
        let between: Vec<PairsInstant> =
            (1..PARTS_OF_STEP).map(|parts| asked.instant(&firm, looks, at, parts)).collect();
        let mut pairs_on = rows(&tables.layers[at].pair, tables.contacts);
        pairs_on.keep(&rows(&tables.layers[next].pair, tables.contacts).stepped());
        pairs_on.keep(&room);
        between.iter().for_each(|instant| pairs_on.keep(&instant.pair));
        let triples_on = rolling_triples(tables, [at, next], &room, &between);
        tables.layers[at].roll_pair = flat(&pairs_on);
        tables.layers[at].roll_triple = triples_on;
    }
}

fn rolling_triples(tables: &Tables, [at, next]: [usize; 2], room: &PairRows, between: &[PairsInstant]) -> ContactBits {
    let size = tables.contacts;
    let mut triples = ContactBits::new(size.pow(3));
    let (mut row, mut then) = (vec![0; room.width()], vec![0; room.width()]);
    let mut then_here = row.clone();
    for (i, j) in pairs(room) {
        tables.layers[at].triple.read_row(tables.three(i, j, 0), size, &mut row);
        let [before_i, before_j] = [i, j].map(|contact| (contact + size - 1) % size);
        tables.layers[next].triple.read_row(tables.three(before_i, before_j, 0), size, &mut then);
        step(&then, size, &mut then_here);
        for (k, word) in row.iter_mut().enumerate() {
            *word &= then_here[k] & room.row(i)[k] & room.row(j)[k];
        }
        put_both(&mut triples, tables, [i, j], &row);
    }
    between.iter().for_each(|instant| instant.remove_unheld(&mut triples, tables));
    triples
}

fn put_both(bits: &mut ContactBits, tables: &Tables, [i, j]: [usize; 2], row: &[u64]) {
    bits.put_row(tables.three(i, j, 0), row);
    bits.put_row(tables.three(j, i, 0), row);
}

fn flat(rows: &PairRows) -> ContactBits {
    let mut bits = ContactBits::new(rows.size().pow(2));
    (0..rows.size()).for_each(|i| bits.put_row(i * rows.size(), rows.row(i)));
    bits
}

fn rows(bits: &ContactBits, size: usize) -> PairRows {
    PairRows::symmetric(size, |i, j| bits.has(i * size + j))
}
