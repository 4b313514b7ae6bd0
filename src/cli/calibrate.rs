//! `tmam calibrate`

use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use super::quiet::Quiet;
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::replay::Replay;
use crate::io::config::changed::with_keys;
use crate::io::config::file::ConfigError;
use crate::io::log;
use crate::io::output::{Output, show, write_whole};
use crate::observe::progress::Progress;
use crate::observe::report;
use crate::tools::calibrate::{Calibration, text};

/// Tell what a log says of its mounts, beams, clocks and scales, and what of these is off
///
/// Every value is held against the ranges; what is clearly off is tried: the log is replayed with it, and it
/// counts only where the log's own map then explains the readings better. Needs no truth.
///
/// Exit codes: 0 done; 2 usage, configuration or input that cannot be read; 3 done, but the log is
/// incomplete, or there was nothing to replay.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tmam calibrate drive.mcap                       what is off, and what the log cannot tell
  tmam calibrate drive.mcap --write tmam.toml     and the configuration that mends it
  tmam calibrate drive.mcap --json | jq .keys     for machines")]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Write the configuration here: what is given, with the keys that mend what is off
    #[arg(long, value_name = "FILE.toml", value_parser = ending_in("toml"))]
    write: Option<PathBuf>,
    /// Tell it in JSON (tmam.calibration/1): SI units and radians
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.of_tmam("calibrate")?;
        if let Some(path) = &self.write {
            Output::try_out(path)?;
        }
        let log = log::read(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let setting = replay.setting();
        let mut progress = Progress::new(&setting, !self.quiet.is_set());
        let outcome = replay.run(&mut [&mut progress])?;
        drop(progress);
        let calibration = Calibration::new(&replay, &outcome);
        if self.json {
            Output::whole(Path::new("-"), |out| calibration.write(out))?;
        } else {
            show(&text::text(&calibration), false)?;
        }
        let problems = report::problems(&log, &setting, &outcome);
        show(&self.quiet.less(problems), true)?;
        if let Some(path) = &self.write {
            let given = self.parameters.layers()?;
            let text = with_keys(&given, &calibration.keys()).map_err(ConfigError::from)?;
            write_whole(path, text.as_bytes())?;
        }
        let whole = log.losses.is_empty() && outcome.tally.echoes > 0;
        Ok(Exit::of_whole(whole))
    }
}
