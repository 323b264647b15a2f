//! The lattice on which most electrodes of a drawing lie.
//!
//! The pitch is the median of the distances from each electrode to the nearest one that does not lie over it; other
//! distances are tried while no connected set has more than half of the electrodes. Two electrodes are neighbours if
//! one lies a pitch beside or above the other, within a share of it; the largest connected set is the board. Places are
//! counted from neighbour to neighbour, so that an error of the pitch does not accumulate. Cost grows with the square
//! of the number of electrodes.

use super::DrawnElectrode;
use crate::check::value::{BoardFile, LeftOut};
use crate::device::BoardLimits;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Greatest offset of an electrode's centre from its place, in pitches: interdigitated electrodes have shifted centres.
const OFF_PLACE: f64 = 0.2;

/// Least and greatest side of an electrode of the lattice, in pitches.
const SIDES: [f64; 2] = [0.5, 1.3];

/// Greatest relative difference between the sides of an electrode that is on the lattice but cut off and those of the
/// nearest connected one.
const OTHER_SIDES: f64 = 0.25;

/// Overlap threshold: an electrode whose centre is nearer than this to that of another one, in sides of that one, lies
/// over it.
const OVER: f64 = 0.7;

/// Greatest number of distances tried as the pitch.
const MOST_SPACINGS: usize = 4;

/// Rounds after which every shared channel is left out.
const MOST_TURNS: usize = 8;

/// A column and a row, downwards, relative to one electrode.
type LatticePlace = [i64; 2];

/// Connected electrodes by index, and their pitch; 0 for one alone.
struct Lattice {
    places: BTreeMap<usize, LatticePlace>,
    spacing: f64,
}

/// The board of a drawing.
///
/// Why the drawing is not a board, as the rest of a sentence.
pub(super) fn board(path: &str, electrodes: Vec<DrawnElectrode>, limits: BoardLimits) -> Result<BoardFile, String> {
    let BoardLimits { most_side, .. } = limits;
    let (Lattice { places, spacing }, sharing) =
        whole_channels(&electrodes).ok_or("has no electrode with a channel on a lattice")?;
    let axis = |axis: usize| {
        let values = || places.values().map(|place| place[axis]);
        values().min().zip(values().max()).unwrap_or_default()
    };
    let [(left, right), (top, bottom)] = [0, 1].map(axis);
    let sides = [right - left + 1, bottom - top + 1];
    let [columns, rows] = sides.map(|side| u32::try_from(side).ok().filter(|side| *side <= most_side));
    let (Some(columns), Some(rows)) = (columns, rows) else {
        return Err(format!("has {} columns and {} rows; at most {most_side} of each are allowed", sides[0], sides[1]));
    };
    let cut_off = cut_off(&electrodes, &places, spacing);
    let mut channels = vec![None; columns as usize * rows as usize];
    let mut left_out = LeftOut::default();
    for (index, electrode) in electrodes.into_iter().enumerate() {
        let cell = places.get(&index).map(|[x, y]| ((bottom - y) * i64::from(columns) + (x - left)) as usize);
        match cell.and_then(|cell| channels.get_mut(cell)) {
            Some(place @ None) => *place = Some(electrode.channel),
            Some(Some(_)) | None if sharing.contains(&electrode.channel) => left_out.sharing.push(electrode.name),
            Some(Some(_)) | None if cut_off.contains(&index) => left_out.cut_off.push(electrode.name),
            Some(Some(_)) | None => left_out.off_lattice.push(electrode.name),
        }
    }
    Ok(BoardFile { path: path.to_owned(), columns, rows, channels, left_out })
}

/// The lattice of the electrodes whose channels switch none off it, and the shared channels that do, which are left
/// out: the pull of their electrodes off the lattice is unknown. Each round leaves out some more channels; `None` if no
/// electrode is left on a lattice.
fn whole_channels(electrodes: &[DrawnElectrode]) -> Option<(Lattice, BTreeSet<u32>)> {
    let mut uses: BTreeMap<u32, u32> = BTreeMap::new();
    electrodes.iter().for_each(|electrode| *uses.entry(electrode.channel).or_default() += 1);
    let is_shared = |channel: u32| uses.get(&channel).is_some_and(|count| *count > 1);
    let mut left_out: BTreeSet<u32> = BTreeSet::new();
    for turn in 0.. {
        if turn == MOST_TURNS {
            left_out.extend(uses.keys().copied().filter(|channel| is_shared(*channel)));
        }
        let kept: Vec<usize> =
            (0..electrodes.len()).filter(|index| !left_out.contains(&electrodes[*index].channel)).collect();
        let own: Vec<DrawnElectrode> = kept.iter().map(|index| electrodes[*index].clone()).collect();
        let Lattice { places, spacing } = lattice(&own)?;
        let off = (0..own.len()).filter(|index| !places.contains_key(index)).map(|index| own[index].channel);
        let torn: BTreeSet<u32> = off.filter(|channel| is_shared(*channel)).collect();
        if torn.is_empty() {
            let places = places.into_iter().map(|(index, place)| (kept[index], place)).collect();
            return Some((Lattice { places, spacing }, left_out));
        }
        left_out.extend(torn);
    }
    None
}

/// The largest connected set of electrodes; `None` if no electrode has bounds that fit a lattice.
fn lattice(electrodes: &[DrawnElectrode]) -> Option<Lattice> {
    let drawn = electrodes.iter().enumerate().filter_map(|(index, electrode)| Some((index, electrode.bounds?)));
    let drawn: Vec<(usize, [f64; 4])> = drawn.collect();
    let spacings = spacings(&drawn);
    if spacings.is_empty() {
        let (alone, _) = drawn.first()?;
        return Some(Lattice { places: BTreeMap::from([(*alone, [0, 0])]), spacing: 0.0 });
    }
    let mut best = Lattice { places: BTreeMap::new(), spacing: 0.0 };
    for spacing in spacings {
        let places = places(&drawn, spacing);
        if places.len() > best.places.len() {
            best = Lattice { places, spacing };
        }
        if 2 * best.places.len() > drawn.len() {
            break;
        }
    }
    (!best.places.is_empty()).then_some(best)
}

/// The places of the largest set of electrodes connected at a given pitch, by index.
fn places(drawn: &[(usize, [f64; 4])], spacing: f64) -> BTreeMap<usize, LatticePlace> {
    let mut open: BTreeMap<usize, [f64; 2]> = drawn
        .iter()
        .filter(|(_, bounds)| {
            sides(*bounds).iter().all(|side| (SIDES[0] * spacing..=SIDES[1] * spacing).contains(side))
        })
        .map(|(index, bounds)| (*index, middle(*bounds)))
        .collect();
    let mut largest: BTreeMap<usize, LatticePlace> = BTreeMap::new();
    while let Some((index, at)) = open.pop_first() {
        let found = connected_component((index, at), &mut open, spacing);
        if found.len() > largest.len() {
            largest = found;
        }
    }
    largest
}

/// The electrodes on free places of the lattice that no droplet reaches from the others, by index.
fn cut_off(electrodes: &[DrawnElectrode], places: &BTreeMap<usize, LatticePlace>, spacing: f64) -> BTreeSet<usize> {
    let placed: Vec<([f64; 4], LatticePlace)> =
        places.iter().filter_map(|(index, place)| Some((electrodes.get(*index)?.bounds?, *place))).collect();
    let taken: BTreeSet<LatticePlace> = places.values().copied().collect();
    let is_cut_off = |bounds: [f64; 4]| {
        let [x, y] = middle(bounds);
        let steps_to = |other: [f64; 4]| {
            let [from_x, from_y] = middle(other);
            [(x - from_x) / spacing, (y - from_y) / spacing]
        };
        let far = |other: [f64; 4]| steps_to(other).map(|step| step * step).iter().sum::<f64>();
        // Counted from the nearest electrode, so that an error of the pitch stays small.
        let Some((near, [column, row])) = placed.iter().min_by(|a, b| far(a.0).total_cmp(&far(b.0))) else {
            return false;
        };
        let steps = steps_to(*near);
        let place = [column + steps[0].round() as i64, row + steps[1].round() as i64];
        let is_alike = |(side, other): (&f64, &f64)| (side - other).abs() <= OTHER_SIDES * other;
        steps.iter().all(|step| (step - step.round()).abs() <= OFF_PLACE)
            && sides(bounds).iter().zip(&sides(*near)).all(is_alike)
            && !taken.contains(&place)
    };
    let others = electrodes.iter().enumerate().filter(|(index, _)| spacing > 0.0 && !places.contains_key(index));
    others.filter(|(_, electrode)| electrode.bounds.is_some_and(is_cut_off)).map(|(index, _)| index).collect()
}

/// The electrodes connected to a first one, each with its place, by breadth-first search; they are removed from `open`.
fn connected_component(
    first: (usize, [f64; 2]),
    open: &mut BTreeMap<usize, [f64; 2]>,
    spacing: f64,
) -> BTreeMap<usize, LatticePlace> {
    let mut places = BTreeMap::from([(first.0, [0, 0])]);
    let mut taken: BTreeSet<LatticePlace> = BTreeSet::from([[0, 0]]);
    let mut queue = VecDeque::from([(first.1, [0, 0])]);
    while let Some((at, place)) = queue.pop_front() {
        for step in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
            let next = [place[0] + step[0], place[1] + step[1]];
            let goal = [at[0] + step[0] as f64 * spacing, at[1] + step[1] as f64 * spacing];
            let off = |other: &[f64; 2]| (other[0] - goal[0]).abs().max((other[1] - goal[1]).abs());
            let near = open.iter().filter(|(_, other)| off(other) <= OFF_PLACE * spacing);
            let Some((index, other)) = near.min_by(|a, b| off(a.1).total_cmp(&off(b.1))) else { continue };
            if !taken.insert(next) {
                continue;
            }
            let (index, other) = (*index, *other);
            open.remove(&index);
            places.insert(index, next);
            queue.push_back((other, next));
        }
    }
    places
}

fn middle([left, top, right, bottom]: [f64; 4]) -> [f64; 2] {
    [(left + right) / 2.0, (top + bottom) / 2.0]
}

/// Width and height.
fn sides([left, top, right, bottom]: [f64; 4]) -> [f64; 2] {
    [right - left, bottom - top]
}

/// Candidates for the pitch, the likeliest first: the median of the distances from each electrode to the nearest one
/// beside, above or below it that does not lie over it, then the other distances in ascending order.
fn spacings(drawn: &[(usize, [f64; 4])]) -> Vec<f64> {
    let nearest = |(index, bounds): &(usize, [f64; 4])| {
        let (at, own) = (middle(*bounds), sides(*bounds));
        let others = drawn.iter().filter(|(other, _)| other != index);
        let apart = others.map(|(_, other)| [0, 1].map(|axis| (middle(*other)[axis] - at[axis]).abs()));
        let is_over = |[x, y]: &[f64; 2]| *x < OVER * own[0] && *y < OVER * own[1];
        let along = |[x, y]: [f64; 2]| (x.min(y) <= OFF_PLACE * x.max(y)).then_some(x.max(y));
        let ways = apart.filter(|step| !is_over(step)).filter_map(along).filter(|way| *way > 0.0);
        ways.min_by(f64::total_cmp)
    };
    let mut ways: Vec<f64> = drawn.iter().filter_map(nearest).collect();
    ways.sort_by(f64::total_cmp);
    let median = ways.get(ways.len() / 2).copied();
    ways.dedup_by(|way, least| *way <= (1.0 + OFF_PLACE) * *least);
    let others = ways.into_iter().filter(|way| Some(*way) != median);
    median.into_iter().chain(others).take(MOST_SPACINGS).collect()
}
