//! Checks of the steps of a task that do not depend on the part's orientation at that time.

use super::errors;
use super::orientation;
use super::part::{self, JudgedPart, MAX_LOAD_UN};
use super::scene::HandScene;
use super::step;
use crate::check::Checker;
use crate::check::figures::Figures;
use crate::check::lets::Argument;
use crate::check::scope::nearest;
use crate::check::tasks::{self, Parts, TaskSite};
use crate::check::value::{Value, whole};
use crate::check::verbs::Call;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersPlanner, FingersStep, HandPart, Section};
use crate::device::fingers::{FingersFacts, FingersVerb, MAX_HOLDING, Plane, TurnAxis};
use crate::diagnostic::{Diagnostic, Sink};
use crate::geometry::outline::Curve;
use crate::quantity::count;
use crate::real::Real;
use crate::source::Span;
use nalgebra::Vector3;
use std::sync::Arc;

/// Largest `precision`: with a larger one nearly any turn would do.
const MAX_PRECISION_RAD: f64 = 90.0 * std::f64::consts::PI / 180.0;

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error. Orientations become turns when the runs of a
    /// schedule are walked.
    pub fn fingers_order(&mut self, site: &TaskSite, facts: &Arc<FingersFacts>, parts: Parts) -> Option<FingersOrder> {
        let hand_scene = self.hand_scene(site, facts);
        let scene = site.scene.as_ref().map(|(place, _)| self.named(*place).1);
        let judged = the_part(&hand_scene, &parts, scene, site, self.sink)?;
        let judged = judged?;
        let precision_rad = precision_rad(&parts, self.sink)?;
        let load_un = load_un(&parts, &judged, self.sink)?;
        let part = judged.part;
        if let Some(fault) = judged.xz_fault.filter(|_| parts.steps.iter().any(leaves_plane_xy)) {
            self.sink.push(fault);
            return None;
        }
        let turns = turns(&parts.steps);
        let is_loaded = turns.iter().any(|(plane, _)| part::is_in_plane(Vector3::from(load_un), *plane));
        let mut judge = HandStepJudge { facts, part: &part, precision_rad, is_loaded, turns, sink: self.sink };
        let planes = grasp_planes(&parts.steps, &part);
        let steps: Vec<Option<FingersStep>> =
            parts.steps.iter().zip(&planes).map(|(step, planes)| judge.step(step, planes)).collect();
        Some(FingersOrder {
            facts: Arc::clone(facts),
            part,
            precision_rad,
            load_un,
            planner: planner(&parts)?,
            expansions: parts.expansions()?,
            looks: parts.options.get("looks").and_then(|_| parts.options.count("looks")).map(u64::from),
            steps: steps.into_iter().collect::<Option<Vec<FingersStep>>>()?,
        })
    }
}

/// Tolerance of the end of a turn; `None` after an error.
fn precision_rad(parts: &Parts, sink: &mut Sink) -> Option<f64> {
    let angle = parts.settings.quantity("precision")?;
    if let Some(setting) = parts.settings.get("precision").filter(|_| angle.si > MAX_PRECISION_RAD * (1.0 + 1e-12)) {
        sink.push(errors::precision_too_large(setting.span, angle, MAX_PRECISION_RAD));
        return None;
    }
    Some(angle.si)
}

fn planner(parts: &Parts) -> Option<FingersPlanner> {
    let asked_for = parts.planner.as_ref().map(|planner| planner.value.name);
    asked_for.map_or(Some(FingersPlanner::JointAstar), FingersPlanner::find)
}

/// The force on the part, weight included, in micronewtons; `None` where it is unknown, or after an error.
fn load_un(parts: &Parts, judged: &JudgedPart, sink: &mut Sink) -> Option<[f64; 3]> {
    let mut load_un = [0.0; 3];
    if let Some(setting) = parts.settings.get("load") {
        let Value::Point(point) = &setting.value else { return None };
        load_un = [0, 1, 2].map(|axis| point.get(axis).map_or(0.0, |force| force.in_unit("uN")));
        let size_un = Vector3::from(load_un).norm();
        if size_un > MAX_LOAD_UN {
            sink.push(errors::load_too_large(setting.span, size_un, MAX_LOAD_UN));
            return None;
        }
        if let Some(shape) = judged.uncentred.filter(|_| size_un > 0.0) {
            sink.push(errors::load_without_centre(setting.span, &judged.part.name, shape));
            return None;
        }
    }
    load_un[2] -= judged.weight_un;
    Some(load_un)
}

/// The part of a task: the one that its steps name, or the only one of its scene. `None` after an error, `Some(None)`
/// for a part with a fault.
fn the_part(
    hand_scene: &HandScene,
    parts: &Parts,
    scene: Option<Span>,
    site: &TaskSite,
    sink: &mut Sink,
) -> Option<Option<JudgedPart>> {
    let mut first: Option<(&str, Span)> = None;
    for call in calls(parts) {
        let Some(argument) = &call.object else { continue };
        let Value::Object(object) = &argument.value else { return None };
        if !hand_scene.parts.contains_key(&object.name) {
            let known = hand_scene.parts.keys().map(String::as_str);
            let near = nearest(&object.name, known);
            let wrong = errors::unknown_object(argument.span, object, near, scene);
            sink.push(errors::given_at(wrong, argument));
            return None;
        }
        match first {
            Some((name, span)) if name != object.name => {
                sink.push(errors::two_parts((name, span), (&object.name, argument.span)));
                return None;
            }
            Some(_) => {}
            None => first = Some((&object.name, argument.span)),
        }
    }
    let name = match (first, hand_scene.parts.len()) {
        (Some((name, _)), _) => name,
        (None, 1) => hand_scene.parts.keys().next()?,
        (None, 0) => {
            sink.push(errors::no_part(scene.unwrap_or(site.device.span)));
            return None;
        }
        (None, _) => {
            let known: Vec<&str> = hand_scene.parts.keys().map(String::as_str).collect();
            sink.push(errors::which_part(parts.steps.first().map_or(site.device.span, |step| step.span), &known));
            return None;
        }
    };
    hand_scene.parts.get(name).map(|part| part.judged.clone())
}

fn calls(parts: &Parts) -> impl Iterator<Item = &Call> {
    parts.steps.iter().filter_map(|step| match &step.action {
        tasks::VocabularyAction::Verb(call) => Some(call),
        tasks::VocabularyAction::Together(_) | tasks::VocabularyAction::Assay(_) | tasks::VocabularyAction::Wait(_) => {
            None
        }
    })
}

/// For each step, the planes in which the contact numbers of a grasp there may count: that of the next turn, or else
/// that of the last one.
fn grasp_planes(steps: &[tasks::VocabularyStep], part: &HandPart) -> Vec<Vec<Plane>> {
    let turned: Vec<Option<Vec<Plane>>> = steps.iter().map(|step| planes_of(step, part)).collect();
    (0..steps.len())
        .map(|index| {
            let next = turned[index..].iter().find_map(Option::as_ref);
            let known = next.or_else(|| turned[..index].iter().rev().find_map(Option::as_ref));
            known.cloned().unwrap_or_else(|| vec![Plane::Xy])
        })
        .collect()
}

/// The planes that a step may begin to turn in; `None` if it turns nothing.
fn planes_of(step: &tasks::VocabularyStep, part: &HandPart) -> Option<Vec<Plane>> {
    let tasks::VocabularyAction::Verb(call) = &step.action else { return None };
    let any = || Plane::ALL.into_iter().filter(|plane| part.section(*plane).is_some()).collect();
    match FingersVerb::find(call.verb.name)? {
        FingersVerb::Rotate => Some(axis(call).and_then(TurnAxis::plane).map_or_else(any, |plane| vec![plane])),
        FingersVerb::Orient => Some(any()),
        FingersVerb::Grasp | FingersVerb::Translate | FingersVerb::Release => None,
    }
}

/// The axis about which a step turns the part.
fn axis(call: &Call) -> Option<TurnAxis> {
    match &phrase(call, "about")?.value {
        Value::Text(axis) => TurnAxis::find(axis),
        _ => None,
    }
}

fn phrase<'c>(call: &'c Call, preposition: &str) -> Option<&'c Argument> {
    call.phrases.iter().find(|(name, _)| *name == preposition).map(|(_, argument)| argument)
}

/// Judges the steps of one task.
struct HandStepJudge<'a> {
    facts: &'a FingersFacts,
    part: &'a HandPart,
    precision_rad: f64,
    is_loaded: bool,
    /// All turns of the task about z and y, in radians.
    turns: Vec<(Plane, f64)>,
    sink: &'a mut Sink,
}

/// Whether a step may turn the part in the plane xz.
fn leaves_plane_xy(step: &tasks::VocabularyStep) -> bool {
    let tasks::VocabularyAction::Verb(call) = &step.action else { return false };
    match FingersVerb::find(call.verb.name) {
        Some(FingersVerb::Rotate) => axis(call).and_then(TurnAxis::plane) != Some(Plane::Xy),
        Some(FingersVerb::Orient) => true,
        Some(FingersVerb::Grasp | FingersVerb::Translate | FingersVerb::Release) | None => false,
    }
}

/// The turns that steps make by an angle about z or y, in radians.
fn turns(steps: &[tasks::VocabularyStep]) -> Vec<(Plane, f64)> {
    let turn = |step: &tasks::VocabularyStep| {
        let tasks::VocabularyAction::Verb(call) = &step.action else { return None };
        let Value::Quantity(angle) = &phrase(call, "by")?.value else { return None };
        Some((axis(call)?.plane()?, angle.si))
    };
    steps.iter().filter_map(turn).collect()
}

impl HandStepJudge<'_> {
    fn step(&mut self, step: &tasks::VocabularyStep, planes: &[Plane]) -> Option<FingersStep> {
        let action = match &step.action {
            tasks::VocabularyAction::Wait(duration_ns) => FingersAction::Wait(*duration_ns),
            tasks::VocabularyAction::Verb(call) => self.call(call, planes)?,
            // The kind has no simultaneous goals, already reported.
            tasks::VocabularyAction::Together(_) | tasks::VocabularyAction::Assay(_) => return None,
        };
        Some(FingersStep { action, span: step.span })
    }

    fn call(&mut self, call: &Call, planes: &[Plane]) -> Option<FingersAction> {
        match FingersVerb::find(call.verb.name)? {
            FingersVerb::Grasp => match phrase(call, "at") {
                None => Some(FingersAction::Grasp(None)),
                Some(argument) => self.grasp(argument, planes).map(|contacts| FingersAction::Grasp(Some(contacts))),
            },
            FingersVerb::Rotate => self.rotate(call),
            FingersVerb::Orient => self.orient(phrase(call, "to")?),
            FingersVerb::Translate => translate(phrase(call, "by")?),
            FingersVerb::Release => self.release(call.span),
        }
    }

    fn rotate(&mut self, call: &Call) -> Option<FingersAction> {
        let (by, about) = (phrase(call, "by")?, phrase(call, "about")?);
        let (Value::Quantity(angle), Some(axis)) = (&by.value, axis(call)) else { return None };
        let asked_rad = angle.si;
        if asked_rad.abs() > errors::MOST_RAD {
            return self.wrong(errors::turn_too_far(by.span, asked_rad), by);
        }
        let Some(plane) = axis.plane() else { return self.about_x(asked_rad, about.span) };
        let Some(section) = self.part.section(plane) else { return self.flat(about.span, "not about y") };
        let most = i32::try_from(self.facts.steps_per_turn).ok()?;
        let steps = ((asked_rad / section.step_rad).round() as i32).clamp(-most, most);
        if (f64::from(steps) * section.step_rad - asked_rad).abs() > self.precision_rad * (1.0 + 1e-9) {
            let demand = step::TurnDemand { precision_rad: self.precision_rad, is_loaded: self.is_loaded };
            let mend =
                step::nearest_fitting_step(self.part, self.facts, &step::WantedTurn::Turns(&self.turns), &demand);
            let wrong = errors::no_whole_steps(by.span, asked_rad, section.step_rad, self.precision_rad, mend);
            return self.wrong(wrong, by);
        }
        Some(FingersAction::Rotate { plane, steps, angle_rad: asked_rad })
    }

    fn about_x(&mut self, asked_rad: f64, about: Span) -> Option<FingersAction> {
        if self.part.xz.is_none() {
            return self.flat(about, "not about x");
        }
        Some(super::walk::relative(orientation::about_x(asked_rad)))
    }

    fn orient(&mut self, to: &Argument) -> Option<FingersAction> {
        let Value::Orientation(goal) = &to.value else { return None };
        Some(super::walk::absolute(*goal))
    }

    fn release(&mut self, span: Span) -> Option<FingersAction> {
        let needed_un = self.facts.removal_safety * self.facts.sticking_un();
        if self.facts.support_un < needed_un * (1.0 - 1e-12) {
            self.sink.push(errors::sticks(
                span,
                needed_un,
                self.facts.support_un,
                self.facts.pull_off_un,
                self.facts.removal_safety,
            ));
            return None;
        }
        Some(FingersAction::Release)
    }

    fn flat(&mut self, span: Span, what: &str) -> Option<FingersAction> {
        self.sink.push(errors::flat_part(span, &self.part.name, what, self.part.span));
        None
    }

    fn wrong<T>(&mut self, diagnostic: Diagnostic, argument: &Argument) -> Option<T> {
        self.sink.push(errors::given_at(diagnostic, argument));
        None
    }

    /// A contact for each finger, checked in each of the planes in which its numbers may count; `None` after an error.
    fn grasp(&mut self, argument: &Argument, planes: &[Plane]) -> Option<Vec<u32>> {
        let fingers = self.facts.fingers as usize;
        let numbers = numbers(&argument.value)?;
        if numbers.len() > fingers {
            let what = format!("a grasp of {} fingers, but the hand has {fingers}", numbers.len());
            return self.wrong(
                errors::bad_grasp(argument.span, what, "write a number for each finger, 0 for a free one".to_owned()),
                argument,
            );
        }
        let mut contacts = Vec::with_capacity(fingers);
        for number in numbers {
            let most =
                planes.iter().filter_map(|plane| self.part.section(*plane)).map(|section| section.contacts).min()?;
            let whole = whole(number).and_then(|number| u32::try_from(number).ok()).filter(|number| *number <= most);
            let Some(contact) = whole else {
                let plane = planes.first()?.name();
                let what = format!(
                    "contact {number} does not exist: the contacts of `{}` in the plane {plane} are 1 to {most}",
                    self.part.name
                );
                let help = "write one of these numbers, or 0 for a free finger".to_owned();
                return self.wrong(errors::bad_grasp(argument.span, what, help), argument);
            };
            contacts.push(contact);
        }
        contacts.resize(fingers, 0);
        let wrong = self.count_fault(&contacts, argument.span);
        let wrong = wrong.or_else(|| planes.iter().find_map(|plane| self.tips_fault(&contacts, *plane, argument.span)));
        match wrong {
            Some(wrong) => self.wrong(wrong, argument),
            None => Some(contacts),
        }
    }

    fn count_fault(&self, contacts: &[u32], span: Span) -> Option<Diagnostic> {
        let held: Vec<u32> = contacts.iter().copied().filter(|contact| *contact > 0).collect();
        if !(2..=MAX_HOLDING).contains(&held.len()) {
            let what = format!("a grasp by {}; two or three must hold a part", count(held.len(), "finger"));
            return Some(errors::bad_grasp(span, what, "write 0 for the other fingers, as `(1, 38, 0)`".to_owned()));
        }
        let twice = held.iter().enumerate().find(|(index, contact)| held[..*index].contains(contact));
        twice.map(|(_, contact)| {
            let what = format!("two fingers are at contact {contact}");
            errors::bad_grasp(span, what, "give each finger a contact of its own".to_owned())
        })
    }

    /// Diagnostic for tips that are too near to one another, or that cut into the part away from their contacts.
    fn tips_fault(&self, contacts: &[u32], plane: Plane, span: Span) -> Option<Diagnostic> {
        let section: &Section = self.part.section(plane)?;
        let curve = Curve::of(&section.outline).ok()?;
        let tip_um = self.facts.tip_radius_um;
        let held = contacts.iter().copied().filter(|contact| *contact > 0);
        let tips: Vec<(u32, [f64; 2])> =
            held.map(|contact| (contact, part::tip_um_at(section, &curve, contact, tip_um).0)).collect();
        let cuts = tips.iter().find_map(|(contact, centre)| {
            let free_um = curve.nearest(*centre).distance_um;
            (free_um < tip_um - self.facts.tolerance_um).then_some((*contact, tip_um - free_um))
        });
        if let Some((contact, deep_um)) = cuts {
            let what = format!(
                "a tip at contact {contact} would cut {} into `{}` elsewhere",
                errors::length(deep_um),
                self.part.name
            );
            return Some(errors::bad_grasp(span, what, "use a contact outside the hollow".to_owned()));
        }
        let least_um = 2.0 * tip_um + self.facts.clearance_um;
        tips.iter().enumerate().find_map(|(index, (contact, [x, y]))| {
            tips[..index].iter().find_map(|(other, [a, b])| {
                let apart_um = (x - a).hypotenuse(y - b);
                let is_near = apart_um < least_um * (1.0 - 1e-9);
                is_near.then(|| errors::tips_too_near(span, *other, *contact, apart_um, least_um))
            })
        })
    }
}

/// The numbers of a grasp.
fn numbers(value: &Value) -> Option<Vec<crate::quantity::Quantity>> {
    match value {
        Value::Point(point) => Some(point.clone()),
        Value::List(list) => list
            .iter()
            .map(|element| match &element.value {
                Value::Quantity(number) => Some(*number),
                _ => None,
            })
            .collect(),
        _ => None,
    }
}

fn translate(by: &Argument) -> Option<FingersAction> {
    let Value::Point(point) = &by.value else { return None };
    let um = |axis: usize| point.get(axis).map_or(0.0, |length| length.in_unit("um"));
    Some(FingersAction::Translate([um(0), um(1), um(2)]))
}
