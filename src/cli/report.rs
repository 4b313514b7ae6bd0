//! `tmam report`

use std::io::Write as _;
use std::path::PathBuf;

use super::parameters::Parameters;
use super::quiet::Quiet;
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::least_explained::least_explained;
use crate::core::legible::quoted;
use crate::core::replay::Replay;
use crate::io::log;
use crate::io::output::{Output, show};
use crate::io::outputs::{Settled, refuse_collisions};
use crate::observe::causes;
use crate::observe::progress::Progress;
use crate::observe::report::{problems, written};
use crate::tools::report::page::page;

/// Replay a log and write what was found on one page of HTML, with the map
///
/// The page needs nothing else, no network either: for a ticket, or as an artefact of CI.
///
/// Exit codes: 0 done; 2 usage, configuration or input that cannot be read; 3 done, but the log is
/// incomplete or holds no echo, or there was nothing to replay.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Examples:
  tmam report drive.mcap -o drive.html
  tmam report drive.mcap -o drive.html --rule paper"
)]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Write the page here; `-` is standard output
    #[arg(short, long = "output", value_name = "FILE.html", value_parser = ending_in("html"))]
    output: PathBuf,
    /// Do not look for what is off: mounts, beams, clocks, scales
    #[arg(long)]
    no_causes: bool,
    #[command(flatten)]
    quiet: Quiet,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let inputs = std::iter::once(self.log.as_path()).chain(self.parameters.file());
        refuse_collisions(&inputs.collect::<Vec<_>>(), &[Some(&self.output)])?;
        let log = log::read(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let setting = replay.setting();
        let mut outcome = replay.run(&mut [&mut Progress::new(&setting, !self.quiet.is_set())])?;
        if !self.no_causes {
            outcome.causes = causes::look_for(&replay, &outcome);
        }
        outcome.stretch = least_explained(&replay, &outcome);
        let problems = problems(&log, &setting, &outcome);
        let path = replay.path(&outcome);
        let named = quoted(&self.log.display().to_string()) + &self.parameters.as_typed();
        let html = page(&setting, &outcome, &path, &named, &problems);
        let mut out = Output::create(&self.output)?;
        out.write_all(html.as_bytes())
            .map_err(|source| out.failed(source))?;
        let output = Settled::new([out])?;
        show(&self.quiet.less(problems), true)?;
        if !self.quiet.is_set() {
            show(&written(&output.files()), false)?;
        }
        output.commit()?;
        Ok(Exit::of_whole(
            setting.source.complete && outcome.tally.echoes > 0,
        ))
    }
}
