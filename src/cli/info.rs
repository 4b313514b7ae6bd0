//! `tmam info`

use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::io::log::survey::survey;
use crate::io::output::{Output, show};
use crate::tools::findings::trial::attempted;
use crate::tools::info::{Info, text};

/// Tell what a log holds, whether it can be replayed, and what it lacks
///
/// Channels, sonars, odometry and clocks as the log has them, what is wrong with them in order of
/// weight, and the part of tmam.toml that would make a log work that does not.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit codes: 0 the log is whole and can be replayed as it is; 2 usage, configuration or a file that \
cannot be read; 3 told, but the log is incomplete, or cannot be replayed as it is, or holds no echo.

Examples:
  tmam info drive.mcap                            what is in it and what is wrong with it
  tmam info drive.mcap --skeleton > tmam.toml     what its configuration must say
  tmam info drive.mcap --json | jq .findings      for machines")]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Tell it in JSON (tmam.info/1): SI units and radians
    #[arg(long)]
    json: bool,
    /// Print only the keys that the configuration lacks, as TOML
    #[arg(long, conflicts_with = "json")]
    skeleton: bool,
    /// Do not look for what is off: mounts, beams, clocks, scales
    #[arg(long, conflicts_with = "skeleton")]
    no_causes: bool,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let survey = survey(&self.log, &config)?;
        let mut info = Info::new(&survey, &|config| attempted(&self.log, config));
        if !self.no_causes && !self.skeleton {
            info.look_for_causes(&survey);
        }
        if self.json {
            Output::whole(Path::new("-"), |out| info.write(out))?;
        } else if self.skeleton {
            show(info.skeleton.as_deref().unwrap_or_default(), false)?;
        } else {
            show(&text::text(&info), false)?;
        }
        Ok(Exit::of_whole(info.is_fine()))
    }
}
