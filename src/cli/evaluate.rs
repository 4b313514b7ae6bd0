//! `tmam evaluate`

use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use super::quiet::Quiet;
use super::simulate::{WorldFile, world_file};
use crate::cli::error::Error;
use crate::cli::named::{ending_in, is_folder};
use crate::core::config::Config;
use crate::core::exit::Exit;
use crate::core::observer::{Kept, Observer};
use crate::core::replay::{Replay, ReplayError};
use crate::io::drives::{self, Drive};
use crate::io::log;
use crate::io::output::{is_stdout, print, show};
use crate::io::outputs::{Requested, Settled};
use crate::observe::progress::{Progress, ReplaysProgress};
use crate::observe::recording::Recording;
use crate::observe::report;
use crate::tools::evaluate::drawing::overlay;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::evaluate::{Evaluation, Truth, text, write};
use crate::tools::fleet::Fleet;
use crate::tools::fleet::replayed::Replayed;
use crate::tools::golden::carried;
use crate::tools::sweep::score::TruthScore;

/// Score a replay against the truth: labels, suspects, features and their covariances
///
/// The truth is what the log carries itself, as `tmam simulate` writes it, or a world file, in
/// which the echo model says what each arc came from.
///
/// Exit codes: 0 done; 2 usage, configuration, no truth, or input that cannot be read; 3 done, but the
/// log is incomplete, no arc could be labelled, or there was nothing to replay.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Examples:
  tmam simulate -o room.mcap --noise 0.003
  tmam evaluate room.mcap                         with the truth in the log
  tmam evaluate drive.mcap --truth hall.json      with walls and points that were surveyed
  tmam evaluate room.mcap --gamma 5 --json | jq .labels.wrong_share"
)]
pub struct Args {
    /// MCAP logs, folders of them, or patterns; several are told in a table, the worst first
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// The world in JSON [default: the truth in the log]
    ///
    /// Metres in the odometry frame: {"walls": [[x1,y1,x2,y2], ...], "points": [[x,y], ...], "pillars":
    /// [[x,y,radius], ...]}
    #[arg(long, value_name = "WORLD.json", value_parser = world_file)]
    truth: Option<WorldFile>,
    /// A range agrees with the echo model within this, or five of its standard deviations
    #[arg(long, value_name = "M", default_value_t = AGREEING_RANGE)]
    agree: f64,
    /// Write a recording here, with the truth and the errors in it
    ///
    /// Of several logs it is the folder for recordings.
    #[arg(short, long = "output", value_name = "FILE.rrd", value_parser = ending_in("rrd"))]
    output: Option<PathBuf>,
    /// Tell it in JSON (tmam.evaluation/1): SI units and radians
    ///
    /// Of several logs it is a line each (tmam.replayed/1).
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
    /// How many logs to replay at a time; 0: one per processor [default: 0]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    jobs: usize,
    #[command(flatten)]
    parameters: Parameters,
}

/// Where the truth is another world's.
const NO_FIT: &str = "warning: hardly a range agrees with the world; is it in the odometry frame, in metres, and \
of this place?\n";

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
        let told = self.evaluate(log, config, self.requested(), true)?;
        show(&told.summary.problems, true)?;
        if !self.json {
            show(&told.text, told.outputs.to_stdout())?;
        }
        show(told.doubts, true)?;
        told.outputs.commit()?;
        Ok(told.summary.exit)
    }

    fn several(&self, drives: &[Drive], config: &Config) -> Result<Exit, Error> {
        let logs = drives.len();
        let folders = Requested {
            evaluation: None,
            ..self.requested()
        };
        if folders.paths().into_iter().flatten().any(is_stdout) {
            let flag = "-";
            return Err(Error::ForOneLog { flag, logs });
        }
        if let Some(path) = self.output.clone().filter(|path| !is_folder(path)) {
            return Err(Error::FileOfSeveral { path, logs });
        }
        let progress = ReplaysProgress::new(logs, "logs", !self.quiet.is_set());
        let fleet = Fleet::run(drives, self.jobs, |drive| {
            let told = self.evaluate(&drive.path, config, folders.of_drive(&drive.name), false);
            progress.tick();
            let Told {
                mut summary,
                doubts,
                outputs,
                ..
            } = told?;
            outputs.commit().map_err(Error::from)?;
            summary.problems += doubts;
            Ok(summary)
        })?;
        drop(progress);
        show(&fleet.problems(), true)?;
        if self.json {
            print(&fleet.json_lines())?;
        } else {
            show(&fleet.table(&Replayed::AGAINST_TRUTH), false)?;
        }
        Ok(fleet.exit())
    }

    fn requested(&self) -> Requested {
        Requested {
            recording: self.output.clone(),
            evaluation: self.json.then(|| PathBuf::from("-")),
            inputs: (self.parameters.file().map(PathBuf::from).into_iter())
                .chain(self.truth.iter().map(|world| world.path.clone()))
                .collect(),
            ..Requested::default()
        }
    }

    fn evaluate(
        &self,
        path: &Path,
        config: &Config,
        requested: Requested,
        with_progress: bool,
    ) -> Result<Told, Error> {
        let (log, recorded) = log::read_with_truth(path, config)?;
        let replay = Replay::new(&log, config)?;
        let world = self.truth.as_ref().map(|file| file.world.clone());
        let truth = Truth::new(&replay, &recorded, world, self.agree)?;
        let asked = requested.paths().iter().any(Option::is_some);
        let mut outputs = asked.then(|| requested.open(path)).transpose()?;

        let mut kept = Kept::default();
        let is_recorded = outputs.as_ref().is_some_and(|o| o.recording.is_some());
        let mut progress =
            with_progress.then(|| Progress::new(&replay.setting(), !self.quiet.is_set()));
        let mut observers: Vec<&mut dyn Observer> = Vec::new();
        observers.extend(is_recorded.then_some(&mut kept as &mut dyn Observer));
        observers.extend(progress.as_mut().map(|it| it as &mut dyn Observer));
        let outcome = replay.run(&mut observers)?;
        drop(progress);
        let evaluation = Evaluation::new(&truth, &replay.path(&outcome), &outcome);
        let setting = replay.setting();
        let mut settled = Settled::default();
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
            settled = outputs.settle()?;
        }
        let problems = self.quiet.less(report::problems(&log, &setting, &outcome));
        let score = Some(TruthScore::new(&evaluation));
        let mut summary = Replayed::new(&setting, &outcome, score, problems);
        let fits = evaluation.labels.fits_the_world();
        let is_scored = setting.source.complete && evaluation.labels.given() > 0 && fits;
        summary.exit = Exit::of_whole(is_scored);
        let text = text::text(&setting, &truth, &evaluation);
        Ok(Told {
            summary,
            text: text + &report::written(&settled.files()),
            outputs: settled,
            doubts: if fits { "" } else { NO_FIT },
        })
    }
}

/// What is told of a log that was held against the truth.
struct Told {
    summary: Replayed,
    text: String,
    outputs: Settled,
    doubts: &'static str,
}
