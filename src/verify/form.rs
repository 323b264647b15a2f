//! First round: whether the schedule is well formed, and for these devices.
//!
//! Input: a schedule as it was read, and the claims. Promise: if nothing is found, every index is within its list, no
//! sum of a start and a duration overflows, every number is finite, and every channel belongs to a claimed device or
//! output.

use super::judge_of;
use super::rule::{Findings, Rule, Violation, ms};
use crate::claims::{Claims, Order};
use crate::device::instrument::{AuxiliarySort, Direction, Link};
use crate::schedule::{Actuation, Channel, ChannelUnit, PlanRecord, Reached, Schedule, Swing};
use std::collections::{BTreeMap, BTreeSet};

/// Tolerance for the rounding of a product of two figures of the program.
const BENCH_ROUNDING: f64 = 1.0 + 1e-12;

pub(super) fn check(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    references(schedule, findings);
    actuation_numbers(schedule, findings);
    clock_numbers(schedule, findings);
    figures(schedule, findings);
    channels(schedule, claims, findings);
    rests(schedule, claims, findings);
    wires(schedule, claims, findings);
    bench(schedule, claims, findings);
    stage_speeds(schedule, claims, findings);
    if findings.is_empty() {
        order(schedule, findings);
        overlaps(schedule, findings);
        swings(schedule, claims, findings);
    }
}

fn references(schedule: &Schedule, findings: &mut Findings) {
    findings.count_checks(Rule::Reference, 2 * schedule.actuations.len() + schedule.steps.len());
    let mut find = |what: &str, index: usize, of: &str, named: u32, known: usize, time_ns: u64| {
        if named as usize >= known {
            let title = format!("{what} {index} names {of} {named}, but there are {known}, counted from 0");
            findings.push(Violation::new(Rule::Reference, time_ns, title));
        }
    };
    for (index, actuation) in schedule.actuations.iter().enumerate() {
        find("actuation", index, "channel", actuation.channel, schedule.channels.len(), actuation.start_ns);
        find("actuation", index, "step", actuation.step, schedule.steps.len(), actuation.start_ns);
    }
    for (index, step) in schedule.steps.iter().enumerate() {
        find("step", index, "plan", step.plan, schedule.plans.len(), step.start_ns);
    }
}

fn actuation_numbers(schedule: &Schedule, findings: &mut Findings) {
    findings.count_checks(Rule::Number, schedule.actuations.len());
    for (index, actuation) in schedule.actuations.iter().enumerate() {
        let Actuation { start_ns, duration_ns, from, to, .. } = *actuation;
        let fault = if duration_ns == 0 {
            "lasts 0 ns, but must last longer".to_owned()
        } else if start_ns.checked_add(duration_ns).is_none() {
            past_the_clock(start_ns, duration_ns)
        } else if !from.is_finite() || !to.is_finite() {
            format!("goes from {from} to {to}, but both must be finite")
        } else {
            continue;
        };
        findings.push(Violation::new(Rule::Number, start_ns, format!("actuation {index} {fault}")));
    }
}

fn past_the_clock(start_ns: u64, duration_ns: u64) -> String {
    format!("starts at {start_ns} ns and lasts {duration_ns} ns, but the clock ends at {} ns", u64::MAX)
}

fn clock_numbers(schedule: &Schedule, findings: &mut Findings) {
    let steps = schedule.steps.iter().map(|step| ("step", step.start_ns, step.duration_ns)).enumerate();
    let plans = schedule.plans.iter().map(|plan| ("plan", plan.start_ns, plan.duration_ns)).enumerate();
    findings.count_checks(Rule::Number, schedule.steps.len() + schedule.plans.len());
    for (index, (what, start_ns, duration_ns)) in steps.chain(plans) {
        if start_ns.checked_add(duration_ns).is_none() {
            let title = format!("{what} {index} {}", past_the_clock(start_ns, duration_ns));
            findings.push(Violation::new(Rule::Number, start_ns, title));
        }
    }
    findings.count_checks(Rule::Number, schedule.holds.len());
    for (index, hold) in schedule.holds.iter().enumerate() {
        if hold.start_ns.checked_add(hold.terms.duration_ns).is_none() {
            let title = format!("wait {index} {}", past_the_clock(hold.start_ns, hold.terms.duration_ns));
            findings.push(Violation::new(Rule::Number, hold.start_ns, title));
        }
    }
    findings.count_checks(Rule::Number, schedule.steps.iter().map(|step| step.operations.len()).sum());
    for (index, operation) in schedule.steps.iter().flat_map(|step| &step.operations).enumerate() {
        if operation.start_ns.checked_add(operation.duration_ns).is_none() {
            let title = format!("operation {index} {}", past_the_clock(operation.start_ns, operation.duration_ns));
            findings.push(Violation::new(Rule::Number, operation.start_ns, title));
        }
    }
}

fn figures(schedule: &Schedule, findings: &mut Findings) {
    let of_plan = |plan: &PlanRecord| 2 + plan.outcomes.len() + plan.bounds.len() + plan.states.len();
    findings.count_checks(Rule::Number, schedule.steps.len() + schedule.plans.iter().map(of_plan).sum::<usize>());
    for (index, step) in schedule.steps.iter().enumerate() {
        let floats: Vec<f64> = step.reached.iter().flat_map(Reached::floats).collect();
        if !floats.iter().all(|value| value.is_finite()) {
            let title = format!("step {index} is recorded as reaching {floats:?}, but all must be finite");
            findings.push(Violation::new(Rule::Number, step.start_ns, title).step(index));
        }
    }
    for (index, plan) in schedule.plans.iter().enumerate() {
        let named = [("cost", plan.cost), ("bound", plan.bound)].into_iter();
        let outcomes = plan.outcomes.iter().chain(&plan.bounds).map(|(name, value)| (name.as_str(), *value));
        for (name, value) in named.chain(outcomes).filter(|(_, value)| !value.is_finite() || *value < 0.0) {
            let title = format!("`{name}` of plan {index} is {value}, but must be finite and 0 or above");
            findings.push(Violation::new(Rule::Number, plan.start_ns, title));
        }
        for (at, timed) in plan.states.iter().enumerate() {
            let floats = timed.state.floats();
            if !floats.iter().all(|value| value.is_finite()) {
                let title = format!("state {at} of plan {index} is {floats:?}, but all must be finite");
                findings.push(Violation::new(Rule::Number, timed.t_ns, title));
            }
        }
    }
}

/// Whether a channel belongs to an auxiliary output of the program.
pub(super) fn is_auxiliary(channel: &Channel, claims: &Claims) -> bool {
    let own = channel.name.strip_prefix(channel.device.as_str()).and_then(|name| name.strip_prefix('.'));
    claims.outputs.contains_key(&channel.device) && own == Some(AuxiliarySort::CHANNEL)
}

fn channels(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    let orders: BTreeMap<&str, &Order> = claims.jobs.iter().map(|job| (job.device.as_str(), &job.order)).collect();
    let mut met = BTreeSet::new();
    findings.count_checks(Rule::Channel, schedule.channels.len());
    for channel in &schedule.channels {
        let own = is_auxiliary(channel, claims).then_some((channel.device.as_str(), ChannelUnit::Volt));
        let fault = match own.or_else(|| owner(&channel.name, &orders)) {
            None => format!("channel `{}` belongs to no device of this program", channel.name),
            Some((device, _)) if device != channel.device => {
                format!("channel `{}` belongs to the device `{device}`, not to `{}`", channel.name, channel.device)
            }
            Some((_, unit)) if unit != channel.unit => {
                format!("channel `{}` is in {}, not in {}", channel.name, unit.symbol(), channel.unit.symbol())
            }
            Some(_) if !met.insert(channel.name.as_str()) => format!("channel `{}` is listed twice", channel.name),
            Some(_) => continue,
        };
        findings.push(Violation::new(Rule::Channel, 0, fault));
    }
}

/// The claimed device that has a channel of this name, and the channel's unit.
fn owner<'a>(name: &str, orders: &BTreeMap<&'a str, &Order>) -> Option<(&'a str, ChannelUnit)> {
    orders.iter().find_map(|(device, order)| {
        let channel = name.strip_prefix(device)?.strip_prefix('.')?;
        judge_of(order).unit(channel).map(|unit| (*device, unit))
    })
}

/// Channels of devices rest at 0 V; auxiliary outputs rest at the voltage of the program.
fn rests(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    findings.count_checks(Rule::Output, schedule.channels.len());
    for channel in &schedule.channels {
        let output = claims.outputs.get(&channel.device).filter(|_| is_auxiliary(channel, claims));
        let claimed_v = output.map_or(0.0, |output| output.rest_v);
        if channel.rest_v != claimed_v {
            let (name, recorded_v) = (&channel.name, channel.rest_v);
            let title = format!("channel `{name}` rests at {recorded_v} V, but the program has {claimed_v} V");
            findings.push(Violation::new(Rule::Output, 0, title));
        }
    }
}

fn wires(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    findings.count_checks(Rule::Wire, schedule.channels.len());
    let shown = |wire: Option<&String>| wire.map_or("none".to_owned(), |wire| format!("`{wire}`"));
    for channel in &schedule.channels {
        let (recorded, claimed) = (channel.wire.as_ref(), claims.wires.get(&channel.name));
        if recorded != claimed {
            let title = format!(
                "channel `{}` is wired to {}, but the program has {}",
                channel.name,
                shown(recorded),
                shown(claimed)
            );
            findings.push(Violation::new(Rule::Wire, 0, title));
        }
    }
}

/// The instruments are those of the program, and every value that is played is within what they can give.
fn bench(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    findings.count_checks(Rule::Wire, 1);
    if !schedule.bench.is_same(&claims.bench) {
        let title = "the instruments and their wires are not those of the program".to_owned();
        findings.push(Violation::new(Rule::Wire, 0, title));
        return;
    }
    let at_rest = schedule.channels.iter().map(|channel| (channel, 0, [channel.rest_v; 2]));
    let at_rest = at_rest.filter(|(channel, ..)| channel.rest_v != 0.0);
    let played = schedule.actuations.iter().filter_map(|actuation| {
        let levels = actuation.swing.map_or([actuation.from, actuation.to], |swing| swing.levels);
        Some((schedule.channels.get(actuation.channel as usize)?, actuation.start_ns, levels))
    });
    for (channel, time_ns, levels) in at_rest.chain(played) {
        let Some((drive, instrument)) = claims.bench.drive(&channel.name) else { continue };
        findings.count_checks(Rule::Wire, 1);
        let peak_v = instrument.facts.voltage().map_or(0.0, |output| output.peak_v);
        let is_played = |value: f64| match drive.link {
            Link::Amplifier { gain, limit_v, .. } => {
                value.abs() <= peak_v * gain.abs() * BENCH_ROUNDING
                    && limit_v.is_none_or(|limit_v| value.abs() <= limit_v)
            }
            Link::StageDriver { zero_v, scale_v_per_um } => {
                (zero_v + scale_v_per_um * value).abs() <= peak_v * BENCH_ROUNDING
            }
            Link::Switch { on_v } => value == 0.0 || value == on_v,
            Link::Axis { origin_um, direction, least_um, most_um } => {
                let own_um = match direction {
                    Direction::Forward => origin_um + value,
                    Direction::Backward => origin_um - value,
                };
                least_um <= own_um && own_um <= most_um
            }
        };
        if let Some(value) = levels.into_iter().find(|value| !is_played(*value)) {
            let (name, unit, output) = (&channel.name, channel.unit.symbol(), &drive.output);
            let title = format!(
                "`{name}` must be at {value} {unit}, which output `{output}` of `{}` cannot give",
                drive.instrument
            );
            findings.push(Violation::new(Rule::Wire, time_ns, title));
            return;
        }
    }
}

/// No stage moves faster than the speed limit of the program.
fn stage_speeds(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    for actuation in &schedule.actuations {
        let Some(channel) = schedule.channels.get(actuation.channel as usize) else { continue };
        let Some((drive, _)) = claims.bench.drive(&channel.name) else { continue };
        let Some(most) = drive.limits.speed_um_per_s else { continue };
        findings.count_checks(Rule::Wire, 1);
        let way_um = (actuation.to - actuation.from).abs();
        if way_um > most * (actuation.duration_ns as f64 / 1e9) * BENCH_ROUNDING {
            let (name, lasts) = (&channel.name, ms(actuation.duration_ns));
            let title = format!("`{name}` moves by {way_um} um in {lasts}, but its stage moves at most {most} um/s");
            findings.push(Violation::new(Rule::Wire, actuation.start_ns, title));
            return;
        }
    }
}

fn order(schedule: &Schedule, findings: &mut Findings) {
    let key = |actuation: &Actuation| (actuation.start_ns, actuation.channel);
    findings.count_checks(Rule::Order, schedule.actuations.len());
    for (index, pair) in schedule.actuations.windows(2).enumerate() {
        if key(&pair[0]) > key(&pair[1]) {
            let title = format!(
                "actuation {} starts at {} on channel {}, but comes after one at {} on channel {}",
                index + 1,
                ms(pair[1].start_ns),
                pair[1].channel,
                ms(pair[0].start_ns),
                pair[0].channel
            );
            findings.push(Violation::new(Rule::Order, pair[1].start_ns, title).step(pair[1].step as usize));
        }
    }
}

fn swings(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    let orders: BTreeMap<&str, &Order> = claims.jobs.iter().map(|job| (job.device.as_str(), &job.order)).collect();
    findings
        .count_checks(Rule::Swing, schedule.actuations.iter().filter(|actuation| actuation.swing.is_some()).count());
    for (index, actuation) in schedule.actuations.iter().enumerate() {
        let channel = &schedule.channels[actuation.channel as usize];
        let order = orders.get(channel.device.as_str());
        let Some(fault) = actuation.swing.and_then(|swing| swing_fault(actuation, swing, order.copied())) else {
            continue;
        };
        let title = format!("actuation {index} on `{}` {fault}", channel.name);
        let violation = Violation::new(Rule::Swing, actuation.start_ns, title);
        findings.push(violation.step(actuation.step as usize));
    }
}

/// The fault of a swing, if any, on a device with this order.
fn swing_fault(actuation: &Actuation, swing: Swing, order: Option<&Order>) -> Option<String> {
    let Swing { period_ns, levels: [first, second] } = swing;
    let Actuation { duration_ns, from, to, .. } = *actuation;
    if !order.is_some_and(|order| judge_of(order).swings()) {
        return Some("swings, but a channel of this kind holds its value".to_owned());
    }
    if period_ns == 0 || !period_ns.is_multiple_of(2) {
        return Some(format!("swings with a period of {period_ns} ns, but it must be even and above 0 ns"));
    }
    if !duration_ns.is_multiple_of(period_ns) {
        let (lasts, period) = (ms(duration_ns), ms(period_ns));
        return Some(format!("swings for {lasts}, which is not a whole number of periods of {period}"));
    }
    // Levels that equal two finite numbers are finite.
    let apart = from != first || to != second;
    apart.then(|| format!("swings between {first} V and {second} V, but is recorded as going from {from} V to {to} V"))
}

fn overlaps(schedule: &Schedule, findings: &mut Findings) {
    let mut by_channel: Vec<&Actuation> = schedule.actuations.iter().collect();
    by_channel.sort_by_key(|actuation| (actuation.channel, actuation.start_ns));
    findings.count_checks(Rule::Overlap, by_channel.len());
    for pair in by_channel.windows(2) {
        let (first, second) = (pair[0], pair[1]);
        if first.channel == second.channel && second.start_ns < first.end_ns() {
            let title = format!(
                "channel `{}` has a second value from {} on, but the first one lasts until {}",
                schedule.channels[first.channel as usize].name,
                ms(second.start_ns),
                ms(first.end_ns())
            );
            findings.push(Violation::new(Rule::Overlap, second.start_ns, title).step(second.step as usize));
        }
    }
}
