//! `tmam evaluate`

use std::path::PathBuf;

use super::parameters::Parameters;
use super::simulate::{WorldFile, world_file};
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::observer::Kept;
use crate::core::replay::{Replay, ReplayError};
use crate::io::log;
use crate::io::output::show;
use crate::io::outputs::{Requested, Written};
use crate::observe::recording::Recording;
use crate::observe::report;
use crate::tools::evaluate::drawing::overlay;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::evaluate::{Evaluation, Truth, text, write};
use crate::tools::golden::carried;

/// Score a replay against the truth: labels, suspects, features and their covariances
///
/// The truth is what the log carries itself, as `tmam simulate` writes it, or a world file, in
/// which the echo model says what each arc came from.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Exit codes: 0 done; 2 usage, configuration, no truth, or input that cannot be read; 3 done, but the \
log is incomplete, no arc could be labelled, or there was nothing to replay.

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
    #[arg(long, value_name = "WORLD.json", value_parser = world_file)]
    truth: Option<WorldFile>,
    /// A range agrees with the echo model within this, or five of its standard deviations
    #[arg(long, value_name = "M", default_value_t = AGREEING_RANGE)]
    agree: f64,
    /// Write a recording for the Rerun viewer here, with the truth and the errors in it
    #[arg(short, long = "output", value_name = "FILE.rrd", value_parser = ending_in("rrd"))]
    output: Option<PathBuf>,
    /// Tell it in JSON (tmam.evaluation/1): SI units and radians
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    parameters: Parameters,
}

/// Where the truth is another world's.
const NO_FIT: &str = "warning: hardly a range agrees with the world; is it in the odometry frame, in metres, and \
of this place?\n";

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let (log, recorded) = log::read_with_truth(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let world = self.truth.as_ref().map(|file| file.world.clone());
        let truth = Truth::new(&replay, &recorded, world, self.agree)?;
        let asked = self.output.is_some() || self.json;
        let requested = Requested {
            recording: self.output,
            evaluation: self.json.then(|| PathBuf::from("-")),
            inputs: (self.parameters.file().map(PathBuf::from).into_iter())
                .chain(self.truth.iter().map(|world| world.path.clone()))
                .collect(),
            ..Requested::default()
        };
        let mut outputs = asked.then(|| requested.open(&self.log)).transpose()?;

        let mut kept = Kept::default();
        let is_recorded = outputs.as_ref().is_some_and(|o| o.recording.is_some());
        let outcome = if is_recorded {
            replay.run(&mut [&mut kept])?
        } else {
            replay.run(&mut [])?
        };
        let evaluation = Evaluation::new(&truth, &replay.path(&outcome), &outcome);
        let setting = replay.setting();
        let mut written = Written::default();
        if let Some(mut outputs) = outputs.take() {
            if let Some(out) = &mut outputs.recording {
                let overlay = overlay(&setting, &truth, &evaluation, &outcome.map);
                let mut recording = Recording::new(Some(out), None, setting, overlay)?;
                kept.show(&mut recording).map_err(ReplayError::from)?;
                let carried = carried(&setting, &outcome)?;
                recording.close(Some(&carried))?;
            }
            if let Some(out) = &mut outputs.evaluation {
                write(&mut *out, &setting, &truth, &evaluation)
                    .map_err(|source| out.failed(source))?;
            }
            written = outputs.commit()?;
        }
        show(&report::problems(&log, &setting, &outcome), true)?;
        if !self.json {
            let text = text::text(&setting, &truth, &evaluation);
            let text = text + &report::written(&written.files);
            show(&text, written.to_stdout)?;
        }
        let fits = evaluation.labels.fits_the_world();
        if !fits {
            show(NO_FIT, true)?;
        }
        let is_scored = setting.source.complete && evaluation.labels.given() > 0 && fits;
        Ok(Exit::of_whole(is_scored))
    }
}
