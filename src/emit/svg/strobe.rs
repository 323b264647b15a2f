//! The instants whose positions are drawn and numbered.

use crate::quantity::Quantity;
use std::collections::BTreeSet;

/// Greatest number of numbered instants in a panel.
pub const MAX_STROBES: usize = 12;

/// Greatest number of numbers in a panel, over all movers.
pub const MAX_NUMBERS: usize = 72;

/// Places nearer than this on paper share one label.
const CLUSTER_PT: f64 = 4.0;

/// The instants of a panel, in order; the first is number 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strobes {
    pub instants: Vec<u64>,
    /// Note on omitted instants.
    pub note: Option<String>,
}

impl Strobes {
    /// Chooses among all instants: the first, the last and the stops, and others evenly between these while there are
    /// few.
    pub fn chosen(all: &BTreeSet<u64>, stops: &BTreeSet<u64>, most: usize) -> Strobes {
        let most = most.max(2);
        if all.len() <= most {
            return Strobes { instants: all.iter().copied().collect(), note: None };
        }
        let ends = [all.first(), all.last()].into_iter().flatten().copied();
        let stops: BTreeSet<u64> = ends.chain(stops.intersection(all).copied()).collect();
        let mut chosen: BTreeSet<u64> = evenly(&stops.iter().copied().collect::<Vec<_>>(), most).collect();
        let all_stops = chosen.len() == stops.len();
        while chosen.len() < most {
            let Some(next) = between(all, &chosen) else { break };
            chosen.insert(next);
        }
        let kept = match all_stops {
            true => "all stops among them".to_owned(),
            false => format!("{most} of {} stops", stops.len()),
        };
        let note = format!("{} of {} states are numbered, {kept}", chosen.len(), all.len());
        Strobes { instants: chosen.into_iter().collect(), note: Some(note) }
    }

    /// The strobe numbers with their instants.
    pub fn numbered(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        (1..).zip(self.instants.iter().copied())
    }

    /// `1: 0 s, 2: 15 ms`; no line breaks between a number and its time.
    pub fn times(&self) -> String {
        let one = |(number, t_ns): (usize, u64)| format!("{number}: {}", time(t_ns)).replace(' ', "\u{a0}");
        self.numbered().map(one).collect::<Vec<_>>().join(", ")
    }
}

/// The instant nearest to the middle of the longest gap between chosen instants.
fn between(all: &BTreeSet<u64>, chosen: &BTreeSet<u64>) -> Option<u64> {
    let gaps =
        chosen.iter().zip(chosen.iter().skip(1)).filter(|(from, to)| all.range(*from + 1..**to).next().is_some());
    let (from, to) = gaps.max_by_key(|(from, to)| *to - *from)?;
    let middle = from + (to - from) / 2;
    all.range(from + 1..*to).copied().min_by_key(|t_ns| t_ns.abs_diff(middle))
}

/// At most `most` elements of a list, evenly spaced, including the first and the last.
fn evenly(list: &[u64], most: usize) -> impl Iterator<Item = u64> {
    let count = list.len().min(most);
    let last = list.len().saturating_sub(1);
    (0..count).map(move |index| list[if count > 1 { index * last / (count - 1) } else { 0 }])
}

/// A time for readers.
pub fn time(t_ns: u64) -> String {
    micro(&Quantity::time_ns(t_ns).to_string())
}

/// A length for readers.
pub fn length(um: f64) -> String {
    micro(&Quantity::length_um(um).to_string())
}

/// The text with `µ` in the units of micrometres, microseconds and micronewtons.
pub fn micro(text: &str) -> String {
    text.replace(" um", " µm").replace(" us", " µs").replace(" uN", " µN")
}

/// Ascending numbers as ranges: `1, 3–5`.
pub fn ranges(numbers: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for &number in numbers {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            Some(_) | None => parts.push((number, number)),
        }
    }
    let part = |(first, last): &(usize, usize)| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        2.. => format!("{first}–{last}"),
    };
    parts.iter().map(part).collect::<Vec<_>>().join(", ")
}

/// A place of a mover, with the numbers and instants of its strobes there.
#[derive(Debug, Clone, PartialEq)]
pub struct StrobedPlace {
    pub place: [f64; 2],
    pub strobes: Vec<(usize, u64)>,
}

impl StrobedPlace {
    /// The places of a mover at the strobes, each once, in order of first visit.
    pub fn all(strobes: &Strobes, mut place: impl FnMut(u64) -> Option<[f64; 2]>) -> Vec<StrobedPlace> {
        let mut places: Vec<StrobedPlace> = Vec::new();
        for (number, t_ns) in strobes.numbered() {
            let Some(here) = place(t_ns) else { continue };
            match places.iter_mut().find(|known| known.place == here) {
                Some(known) => known.strobes.push((number, t_ns)),
                None => places.push(StrobedPlace { place: here, strobes: vec![(number, t_ns)] }),
            }
        }
        places
    }

    /// Merges places near each other on paper; each cluster lies at its first place and has the numbers of all.
    pub fn clustered<'p>(
        places: impl IntoIterator<Item = (&'p StrobedPlace, [f64; 2])>,
    ) -> Vec<([f64; 2], Vec<usize>)> {
        let mut clusters: Vec<([f64; 2], Vec<usize>)> = Vec::new();
        for (place, at) in places {
            let near = |(other, _): &&mut ([f64; 2], Vec<usize>)| {
                (0..2).all(|axis: usize| (other[axis] - at[axis]).abs() < CLUSTER_PT)
            };
            let numbers = place.strobes.iter().map(|(number, _)| *number);
            match clusters.iter_mut().find(near) {
                Some((_, known)) => known.extend(numbers),
                None => clusters.push((at, numbers.collect())),
            }
        }
        clusters.iter_mut().for_each(|(_, numbers)| numbers.sort_unstable());
        clusters
    }

    /// `1, 3–5`.
    pub fn numbers(&self) -> String {
        ranges(&self.strobes.iter().map(|(number, _)| *number).collect::<Vec<_>>())
    }

    /// Its instants, in nanoseconds.
    pub fn instants(&self) -> String {
        self.strobes.iter().map(|(_, t_ns)| t_ns.to_string()).collect::<Vec<_>>().join(" ")
    }
}
