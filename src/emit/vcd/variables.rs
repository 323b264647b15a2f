//! The variables of a VCD file and how they represent channels.

use super::counts::{self, COUNT_UM};
use super::plain;
use crate::emit::csv::one_line;
use crate::emit::identifier;
use crate::emit::signal::{Drive, Signals};
use crate::schedule::{Channel, ChannelUnit};
use std::fmt::Write as _;

/// Representation of a channel.
#[derive(Debug, Clone, PartialEq)]
pub enum ChannelForm {
    /// A voltage that is either 0 V or this one; `None` if it is always 0 V.
    Switch(Option<f64>),
    Volts,
    /// A channel with drive trains, in four variables.
    Train,
    Counts,
}

impl ChannelForm {
    /// The narrowest form that represents a channel.
    pub fn new(signals: &Signals, channel: usize) -> ChannelForm {
        match signals.unit(channel) {
            ChannelUnit::Micrometre => ChannelForm::Counts,
            ChannelUnit::Volt if signals.has_trains(channel) => ChannelForm::Train,
            ChannelUnit::Volt => {
                let levels = signals.of(channel).iter().map(|actuation| actuation.to).chain(signals.rest_v(channel));
                let mut levels = levels.filter(|volts| *volts != 0.0);
                let first = levels.next();
                if levels.all(|volts| Some(volts) == first) { ChannelForm::Switch(first) } else { ChannelForm::Volts }
            }
        }
    }

    /// Explanation of the channel and its variables in its comment.
    fn says(&self, names: &[&str]) -> String {
        match (self, names) {
            (ChannelForm::Switch(Some(volts)), _) => format!(", 1 stands for {volts} V"),
            (ChannelForm::Switch(None), _) => ", 0 V throughout".to_owned(),
            (ChannelForm::Train, [train, first, second, period]) => format!(
                ", a drive train while {train} is 1: half of each {period} at {first}, then half at {second}, \
                 counted from the last change of the four; while it is 0, both levels are the voltage"
            ),
            (ChannelForm::Volts | ChannelForm::Train, _) => String::new(),
            (ChannelForm::Counts, _) => format!(", the nearest multiple of {COUNT_UM} um"),
        }
    }

    fn roles(&self) -> &'static [VariableRole] {
        match self {
            ChannelForm::Switch(_) => &[VariableRole::Switch],
            ChannelForm::Volts => &[VariableRole::Volts],
            ChannelForm::Train => {
                &[VariableRole::Train, VariableRole::First, VariableRole::Second, VariableRole::Period]
            }
            ChannelForm::Counts => &[VariableRole::Counts],
        }
    }
}

/// Meaning of one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableRole {
    Switch,
    Volts,
    Counts,
    Train,
    First,
    Second,
    Period,
}

impl VariableRole {
    /// Whether the value is 0 or 1.
    pub fn is_bit(self) -> bool {
        match self {
            VariableRole::Switch | VariableRole::Train => true,
            VariableRole::Volts
            | VariableRole::Counts
            | VariableRole::First
            | VariableRole::Second
            | VariableRole::Period => false,
        }
    }

    fn suffix(self) -> &'static str {
        match self {
            VariableRole::Switch | VariableRole::Volts | VariableRole::Counts => "",
            VariableRole::Train => "_train",
            VariableRole::First => "_first",
            VariableRole::Second => "_second",
            VariableRole::Period => "_period_ns",
        }
    }
}

/// A variable, with its second name in the scope of wires.
#[derive(Debug)]
pub struct Variable {
    pub channel: usize,
    pub role: VariableRole,
    pub name: String,
    wire: Option<String>,
    code: String,
    /// Same as `code` for numbers. Bits have a separate one, because sigrok up to 0.5.2 changes only the first variable
    /// of a code.
    wire_code: String,
}

/// The variables of all channels, in channel order.
pub fn all(signals: &Signals, forms: &[ChannelForm]) -> Vec<Variable> {
    let channels = &signals.schedule.channels;
    let roles =
        forms.iter().enumerate().flat_map(|(channel, form)| form.roles().iter().map(move |role| (channel, *role)));
    let roles: Vec<(usize, VariableRole)> = roles.collect();
    let named = |name: &str, role: VariableRole| format!("{}{}", plain(name), role.suffix());
    let names: Vec<String> = roles.iter().map(|(channel, role)| named(&channels[*channel].name, *role)).collect();
    let wired = |(channel, role): &(usize, VariableRole)| Some(named(channels[*channel].wire.as_deref()?, *role));
    let wires: Vec<Option<String>> = roles.iter().map(wired).collect();
    let names = identifier::distinct_by(names.iter().map(String::as_str), str::to_owned);
    let distinct = identifier::distinct_by(wires.iter().flatten().map(String::as_str), str::to_owned);
    let mut distinct = distinct.into_iter();
    let wires = wires.iter().map(|wire| wire.as_ref().and_then(|_| distinct.next()));
    let count = roles.len();
    let named = roles.into_iter().zip(names).zip(wires).enumerate();
    named
        .map(|(index, (((channel, role), name), wire))| {
            let wire_code = if role.is_bit() { code(count + index) } else { code(index) };
            Variable { channel, role, name, wire, code: code(index), wire_code }
        })
        .collect()
}

/// The comment of a channel, which explains its variables.
pub fn comment(channel: &Channel, form: &ChannelForm, variables: &[Variable]) -> String {
    let names: Vec<&str> = variables.iter().map(|variable| variable.name.as_str()).collect();
    let first = names.first().copied().unwrap_or_default();
    let subject = first.strip_suffix(VariableRole::Train.suffix()).filter(|_| names.len() > 1).unwrap_or(first);
    let [name, wire] =
        [&channel.name, channel.wire.as_deref().unwrap_or("none")].map(|text| one_line(text).replace('$', "_"));
    let unit = channel.unit.symbol();
    format!("$comment {subject} is {name} [{unit}]{}, wire: {wire} $end", form.says(&names))
}

impl Variable {
    /// Its declaration line.
    pub fn declaration(&self) -> String {
        self.declared(&self.name, &self.code)
    }

    /// Its declaration line in the scope of wires, if its channel is wired.
    pub fn wire_declaration(&self) -> Option<String> {
        self.wire.as_ref().map(|wire| self.declared(wire, &self.wire_code))
    }

    fn declared(&self, name: &str, code: &str) -> String {
        let kind = if self.role.is_bit() { "wire 1" } else { "real 64" };
        format!("$var {kind} {code} {name} $end\n")
    }

    /// Its value at an instant; at a jump, the new one.
    pub fn value(&self, signals: &Signals, t_ns: u64) -> f64 {
        let is_one = |one: bool| if one { 1.0 } else { 0.0 };
        let Drive { levels: [first, second], period_ns, .. } = signals.drive(self.channel, t_ns);
        match self.role {
            VariableRole::Switch => is_one(first != 0.0),
            VariableRole::Volts | VariableRole::First => first,
            VariableRole::Second => second,
            VariableRole::Train => is_one(period_ns > 0),
            VariableRole::Period => period_ns as f64,
            VariableRole::Counts => counts::counted(first),
        }
    }

    /// Appends the lines of a change.
    pub fn write(&self, text: &mut String, value: f64) {
        let Variable { code, wire_code, .. } = self;
        if !self.role.is_bit() {
            let _ = writeln!(text, "r{value} {code}");
            return;
        }
        let _ = writeln!(text, "{value}{code}");
        if self.wire.is_some() {
            let _ = writeln!(text, "{value}{wire_code}");
        }
    }
}

/// The short code of a variable; VCD allows printable characters, here only letters, which every reader accepts.
fn code(mut index: usize) -> String {
    let mut code = String::new();
    loop {
        code.push(char::from(b'a' + (index % 26) as u8));
        index /= 26;
        if index == 0 {
            return code;
        }
    }
}
