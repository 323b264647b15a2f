//! Weights of conflicts between pairs of agents.
//!
//! Each pair has weight 1 until it is raised. Repair raises the pairs that it fails to resolve (the breakout method: P.
//! Morris, "The breakout method for escaping from local minima", AAAI 1993), so that a plan in which only they conflict
//! stops being a local minimum. Cost: memory for each raised pair, none for the others.

/// The weight of each pair of agents; at least 1.
#[derive(Debug)]
pub(super) struct ConflictWeights {
    /// By agent: the other agents of its raised pairs, each with the amount added to 1.
    raised: Vec<Vec<(u32, u32)>>,
    /// By agent: its weight against [`Self::row_agent`].
    row: Vec<u32>,
    row_agent: usize,
}

impl ConflictWeights {
    pub(super) fn new(agents: usize) -> ConflictWeights {
        ConflictWeights { raised: vec![Vec::new(); agents], row: vec![1; agents], row_agent: 0 }
    }

    /// Adds 1 to the weight of `agent` against `other`, but not to that of `other` against `agent`.
    pub(super) fn raise(&mut self, agent: usize, other: usize) {
        let known = self.raised[agent].iter_mut().find(|(known, _)| *known as usize == other);
        match known {
            Some((_, more)) => *more = more.saturating_add(1),
            None => self.raised[agent].push((other as u32, 1)),
        }
        if agent == self.row_agent {
            self.row[other] = self.row[other].saturating_add(1);
        }
    }

    /// The weight of one agent against another.
    pub(super) fn of(&self, agent: usize, other: usize) -> u64 {
        let known = self.raised[agent].iter().find(|(known, _)| *known as usize == other);
        1 + known.map_or(0, |(_, more)| u64::from(*more))
    }

    /// The weights of one agent against each other one.
    pub(super) fn row(&mut self, agent: usize) -> &[u32] {
        if agent != self.row_agent {
            for (other, _) in &self.raised[self.row_agent] {
                self.row[*other as usize] = 1;
            }
            for (other, more) in &self.raised[agent] {
                self.row[*other as usize] = more.saturating_add(1);
            }
            self.row_agent = agent;
        }
        &self.row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_weights_of_its_agent_alone() {
        let mut weights = ConflictWeights::new(3);
        assert_eq!(weights.row(1), [1, 1, 1]);
        weights.raise(1, 2);
        weights.raise(1, 2);
        weights.raise(0, 1);
        assert_eq!((weights.of(1, 2), weights.of(2, 1), weights.of(0, 1)), (3, 1, 2));
        assert_eq!(weights.row(1), [1, 1, 3]);
        assert_eq!(weights.row(0), [1, 2, 1]);
        assert_eq!(weights.row(2), [1, 1, 1]);
    }
}
