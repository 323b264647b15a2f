//! The catalogue of rules: for each one its code and what it demands.

use crate::diagnostic::Code;

macro_rules! rules {
    ($($rule:ident $code:ident $says:literal)*) => {
        /// The rules of a schedule: each has one function that checks it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Rule { $(#[doc = $says] $rule,)* }

        impl Rule {
            /// Every rule, in the order in which violations of one instant are listed.
            pub const ALL: &'static [Rule] = &[$(Rule::$rule),*];

            /// Code of the diagnostic for a violation.
            pub fn code(self) -> Code {
                match self { $(Rule::$rule => Code::$code,)* }
            }

            /// The demand of the rule, as a sentence without its full stop.
            pub fn says(self) -> &'static str {
                match self { $(Rule::$rule => $says,)* }
            }
        }
    };
}

rules! {
    Reference E0701 "Every index refers to an entry"
    Number E0702 "Numbers are finite, durations are above zero, and instants are within the clock"
    Order E0703 "Actuations are sorted by start, then by channel"
    Overlap E0704 "A channel has one value at a time"
    Channel E0705 "Channels are those of the devices, each listed once"
    Wire E0706 "Wires and instruments are those of the program and can give every value"
    Interval E0707 "An actuation lies within its step, on a channel of its device"
    Plan E0708 "Each job has one plan, with the job's task, device and kind"
    Step E0709 "The steps of a run are those of its task, without gaps"
    Timeline E0710 "Runs begin and the schedule ends at the claimed times"
    Busy E0711 "A device is in one run at a time"
    Wait E0712 "A wait lasts as long as claimed, and nothing moves during it"
    Figure E0713 "The recorded planner, objective and figures are those of the claims and of the replay"
    State E0714 "The recorded states are those of the replay"
    Requirement E0715 "Conditions on the outcome hold"
    Start E0716 "A run starts where its device is, and at the task's `start at`"
    Goal E0717 "Stops are reached, in order where the task gives one"
    Place E0718 "The cell used for a place is the nearest one, within the precision"
    Pulse E0721 "A pulse has the voltage and the duration of the device"
    Rest E0722 "No module is switched before the rest after a pulse is over"
    Idle E0723 "No time is lost between the pulses of a step, after the last arrival of parts, or between the levels of a bed"
    Switch E0724 "A pulse changes the state of its module"
    Opposed E0725 "No module is set and reset at the same time"
    Simultaneous E0726 "Several modules are switched at once only where that is allowed"
    Sweep E0727 "The path of the tip is clear"
    Mixture E0728 "Every path that modules switched at once can take is clear"
    Potential E0729 "An electrode is on at the potential of the device"
    Disabled E0773 "An electrode that does not work stays off"
    Beat E0730 "Electrodes are switched only between the steps of the board"
    Pull E0731 "An electrode pulls no part but the one that it moves"
    Unused E0732 "An electrode that is on pulls a part"
    Hold E0733 "The electrode under a resting droplet is on if the device holds its parts, and off otherwise"
    Touch E0734 "Parts keep the separation of the device"
    Clearance E0735 "Parts keep the clearance of the device from obstacles"
    Bystander E0736 "A part without a goal stays, or returns"
    Trace E0775 "A droplet never enters an electrode with a trace that it must avoid"
    Zone E0777 "A part that is heated, read or held stays within its zone for that time, and is alone there while it is read"
    Reservoir E0778 "Reservoir pads and the outlet electrode follow the dispensing frames; pads are off at all other times"
    Lag E0785 "An operation begins within the delay that the program allows after the operations before it"
    Broadcast E0786 "The electrodes of a shared channel act on no droplet except at its own destination"
    Choice E0787 "An operation takes place at one of the places that the program names for it"
    Level E0737 "A control cycle visits steady levels within the range of the source, each for at least the dwell time"
    Train E0738 "Strokes are those of the device, and follow a control cycle"
    Arm E0739 "Every arm is certainly up or certainly down, and no stroke moves it"
    Control E0744 "The arms are in a control state of the claims"
    Apply E0745 "A control state is applied in one leg for as long as claimed"
    Graze E0746 "A robot that moves keeps its clearance from obstacles"
    Meet E0747 "Two robots keep their clearance while either of them moves"
    Orbit E0748 "Obstacles, robots and other orbits keep clear of an orbit"
    Dock E0749 "Robots of an assembly end docked"
    Twist E0761 "The arms of docked robots are up while strokes are driven"
    Swing E0750 "A swing lasts a whole number of periods of two levels, on a channel that may swing"
    Axis E0751 "An axis of a hand has one value at every instant of a run, and never jumps"
    Range E0752 "A stage stays within its range"
    Gap E0753 "A holding tip always touches the part"
    Slip E0754 "A holding tip rolls without slip"
    Contact E0755 "Fingers arrive and leave at contacts, and never leave the part to a single finger"
    Equilibrium E0756 "The holding fingers are in equilibrium"
    Removal E0757 "The remaining fingers resist the pull of one that leaves"
    Support E0758 "The support holds the part as the last fingers leave"
    Pierce E0759 "No tip penetrates the part, and free tips keep their clearance from it"
    Apart E0760 "Tips keep clear of one another"
    Encounter E0770 "The tips of robots that share a scene never touch"
    Output E0774 "An auxiliary output has the value that the steps set, and rests at all other times"
    Held E0776 "While a program waits for an input or a person, no channel changes and nothing else runs"
    SourceMap E0771 "The text and the position of a step are those in the program's file"
    Speed E0762 "No tip of a hand moves faster than the device allows there"
    Exchange E0763 "A recording is an exchange of measurements and commands for the steps of the task"
    Path E0764 "A robot is measured where the recorded commands bring it"
    GivenUp E0765 "A controlled task was completed"
}

impl Rule {
    /// Whether the rule is about the schedule's own record, as opposed to what happens on the devices.
    pub fn is_of_the_record(self) -> bool {
        matches!(self, Rule::Figure | Rule::State | Rule::Requirement)
    }
}
