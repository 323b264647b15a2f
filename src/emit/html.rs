//! HTML: one page that plays a schedule, without a server, a network or another file.
//!
//! The page holds the program, the schedule and the claims as JSON (`schema/page.schema.json`), and draws them itself: program, scene,
//! timeline and claims on one clock. Style and script are those of `assets/page`, put together here as they are.

use super::error::MAX_TEXT_BYTES;
use super::{EmitError, Format, Provenance};
use crate::log;
use crate::schedule::json;
use crate::verify::Verified;
use serde::Serialize;
use serde_json::value::RawValue;

/// The page without its style, data and script.
const PAGE: &str = include_str!("../../assets/page/page.html");

const STYLE: &str = include_str!("../../assets/page/page.css");

/// The parts of the script, in the order in which they use one another.
const SCRIPTS: [&str; 6] = [
    include_str!("../../assets/page/model.js"),
    include_str!("../../assets/page/scene.js"),
    include_str!("../../assets/page/timeline.js"),
    include_str!("../../assets/page/program.js"),
    include_str!("../../assets/page/claims.js"),
    include_str!("../../assets/page/main.js"),
];

/// Version of the data in a page.
const VERSION: u32 = 1;

/// All that a page shows.
#[derive(Serialize)]
struct PageData<'a> {
    format: &'static str,
    version: u32,
    /// The version that wrote it.
    tweeze: &'static str,
    schedule: &'a RawValue,
    claims: &'a RawValue,
    /// The program's own file first, then those that it uses.
    sources: Vec<PageSource<'a>>,
    settings: &'a [String],
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
    let failed = |error: serde_json::Error| EmitError::Failed { format: Format::Html, detail: error.to_string() };
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let schedule = RawValue::from_string(text(json::write(verified.schedule()))).map_err(failed)?;
    EmitError::refuse_size(Format::Html, schedule.get().len() as u64, MAX_TEXT_BYTES)?;
    let claims = log::write_claims(verified.claims()).and_then(|claims| RawValue::from_string(text(claims)));
    let data = PageData {
        format: "tweeze-page",
        version: VERSION,
        tweeze: env!("CARGO_PKG_VERSION"),
        schedule: &schedule,
        claims: &claims.map_err(failed)?,
        sources: provenance.files.iter().map(|(name, text)| PageSource { name, text }).collect(),
        settings: &provenance.settings,
    };
    // In JSON a `<` stands within strings only; escaped, nothing in them can end the script that carries them.
    let data = serde_json::to_string(&data).map_err(failed)?.replace('<', "\\u003c");
    let page = assembled(&[("/*style*/", STYLE), ("/*data*/", &data), ("/*script*/", &SCRIPTS.concat())]);
    EmitError::refuse_size(Format::Html, page.len() as u64, MAX_TEXT_BYTES)?;
    Ok(page.into_bytes())
}

/// The page with each mark, in the order in which they stand in it, replaced by its text; marks within these texts stay.
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
