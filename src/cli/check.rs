//! `tmam check`

use std::io::{self, Write as _};
use std::path::PathBuf;

use super::parameters::Parameters;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::core::legible::inert_line;
use crate::io::drives;
use crate::io::output::{print, print_aside};
use crate::tools::check::text::{closing, report};
use crate::tools::check::{
    Options, ReportFiles, Suite, annotations, exit, json, markdown, refused,
};
use crate::tools::golden::{SHOWN, is_set};

/// Hold logs to golden files: has anything changed that should not have?
///
/// Replays each log with the configuration recorded in its golden file, DIR/LOG.golden.json, and
/// compares the map, the extracted features and the label of every arc, within the tolerances in
/// that file. With --config FILE, with that configuration, which ships: what of it is otherwise differs.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Exit codes, the gravest of all logs: 2 usage, or a log or golden file that cannot be read; 1 differs; \
3 nothing to judge: no golden file, an incomplete log, no echoes, no log in this part; 0 all match.

Examples:
  tmam check drives/*.mcap --golden golden --bless          write the golden files
  tmam check drives/*.mcap --golden golden                  hold the logs to them
  tmam check drives/*.mcap --golden golden --artifacts out --junit out/junit.xml
  tmam check drives/*.mcap --golden golden --config tmam.toml   does what ships give the same?"
)]
pub struct Args {
    /// The MCAP logs, or folders of them
    ///
    /// Of a folder each log in it is meant; the parts of one recording, as `ros2 bag` splits it, are one log.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Directory of the golden files
    #[arg(long, value_name = "DIR")]
    golden: PathBuf,
    /// Where a log differs, write what shows the differences here
    ///
    /// A recording of them, a picture, and what the log gives now.
    #[arg(long, value_name = "DIR", conflicts_with = "bless")]
    artifacts: Option<PathBuf>,
    /// Record only so many frames around each difference [default: 20]
    #[arg(long, value_name = "FRAMES", num_args = 0..=1, require_equals = true, default_missing_value = "20", requires = "artifacts", hide_short_help = true)]
    only_around_differences: Option<u32>,
    /// What to compare
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Compared::All)]
    compare: Compared,
    /// What is required of the results, besides that they stay
    ///
    /// A file with `[require]` and lines such as walls = ">= 6".
    #[arg(long, value_name = "FILE.toml")]
    suite: Option<PathBuf>,
    /// Labels that flipped with next to nothing to spare are differences, too
    #[arg(long, hide_short_help = true)]
    strict: bool,
    /// Check part I of N only; the parts are the same wherever they run
    #[arg(long, value_name = "I/N", hide_short_help = true)]
    partition: Option<String>,
    /// Write a JUnit report
    #[arg(long, value_name = "FILE.xml", help_heading = "Reports")]
    junit: Option<PathBuf>,
    /// Write a Markdown summary
    #[arg(long, value_name = "FILE.md", help_heading = "Reports")]
    summary: Option<PathBuf>,
    /// Tell nothing of logs that match
    #[arg(short, long, conflicts_with = "json", help_heading = "Reports")]
    quiet: bool,
    /// Print the report in JSON (tmam.check/1): SI units and radians
    #[arg(long, help_heading = "Reports")]
    json: bool,
    /// How many differences of a kind to print
    #[arg(long, value_name = "N", default_value_t = SHOWN, help_heading = "Reports")]
    show: usize,
    /// Write or update the golden files instead, and tell what changed
    ///
    /// Of the configuration in an existing one, only the parameters given here change.
    #[arg(long, help_heading = "Blessing")]
    bless: bool,
    /// Bless even where CI is set
    #[arg(
        long,
        requires = "bless",
        help_heading = "Blessing",
        hide_short_help = true
    )]
    force: bool,
    /// A tolerance to bless with, repeatable: rho=0.02 (metres and radians)
    #[arg(
        long,
        value_name = "KEY=VALUE",
        requires = "bless",
        help_heading = "Blessing",
        hide_short_help = true
    )]
    tolerance: Vec<String>,
    #[command(flatten)]
    parameters: Parameters,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Compared {
    /// Everything: map, extracted features, the label of every arc
    All,
    /// Only the confirmed features of the map and where they are, as for drives made again
    Map,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let outcome = self.check();
        if let (Err(error), true) = (&outcome, in_github()) {
            print_aside(&annotations::refused(error))?;
        }
        outcome
    }

    fn check(self) -> Result<Exit, Error> {
        let (with_artifacts, bless) = (self.artifacts.is_some(), self.bless);
        let logs = drives::logs(&self.logs);
        let options = Options {
            logs: logs.as_ref().cloned().unwrap_or_default(),
            golden: self.golden,
            artifacts: self.artifacts,
            around: self.only_around_differences,
            bless: self.bless,
            force: self.force,
            strict: self.strict,
            tolerances: self.tolerance,
            partition: self.partition,
            only_map: self.compare == Compared::Map,
            suite: self.suite,
            ..Options::default()
        };
        let (junit, summary) = (self.junit.as_deref(), self.summary.as_deref());
        options.refuse_collisions(junit, summary, self.parameters.file(), self.json)?;
        let files = ReportFiles::open(junit, summary)?;
        let ready = logs.map_err(Error::from);
        let suite = match ready.and_then(|_| prepare(options, &self.parameters)) {
            Ok(suite) => suite,
            Err(error) => {
                files.refuse(&error)?;
                if self.json {
                    print(&format!("{:#}\n", refused(&error)))?;
                }
                return Err(error);
            }
        };
        // A report that other programs read stands alone.
        let print = if files.take_stdout() {
            print_aside
        } else {
            print
        };
        // The reports are written even where standard output cannot be.
        let mut printed = Ok(());
        let mut say = |text: &str| {
            if printed.is_ok() {
                printed = print(text);
            }
        };
        let reports = suite.run(|one| {
            let is_told = !self.quiet || exit(std::slice::from_ref(one)) != Exit::Done;
            if !self.json && is_told {
                say(&report(one, self.show, self.strict));
            }
        });
        files.write(&reports, suite.notes(), self.strict)?;

        let errors = if in_github() {
            annotations::annotations(&reports, suite.notes(), self.strict)
        } else {
            String::new()
        };
        if self.json {
            let _ = io::stderr().write_all(errors.as_bytes());
            say(&format!("{:#}\n", json(&reports, suite.notes())));
        } else {
            say(&errors);
            for note in suite.notes() {
                say(&format!("note: {}\n", inert_line(note)));
            }
            say(&closing(&reports, with_artifacts));
            if bless {
                say("\nto paste into the review:\n\n");
                say(&markdown(&reports, suite.notes(), self.strict));
            }
        }
        printed?;
        Ok(exit(&reports))
    }
}

fn in_github() -> bool {
    std::env::var("GITHUB_ACTIONS").is_ok_and(|value| is_set(&value))
}

/// What can be wrong with what is given, once the reports can say so.
fn prepare(options: Options, parameters: &Parameters) -> Result<Suite, Error> {
    let layers = parameters.layers()?;
    let options = match parameters.file() {
        Some(_) if !options.bless => Options {
            shipped: Some(layers),
            ..options
        },
        _ => Options { layers, ..options },
    };
    Ok(Suite::new(options)?)
}
