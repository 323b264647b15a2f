//! HTML: one page that plays a schedule, without a server, a network or another file.
//!
//! A program that could not be built has a page too (`failed`) with its errors, and the scene as far as it could be
//! built. So has a refused log, with the rules that it breaks and its content; this is the only form in which anything
//! unverified is written.
//!
//! The page holds the program, the schedule and the claims as JSON (`schema/page.schema.json`), and draws program,
//! scene, timeline and claims on one clock by a script. Style and script are those of `assets/page`, inserted
//! unchanged.

mod evidence;
mod failed;
mod follow;

pub use failed::{FAILED_ENDING, FailedProgram, RefusedSchedule};
pub use follow::Follower;

use super::error::MAX_TEXT_BYTES;
use super::{EmitError, Format, Provenance};
use crate::claims::Claims;
use crate::log;
use crate::schedule::{Schedule, json};
use crate::verify::Verified;
use evidence::PageEvidence;
use failed::PageFailure;
use serde::Serialize;
use serde_json::value::RawValue;

/// The page without its style, data and script.
const PAGE: &str = include_str!("../../../assets/page/page.html");

const STYLE: &str = include_str!("../../../assets/page/page.css");

/// The parts of the script, in dependency order.
const SCRIPTS: [&str; 11] = [
    include_str!("../../../assets/page/model.js"),
    include_str!("../../../assets/page/pen.js"),
    include_str!("../../../assets/page/scene.js"),
    include_str!("../../../assets/page/hand.js"),
    include_str!("../../../assets/page/timeline.js"),
    include_str!("../../../assets/page/program.js"),
    include_str!("../../../assets/page/claims.js"),
    include_str!("../../../assets/page/ruler.js"),
    include_str!("../../../assets/page/failure.js"),
    include_str!("../../../assets/page/follow.js"),
    include_str!("../../../assets/page/main.js"),
];

/// Version of the data in a page.
const VERSION: u32 = 1;

/// The data of a page.
#[derive(Serialize)]
struct PageData<'a> {
    format: &'static str,
    version: u32,
    /// The version that wrote it.
    tweeze: &'static str,
    /// `None` if nothing of the program could be built.
    schedule: Option<&'a RawValue>,
    claims: Option<&'a RawValue>,
    /// The program's own file first, then those that it uses.
    sources: Vec<PageSource<'a>>,
    settings: &'a [String],
    /// Whether the page is of a log, so that the bounds, proofs, estimates, guarantees and remarks of its plans were
    /// not derived again.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    recorded: bool,
    /// What was verified; `None` for a refused log.
    #[serde(skip_serializing_if = "Option::is_none")]
    evidence: Option<PageEvidence<'a>>,
    /// Why the program could not be built, or the log was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<PageFailure<'a>>,
}

#[derive(Serialize)]
struct PageSource<'a> {
    name: &'a str,
    text: &'a str,
}

/// The bytes of the page.
///
/// # Errors
/// [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`]; [`EmitError::Failed`] if the library that writes JSON fails.
pub(super) fn write(verified: &Verified, provenance: &Provenance) -> Result<Vec<u8>, EmitError> {
    let evidence = PageEvidence::of(verified);
    page(Some((verified.schedule(), verified.claims())), provenance, Some(evidence), None)
}

/// The bytes of the page of a program that could not be built.
///
/// # Errors
/// As [`write()`].
pub(super) fn write_failed(failed: &FailedProgram, provenance: &Provenance) -> Result<Vec<u8>, EmitError> {
    let part = failed.part.map(|(verified, whole)| (verified.schedule(), whole.unwrap_or(verified.claims())));
    let evidence = failed.part.map(|(verified, _)| PageEvidence::of(verified));
    page(part, provenance, evidence, Some(failed.failure()))
}

/// The bytes of the page of a schedule that was refused.
///
/// # Errors
/// As [`write()`].
pub(super) fn write_refused(refused: &RefusedSchedule, provenance: &Provenance) -> Result<Vec<u8>, EmitError> {
    page(refused.shown(), provenance, None, Some(refused.failure()))
}

fn page(
    shown: Option<(&Schedule, &Claims)>,
    provenance: &Provenance,
    evidence: Option<PageEvidence>,
    failure: Option<PageFailure>,
) -> Result<Vec<u8>, EmitError> {
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let schedule = shown.map(|(schedule, _)| RawValue::from_string(text(json::write(schedule))));
    let schedule = schedule.transpose().map_err(unwritten)?;
    let length = schedule.as_ref().map_or(0, |schedule| schedule.get().len());
    EmitError::refuse_size(Format::Html, length as u64, MAX_TEXT_BYTES)?;
    let claims = shown.map(|(_, claims)| log::write_claims(claims).and_then(|it| RawValue::from_string(text(it))));
    let claims = claims.transpose().map_err(unwritten)?;
    let data = PageData {
        format: "tweeze-page",
        version: VERSION,
        tweeze: env!("CARGO_PKG_VERSION"),
        schedule: schedule.as_deref(),
        claims: claims.as_deref(),
        sources: provenance.files.iter().map(|(name, text)| PageSource { name, text }).collect(),
        settings: &provenance.settings,
        recorded: provenance.is_recorded,
        evidence,
        failure,
    };
    // In JSON `<` occurs only within strings; escaped, no string can end the script element that carries the data.
    let data = serde_json::to_string(&data).map_err(unwritten)?.replace('<', "\\u003c");
    let page = assembled(&[("/*style*/", STYLE), ("/*data*/", &data), ("/*script*/", &SCRIPTS.concat())]);
    EmitError::refuse_size(Format::Html, page.len() as u64, MAX_TEXT_BYTES)?;
    Ok(page.into_bytes())
}

fn unwritten(error: serde_json::Error) -> EmitError {
    EmitError::Failed { format: Format::Html, detail: error.to_string() }
}

/// The page with its markers replaced by texts, in the order in which they occur; markers within these texts stay.
fn assembled(parts: &[(&str, &str)]) -> String {
    let (mut page, mut rest) = (String::new(), PAGE);
    for (mark, text) in parts {
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page + rest
}
