//! `tmam explain`

use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use super::quiet::Quiet;
use super::simulate::read_world;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::core::geometry::Vec2;
use crate::core::legible::quoted;
use crate::core::replay::Replay;
use crate::core::world::World;
use crate::io::log;
use crate::io::output::{Output, show};
use crate::observe::progress::Progress;
use crate::observe::report;
use crate::tools::evaluate::Truth;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::explain::{Question, Which, explain, suspects, write_json};

/// Tell the whole story of one arc: why it was labelled so, and what would have changed that
///
/// Name an arc by its sonar and a frame or a time, or by a place in the map; or list the arcs whose
/// labels are contradicted most.
///
/// Exit codes: 0 done; 2 usage, configuration, no such arc, or input that cannot be read; 3 done, but
/// the log is incomplete, there was nothing to replay, or no label that could be suspect.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    group = clap::ArgGroup::new("which").required(true),
    after_help = "\
Examples:
  tmam explain drive.mcap --sensor sonar_03 --frame 57
  tmam explain drive.mcap --sensor sonar_03 --time 12.5
  tmam explain drive.mcap --at 3.95,2.02          what passes through this corner
  tmam explain drive.mcap --suspects=20           the 20 most doubtful labels"
)]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// The arc that the sonar gave this frame
    #[arg(long, value_name = "K", group = "which")]
    frame: Option<u32>,
    /// The sonar's arc nearest to this many seconds after the first reading
    #[arg(long, value_name = "S", group = "which", value_parser = seconds)]
    time: Option<f64>,
    /// The arc that passes nearest to this place, metres in the odometry frame
    ///
    /// Of any sonar where none is named.
    #[arg(
        long,
        value_name = "X,Y",
        group = "which",
        allow_hyphen_values = true,
        value_parser = place
    )]
    at: Option<Vec2>,
    /// List so many arcs whose labels are contradicted most [default: 10]
    ///
    /// The worst come first.
    #[arg(
        long,
        value_name = "N",
        group = "which",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "10",
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    suspects: Option<u32>,
    /// What really echoed, as a world in JSON [default: the truth in the log]
    #[arg(long, value_name = "WORLD.json", value_parser = read_world)]
    truth: Option<World>,
    /// Tell it in JSON (tmam.explanation/1, tmam.suspects/1)
    ///
    /// SI units and radians.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
    /// Tell what did not decide, too: pairs, and what the other rule would say
    #[arg(short, long, conflicts_with = "suspects")]
    verbose: bool,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(mut self) -> Result<Exit, Error> {
        // Here --sensor names an arc; it does not keep readings out of the replay.
        let sonars = self.parameters.take_sensors();
        let config = self.parameters.of_tmam("explain")?;
        let (log, recorded) = log::read_with_truth(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let setting = replay.setting();
        let named = format!(
            "{}{}",
            quoted(&self.log.display().to_string()),
            self.parameters.as_typed()
        );
        let mut progress = Progress::new(&setting, !self.quiet.is_set());
        let (outcome, found) = if let Some(which) = self.which() {
            let question = Question { sonars, which };
            let truth = Truth::if_known(&replay, &recorded, self.truth, AGREEING_RANGE)?;
            let (outcome, told) = explain(&replay, &question, truth.as_ref(), &mut progress)?;
            drop(progress);
            if self.json {
                Output::whole(Path::new("-"), |out| {
                    write_json(out, "tmam.explanation/1", &setting, &told)
                })?;
            } else {
                show(&told.text(&setting, &named, self.verbose), false)?;
            }
            (outcome, true)
        } else {
            let most = self.suspects.unwrap_or_default();
            let most = usize::try_from(most).unwrap_or(usize::MAX);
            let (outcome, list) = suspects::list(&replay, &sonars, most, &mut progress)?;
            drop(progress);
            if self.json {
                Output::whole(Path::new("-"), |out| {
                    write_json(out, "tmam.suspects/1", &setting, &list)
                })?;
            } else {
                show(&suspects::text(&setting, &named, &list), false)?;
            }
            (outcome, list.labels > 0)
        };
        let problems = report::problems(&log, &setting, &outcome);
        show(&self.quiet.less(problems), true)?;
        Ok(Exit::of_whole(found && setting.source.complete))
    }

    fn which(&self) -> Option<Which> {
        let frame = self.frame.map(Which::Frame);
        let time = self.time.map(Which::Time);
        frame.or(time).or(self.at.map(Which::Place))
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse::<f64>().ok();
    seconds
        .filter(|s| s.is_finite() && *s >= 0.0)
        .ok_or_else(|| "seconds after the log's first reading, 0 or more".to_owned())
}

fn place(text: &str) -> Result<Vec2, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    text.split_once(',')
        .and_then(|(x, y)| Some(Vec2::new(number(x)?, number(y)?)))
        .ok_or_else(|| "a place is two numbers in metres, X,Y: 3.95,2.02".to_owned())
}
