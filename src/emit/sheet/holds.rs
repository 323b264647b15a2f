//! Waits for an input or a person on the sheet: what to do, and the reference of the times after them.

use super::{SheetRow, time};
use crate::device::instrument::Awaited;
use crate::schedule::ScheduledHold;
use crate::verify::Verified;

/// A row for each wait.
pub(super) fn rows(verified: &Verified) -> impl Iterator<Item = SheetRow<'_>> {
    verified.schedule().holds.iter().filter_map(|hold| {
        let step = verified.schedule().steps.get(hold.step as usize)?;
        let device = verified.claims().jobs.get(step.plan as usize)?.device.as_str();
        let times = [hold.start_ns, hold.end_ns()];
        let end = if hold.terms.is_bounded { "at the latest" } else { "at the answer" };
        Some(SheetRow { times, end: format!("{} {end}", time(times[1])), device, text: hold_text(hold) })
    })
}

/// Explanation of times in a schedule with waits; `None` without waits.
pub(super) fn of_times(holds: &[ScheduledHold]) -> Option<String> {
    let open = holds.iter().find(|hold| !hold.terms.is_bounded);
    let mut text = match open {
        Some(open) => format!(
            "The clock stands still from a prompt to its answer, for which {} is counted here: the times after it count on from the answer.",
            time(open.terms.duration_ns)
        ),
        None => String::new(),
    };
    if holds.iter().any(|hold| hold.terms.is_bounded) {
        text.push_str(if text.is_empty() { "" } else { " " });
        text.push_str(
            "A wait with a longest time ends as soon as what it waits for has come, and the times after it count on from then; \
             where that does not come in time, the run is broken off.",
        );
    }
    (!text.is_empty()).then_some(text)
}

/// `**put the lid on**, until it is answered`
fn hold_text(hold: &ScheduledHold) -> String {
    let until = match hold.terms.is_bounded {
        true => format!("at most {}", time(hold.terms.duration_ns)),
        false => "until it is answered".to_owned(),
    };
    match &hold.terms.awaited {
        Awaited::Person { prompt } if prompt.is_empty() => format!("waits for an answer, {until}"),
        Awaited::Person { prompt } => format!("**{}**, {until}", plain(prompt)),
        Awaited::Input { name, level, .. } => format!("waits for {} to be {}, {until}", plain(name), level.name()),
    }
}

/// A text of the program escaped for Markdown, also within tables.
fn plain(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if matches!(c, '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '~' | '&' | '$') {
            shown.push('\\');
        }
        shown.push(if c.is_control() { ' ' } else { c });
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::instrument::{HoldTerms, Level};

    fn hold(awaited: Awaited, is_bounded: bool) -> ScheduledHold {
        ScheduledHold { step: 0, start_ns: 0, terms: HoldTerms { awaited, duration_ns: 1_000_000_000, is_bounded } }
    }

    #[test]
    fn waits_say_what_to_do_and_how_long() {
        let prompt = |text: &str| Awaited::Person { prompt: text.to_owned() };
        let input = Awaited::Input { name: "card.port0.line5".to_owned(), place: None, level: Level::Low };
        for (awaited, is_bounded, expected) in [
            (prompt("put the lid on"), false, "**put the lid on**, until it is answered"),
            (prompt("add | <b>`x`_1"), true, "**add \\| \\<b\\>\\`x\\`\\_1**, at most 1 s"),
            (prompt(""), false, "waits for an answer, until it is answered"),
            (input, true, "waits for card.port0.line5 to be low, at most 1 s"),
        ] {
            assert_eq!(hold_text(&hold(awaited, is_bounded)), expected);
        }
    }

    #[test]
    fn times_are_explained_where_a_schedule_waits() {
        let of = |bounded: &[bool]| {
            let awaited = Awaited::Person { prompt: "go".to_owned() };
            of_times(&bounded.iter().map(|is_bounded| hold(awaited.clone(), *is_bounded)).collect::<Vec<_>>())
        };
        assert_eq!(of(&[]), None);
        let says = |bounded: &[bool], words: &str| of(bounded).is_some_and(|text| text.contains(words));
        assert!(says(&[false], "count on from the answer") && !says(&[false], "broken off"));
        assert!(says(&[true], "broken off") && !says(&[true], "answer"));
        assert!(says(&[true, false], "from the answer. A wait"));
    }
}
