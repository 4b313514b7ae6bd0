//! `tmam evaluate`

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use super::simulate::read_world;
use crate::error::{DONE, Error, INCOMPLETE};
use crate::evaluate::truth::AGREEING_RANGE;
use crate::evaluate::{Truth, evaluate, json, text};
use crate::log;
use crate::output::Output;
use crate::replay::Replay;
use crate::report;
use crate::world::World;

/// Score a replay against the truth: labels, suspects, features and their covariances
///
/// The truth is what the log carries itself, as `tmam simulate` writes it, or a world file, in
/// which the echo model says what each arc came from.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Exit codes: 0 done; 2 usage, configuration, no truth, or input that cannot be read; 3 done, but the \
log is incomplete or holds no echo, or there was nothing to replay.

Examples:
  tmam simulate -o room.mcap --noise 0.003
  tmam evaluate room.mcap                         with the truth in the log
  tmam evaluate drive.mcap --truth hall.json      with walls and points that were surveyed
  tmam evaluate room.mcap --gamma 5 --json | jq .labels.wrong_share"
)]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// The world in JSON, metres in the odometry frame: {"walls": [[x1,y1,x2,y2], ...], "points":
    /// [[x,y], ...]} [default: the truth in the log]
    #[arg(long, value_name = "WORLD.json", value_parser = read_world)]
    truth: Option<World>,
    /// A range agrees with the echo model within this, or five of its standard deviations
    #[arg(long, value_name = "M", default_value_t = AGREEING_RANGE)]
    agree: f64,
    /// Tell it in JSON (tmam.evaluation/1): SI units and radians
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<u8, Error> {
        let config = self.parameters.configuration()?;
        let (log, recorded) = log::read_with_truth(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let truth = Truth::new(&replay, &recorded, self.truth, self.agree)?;
        let (outcome, evaluation) = evaluate(&replay, &truth)?;
        let setting = replay.setting();
        if self.json {
            let mut out = Output::create(Path::new("-"))?;
            json::write(&mut out, &setting, &truth, &evaluation)
                .map_err(|source| out.failed(source))?;
            out.commit()?;
        } else {
            let text = text::text(&setting, &truth, &evaluation);
            // A reader that has gone away has seen enough.
            let _ = io::stdout().write_all(text.as_bytes());
        }
        let _ = io::stderr().write_all(report::problems(&log, &outcome).as_bytes());
        let judged = setting.source.complete && outcome.tally.echoes > 0;
        Ok(if judged { DONE } else { INCOMPLETE })
    }
}
