//! `tmam info`

use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use super::quiet::Quiet;
use crate::cli::error::Error;
use crate::core::config::Config;
use crate::core::exit::Exit;
use crate::io::drives::{self, Drive};
use crate::io::log::survey::survey;
use crate::io::output::{Output, show};
use crate::observe::progress::{Doing, ReplaysProgress};
use crate::tools::findings::trial::attempted;
use crate::tools::fleet::Fleet;
use crate::tools::info::{Info, text};

/// Tell what a log holds, whether it can be replayed, and what it lacks
///
/// Channels, sonars, odometry and clocks as the log has them, what is wrong with them in order of
/// weight, and the part of tmam.toml that would make a log work that does not.
///
/// Exit codes: 0 the log is whole and can be replayed as it is; 2 usage, configuration or a file that
/// cannot be read; 3 told, but the log is incomplete, or cannot be replayed as it is, or holds no echo.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tmam info drive.mcap                            what is in it and what is wrong with it
  tmam info drives/*.mcap                         which of them have something wrong
  tmam info drive.mcap --skeleton > tmam.toml     what its configuration must say
  tmam info drive.mcap --json | jq .findings      for machines")]
pub struct Args {
    /// MCAP logs, folders of them, or patterns; several are told in a table, the worst first
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Tell it in JSON (tmam.info/1): SI units and radians
    ///
    /// Of several logs one document comes after the other.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
    /// Print only the keys that the configuration lacks, as TOML
    #[arg(long, conflicts_with = "json")]
    skeleton: bool,
    /// Do not look for what is off: mounts, beams, clocks, scales
    #[arg(long, conflicts_with = "skeleton")]
    no_causes: bool,
    /// How many logs to look into at a time; 0: one per processor [default: 0]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    jobs: usize,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let logs = drives::logs(&self.logs)?;
        match logs.as_slice() {
            [log] => self.one(log, &config),
            _ => self.several(&drives::drives(logs), &config),
        }
    }

    fn one(&self, log: &Path, config: &Config) -> Result<Exit, Error> {
        let mut doing = Doing::new(!self.quiet.is_set());
        let info = self.info(log, config, &mut |what| doing.tell(what))?;
        drop(doing);
        if self.json {
            Output::whole(Path::new("-"), |out| info.write(out))?;
        } else if self.skeleton {
            show(info.skeleton.as_deref().unwrap_or_default(), false)?;
        } else {
            show(&text::text(&info), false)?;
        }
        Ok(Exit::of_whole(info.is_fine()))
    }

    fn several(&self, drives: &[Drive], config: &Config) -> Result<Exit, Error> {
        if self.skeleton {
            return Err(Error::ForOneLog {
                flag: "--skeleton",
                logs: drives.len(),
            });
        }
        let progress = ReplaysProgress::new(drives.len(), "logs", !self.quiet.is_set());
        let fleet = Fleet::run(drives, self.jobs, |drive| {
            let info = self.info(&drive.path, config, &mut |_| ());
            progress.tick();
            Ok(info?)
        })?;
        drop(progress);
        show(&fleet.problems(), true)?;
        if self.json {
            let mut told = fleet.told();
            Output::whole(Path::new("-"), |out| {
                told.try_for_each(|info| info.write(out))
            })?;
        } else {
            show(&fleet.table(&Info::COLUMNS), false)?;
        }
        Ok(fleet.exit())
    }

    fn info(&self, log: &Path, config: &Config, tell: &mut dyn FnMut(&str)) -> Result<Info, Error> {
        tell("reading");
        let survey = survey(log, config)?;
        tell("replaying");
        let mut info = Info::new(&survey, &|config| attempted(log, config));
        if !self.no_causes && !self.skeleton {
            tell("looking for what is off");
            info.look_for_causes(&survey);
        }
        Ok(info)
    }
}
