//! Interchangeable goals: each is reached by any part of the team.

use super::build::{chip, go};
use super::{judged, moving};
use crate::claims::electrode_array::{ElectrodeArrayMove, ElectrodeArrayOrder};
use crate::verify::Rule;

const THREE: [(&str, u32, u32); 3] = [("m0", 4, 4), ("m1", 4, 8), ("a", 10, 12)];

fn any(part: usize, goal: (u32, u32)) -> ElectrodeArrayMove {
    ElectrodeArrayMove { team: Some(0), ..go(part, &[goal]) }
}

fn two(goals: [(u32, u32); 2], more: Option<ElectrodeArrayMove>) -> ElectrodeArrayOrder {
    let moves = [any(0, goals[0]), any(1, goals[1])].into_iter().chain(more).collect();
    moving(chip(14, 14), &THREE, moves)
}

#[test]
fn each_goal_has_one_of_the_parts() {
    // In the order of the program, and exchanged.
    judged(two([(6, 4), (6, 8)], None), &["RR", "RR", ""], &[]);
    judged(two([(6, 8), (6, 4)], None), &["RR", "RR", ""], &[]);
    judged(two([(6, 8), (6, 4)], None), &["R", "RR", ""], &[Rule::Goal]);
    judged(two([(6, 8), (6, 4)], None), &["RRR", "RR", ""], &[Rule::Goal]);
    // One of them is at a goal from the start and stays there.
    judged(two([(4, 8), (6, 4)], None), &["RR", "", ""], &[]);
    judged(two([(4, 8), (6, 4)], None), &["RR", "R", ""], &[Rule::Goal]);
}

#[test]
fn another_part_is_none_of_them() {
    let goals = [(6, 4), (12, 12)];
    judged(two(goals, Some(go(2, &[(12, 12)]))), &["RR", "", "RR"], &[Rule::Goal]);
    let asked = Some(go(2, &[(12, 10)]));
    judged(two([(6, 4), (6, 8)], asked.clone()), &["RR", "RR", "RRDD"], &[]);
    judged(two([(6, 4), (6, 8)], asked), &["RR", "RR", "RRD"], &[Rule::Goal]);
}

#[test]
fn two_teams_do_not_stand_in_for_each_other() {
    let other = |part, goal| ElectrodeArrayMove { team: Some(1), ..any(part, goal) };
    let teams = |first, second| moving(chip(14, 14), &THREE, vec![any(0, first), other(1, second)]);
    judged(teams((6, 4), (6, 8)), &["RR", "RR", ""], &[]);
    judged(teams((6, 8), (6, 4)), &["RR", "RR", ""], &[Rule::Goal]);
}
