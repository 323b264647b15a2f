//! The rules, and the messages of their violations.

use crate::diagnostic::{Code, Diagnostic, Label};
use crate::source::Span;

/// The rules of a schedule: each has one function that checks it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// Every index names something.
    Reference,
    /// Numbers are finite, durations above zero, instants within the clock.
    Number,
    /// Actuations stand by start, then channel.
    Order,
    /// A channel has one value at a time.
    Overlap,
    /// Channels are those of the devices, each once.
    Channel,
    /// Wires are those of the claims.
    Wire,
    /// An actuation lies within its step, on its device.
    Interval,
    /// There is one plan for each job, of its task, device and kind.
    Plan,
    /// The steps of a run are those of its task, without a gap.
    Step,
    /// Runs begin and the schedule ends at the claimed times.
    Timeline,
    /// A device is in one run at a time.
    Busy,
    /// A wait lasts as long as claimed, and nothing moves in it.
    Wait,
    /// The recorded planner, objective and figures are those of the claims and of the replay.
    Figure,
    /// The recorded states are those of the replay.
    State,
    /// Conditions on the outcome hold.
    Requirement,
    /// A device starts at its present place and at the task's `start at`.
    Start,
    /// Stops are reached, in their order where there is one.
    Goal,
    /// The cell taken for a place is its nearest, within the precision.
    Place,
    /// A pulse has the voltage and the duration of the device.
    Pulse,
    /// No module is switched before the rest after a pulse is over.
    Rest,
    /// No time is lost between the pulses of a step, or after the last arrival of parts, or between the levels of a bed.
    Idle,
    /// A pulse changes the state of its module.
    Switch,
    /// A module is not set and reset at once.
    Opposed,
    /// Several modules are switched at once only where that is allowed.
    Simultaneous,
    /// The path of the tip is clear.
    Sweep,
    /// Every path that modules switched at once can take is clear.
    Mixture,
    /// An electrode is on at the potential of the device.
    Potential,
    /// An electrode that does not work stays off.
    Disabled,
    /// Electrodes are switched only between the steps of the board.
    Beat,
    /// An electrode pulls no part but the one that it moves.
    Pull,
    /// An electrode that is on pulls a part.
    Unused,
    /// The electrode under a resting droplet is on where the device holds its parts, and only there.
    Hold,
    /// Parts keep the separation of the device.
    Touch,
    /// Parts keep the clearance of the device from obstacles.
    Clearance,
    /// A part without a goal stays, or comes back.
    Bystander,
    /// A droplet comes onto no electrode with traces that are avoided in it.
    Trace,
    /// A control cycle visits steady levels that the source gives, each for the dwell time.
    Level,
    /// Strokes are those of the device, after a control cycle.
    Train,
    /// An arm is up or down for certain, and no stroke moves it.
    Arm,
    /// Arms stand as in a control state of the claims.
    Control,
    /// A control state is applied in one leg for as long as claimed.
    Apply,
    /// A robot that moves keeps its clearance from obstacles.
    Graze,
    /// Two robots of which one moves keep their clearance.
    Meet,
    /// Obstacles, robots and orbits keep clear of an orbit.
    Orbit,
    /// Robots of an assembly end docked.
    Dock,
    /// The arms of docked robots are up while strokes are driven.
    Twist,
    /// A swing has whole periods of two levels, on a channel that may swing.
    Swing,
    /// An axis of a hand has one value at every instant of a run, and never jumps.
    Axis,
    /// A stage stays within its range.
    Range,
    /// A tip that holds touches the part all the time.
    Gap,
    /// A tip that holds rolls without slip.
    Slip,
    /// Fingers come and leave at contacts, and leave no part to one finger.
    Contact,
    /// Fingers that hold are in equilibrium.
    Equilibrium,
    /// Fingers that stay resist the pull of one that leaves.
    Removal,
    /// The support of a part holds it as the last fingers leave.
    Support,
    /// No tip is in the part, and no free one too near it.
    Pierce,
    /// Tips keep clear of one another.
    Apart,
    /// The tips of robots that share a scene never touch.
    Encounter,
    /// An auxiliary output is high when the steps say so, and at no other time.
    Output,
    /// The words and the place of a step are those of the program's file.
    SourceMap,
    /// No tip of a hand moves faster than the device allows there.
    Speed,
    /// A recording is an exchange of measurements and commands, of the task's steps.
    Exchange,
    /// A robot is measured where the recorded commands bring it.
    Path,
    /// A controlled task was brought to its end.
    GivenUp,
}

impl Rule {
    /// The code under which a violation is shown and explained.
    pub fn code(self) -> Code {
        match self {
            Rule::Reference => Code::E0701,
            Rule::Number => Code::E0702,
            Rule::Order => Code::E0703,
            Rule::Overlap => Code::E0704,
            Rule::Channel => Code::E0705,
            Rule::Wire => Code::E0706,
            Rule::Interval => Code::E0707,
            Rule::Plan => Code::E0708,
            Rule::Step => Code::E0709,
            Rule::Timeline => Code::E0710,
            Rule::Busy => Code::E0711,
            Rule::Wait => Code::E0712,
            Rule::Figure => Code::E0713,
            Rule::State => Code::E0714,
            Rule::Requirement => Code::E0715,
            Rule::Start => Code::E0716,
            Rule::Goal => Code::E0717,
            Rule::Place => Code::E0718,
            Rule::Pulse => Code::E0721,
            Rule::Rest => Code::E0722,
            Rule::Idle => Code::E0723,
            Rule::Switch => Code::E0724,
            Rule::Opposed => Code::E0725,
            Rule::Simultaneous => Code::E0726,
            Rule::Sweep => Code::E0727,
            Rule::Mixture => Code::E0728,
            Rule::Potential => Code::E0729,
            Rule::Disabled => Code::E0773,
            Rule::Beat => Code::E0730,
            Rule::Pull => Code::E0731,
            Rule::Unused => Code::E0732,
            Rule::Hold => Code::E0733,
            Rule::Touch => Code::E0734,
            Rule::Clearance => Code::E0735,
            Rule::Bystander => Code::E0736,
            Rule::Trace => Code::E0775,
            Rule::Level => Code::E0737,
            Rule::Train => Code::E0738,
            Rule::Arm => Code::E0739,
            Rule::Control => Code::E0744,
            Rule::Apply => Code::E0745,
            Rule::Graze => Code::E0746,
            Rule::Meet => Code::E0747,
            Rule::Orbit => Code::E0748,
            Rule::Dock => Code::E0749,
            Rule::Twist => Code::E0761,
            Rule::Swing => Code::E0750,
            Rule::Axis => Code::E0751,
            Rule::Range => Code::E0752,
            Rule::Gap => Code::E0753,
            Rule::Slip => Code::E0754,
            Rule::Contact => Code::E0755,
            Rule::Equilibrium => Code::E0756,
            Rule::Removal => Code::E0757,
            Rule::Support => Code::E0758,
            Rule::Pierce => Code::E0759,
            Rule::Apart => Code::E0760,
            Rule::Encounter => Code::E0770,
            Rule::Output => Code::E0774,
            Rule::SourceMap => Code::E0771,
            Rule::Speed => Code::E0762,
            Rule::Exchange => Code::E0763,
            Rule::Path => Code::E0764,
            Rule::GivenUp => Code::E0765,
        }
    }
}

impl Rule {
    /// Whether it is about what the schedule says of itself, and not about what takes place.
    pub fn is_of_the_record(self) -> bool {
        matches!(self, Rule::Figure | Rule::State | Rule::Requirement)
    }
}

/// One breach of a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub rule: Rule,
    /// When it happens, from the schedule's beginning.
    pub time_ns: u64,
    pub title: String,
    /// Index of the schedule's steps.
    pub step: Option<u32>,
    /// Places in the source that the claims know; without them where the claims were read without spans.
    pub labels: Vec<Label>,
    /// The fix, where it is in the user's hands.
    pub help: Option<String>,
}

/// Closing note where the program is not to blame.
const NOT_THE_PROGRAM: &str = "a schedule fresh from `tweeze build` never breaks this rule, so report it as a bug with the \
     program; a log that breaks it was edited, or made for another device";

impl Violation {
    pub(super) fn new(rule: Rule, time_ns: u64, title: impl Into<String>) -> Self {
        Violation { rule, time_ns, title: title.into(), step: None, labels: Vec::new(), help: None }
    }

    #[must_use]
    pub(super) fn step(mut self, step: usize) -> Self {
        self.step = u32::try_from(step).ok();
        self
    }

    /// Adds a place, if it is known.
    #[must_use]
    pub(super) fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        if span != Span::default() {
            self.labels.push(Label { span, text: text.into() });
        }
        self
    }

    #[must_use]
    pub(super) fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

impl From<Violation> for Diagnostic {
    fn from(violation: Violation) -> Diagnostic {
        Diagnostic {
            code: violation.rule.code(),
            title: violation.title,
            labels: violation.labels,
            help: violation.help.or_else(|| Some(NOT_THE_PROGRAM.to_owned())),
            mend: Vec::new(),
        }
    }
}

/// Greatest number of violations that are kept: one is enough to refuse, and a hostile log could have millions.
pub const MAX_VIOLATIONS: usize = 100;

/// Collects violations, the first [`MAX_VIOLATIONS`] of them.
#[derive(Debug, Default)]
pub(super) struct Findings {
    list: Vec<Violation>,
}

impl Findings {
    pub fn push(&mut self, violation: Violation) {
        if self.list.len() < MAX_VIOLATIONS {
            self.list.push(violation);
        }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// By time, then rule, then the order of finding.
    pub fn sorted(mut self) -> Vec<Violation> {
        self.list.sort_by_key(|violation| (violation.time_ns, violation.rule));
        self.list
    }
}

/// A time in milliseconds to the last nanosecond: two times that differ never print the same.
pub(super) fn ms(time_ns: u64) -> String {
    let (whole, rest) = (time_ns / 1_000_000, time_ns % 1_000_000);
    match rest {
        0 => format!("{whole} ms"),
        rest => format!("{whole}.{} ms", format!("{rest:06}").trim_end_matches('0')),
    }
}
