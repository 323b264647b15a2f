//! Joins consecutive actuations at the same level, since nothing changes between them.

use super::Actuation;

impl Actuation {
    /// Its constant value; `None` for a slope or a swing.
    fn level(&self) -> Option<f64> {
        (self.swing.is_none() && self.from == self.to).then_some(self.from)
    }
}

/// The actuations of a channel, in order of time, with each run of adjoining ones at the same level joined into one.
pub fn joined<'a>(actuations: impl IntoIterator<Item = &'a Actuation>) -> Vec<Actuation> {
    let mut joined: Vec<Actuation> = Vec::new();
    for actuation in actuations {
        let goes_on = |last: &&mut Actuation| {
            last.end_ns() == actuation.start_ns && last.level().is_some() && last.level() == actuation.level()
        };
        match joined.last_mut().filter(goes_on) {
            Some(last) => last.duration_ns += actuation.duration_ns,
            None => joined.push(*actuation),
        }
    }
    joined
}

/// As [`joined`], without those that keep a channel at rest; the ends of the remaining ones are where its value
/// changes.
pub fn away_from_rest<'a>(actuations: impl IntoIterator<Item = &'a Actuation>, rest_v: f64) -> Vec<Actuation> {
    joined(actuations).into_iter().filter(|actuation| actuation.level() != Some(rest_v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::Swing;

    #[test]
    fn a_level_that_goes_on_is_one() {
        let at = |start_ns: u64, duration_ns: u64, [from, to]: [f64; 2]| Actuation {
            channel: 0,
            start_ns,
            duration_ns,
            from,
            to,
            swing: None,
            step: 0,
        };
        let list = [
            at(0, 3, [5.0; 2]),
            at(3, 4, [5.0; 2]),
            at(7, 1, [0.0; 2]),
            at(9, 1, [0.0; 2]),
            at(10, 2, [0.0, 1.0]),
            at(12, 2, [1.0; 2]),
            Actuation { swing: Some(Swing { period_ns: 2, levels: [1.0; 2] }), ..at(14, 2, [1.0; 2]) },
        ];
        let ends = |list: &[Actuation]| -> Vec<[u64; 2]> {
            list.iter().map(|actuation| [actuation.start_ns, actuation.end_ns()]).collect()
        };
        assert_eq!(ends(&joined(&list)), [[0, 7], [7, 8], [9, 10], [10, 12], [12, 14], [14, 16]]);
        assert_eq!(ends(&away_from_rest(&list, 0.0)), [[0, 7], [10, 12], [12, 14], [14, 16]]);
    }
}
