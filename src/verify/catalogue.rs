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
    Reference E0701 "Every index names something"
    Number E0702 "Numbers are finite, durations above zero, instants within the clock"
    Order E0703 "Actuations stand by start, then channel"
    Overlap E0704 "A channel has one value at a time"
    Channel E0705 "Channels are those of the devices, each once"
    Wire E0706 "Wires are those of the claims"
    Interval E0707 "An actuation lies within its step, on its device"
    Plan E0708 "There is one plan for each job, of its task, device and kind"
    Step E0709 "The steps of a run are those of its task, without a gap"
    Timeline E0710 "Runs begin and the schedule ends at the claimed times"
    Busy E0711 "A device is in one run at a time"
    Wait E0712 "A wait lasts as long as claimed, and nothing moves in it"
    Figure E0713 "The recorded planner, objective and figures are those of the claims and of the replay"
    State E0714 "The recorded states are those of the replay"
    Requirement E0715 "Conditions on the outcome hold"
    Start E0716 "A device starts at its present place and at the task's `start at`"
    Goal E0717 "Stops are reached, in their order where there is one"
    Place E0718 "The cell taken for a place is its nearest, within the precision"
    Pulse E0721 "A pulse has the voltage and the duration of the device"
    Rest E0722 "No module is switched before the rest after a pulse is over"
    Idle E0723 "No time is lost between the pulses of a step, or after the last arrival of parts, or between the levels of a bed"
    Switch E0724 "A pulse changes the state of its module"
    Opposed E0725 "A module is not set and reset at once"
    Simultaneous E0726 "Several modules are switched at once only where that is allowed"
    Sweep E0727 "The path of the tip is clear"
    Mixture E0728 "Every path that modules switched at once can take is clear"
    Potential E0729 "An electrode is on at the potential of the device"
    Disabled E0773 "An electrode that does not work stays off"
    Beat E0730 "Electrodes are switched only between the steps of the board"
    Pull E0731 "An electrode pulls no part but the one that it moves"
    Unused E0732 "An electrode that is on pulls a part"
    Hold E0733 "The electrode under a resting droplet is on where the device holds its parts, and only there"
    Touch E0734 "Parts keep the separation of the device"
    Clearance E0735 "Parts keep the clearance of the device from obstacles"
    Bystander E0736 "A part without a goal stays, or comes back"
    Trace E0775 "A droplet comes onto no electrode with traces that are avoided in it"
    Zone E0777 "A part that is heated, read or held is within its zone all that time, and alone where it is read"
    Reservoir E0778 "Pads of a reservoir and the electrode at its outlet are on as in the frames that make a droplet, and pads at no other time"
    Lag E0785 "An operation begins no later after others than the program says"
    Broadcast E0786 "Of the electrodes that a shared channel switches on, none acts on a droplet but where that goes"
    Choice E0787 "An operation takes place at one of the places that the program names for it"
    Level E0737 "A control cycle visits steady levels that the source gives, each for the dwell time"
    Train E0738 "Strokes are those of the device, after a control cycle"
    Arm E0739 "An arm is up or down for certain, and no stroke moves it"
    Control E0744 "Arms stand as in a control state of the claims"
    Apply E0745 "A control state is applied in one leg for as long as claimed"
    Graze E0746 "A robot that moves keeps its clearance from obstacles"
    Meet E0747 "Two robots of which one moves keep their clearance"
    Orbit E0748 "Obstacles, robots and orbits keep clear of an orbit"
    Dock E0749 "Robots of an assembly end docked"
    Twist E0761 "The arms of docked robots are up while strokes are driven"
    Swing E0750 "A swing has whole periods of two levels, on a channel that may swing"
    Axis E0751 "An axis of a hand has one value at every instant of a run, and never jumps"
    Range E0752 "A stage stays within its range"
    Gap E0753 "A tip that holds touches the part all the time"
    Slip E0754 "A tip that holds rolls without slip"
    Contact E0755 "Fingers come and leave at contacts, and leave no part to one finger"
    Equilibrium E0756 "Fingers that hold are in equilibrium"
    Removal E0757 "Fingers that stay resist the pull of one that leaves"
    Support E0758 "The support of a part holds it as the last fingers leave"
    Pierce E0759 "No tip is in the part, and no free one too near it"
    Apart E0760 "Tips keep clear of one another"
    Encounter E0770 "The tips of robots that share a scene never touch"
    Output E0774 "An auxiliary output is where the steps have it, and at rest at all other times"
    Held E0776 "While a program waits for what comes nothing changes, and nothing else goes on"
    SourceMap E0771 "The words and the place of a step are those of the program's file"
    Speed E0762 "No tip of a hand moves faster than the device allows there"
    Exchange E0763 "A recording is an exchange of measurements and commands, of the task's steps"
    Path E0764 "A robot is measured where the recorded commands bring it"
    GivenUp E0765 "A controlled task was brought to its end"
}

impl Rule {
    /// Whether the rule is about the schedule's own record, as opposed to what happens on the devices.
    pub fn is_of_the_record(self) -> bool {
        matches!(self, Rule::Figure | Rule::State | Rule::Requirement)
    }
}
