//! Where the claims of two programs differ.

use serde_json::Value;

/// Greatest number of characters of a value and of a place that a message shows.
const SHOWN_CHARACTERS: usize = 60;
const PLACE_CHARACTERS: usize = 120;

/// The first place at which two claims differ, with the values there.
pub struct Difference {
    /// Path such as `jobs[0].order.microrobots.facts.clearance_um`.
    pub place: String,
    pub of_log: String,
    pub of_program: String,
}

/// The first difference of two claims, each serialised as JSON; `None` if one is not JSON or they have the same values.
pub fn first(of_log: &[u8], of_program: &[u8]) -> Option<Difference> {
    let [of_log, of_program] = [of_log, of_program].map(|bytes| serde_json::from_slice::<Value>(bytes).ok());
    within(String::new(), Some(&of_log?), Some(&of_program?))
}

/// The first difference within the values at one place.
fn within(place: String, of_log: Option<&Value>, of_program: Option<&Value>) -> Option<Difference> {
    match (of_log, of_program) {
        (Some(Value::Object(one)), Some(Value::Object(other))) => {
            let new = other.keys().filter(|key| !one.contains_key(*key));
            one.keys().chain(new).find_map(|key| {
                let inner = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
                within(inner, one.get(key), other.get(key))
            })
        }
        (Some(Value::Array(one)), Some(Value::Array(other))) => (0..one.len().max(other.len()))
            .find_map(|index| within(format!("{place}[{index}]"), one.get(index), other.get(index))),
        (one, other) if one == other => None,
        (one, other) => {
            // The keys in a log may be arbitrary text.
            let place = place.chars().filter(|c| !c.is_control()).take(PLACE_CHARACTERS).collect();
            Some(Difference { place, of_log: shown(one), of_program: shown(other) })
        }
    }
}

fn shown(value: Option<&Value>) -> String {
    let Some(value) = value else { return "nothing".to_owned() };
    let text = value.to_string();
    match text.char_indices().nth(SHOWN_CHARACTERS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_is_found_wherever_it_is() {
        let found = |one: &str, other: &str| {
            first(one.as_bytes(), other.as_bytes()).map(|found| (found.place, found.of_log, found.of_program))
        };
        let of = |place: &str, one: &str, other: &str| Some((place.to_owned(), one.to_owned(), other.to_owned()));
        let claims = r#"{"jobs":[{"steps":[1,2]},{"facts":{"gap_um":20}}],"name":"a"}"#;
        assert_eq!(found(claims, claims), None);
        assert_eq!(found(claims, &claims.replace("20", "25.5")), of("jobs[1].facts.gap_um", "20", "25.5"));
        assert_eq!(found(claims, &claims.replace("1,2", "1,2,3")), of("jobs[0].steps[2]", "nothing", "3"));
        assert_eq!(found(claims, r#"{"jobs":[],"name":"a"}"#), of("jobs[0]", r#"{"steps":[1,2]}"#, "nothing"));
        let long = "x".repeat(100);
        let (_, shown, _) = found(&format!(r#"{{"a":"{long}"}}"#), r#"{"a":1}"#).expect("they differ");
        assert_eq!(shown.chars().count(), SHOWN_CHARACTERS + 1);
        assert_eq!(found("{", "{}"), None);
        assert_eq!(found(r#"{"\u001bx":1}"#, "{}"), of("x", "1", "nothing"));
    }
}
