//! The commands of a controller as lines of the control protocol.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::control::StopReason;
use crate::plan::microrobots::control::{Command, Controller, InTheWay, Stop, StrokeSegment};
use crate::quantity::digits;
use crate::schedule::control::{CommandLine, CommandWord, SegmentLine};

/// The last command of a controller, as the answer to the measurement at `t_ns`; `text_lines` has the line of each
/// step of the order in the program's text.
pub fn command_line(order: &MicrorobotsOrder, text_lines: &[u32], controller: &Controller, t_ns: u64) -> CommandLine {
    let name = |robot: usize| order.robot(robot).name.clone();
    let (command, until_ns, segments, stop) = match controller.last() {
        Command::Drive { segments, until_ns } => (CommandWord::Drive, Some(until_ns), Some(segments), None),
        Command::Rest { until_ns } => (CommandWord::Rest, Some(until_ns), None, None),
        Command::Continue { until_ns } => (CommandWord::Continue, Some(until_ns), None, None),
        Command::Finished => (CommandWord::Finished, None, None, None),
        Command::Stop(stop) => (CommandWord::Stop, None, None, Some(stop)),
    };
    let segment = |segment: &StrokeSegment| {
        let state = &order.states[segment.state];
        let levels_v = if segment.sets_arms { state.levels_v.clone() } else { Vec::new() };
        SegmentLine { state: state.digits(), levels_v, strokes: segment.strokes }
    };
    let step = controller.step();
    let docked = (0..order.robots.len()).filter(|robot| controller.is_docked(*robot));
    CommandLine {
        t_ns,
        command,
        until_ns,
        segments: segments.map(|segments| segments.iter().map(segment).collect()),
        reason: stop.map(|stop| stop.reason),
        message: stop.map(|stop| stopped(order, stop)),
        robot: stop.and_then(|stop| stop.robot).map(name),
        in_the_way: stop.and_then(|stop| stop.in_the_way).map(|thing| thing.name(order).to_owned()),
        step,
        line: text_lines.get(step).copied(),
        phase: controller.phase(),
        driven: controller.driven().into_iter().flatten().map(name).collect(),
        docked: docked.map(name).collect(),
    }
}

/// The reason why a task was given up, for people.
pub fn stopped(order: &MicrorobotsOrder, stop: Stop) -> String {
    let name = |robot: usize| order.robot(robot).name.as_str();
    let robot = stop.robot.map_or("a robot", name);
    match stop.reason {
        StopReason::LeftCylinder => format!("`{robot}` did not reach the end of its motion within the allowed rounds"),
        StopReason::MissedCone => format!("the goal of `{robot}` is out of reach of the fine motion"),
        StopReason::Misplaced => format!("`{robot}` is measured at its structure, but too far from its place"),
        StopReason::TimeLimit => format!("`{robot}` took too long"),
        StopReason::Unseen => format!("`{robot}` was not seen in too many measurements in a row"),
        StopReason::Doubtful => format!("`{robot}` was measured too often where it cannot be"),
        StopReason::Astray => format!(
            "`{robot}` does not follow the commands: it was measured too often in a row where they cannot have moved it"
        ),
        StopReason::Moved => format!(
            "`{robot}` was measured twice in a row where it cannot be: it was moved, or mistaken for another robot"
        ),
        StopReason::Blocked => match stop.in_the_way {
            Some(InTheWay::Robot(other)) => format!("`{robot}` and `{}` would collide next", name(other)),
            Some(obstacle @ InTheWay::Obstacle(_)) => {
                format!("`{robot}` would be driven into `{}` next", obstacle.name(order))
            }
            None => format!("`{robot}` would be driven into something next"),
        },
        StopReason::Silence => {
            let watchdog_s = order.facts.watchdog_ns() as f64 / 1e9;
            format!("no measurement arrived within {} s after the end of the last command", digits(watchdog_s))
        }
        StopReason::Closed => "the measurements ended before the task was done".to_owned(),
        StopReason::Clock => "the time of a measurement is before that of the previous one".to_owned(),
        StopReason::Garbled => "too many lines in a row are not measurements".to_owned(),
        StopReason::Interrupted => "the controller was interrupted".to_owned(),
        StopReason::Unread => "the process that carries out the commands does not read them".to_owned(),
        StopReason::Unrecorded => "the recording cannot be written".to_owned(),
    }
}
