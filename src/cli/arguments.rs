//! Command-line arguments.

use super::Address;
use super::formats::{self, EmitChoice};
use crate::device::Kind;
use crate::quantity::{Dimension, Unit};
use crate::simulate::Disturbances;
use clap::{Args, Parser, Subcommand, ValueEnum, builder::PossibleValuesParser, builder::TypedValueParser};

use std::path::PathBuf;

/// Compiles micro-manipulation programs: reports what cannot work before the hardware moves, finds the best plan,
/// verifies it, and writes it for instruments, simulators and viewers.
#[derive(Debug, Parser)]
#[command(name = "tweeze", version, max_term_width = 100, after_help = EXIT_STATUS)]
pub struct Invocation {
    #[command(subcommand)]
    pub command: Command,
    /// Colours of reports and diagnostics; `auto` uses them on terminals unless `NO_COLOR` is set
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value = "auto", hide_possible_values = true)]
    pub color: ColourChoice,
}

/// When to use colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColourChoice {
    Auto,
    Always,
    Never,
}

const EXIT_STATUS: &str = "\
Exit status: 0 done; 1 the program has errors; 2 wrong usage; 3 a schedule failed verification; 4 a file could not be read or written; 5 tweeze itself failed, which is a bug; 6 a controlled task was given up.

Start with `tweeze build FILE.twz`; `tweeze devices` lists what can be programmed.";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Report every error in programs, each once; with --plan, also search for a plan of each task
    #[command(after_help = "Examples:\n  tweeze check fetch.twz --set pitch=80um\n  tweeze check fetch.twz --plan\n  \
                            tweeze check *.twz --format sarif > tweeze.sarif")]
    Check(CheckArguments),
    /// Check, plan, verify and write a program
    #[command(after_help = "Examples:\n  tweeze build fetch.twz\n  \
                      tweeze build fetch.twz --emit mcap,csv,scpi -o out --task fetch\n  \
                      tweeze build *.twz --emit all -o out --quiet\n\n\
                      Several programs are built independently of each other; the exit status is the most severe one.\n\
                      With --watch they are built again whenever they change.")]
    Build(BuildArguments),
    /// Replay a written log against the device models, independently of the planner; or check the recording of a controlled run
    #[command(after_help = "Examples:\n  tweeze verify fetch.mcap\n  tweeze verify fetch.mcap --against fetch.twz\n  \
                      tweeze verify fetch.mcap --against fetch.twz --set pitch=80um\n  \
                      tweeze verify fetch.mcap --replan\n  \
                      tweeze verify run.mcap --against assemble.twz --goal-tolerance 20um")]
    Verify(VerifyArguments),
    /// Write the page that plays a program or a log, and open it in the browser
    #[command(
        after_help = "Examples:\n  tweeze view fetch.twz --watch\n  tweeze view out/fetch.mcap -o out --no-open\n\n\
                            A log is verified first; one that violates rules is shown with its violations, as LOG.failed.html. For a program with errors, the page, FILE.failed.html, shows them at their lines and in the scene. The page is one file: it needs no network and can be shared."
    )]
    View(ViewArguments),
    /// Create a folder with a small program that builds right away
    #[command(after_help = "Examples:\n  tweeze new fetch\n  tweeze new quartet --kind microrobots\n  \
                      tweeze new dilution --template assay")]
    New(NewArguments),
    /// Explain a diagnostic, with an example and its fix
    #[command(after_help = "Example: tweeze explain E0503")]
    Explain(ExplainArguments),
    /// Write programs in their canonical form: spacing, indentation, columns and units; line breaks and comments stay
    #[command(
        after_help = "Examples:\n  tweeze fmt fetch.twz\n  tweeze fmt --diff fetch.twz\n  tweeze fmt --check .\n  \
                      tweeze fmt - < fetch.twz\n\nA declaration with a syntax error is left unchanged, and the error is reported. Exit status: 0 done; 1 a program has syntax errors or, with --check, would change."
    )]
    Fmt(FmtArguments),
    /// Serve an editor on standard input and output, with the Language Server Protocol
    #[command(after_help = "Editors start it themselves, as `tweeze lsp`. Example for Helix, in languages.toml:\n  \
                      [language-server.tweeze]\n  command = \"tweeze\"\n  args = [\"lsp\"]\n\n\
                      Settings for Neovim and Helix are in docs/editor.md. It provides diagnostics while you type, the meaning of words, completion, declarations and formatting; saved programs are planned. Exit status: 0 after an orderly shutdown; 1 otherwise.")]
    Lsp(LspArguments),
    /// Simulate the assemblies of a program with imperfect robots and measurements, and count the outcomes
    #[command(after_help = "Examples:\n  tweeze simulate assemble.twz --trials 1000 --seed 7\n  \
                      tweeze simulate assemble.twz --trials 5 --against-controller --delay 50ms --lost 0.02 --wrong 0.01")]
    Simulate(SimulateArguments),
    /// Control a task on a bed of microrobots: read measured poses as lines, answer each with the next drive segments
    #[command(after_help = "Examples:\n  camera | tweeze control assemble.twz --record run.mcap | source\n  \
                      tweeze control assemble.twz --listen 127.0.0.1:7000\n  \
                      tweeze control assemble.twz --listen unix:/tmp/bed.sock\n\n\
                      A line of input: {\"t_ns\": 0, \"robots\": {\"D1\": {\"x_um\": 1.5, \"y_um\": 2, \"heading_deg\": 90}}}\n\
                      A line of output: {\"command\": \"drive\", \"until_ns\": ..., \"segments\": [...], ...}\n\n\
                      The protocol is described in docs/control.md and schema/control.schema.json. Exit status: 0 the \
                      task is done; 6 it was given up, for the reason in the last line.")]
    Control(ControlArguments),
    /// List the device kinds and the families of instruments, the vocabulary of one of them, or the devices of a program with all derived figures
    #[command(
        after_help = "Examples:\n  tweeze devices dimibot\n  tweeze devices waveform_generator\n  tweeze devices assemble.twz\n  \
                      tweeze devices --suggest microrobots --robots 6 --margin 4V --max 200V"
    )]
    Devices(DevicesArguments),
    /// Write a completion script for a shell
    #[command(after_help = "Example: tweeze completions bash > ~/.local/share/bash-completion/completions/tweeze")]
    Completions(CompletionsArguments),
}

/// Format of diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ReportFormat {
    /// The source with every place labelled, and the fix
    Human,
    /// One line per diagnostic, as `FILE:LINE:COLUMN: error[CODE]: TITLE`
    Short,
    /// One JSON object per line
    Json,
    /// Workflow commands of GitHub Actions
    Github,
}

/// Format of the diagnostics of `check`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CheckFormat {
    /// The source with every place labelled, and the fix
    Human,
    /// One line per diagnostic, as `FILE:LINE:COLUMN: error[CODE]: TITLE`
    Short,
    /// One JSON object per line
    Json,
    /// Workflow commands of GitHub Actions
    Github,
    /// One SARIF 2.1.0 document for all programs, on standard output
    Sarif,
}

impl CheckFormat {
    /// The format that reports diagnostics one by one; `None` for one that reports all at the end.
    pub fn one_by_one(self) -> Option<ReportFormat> {
        match self {
            CheckFormat::Human => Some(ReportFormat::Human),
            CheckFormat::Short => Some(ReportFormat::Short),
            CheckFormat::Json => Some(ReportFormat::Json),
            CheckFormat::Github => Some(ReportFormat::Github),
            CheckFormat::Sarif => None,
        }
    }
}

#[derive(Debug, Args)]
pub struct LspArguments {
    /// Passed by many editors; the only transport, so it changes nothing
    #[arg(long, hide = true)]
    pub stdio: bool,
}

#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Programs to check; - for standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Also search for a plan of each schedule and verify it, as `build` does; nothing is written
    #[arg(long)]
    pub plan: bool,
    /// Check again whenever a file of the programs changes, until interrupted
    #[arg(long)]
    pub watch: bool,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub quiet: QuietArgument,
    /// Format of diagnostics, on standard error (SARIF on standard output); with `json`, the success line is JSON too
    #[arg(long, value_enum, default_value = "human")]
    pub format: CheckFormat,
}

#[derive(Debug, Args)]
pub struct BuildArguments {
    /// Programs to build; - for standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Build only this task or program
    #[arg(long, value_name = "NAME")]
    pub task: Option<String>,
    /// Formats to write, separated by commas; `all` for every format that can represent the schedule
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "mcap", value_parser = formats::parser())]
    pub emit: Vec<EmitChoice>,
    /// Build again whenever a file of the programs changes, until interrupted; open pages of --emit html update themselves
    #[arg(long)]
    pub watch: bool,
    /// On Ctrl-C, continue with the best plan found; a search without one continues until its first. A second Ctrl-C stops
    #[arg(long)]
    pub keep_best: bool,
    /// With `--emit svg`: draw this one instant, such as 120ms, instead of numbered positions
    #[arg(long, value_name = "TIME", value_parser = instant_ns)]
    pub at: Option<u64>,
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Replace files that were built from other programs
    #[arg(long)]
    pub force: bool,
    /// Also report the search steps, and every line of long lists
    #[arg(short, long, conflicts_with = "is_quiet")]
    pub verbose: bool,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub quiet: QuietArgument,
    #[command(flatten)]
    pub report: ReportArguments,
}

#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// The log to replay, or the recording of `tweeze control`
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Check the log against this program, not only against the one that it contains
    #[arg(long, value_name = "FILE.twz")]
    pub against: Option<PathBuf>,
    /// Set a value of the `--against` program; without this option the program's own values apply, whatever the log contains
    #[arg(long = "set", value_name = "NAME=VALUE", requires = "against")]
    pub set: Vec<String>,
    /// Also plan the log's program again: bounds, `optimal`, estimates, guarantees and remarks of the log must match
    #[arg(long)]
    pub replan: bool,
    #[command(flatten)]
    pub tolerances: ToleranceArguments,
    #[command(flatten)]
    pub quiet: QuietArgument,
    #[command(flatten)]
    pub report: ReportArguments,
}

/// What is granted to the recording of a controlled run.
#[derive(Debug, Args)]
#[command(next_help_heading = "Recordings of tweeze control")]
pub struct ToleranceArguments {
    /// Tolerance of each measured place, in addition to the errors of the device, such as 20um
    #[arg(long, value_name = "LENGTH", default_value = "0um", value_parser = length_um)]
    pub path_tolerance: f64,
    /// Tolerance of each goal, in addition to the precision of the task, such as 50um
    #[arg(long, value_name = "LENGTH", default_value = "0um", value_parser = length_um)]
    pub goal_tolerance: f64,
    /// Tolerance of the heading at each goal, in addition to the precision of the task, such as 5deg
    #[arg(long, value_name = "ANGLE", default_value = "0deg", value_parser = angle_rad)]
    pub heading_tolerance: f64,
    /// Tolerance of each `require time`, such as 10s
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = time_ns)]
    pub time_tolerance: u64,
}

impl ToleranceArguments {
    /// Whether any tolerance is above zero.
    pub fn is_any(&self) -> bool {
        self.path_tolerance + self.goal_tolerance + self.heading_tolerance > 0.0 || self.time_tolerance > 0
    }
}

#[derive(Debug, Args)]
pub struct ViewArguments {
    /// The program or the log to show
    #[arg(value_name = "FILE.twz|FILE.mcap")]
    pub file: PathBuf,
    /// Show only this task or program
    #[arg(long, value_name = "NAME")]
    pub task: Option<String>,
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Only write the page
    #[arg(long)]
    pub no_open: bool,
    /// Build again whenever a file of the program changes, until interrupted; the open page updates itself
    #[arg(long)]
    pub watch: bool,
    /// Replace files that were built from other programs
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub report: ReportArguments,
}

#[derive(Debug, Args)]
pub struct NewArguments {
    /// Folder to create; the program in it has the same name
    #[arg(value_name = "NAME")]
    pub path: PathBuf,
    /// What the program does
    #[arg(long, value_enum)]
    pub template: Option<Template>,
    /// Use the first template of this kind of device
    #[arg(long, value_name = "KIND", conflicts_with = "template", value_parser = kinds())]
    pub kind: Option<Kind>,
    #[command(flatten)]
    pub report: ReportArguments,
}

fn kinds() -> impl TypedValueParser<Value = Kind> {
    let names = PossibleValuesParser::new(Kind::ALL.iter().map(|kind| kind.name()));
    names.try_map(|name| Kind::find(&name).ok_or("no such kind"))
}

/// What the program of a new project does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// A DiMiBot carries its tip past obstacles to two places
    PickAndPlace,
    /// A DiMiBot probes a grid of pads in the best order
    Scan,
    /// Microparts change places on an electrode array
    Sort,
    /// A droplet chip dilutes a sample and carries it to a detector
    Assay,
    /// STRING microrobots come together
    Assemble,
    /// A hand turns a bead between its fingertips
    Turn,
}

#[derive(Debug, Args)]
pub struct ExplainArguments {
    /// A code such as E0503; all codes are listed if omitted
    pub code: Option<String>,
    /// Print the pages of all codes as one Markdown text
    #[arg(long, conflicts_with = "code")]
    pub all: bool,
}

#[derive(Debug, Args)]
pub struct FmtArguments {
    /// Programs to rewrite in place; folders stand for all .twz files in them, - for standard input
    #[arg(required = true, value_name = "FILE|DIR|-")]
    pub files: Vec<PathBuf>,
    /// Write nothing; list the files that would change, and exit with 1 if there are any
    #[arg(long)]
    pub check: bool,
    /// Write nothing; show what would change
    #[arg(long)]
    pub diff: bool,
    #[command(flatten)]
    pub report: ReportArguments,
}

#[derive(Debug, Args)]
pub struct DevicesArguments {
    /// A device kind, a family of instruments or a program; all kinds and families are listed if omitted
    #[arg(value_name = "KIND|FILE.twz")]
    pub subject: Option<String>,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub report: ReportArguments,
    /// Find a voltage table for robots of this kind
    #[arg(long, value_name = "KIND", requires_all = ["robots", "margin", "max"], conflicts_with = "subject", value_parser = ["microrobots"])]
    pub suggest: Option<String>,
    /// Number of robots in the table
    #[arg(long, value_name = "NUMBER", requires = "suggest", value_parser = clap::value_parser!(u32).range(1..=128))]
    pub robots: Option<u32>,
    /// Uncertainty (plus or minus) of each transition voltage, such as 4V
    #[arg(long, value_name = "VOLTAGE", requires = "suggest", value_parser = voltage)]
    pub margin: Option<f64>,
    /// Greatest voltage of the source, such as 200V
    #[arg(long, value_name = "VOLTAGE", requires = "suggest", value_parser = voltage)]
    pub max: Option<f64>,
    /// Relax level of the drive train, if fixed
    #[arg(long, value_name = "VOLTAGE", requires_all = ["suggest", "flex"], value_parser = voltage)]
    pub relax: Option<f64>,
    /// Flex level of the drive train, if fixed
    #[arg(long, value_name = "VOLTAGE", requires_all = ["suggest", "relax"], value_parser = voltage)]
    pub flex: Option<f64>,
    /// Required distance of the flex level above the relax level, if these are not given
    #[arg(long, value_name = "VOLTAGE", requires = "suggest", default_value = "38V", value_parser = voltage)]
    pub swing: f64,
}

/// A ratio from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "expected a number from 0 to 1, such as 0.02".to_owned())?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err("expected a number from 0 to 1".to_owned()) }
}

/// A number with a unit of a dimension, in the SI unit; `form` is the error that shows how to write it.
fn quantity(text: &str, dimension: Dimension, form: &str) -> Result<f64, String> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let unit = text[digits.len()..].trim();
    let quantity = Unit::parse(unit).ok().and_then(|unit| unit.of(digits));
    match quantity {
        Some(quantity) if quantity.dimension == dimension => Ok(quantity.si),
        Some(_) | None => Err(form.to_owned()),
    }
}

/// A time from zero to an hour, in nanoseconds.
fn time_ns(text: &str) -> Result<u64, String> {
    let time_s = quantity(text, Dimension::TIME, "expected a time, such as 50ms or 0.5s")?;
    match (0.0..=3600.0).contains(&time_s) {
        true => Ok((time_s * 1e9).round() as u64),
        false => Err("expected a time from 0 s to 3600 s".to_owned()),
    }
}

/// A time of zero or more, in nanoseconds.
fn instant_ns(text: &str) -> Result<u64, String> {
    let time_s = quantity(text, Dimension::TIME, "expected a time, such as 50ms or 0.5s")?;
    if time_s >= 0.0 { Ok((time_s * 1e9).round() as u64) } else { Err("expected a time of 0 s or more".to_owned()) }
}

/// A voltage above zero, in volts.
fn voltage(text: &str) -> Result<f64, String> {
    let voltage_v = quantity(text, Dimension::VOLTAGE, "expected a voltage, such as 4V or 250mV")?;
    if voltage_v > 0.0 { Ok(voltage_v) } else { Err("expected a voltage above 0 V".to_owned()) }
}

/// A length from zero to a metre, in micrometres.
fn length_um(text: &str) -> Result<f64, String> {
    let length_m = quantity(text, Dimension::LENGTH, "expected a length, such as 20um or 0.1mm")?;
    if (0.0..=1.0).contains(&length_m) {
        Ok(length_m * 1e6)
    } else {
        Err("expected a length from 0 m to 1 m".to_owned())
    }
}

/// An angle from zero to half a turn, in radians.
fn angle_rad(text: &str) -> Result<f64, String> {
    let angle = quantity(text, Dimension::ANGLE, "expected an angle, such as 2deg or 0.05rad")?;
    match (0.0..=std::f64::consts::PI).contains(&angle) {
        true => Ok(angle),
        false => Err("expected an angle from 0 deg to 180 deg".to_owned()),
    }
}

#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// The program
    pub file: PathBuf,
    /// Simulate only this task or program
    #[arg(long, value_name = "NAME")]
    pub task: Option<String>,
    /// Number of runs of each assembly
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=MAX_TRIALS))]
    pub trials: u32,
    /// Seed of the random numbers; the same seed gives the same results. `build` draws its trials from seeds 1 and 2
    #[arg(long, default_value_t = 3)]
    pub seed: u64,
    /// Let `tweeze control` bring the robots together, in another process over a socket: one for each run
    #[arg(long)]
    pub against_controller: bool,
    /// Record the exchange with the controller in a new file; needs a single trial
    #[arg(long, value_name = "FILE.mcap", requires = "against_controller")]
    pub record: Option<PathBuf>,
    /// Time from a measurement to its command, such as 50ms; the bed holds still meanwhile
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = time_ns)]
    pub delay: u64,
    /// Share of measured poses that are lost, such as 0.02
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub lost: f64,
    /// Share of measured poses that are off by up to 0.5 mm and any angle
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub wrong: f64,
    /// Share of intervals in which a robot does not move
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub stalls: f64,
    /// Share of intervals before which a robot slips by up to 10 um and 3 deg
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub slips: f64,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub report: ReportArguments,
}

#[derive(Debug, Args)]
pub struct ControlArguments {
    /// The program
    pub file: PathBuf,
    /// Control this task; required if the program has several
    #[arg(long, value_name = "NAME")]
    pub task: Option<String>,
    /// Wait for one connection at this address of this machine instead of using standard input and output
    #[arg(long, value_name = "HOST:PORT|unix:PATH", value_parser = Address::parse)]
    pub listen: Option<Address>,
    /// Record all lines in a new MCAP file
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub report: ReportArguments,
}

impl SimulateArguments {
    /// Disturbances in addition to the errors of the device.
    pub fn disturbances(&self) -> Disturbances {
        let SimulateArguments { delay, lost, wrong, stalls, slips, .. } = *self;
        Disturbances { delay_ns: delay, lost, wrong, stalls, slips }
    }
}

/// Greatest number of trials in one simulation.
const MAX_TRIALS: i64 = 1_000_000;

#[derive(Debug, Args)]
pub struct CompletionsArguments {
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Clone, Args)]
pub struct Settings {
    /// Replace a top-level `let`, such as pitch=80um, or lab.pitch=80um in a used file
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
}

#[derive(Debug, Clone, Copy, Args)]
pub struct QuietArgument {
    /// Report only errors and warnings
    #[arg(short = 'q', long = "quiet")]
    pub is_quiet: bool,
}

#[derive(Debug, Clone, Args)]
pub struct ReportArguments {
    /// Format of diagnostics on standard error; with `json`, the report of a build, a verification or a simulation is JSON too
    #[arg(long, value_enum, default_value = "human")]
    pub format: ReportFormat,
}
