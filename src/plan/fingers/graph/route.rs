//! Search over alternative routes: the route with the least lower bound is advanced, until one reaches its goal.

use super::course::{PreparedRoute, courses};
use super::flood::{Direction, GraspFlood, TRIPLE_LOOKS};
use super::layout::{MAX_WORDS, NodeSpot};
use super::published::Published;
use super::strands::has;
use super::walk::{Estimate, NEVER, RankedEntry, RouteWalk, WalkProgress, ranked, unranked};
use super::{
    Estimator, FarthestRoute, GraspAnswer, GraspCosts, GraspNode, GraspPath, GraspRequest, GraspSearchEnd, Start,
    TurnLeg,
};
use crate::plan::search::Meter;

/// The exact number of remaining reconfigurations where the flood has reached; a lower bound elsewhere.
#[derive(Debug)]
pub struct RemainingReconfigurations<'a, const N: usize>(pub GraspFlood<'a, N>);

impl<const N: usize> Estimate for RemainingReconfigurations<'_, N> {
    #[inline]
    fn gaits(&self, spot: NodeSpot) -> u32 {
        match self.0.layer_of(spot) {
            Some(layer) => layer,
            None if self.0.ended() => NEVER,
            None => self.0.floor(spot),
        }
    }

    #[inline]
    fn is_settled(&self, spot: NodeSpot) -> bool {
        self.0.ended() || self.0.stopped() || self.0.layer_of(spot).is_some()
    }

    fn deepen(&mut self) {
        self.0.deepen();
    }
}

/// Function that returns a lower bound for each route, in the unit of the request's costs; `None` for a route without a
/// path. It returns `None` as a whole if bounds are not worth their cost, or if the budget ran out.
pub type RouteBounds = fn(&GraspRequest, Estimator, &mut Meter) -> Option<Vec<Option<u64>>>;

/// See [`super::solve`]; `bounds` are computed first, and order the routes.
pub fn cheapest(request: &GraspRequest, estimator: Estimator, bounds: RouteBounds, meter: &mut Meter) -> GraspAnswer {
    let courses = match courses(request) {
        Ok(courses) => courses,
        Err(nodes) => return GraspAnswer::GaveUp(GraspSearchEnd::TooLarge { nodes }),
    };
    let search = RouteSearch { request, courses: &courses, bounds, meter };
    match angles(request) {
        0..=64 => search.run::<1>(estimator),
        65..=128 => search.run::<2>(estimator),
        129..=256 => search.run::<4>(estimator),
        257..=512 => search.run::<8>(estimator),
        _ => search.run::<MAX_WORDS>(estimator),
    }
}

/// The cheapest path over all routes. The lower bound of each route is the cost of two fingers that roll all the way.
pub fn cheapest_of_few(request: &GraspRequest, estimator: Estimator, meter: &mut Meter) -> GraspAnswer {
    cheapest(request, estimator, |_, _, _| None, meter)
}

/// Lower bound over all routes; `None` if none has a path, or a route is too large. If the looks run out, fewer
/// reconfigurations are counted than are needed, which keeps the bound admissible.
pub fn bound(request: &GraspRequest) -> Option<u64> {
    let courses = courses(request).ok()?;
    let bound = |course: &PreparedRoute| {
        let gaits = match angles(request) {
            0..=64 => gaits::<1>(course, request.start),
            65..=128 => gaits::<2>(course, request.start),
            129..=256 => gaits::<4>(course, request.start),
            257..=512 => gaits::<8>(course, request.start),
            _ => gaits::<MAX_WORDS>(course, request.start),
        };
        let reconfiguring = u64::from(request.costs.gait) * u64::from(gaits);
        (gaits != NEVER).then(|| least(course, request.costs) + reconfiguring)
    };
    courses.iter().filter_map(bound).min()
}

/// Least number of reconfigurations from the start to the end.
fn gaits<const N: usize>(course: &PreparedRoute, start: Start) -> u32 {
    if course.looks.are_spent() {
        return 0;
    }
    let layers = RemainingReconfigurations(flooded::<N>(course, start));
    let prepared = &course.legs[0];
    let mut least = NEVER;
    match start {
        Start::At(grasp) => course.place(0, prepared.start, &grasp).map_or(NEVER, |spot| layers.gaits(spot)),
        Start::Any => {
            for number in 0..course.sets.chains(prepared.contacts) as usize {
                course.looks.take(1);
                if least == 0 || course.looks.are_spent() {
                    return 0;
                }
                let chain = course.sets.chain(prepared.contacts, number);
                let spot = NodeSpot { leg: 0, angle: prepared.start, chain };
                let held = &course.contacts(spot)[..course.sets.members(chain.set).len()];
                if prepared.holds(prepared.start, held) {
                    course.looks.take(TRIPLE_LOOKS);
                    least = least.min(layers.gaits(spot));
                }
            }
            least
        }
    }
}

/// Largest number of angles of a leg.
fn angles(request: &GraspRequest) -> usize {
    request.routes.iter().flatten().map(TurnLeg::angles).max().unwrap_or(1)
}

/// A route that may still be the cheapest.
struct Candidate<'a, E> {
    route: usize,
    /// Lower bound on its paths.
    bound: u64,
    /// `None` until it is first advanced.
    walk: Option<RouteWalk<'a, E>>,
}

struct RouteSearch<'a> {
    request: &'a GraspRequest,
    courses: &'a [PreparedRoute],
    bounds: RouteBounds,
    meter: &'a mut Meter,
}

impl<'a> RouteSearch<'a> {
    fn run<const N: usize>(mut self, estimator: Estimator) -> GraspAnswer {
        if let Some(route) = self.courses.iter().position(|course| course.legs.is_empty()) {
            return GraspAnswer::Found(GraspPath { route, cost: 0, bound: 0, legs: Vec::new(), expanded: 0 });
        }
        let bounds = (self.bounds)(self.request, estimator, self.meter);
        let found = match estimator {
            Estimator::Published => self.portfolio(bounds.as_deref(), Published::of),
            Estimator::Layers => {
                let start = self.request.start;
                self.portfolio(bounds.as_deref(), |course| RemainingReconfigurations::<N>(flooded(course, start)))
            }
        };
        if let Some(found) = found {
            return found;
        }
        // With a limit on reconfigurations, the reach of the routes is not needed.
        let blocked = match self.request.limits.gaits {
            Some(_) => FarthestRoute::NOWHERE,
            None => blocked::<N>(self.courses, self.request.start),
        };
        GraspAnswer::Impossible(blocked)
    }

    /// Advances the route with the least bound (the first of several) up to the bound of the next one.
    ///
    /// `bounds` are the sums over the routes' separate legs, if known.
    fn portfolio<E: Estimate>(
        &mut self,
        bounds: Option<&[Option<u64>]>,
        estimate: impl Fn(&'a PreparedRoute) -> E,
    ) -> Option<GraspAnswer> {
        let (all, costs) = (self.request.costs, reduced(self.request.costs));
        let unit = u64::from(all.roll.max(all.gait) / costs.roll.max(costs.gait).max(1));
        let mut open: Vec<Candidate<'a, E>> = (self.courses.iter().enumerate())
            .filter_map(|(route, course)| {
                let bound = match bounds {
                    Some(bounds) => bounds[route]? / unit,
                    None => least(course, costs),
                };
                Some(Candidate { route, bound: ranked(bound), walk: None })
            })
            .collect();
        let before = self.meter.spent();
        let costs = RankedEntry::of(costs);
        loop {
            let at = (0..open.len()).min_by_key(|at| (open[*at].bound, open[*at].route))?;
            let limit = (open.iter().enumerate())
                .filter(|(other, _)| *other != at)
                .map(
                    |(_, other)| if other.route < open[at].route { other.bound.saturating_sub(1) } else { other.bound },
                )
                .min();
            let candidate = &mut open[at];
            let Some(walk) = &mut candidate.walk else {
                match self.begun(candidate.route, costs, &estimate) {
                    Some(walk) => candidate.walk = Some(walk),
                    None => drop(open.remove(at)),
                }
                continue;
            };
            match walk.advance(limit.unwrap_or(u64::MAX), self.meter) {
                WalkProgress::Found(cost) => {
                    let (route, expanded) = (candidate.route, self.meter.spent() - before);
                    let cost = unranked(cost) * unit;
                    let legs = legs(&self.courses[route], &walk.way());
                    return Some(GraspAnswer::Found(GraspPath { route, cost, bound: cost, legs, expanded }));
                }
                WalkProgress::AtLeast(bound) => candidate.bound = bound,
                WalkProgress::Exhausted => drop(open.remove(at)),
                WalkProgress::Spent(bound) if self.courses[candidate.route].looks.are_spent() => {
                    return Some(GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound: unranked(bound) * unit }));
                }
                WalkProgress::Spent(bound) => {
                    return Some(GraspAnswer::GaveUp(GraspSearchEnd::Expansions(
                        self.meter.gave_up(unranked(bound) * unit),
                    )));
                }
            }
        }
    }

    /// A route's walk before its first step; `None` if its start does not hold.
    fn begun<E: Estimate>(
        &self,
        route: usize,
        costs: RankedEntry,
        estimate: impl Fn(&'a PreparedRoute) -> E,
    ) -> Option<RouteWalk<'a, E>> {
        let course = &self.courses[route];
        match self.request.start {
            Start::Any => Some(RouteWalk::anywhere(course, costs, estimate(course))),
            Start::At(grasp) => {
                let start = course.place(0, course.legs[0].start, &grasp)?;
                Some(RouteWalk::at(course, costs, estimate(course), start))
            }
        }
    }
}

/// The costs divided by their greatest common divisor.
fn reduced(costs: GraspCosts) -> GraspCosts {
    let (mut a, mut b) = (costs.roll, costs.gait);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    let unit = a.max(1);
    GraspCosts { roll: costs.roll / unit, gait: costs.gait / unit }
}

/// Cost of two fingers that roll all the way.
fn least(course: &PreparedRoute, costs: GraspCosts) -> u64 {
    let steps = course.legs.iter().map(|prepared| prepared.start.abs_diff(prepared.end) as u64);
    2 * u64::from(costs.roll) * steps.sum::<u64>()
}

/// A flood from the goals, run until it reaches the start or is exhausted.
pub fn flooded<const N: usize>(course: &PreparedRoute, start: Start) -> GraspFlood<'_, N> {
    let leg = course.legs.len() - 1;
    let mut flood = match course.few_ends(leg) {
        Some(ends) => GraspFlood::from(course, Direction::Back, &ends),
        None => GraspFlood::from_all(course, Direction::Back, leg, course.legs[leg].end),
    };
    while !flood.ended() && !flood.stopped() && !arrived(&flood, course, start) {
        flood.deepen();
    }
    flood
}

/// Whether a flood from the goals has just reached the start.
fn arrived<const N: usize>(flood: &GraspFlood<N>, course: &PreparedRoute, start: Start) -> bool {
    match start {
        Start::Any => flood.arrives(),
        Start::At(grasp) => {
            course.place(0, course.legs[0].start, &grasp).is_some_and(|spot| flood.layer_of(spot).is_some())
        }
    }
}

/// The nodes of a path, by leg.
fn legs(course: &PreparedRoute, way: &[NodeSpot]) -> Vec<Vec<GraspNode>> {
    let mut legs: Vec<Vec<GraspNode>> = vec![Vec::new(); course.legs.len()];
    for spot in way {
        let angle = spot.angle as i32 - course.legs[spot.leg].start as i32;
        legs[spot.leg].push(GraspNode { grasp: course.grasp(*spot), angle });
    }
    legs
}

/// The farthest point of any route, when none reaches its end.
fn blocked<const N: usize>(courses: &[PreparedRoute], start: Start) -> FarthestRoute {
    let reports = courses.iter().enumerate().map(|(route, course)| stuck::<N>(route, course, start));
    let mut farthest: Option<FarthestRoute> = None;
    for report in reports {
        if farthest.as_ref().is_none_or(|other| other.leg < report.leg) {
            farthest = Some(report);
        }
    }
    farthest.unwrap_or(FarthestRoute::NOWHERE)
}

/// The farthest point of a route that has no path.
fn stuck<const N: usize>(route: usize, course: &PreparedRoute, start: Start) -> FarthestRoute {
    let mut flood: GraspFlood<N> = match start {
        Start::Any => GraspFlood::from_all(course, Direction::Onward, 0, course.legs[0].start),
        Start::At(grasp) => {
            let spot = course.place(0, course.legs[0].start, &grasp);
            GraspFlood::from(course, Direction::Onward, spot.as_slice())
        }
    };
    while !flood.ended() && !flood.stopped() {
        flood.deepen();
    }
    // The last leg that can begin is the one whose end is unreachable.
    let is_begun = |leg: &usize| has(&flood.angles(*leg), course.legs[*leg].start);
    let leg = (0..course.legs.len()).rev().find(is_begun).unwrap_or(0);
    let prepared = &course.legs[leg];
    let reached = (0..prepared.angles).filter(|angle| has(&flood.angles(leg), *angle));
    let farthest =
        reached.min_by_key(|angle| angle.abs_diff(prepared.end)).map(|angle| angle as i32 - prepared.start as i32);
    let may_end = |spot: &NodeSpot| course.is_goal(*spot) || course.next(*spot).is_some();
    let ends = match course.few_ends(leg) {
        Some(ends) => ends.iter().filter(|spot| may_end(spot)).count() as u64,
        None => course.count(leg, prepared.end),
    };
    // Under a load the tables are optimistic.
    let is_known = !flood.stopped() && course.legs.iter().all(|prepared| prepared.lazy.is_none());
    // If any grasp may start, one is assumed to hold unless it was proven that none does.
    let farthest = farthest.or((start == Start::Any && !is_known).then_some(0));
    FarthestRoute { route, leg, farthest, ends, is_known }
}
