//! Routes through the grasp graph for a held stretch of a task: from a first grasp to the release, or to the end of the
//! task.
//!
//! Input: the steps of the stretch, and the grasp at its beginning. Output: its routes, one for each combination of
//! alternatives of its `orient` steps, cheapest estimate first. Guaranteed: every route has at least one turn, and each
//! turn knows its step.

use super::graph::Grasp;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersStep, FingersTurn};
use crate::device::fingers::Plane;
use std::ops::Range;

/// Most routes searched for one stretch; of more, those that turn most are left out.
pub const MAX_ROUTES: usize = 256;

/// Most routes under a load, where grasps are evaluated anew for every leg.
pub const MAX_LOADED_ROUTES: usize = 64;

/// A leg of a route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RouteTurn {
    /// Index into the order's steps.
    pub step: usize,
    pub turn: FingersTurn,
    pub end: LegEnd,
}

/// Grasps with which a leg may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegEnd {
    Any,
    /// The one that the task names.
    Pinned(Grasp),
    /// Those that all fingers can leave. Such a leg turns nothing: it only changes to a grasp with which the part can
    /// be released.
    Released,
}

/// The turns of a stretch, in order.
pub type TurnRoute = Vec<RouteTurn>;

/// Grasp held by the fingers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Holding {
    pub grasp: Grasp,
    pub plane: Plane,
}

/// The routes of a stretch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Routes {
    /// Routes with the fewest steps of turning first; at most [`MAX_ROUTES`], or [`MAX_LOADED_ROUTES`].
    pub routes: Vec<TurnRoute>,
    /// The grasp with which each route begins; `None`: any.
    pub start: Option<Grasp>,
    /// Least number of steps turned by the routes left out; `None` if there are none.
    pub left_out: Option<u64>,
}

/// The routes of a range of an order's steps, from the grasp held at their beginning.
pub fn routes(order: &FingersOrder, steps: Range<usize>, held: Option<Holding>) -> Routes {
    let (mut choices, left_out) = choices(order, steps.clone());
    choices.sort_by_key(|choice| turned(choice));
    let planes = free_planes(order, &steps, held);
    let in_plane = |plane: Option<Plane>| {
        let steps = &steps;
        choices.iter().map(move |choice| route(order, steps.clone(), choice, held, plane))
    };
    let routes = planes.into_iter().flat_map(in_plane).collect();
    let start = held.map(|held| held.grasp).or_else(|| first_grasp(order, steps));
    Routes { routes, start, left_out }
}

impl Routes {
    /// The routes, each with an additional last leg to a grasp that all fingers can leave; `None` if the task names the
    /// last grasp.
    pub fn released(&self) -> Option<Routes> {
        let mut routes = self.clone();
        for route in &mut routes.routes {
            let last = *route.last().filter(|last| !matches!(last.end, LegEnd::Pinned(_)))?;
            route.push(RouteTurn { turn: FingersTurn { steps: 0, ..last.turn }, end: LegEnd::Released, ..last });
        }
        Some(routes)
    }
}

/// Number of steps of the turns of a choice: the fewest that it can roll.
fn turned(turns: &[(usize, FingersTurn)]) -> u64 {
    turns.iter().map(|(_, turn)| u64::from(turn.steps.unsigned_abs())).sum()
}

/// The turns of the steps, one list for each combination of alternatives, and the least number of steps turned by the
/// combinations left out.
fn choices(order: &FingersOrder, steps: Range<usize>) -> (Vec<Vec<(usize, FingersTurn)>>, Option<u64>) {
    let mut choices: Vec<Vec<(usize, FingersTurn)>> = vec![Vec::new()];
    let mut left_out: Option<u64> = None;
    let most = if order.load_un == [0.0; 3] { MAX_ROUTES } else { MAX_LOADED_ROUTES };
    for step in steps {
        if let FingersAction::Orient { left_out_steps: Some(least), .. } = &order.steps[step].action {
            left_out = Some(left_out.map_or(u64::from(*least), |known| known.min(u64::from(*least))));
        }
        let ways: Vec<Vec<FingersTurn>> = match &order.steps[step].action {
            FingersAction::Rotate { plane, steps, .. } => vec![vec![FingersTurn { plane: *plane, steps: *steps }]],
            FingersAction::Orient { turns, .. } => turns.clone(),
            FingersAction::Grasp(_) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_) => {
                continue;
            }
        };
        let with = |choice: &Vec<(usize, FingersTurn)>, way: &Vec<FingersTurn>| {
            choice.iter().copied().chain(way.iter().map(|turn| (step, *turn))).collect::<Vec<_>>()
        };
        choices = choices.iter().flat_map(|choice| ways.iter().map(move |way| with(choice, way))).collect();
        choices.sort_by_key(|choice| turned(choice));
        for choice in choices.drain(choices.len().min(most)..) {
            left_out = Some(left_out.map_or(turned(&choice), |least| least.min(turned(&choice))));
        }
    }
    (choices, left_out)
}

/// The grasp with which the stretch begins, if a step names one before anything turns.
fn first_grasp(order: &FingersOrder, steps: Range<usize>) -> Option<Grasp> {
    for step in steps {
        match &order.steps[step].action {
            FingersAction::Grasp(Some(contacts)) => return Grasp::of(contacts),
            FingersAction::Rotate { .. } | FingersAction::Orient { .. } => return None,
            FingersAction::Grasp(None)
            | FingersAction::Translate(_)
            | FingersAction::Release
            | FingersAction::Wait(_) => (),
        }
    }
    None
}

/// Whether an action needs fingers on the part.
pub fn takes_hold(action: &FingersAction) -> bool {
    match action {
        FingersAction::Grasp(_)
        | FingersAction::Rotate { .. }
        | FingersAction::Orient { .. }
        | FingersAction::Translate(_) => true,
        FingersAction::Release | FingersAction::Wait(_) => false,
    }
}

/// Planes in which the fingers may take hold if nothing in the range determines the plane: no turn, no grasp on named
/// contacts, and nothing held. `None` leaves the plane to the turns.
fn free_planes(order: &FingersOrder, steps: &Range<usize>, held: Option<Holding>) -> Vec<Option<Plane>> {
    let is_bound = order.steps[steps.clone()].iter().any(|step| match &step.action {
        FingersAction::Rotate { .. } | FingersAction::Orient { .. } | FingersAction::Grasp(Some(_)) => true,
        FingersAction::Grasp(None) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_) => {
            false
        }
    });
    if held.is_some() || is_bound {
        return vec![None];
    }
    let planes = Plane::ALL.into_iter().filter(|plane| order.part.section(*plane).is_some());
    planes.map(Some).collect()
}

/// Plane of the first or the last turn of a step, as picked by `end`; for an `orient` step, of its first alternative
/// that turns.
fn turned_in(step: &FingersStep, end: fn(&[FingersTurn]) -> Option<&FingersTurn>) -> Option<Plane> {
    match &step.action {
        FingersAction::Rotate { plane, .. } => Some(*plane),
        FingersAction::Orient { turns, .. } => turns.iter().find_map(|turns| end(turns)).map(|turn| turn.plane),
        FingersAction::Grasp(_) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_) => None,
    }
}

fn route(
    order: &FingersOrder,
    steps: Range<usize>,
    turns: &[(usize, FingersTurn)],
    held: Option<Holding>,
    free: Option<Plane>,
) -> TurnRoute {
    // The plane is that of the next turn of the task, else of its last one: turns of this range as chosen, other turns
    // as written.
    let last = turns.last().map(|(_, turn)| turn.plane).or_else(|| {
        let mut before = order.steps[..steps.start].iter().rev();
        before.find_map(|step| turned_in(step, <[FingersTurn]>::last))
    });
    let later = order.steps[steps.end..].iter().find_map(|step| turned_in(step, <[FingersTurn]>::first));
    let plane_at = |step: usize| {
        let next = turns.iter().find(|(of, _)| *of >= step).map(|(_, turn)| turn.plane);
        free.or(next).or(later).or(last).unwrap_or(Plane::Xy)
    };
    let mut route = TurnRoute::new();
    let mut is_held = held.is_some();
    // A wait before the first hold remains a wait.
    let begins = steps.clone().find(|step| takes_hold(&order.steps[*step].action)).unwrap_or(steps.start);
    for step in steps {
        if let FingersAction::Grasp(contacts) = &order.steps[step].action {
            if let Some(pin) = contacts.as_ref().filter(|_| is_held).and_then(|contacts| Grasp::of(contacts)) {
                route.push(RouteTurn {
                    step,
                    turn: FingersTurn { plane: plane_at(step), steps: 0 },
                    end: LegEnd::Pinned(pin),
                });
            }
            is_held = true;
        }
        for (_, turn) in turns.iter().filter(|(of, _)| *of == step) {
            route.push(RouteTurn { step, turn: *turn, end: LegEnd::Any });
        }
        // An `orient` step that is already fulfilled turns nothing, but any grasp may hold the part there.
        is_held |= matches!(order.steps[step].action, FingersAction::Rotate { .. } | FingersAction::Orient { .. });
    }
    let first = route.first().map_or((begins, plane_at(begins)), |first| (first.step, first.turn.plane));
    let changes_plane = held.is_some_and(|held| held.plane != first.1);
    if route.is_empty() || changes_plane {
        let plane = held.map_or(first.1, |held| held.plane);
        route.insert(0, RouteTurn { step: first.0, turn: FingersTurn { plane, steps: 0 }, end: LegEnd::Any });
    }
    route
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::fingers::FingersStep;
    use crate::claims::fixture::hand_order;
    use crate::device::fingers::fixture::hand;
    use crate::source::Span;

    /// Three orientations with these numbers of alternatives; each combination turns a different number of steps.
    fn asked(ways: [i32; 3], is_loaded: bool) -> Routes {
        let step = |(scale, count): (i32, i32)| {
            let turns = (1..=count).map(|steps| vec![FingersTurn { plane: Plane::Xy, steps: scale * steps }]).collect();
            let action = FingersAction::Orient { goal: [1.0, 0.0, 0.0, 0.0], turns, left_out_steps: None };
            FingersStep { action, span: Span::default() }
        };
        let load_un = if is_loaded { [0.0, 0.0, -0.1] } else { [0.0; 3] };
        let steps = [1, 10, 100].into_iter().zip(ways).map(step).collect();
        routes(&FingersOrder { load_un, ..hand_order(hand(), steps) }, 0..3, None)
    }

    /// Beyond the cap the routes that turn most are left out, and the least number of steps that they turn is known.
    #[test]
    fn what_is_left_out_is_counted() {
        let counts = |routes: &Routes| (routes.routes.len(), routes.left_out);
        assert_eq!(counts(&asked([8, 8, 4], false)), (256, None));
        // Of 8 x 8 x 5 the 64 that turn 500 steps in the last.
        assert_eq!(counts(&asked([8, 8, 5], false)), (256, Some(511)));
        assert_eq!(counts(&asked([4, 4, 4], true)), (64, None));
        assert_eq!(counts(&asked([4, 4, 5], true)), (64, Some(511)));
    }
}
