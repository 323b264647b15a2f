//! Interchangeable goals: `any m` stands for all parts of the scene with the name `m` and an index.

use super::errors;
use super::goals::{BoardStepJudge, phrases};
use crate::check::lets::Argument;
use crate::check::value::{ObjectName, Value};
use crate::check::verbs::Call;
use crate::claims::electrode_array::{ElectrodeArrayMove, ElectrodeArrayStop};
use crate::device::electrode_array::MAX_TEAM;
use std::collections::BTreeSet;

impl BoardStepJudge<'_> {
    /// The moves of a team, the `nth` of several simultaneous calls: its parts to its goals, both in source order.
    pub fn team(&mut self, call: &Call, nth: usize) -> Option<Vec<ElectrodeArrayMove>> {
        let object = call.object.as_ref()?;
        let Value::Object(ObjectName { name, .. }) = &object.value else { return None };
        let parts: Vec<usize> = (0..self.board_scene.parts.len())
            .filter(|part| self.board_scene.parts[*part].family() == Some(name))
            .collect();
        if parts.is_empty() {
            let families: BTreeSet<&str> = self.board_scene.parts.iter().filter_map(|part| part.family()).collect();
            let wrong = errors::no_team(object.span, name, &families, self.scene);
            // A scene that was cut for its size has already reported this.
            self.sink.push_if_some(self.board_scene.is_whole.then_some(wrong))?;
            return None;
        }
        let to = phrases(call, "to").next()?;
        let Value::List(list) = &to.value else { return None };
        let goals: Vec<Option<ElectrodeArrayStop>> = list
            .iter()
            .map(|element| self.stop(&Argument { value: element.value.clone(), span: element.span, origin: None }))
            .collect();
        let goals: Vec<ElectrodeArrayStop> = goals.into_iter().collect::<Option<_>>()?;
        let wrong = if parts.len() > MAX_TEAM {
            Some(errors::team_too_large(object.span, name, parts.len()))
        } else if parts.len() != goals.len() {
            let names: Vec<&str> = parts.iter().map(|part| self.name(*part)).collect();
            Some(errors::goals_of_team(call.span, to.span, name, &names, goals.len()))
        } else {
            None
        };
        to.unless(wrong, self.sink)?;
        let moves = parts.into_iter().zip(goals);
        let one = |(part, goal)| ElectrodeArrayMove {
            team: Some(nth),
            ..ElectrodeArrayMove::alone(part, vec![goal], call.span)
        };
        Some(moves.map(one).collect())
    }

    /// Name of the part of a move in messages; in a team the name before the index, since which part will come there is
    /// not known.
    pub fn mover(&self, one: &ElectrodeArrayMove) -> &str {
        let family = one.team.and_then(|_| self.board_scene.parts.get(one.part)?.family());
        family.unwrap_or(self.name(one.part))
    }
}
