//! Live report of a build: prints line by line as the build proceeds.

use super::{Detail, WrittenSchedule, checked, planned, subjects, verified, width, wrote};
use crate::check::Checked;
use crate::claims::Claims;
use crate::cli::Exit;
use crate::cli::disk;
use crate::cli::terminal;
use crate::cli::waiting::ProgressLine;
use crate::compile::CompileObserver;
use crate::emit::Format;
use crate::plan::watch::SearchWatch;
use crate::quantity::count;
use crate::schedule::Schedule;
use crate::verify::Verified;
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// What the report needs to know of the build.
pub struct ReportedBuild<'a> {
    pub program: &'a Path,
    pub settings: &'a [String],
    pub output: &'a Path,
    pub formats: &'a BTreeSet<Format>,
    /// Whether lines are printed at all.
    pub is_printed: bool,
    /// Whether all lines are printed, with the search effort.
    pub detail: Detail,
}

/// The report of a running build.
pub struct LiveReport<'a> {
    build: ReportedBuild<'a>,
    search: Arc<SearchWatch>,
    waiting: Option<ProgressLine>,
    /// Since when a run has been planned.
    planned: Option<Instant>,
    /// Search effort for each run of the current schedule.
    searched: Vec<String>,
    /// Width of the column of names.
    width: usize,
    exit: Exit,
}

impl<'a> LiveReport<'a> {
    /// Starts the report and its progress line.
    pub fn begin(build: ReportedBuild<'a>) -> LiveReport<'a> {
        let search = Arc::<SearchWatch>::default();
        let waiting = Some(ProgressLine::begin(&search));
        LiveReport { build, search, waiting, planned: None, searched: Vec::new(), width: 0, exit: Exit::Done }
    }

    /// The watch of its searches.
    pub fn search(&self) -> Arc<SearchWatch> {
        Arc::clone(&self.search)
    }

    /// Ends all planning and removes the progress line.
    pub fn end_planning(&mut self) {
        self.waiting = None;
    }

    /// Ends the report without files written; returns the exit status of printing it.
    pub fn end(self) -> Exit {
        self.exit
    }

    /// Prints the last lines once everything is written; returns the exit status of printing the report.
    pub fn wrote(mut self, schedules: &[Verified], written: &[WrittenSchedule]) -> Exit {
        self.width = self.width.max(width(written.iter().flat_map(WrittenSchedule::names)));
        for (verified, written) in schedules.iter().zip(written) {
            self.print(&wrote(verified.schedule(), written, self.width));
        }
        self.exit
    }

    fn print(&mut self, text: &str) {
        if !self.build.is_printed {
            return;
        }
        let print = || terminal::answer(text);
        let exit = match &self.waiting {
            Some(waiting) => waiting.beside(print),
            None => print(),
        };
        self.exit = self.exit.max(exit);
    }

    /// Records the search effort of the run that was planned last; the time is shown only on a terminal.
    fn note_searched(&mut self) {
        let Some(begin) = self.planned.take() else { return };
        let mut text = match self.search.progress().steps {
            0 => "nothing: the plan needs no search".to_owned(),
            steps => count(steps, "step"),
        };
        if std::io::stdout().is_terminal() {
            text.push_str(&format!(" in {:.2} s", begin.elapsed().as_secs_f64()));
        }
        self.searched.push(text);
    }

    fn file(&self) -> String {
        self.build.program.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Width of all names that are known before planning.
    fn known_width(&self, claims: &[Claims]) -> usize {
        let endings = || self.build.formats.iter().flat_map(|format| format.endings());
        let shown = |name: &str, ending: &str| disk::shown(self.build.output, &format!("{name}.{ending}"));
        let files = claims.iter().flat_map(|claims| endings().map(|ending| shown(&claims.name, ending)));
        let settings = self.build.settings.iter().map(|setting| format!("--set {setting}"));
        let shown_subjects = |claims| subjects(claims).take(self.build.detail.most_lines());
        let names = files.map(|path| path.to_string_lossy().into_owned());
        width(claims.iter().flat_map(shown_subjects).chain(names).chain(settings).chain([self.file()]))
    }
}

impl CompileObserver for LiveReport<'_> {
    fn checked(&mut self, program: &Checked) {
        self.width = self.known_width(&program.claims);
        let text = checked(&self.file(), program.tally, self.build.settings, self.width);
        self.print(&text);
    }

    fn planning(&mut self, index: usize, count: usize, task: &str) {
        self.note_searched();
        if index == 0 {
            // The effort of a schedule that got no plan.
            self.searched.clear();
        }
        self.planned = Some(Instant::now());
        if let Some(waiting) = &self.waiting {
            waiting.at(index, count, task);
        }
    }

    fn scheduled(&mut self, schedule: &Schedule, claims: &Claims) {
        self.note_searched();
        let mut text = planned(schedule, claims, self.width, self.build.detail);
        let searched = std::mem::take(&mut self.searched);
        if self.build.detail == Detail::Full {
            let line = |(run, steps): (String, String)| terminal::line("Searched", &run, self.width, &steps);
            text.extend(subjects(claims).zip(searched).map(line));
        }
        self.print(&text);
    }

    fn verified(&mut self, schedule: &Verified) {
        let text = verified(schedule.schedule(), self.width);
        self.print(&text);
    }
}

/// Totals over all programs of one build.
pub struct Totals {
    begin: Instant,
    asked: usize,
    programs: usize,
    schedules: usize,
    files: usize,
}

impl Totals {
    /// Totals for `asked` programs.
    pub fn of(asked: usize) -> Totals {
        Totals { begin: Instant::now(), asked, programs: 0, schedules: 0, files: 0 }
    }

    /// Counts a built program.
    pub fn add(&mut self, schedules: usize, files: usize) {
        self.programs += 1;
        self.schedules += schedules;
        self.files += files;
    }

    /// The last line of the report. The time is shown only on a terminal, so that a saved report has the same bytes the
    /// next time. Empty if nothing was built.
    pub fn line(&self) -> String {
        if self.programs == 0 {
            return String::new();
        }
        let programs = match (self.asked, self.programs) {
            (1, _) => String::new(),
            (asked, built) if asked == built => format!("{asked} programs, "),
            (asked, built) => format!("{built} of {asked} programs, "),
        };
        let mut text = format!("{programs}{} in {}", count(self.schedules, "schedule"), count(self.files, "file"));
        if std::io::stdout().is_terminal() {
            text.push_str(&format!(", {:.2} s", self.begin.elapsed().as_secs_f64()));
        }
        terminal::line("Done", &text, 0, "")
    }
}
