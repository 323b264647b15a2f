//! Table of codes, one row each; a code is never reused with another meaning.
//!
//! `E01xx` syntax, `02` names, `03` units and values, `04` devices, `05` scenes and tasks, `06` planning, `07`
//! verification, `08` files and formats; warnings `W…` share the numbers. Each row has its page in `explain/`.

use serde::{Serialize, Serializer};
use std::fmt;

/// Severity of a diagnostic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    Error,
    Warning,
}

macro_rules! ledger {
    ($($code:ident $summary:literal)*) => {
        /// The code of a diagnostic.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code { $(#[doc = $summary] $code,)* }

        impl Code {
            /// Every code, in the order of the table.
            pub const ALL: &'static [Code] = &[$(Code::$code),*];

            /// The code as it is printed.
            pub fn name(self) -> &'static str {
                match self { $(Code::$code => stringify!($code),)* }
            }

            /// Its subject, in a few words.
            pub fn summary(self) -> &'static str {
                match self { $(Code::$code => $summary,)* }
            }

            /// The page that `tweeze explain` shows, as Markdown.
            pub fn page(self) -> &'static str {
                match self { $(Code::$code => include_str!(concat!("explain/", stringify!($code), ".md")),)* }
            }
        }
    };
}

ledger! {
    E0101 "something where an item, a step or a field was expected"
    E0102 "a value is missing"
    E0103 "two entries on one line"
    E0104 "a semicolon"
    E0105 "a `{` on a line of its own"
    E0106 "a line begins with an operator"
    E0107 "a line begins with a preposition"
    E0108 "a space between a name and its bracket"
    E0109 "a doc comment that documents nothing"
    E0110 "a name that is reserved, missing or invalid"
    E0111 "a declaration that begins with an unknown word"
    E0112 "a closing bracket that closes nothing"
    E0113 "a brace that is not closed"
    E0114 "a bracket that is not closed"
    E0115 "a string that does not end"
    E0116 "a malformed number"
    E0117 "a table row with too few or too many cells"
    E0118 "a character that is not part of the language"
    E0119 "a wrong sign between a name and its value"
    E0120 "brackets or blocks nested too deeply"
    E0121 "too many operators in one expression"
    E0122 "a word from another language"
    E0123 "a declaration inside a block"
    E0124 "the head of a declaration is incomplete"
    E0125 "a comment in the style of another language"
    E0126 "no value in the braces of a string"
    E0127 "a place with too many coordinates"
    E0128 "a line of a table that is not a row"
    E0129 "a name that is too long"
    W0101 "a comment that may be meant as a division"
    E0201 "no such name"
    E0202 "a name declared twice"
    E0203 "a name that the language reserves"
    E0204 "a used file that cannot be read"
    E0205 "files that use each other in a cycle"
    E0206 "a name of the wrong sort"
    E0207 "a name defined in terms of itself"
    E0208 "no such verb"
    E0209 "no such field"
    E0210 "no such noun"
    E0211 "no such part in the scene"
    W0201 "a name that is never used"
    W0202 "a used file that is never used"
    E0301 "a quantity of the wrong dimension"
    E0302 "an operator between values that do not fit together"
    E0303 "no such unit"
    E0304 "a value of the wrong sort"
    E0305 "a number that cannot be represented"
    E0306 "an invalid index"
    E0307 "a function with wrong arguments"
    E0308 "too many repetitions"
    E0309 "an invalid `--set`"
    E0310 "a point with mixed coordinates"
    E0311 "not one of the words allowed here"
    E0312 "a table that does not have its columns"
    E0313 "too much generated text"
    E0314 "too much computation"
    E0401 "missing fields"
    E0402 "a field given twice"
    E0403 "a field out of its range"
    E0404 "a time that the clock cannot represent"
    E0405 "a workspace too large to plan in"
    E0406 "no such channel"
    E0407 "a wire used twice"
    E0408 "a device wired twice"
    E0409 "a radius without known forces"
    E0410 "electrodes too near or too far from each other"
    E0411 "a potential that moves no part"
    E0412 "a step too short for a part to come to rest"
    E0413 "a part that no board can carry"
    E0414 "a separation at which parts touch or are pulled"
    E0415 "a board too small for a part"
    E0416 "too many control states to plan with"
    E0417 "two rows for one robot"
    E0418 "a transition voltage that the source cannot use"
    E0419 "a drive level that moves arms"
    E0420 "robots with nested gaps"
    E0421 "robots that no voltage distinguishes"
    E0422 "a control state that no voltages set"
    E0423 "an invalid docking or fine-motion parameter"
    E0425 "a rotation step that does not divide a full turn"
    E0426 "no such output of an instrument"
    E0427 "a wire that does not fit its instrument"
    E0428 "instruments that do not start together"
    E0429 "a map of electrodes that does not fit its board"
    E0430 "a file that does not describe a board"
    W0301 "a loop that repeats nothing"
    W0401 "a lattice finer than the robot's repeatability"
    W0402 "separations that are not safe"
    W0403 "a control state with little slack"
    W0404 "some error bounds without the others"
    W0405 "electrodes of a file that are left out"
    E0501 "a target outside the workspace"
    E0502 "a target on an obstacle"
    E0503 "a target off the lattice"
    E0504 "a word of the wrong width"
    E0505 "a start on an obstacle"
    E0506 "a precision finer than the robot allows"
    E0507 "a start that is not where the device is"
    E0508 "a device used twice at the same time"
    E0509 "a step with something missing or superfluous"
    E0510 "a misplaced setting"
    E0511 "arguments that do not match the parameters"
    E0512 "too many runs"
    E0513 "no such task to build"
    E0514 "an impossible shape"
    E0515 "an object without a valid place"
    E0516 "a condition that cannot be checked"
    E0517 "no such planner"
    E0518 "a step that does not belong here"
    E0519 "too many places to visit"
    E0520 "a planner that cannot do what is asked"
    E0521 "a part of another layout"
    E0522 "too many objects in a scene"
    E0523 "parts that start too near to each other"
    E0524 "goals too near to each other, or to a part that stays"
    E0525 "a part with two goals at the same time"
    E0526 "a part that is gone"
    E0527 "parts that cannot merge"
    E0528 "scenes with unlike parts or robots in one schedule"
    E0529 "a merge on a device that does not hold"
    E0530 "a part or robot that stands where a later scene has an obstacle"
    E0531 "a control state that the bed does not have"
    E0532 "a robot that the table does not have"
    E0533 "a robot without a heading"
    E0534 "robots that start too near to each other"
    E0535 "an assembly without two robots"
    E0536 "robots that do not touch where they should dock"
    E0537 "robots that do not stick where they meet"
    E0539 "a robot that has docked"
    E0540 "a tip too large for a hollow of the part"
    E0541 "too many contacts to plan with"
    E0542 "planes between which a part cannot change fingers"
    E0543 "an angle that is not a whole number of steps"
    E0544 "a turn of more than 360 deg"
    E0545 "an orientation that whole steps cannot reach"
    E0546 "a flat part turned out of its plane"
    E0547 "an invalid grasp"
    E0548 "a step with a part that nothing holds"
    E0549 "a part that sticks to the last finger"
    E0550 "a part out of the stages' range"
    E0551 "a task without its one part"
    E0552 "a solid that tips collide with"
    E0553 "a file of triangles that cannot be used"
    E0554 "an assay of too many steps"
    E0555 "a droplet that is not dispensed"
    E0556 "a step that its output does not support"
    E0557 "a droplet that cannot be split"
    E0558 "a droplet that cannot be mixed"
    E0559 "a droplet with other contents"
    E0560 "an invalid frame"
    E0561 "a frame of a device that takes none"
    E0562 "an obstacle given by cells in a scene that places a robot"
    E0563 "a device at two places in one program"
    E0564 "an `after` without an earlier operation"
    E0565 "droplets that contaminate each other"
    E0566 "something that cannot be waited for"
    E0567 "a lower limit on the time of a task that waits"
    E0570 "a place in pixels without an image"
    E0571 "more than one image in a scene"
    E0572 "interchangeable goals"
    E0573 "a `within` without `after`"
    E0574 "an invalid heater, detector or magnet"
    E0575 "a temperature that its heater cannot keep"
    E0576 "an invalid choice of places"
    E0577 "a load at an unknown centre of mass"
    W0501 "an obstacle outside the workspace"
    W0502 "a task that is never run"
    W0503 "nothing to build"
    W0504 "a setting that changes nothing"
    W0510 "devices that run together but are not checked against each other"
    W0511 "an assembly that is likely to fail"
    W0512 "droplets that nothing holds between tasks"
    W0513 "traces of an earlier task on the same board"
    W0514 "a temperature to which no heater of the bench is set"
    W0515 "a droplet held by a magnet is split and leaves the magnet"
    W0516 "a droplet is held while the magnets of the bench are down"
    W0517 "droplets so wide that they touch despite the separation"
    E0601 "no plan exists"
    E0602 "the search gave up"
    E0603 "a condition that the plan does not keep"
    E0604 "a schedule too long for the clock"
    E0605 "a goal cannot be guaranteed"
    E0606 "a control state that drives robots too close to something"
    E0607 "an output switched again too soon"
    E0608 "something continues while a program waits"
    E0610 "no plans found that keep robots apart"
    E0620 "a voltage beyond its instrument"
    E0621 "a level that a switch does not have"
    E0622 "a change too fast for an amplifier"
    E0623 "times too fine for a sample clock"
    E0624 "a path that a stage cannot follow"
    E0625 "levels too coarse for a device"
    E0701 "a schedule names a channel, step or plan that it does not have"
    E0702 "an invalid number in a schedule"
    E0703 "actuations are not in order of time"
    E0704 "a channel has two values at the same time"
    E0705 "a channel is not one of the program's devices"
    E0706 "a wire differs from the one in the program"
    E0707 "an actuation lies outside of its step"
    E0708 "the plans are not those of the program's tasks"
    E0709 "the steps of a run are not those of its task"
    E0710 "the timing of a run or schedule differs from the program"
    E0711 "a device is in two runs at the same time"
    E0712 "a wait is not as long as claimed, or not quiet"
    E0713 "a recorded figure differs from the replay"
    E0714 "a recorded state differs from the replay"
    E0715 "a required limit is not kept"
    E0716 "a run does not start where its device is"
    E0717 "a stop of a step is not reached"
    E0718 "a cell is not the one for its place"
    E0721 "a pulse differs from that of the device"
    E0722 "a rest after a pulse is too short"
    E0723 "time passes in a step of moves"
    E0724 "a pulse does nothing"
    E0725 "a module is set and reset at once"
    E0726 "several modules are switched at once"
    E0727 "a move touches an obstacle"
    E0728 "modules switched at once can touch an obstacle"
    E0729 "an electrode is not at the potential of the device"
    E0730 "an electrode is switched within a step of the board"
    E0731 "an electrode pulls a part that it must not pull"
    E0732 "an electrode pulls no part"
    E0733 "a resting droplet is not held as its device requires"
    E0734 "two parts come too near each other"
    E0735 "a part comes too near an obstacle"
    E0736 "a part without a goal moves"
    E0737 "an invalid level of the bed"
    E0738 "strokes that differ from those of the device"
    E0739 "an arm in an uncertain state, or moved by a stroke"
    E0740 "unusable claims"
    E0741 "the parts of a log do not belong together"
    E0742 "a log does not match the program it is checked against"
    E0743 "the program in a log has errors"
    E0744 "arms that match no control state"
    E0745 "a control state is not applied as the task requires"
    E0746 "a robot comes too near an obstacle"
    E0747 "two robots come too near each other"
    E0748 "an orbit is not clear"
    E0749 "robots are not docked as the task requires"
    E0750 "an invalid swing"
    E0751 "an axis has no value, or jumps"
    E0752 "a stage leaves its range"
    E0753 "a holding finger leaves the part or penetrates it"
    E0754 "a holding finger slips"
    E0755 "a finger is placed or removed where it must not be"
    E0756 "a grasp that is not in equilibrium"
    E0757 "fingers that do not resist the removal of another"
    E0758 "a part is not held as the last fingers leave"
    E0759 "a tip comes too near the part"
    E0760 "two tips come too near each other"
    E0761 "the arm of a docked robot is down"
    E0762 "a tip moves too fast"
    E0763 "a recording is not an exchange of measurements and commands"
    E0764 "a robot is not where the commands should bring it"
    E0765 "a controlled task was not completed"
    E0770 "the tips of two robots may touch"
    E0771 "a step differs from the source"
    E0772 "a log built with settings that were not repeated"
    E0773 "an electrode that does not work is on"
    E0774 "an output is not switched as the steps require"
    E0775 "a droplet touches traces that it must not touch"
    E0776 "a wait in which something changes"
    E0777 "a part is not where it should be heated, read or held"
    E0778 "a reservoir is not switched as its frames require"
    E0779 "a log whose plan differs from that of its program"
    E0785 "an operation begins too late after another"
    E0786 "a shared channel pulls a droplet that it must not"
    E0787 "an operation at a place that the program does not name"
    E0801 "a file that cannot be read"
    E0802 "a file that is too large"
    E0803 "a file that is not UTF-8"
    E0804 "a file that cannot be written"
    E0806 "a file that was built from another program"
    E0807 "two files of the same name"
    E0808 "a build that was interrupted"
    E0809 "an output that would overwrite an input of the build"
    E0820 "a value of the schedule is not a finite number"
    E0821 "a format of constant voltages meets one that ramps"
    E0822 "a file would be larger than its readers accept"
    E0823 "a schedule has more sample points than the instrument accepts"
    E0824 "no channel is wired to an instrument that plays a format"
    E0825 "a file could not be generated"
    E0826 "a stage must be in two places"
    E0827 "a format for positions meets something else"
    E0828 "a picture requested after the end of the schedule"
    E0829 "digital lines without a sample clock"
    E0830 "a sheet for a schedule without droplets"
    E0831 "a format that cannot express what a schedule needs"
    E0840 "a file is not an MCAP log"
    E0841 "a log is truncated"
    E0842 "a log is damaged"
    E0843 "a part of a log exceeds the size limit"
    E0844 "a log lacks a part that every log of Tweeze contains"
    E0845 "a part of a log cannot be read"
    E0846 "the voltages or positions in a log are not those of its schedule"
    E0847 "a log shows something other than its schedule"
    E0848 "a log of another version of Tweeze"
    E0850 "a log that would not be accepted"
}

impl Code {
    /// The code of a printed name; case is ignored.
    pub fn find(name: &str) -> Option<Code> {
        Code::ALL.iter().copied().find(|code| code.name().eq_ignore_ascii_case(name))
    }

    /// Whether it is about syntax.
    pub fn is_of_syntax(self) -> bool {
        self.name().starts_with("E01")
    }

    /// Errors stop the build and warnings do not; the first letter of the code decides.
    pub fn severity(self) -> Severity {
        if self.name().starts_with('E') { Severity::Error } else { Severity::Warning }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
