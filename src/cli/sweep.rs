//! `tmam sweep`

use std::path::{Path, PathBuf};

use super::parameters::Selection;
use super::quiet::Quiet;
use super::simulate::read_world;
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::world::World;
use crate::io::output::{Output, show};
use crate::io::outputs::{Settled, refuse_collisions};
use crate::observe::progress::ReplaysProgress;
use crate::observe::recording::write_grid;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::sweep::{AxisError, Grid, Plan, Request, SweepError, TruthSource, files, text};

/// Replay a log under every combination of parameters, and rank them
///
/// VALUES are A:B:STEP with both ends, a list with commas, or a single number, in the unit of
/// tmam.toml. With the truth, cells are ranked by the errors of their maps, then by their wrong
/// labels; without it by how well their own map explains their readings, which is how a wrong mount
/// or a late clock shows itself.
///
/// Exit codes: 0 done; 2 usage, configuration or input that cannot be read, or not one cell could be
/// replayed; 3 done, but the log is incomplete or holds no echo.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Examples:
  tmam sweep drive.mcap --alpha 0.3:0.7:0.1 --gamma 6,8,10 -o grid.rrd
  tmam sweep drive.mcap --set sonar.front.yaw=-5:5:0.5        is a mount off?
  tmam sweep drive.mcap --set input.range_delay=-0.2:0.4:0.05 is a clock late?
  tmam sweep room.mcap --step 0.05:0.3:0.05 --sort wrong_share --csv grid.csv"
)]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Rank by this column of the CSV first
    #[arg(long, value_name = "COLUMN")]
    sort: Option<String>,
    /// Cells to show in the table
    #[arg(long, value_name = "N", default_value_t = 20, conflicts_with = "json")]
    rows: usize,
    /// Write every cell here, - for standard output
    #[arg(long, value_name = "FILE.csv", value_parser = ending_in("csv"))]
    csv: Option<PathBuf>,
    /// Tell it in JSON (tmam.sweep/1)
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
    /// Write the grid as pictures for the Rerun viewer here
    #[arg(short, long = "output", value_name = "FILE.rrd", value_parser = ending_in("rrd"))]
    output: Option<PathBuf>,
    /// The world in JSON, to hold cells against [default: the truth in the log]
    #[arg(long, value_name = "WORLD.json", value_parser = read_world)]
    truth: Option<World>,
    /// Do not look at the truth, even if there is one
    #[arg(long, conflicts_with = "truth", hide_short_help = true)]
    no_truth: bool,
    /// A range agrees with the echo model within this, or five of its standard deviations
    #[arg(long, value_name = "M", default_value_t = AGREEING_RANGE, hide_short_help = true)]
    agree: f64,
    /// Threads to replay in [default: one per processor]
    ///
    /// The result is the same.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    #[command(flatten)]
    axes: Axes,
    #[command(flatten)]
    selection: Selection,
}

/// What is swept.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Grid")]
struct Axes {
    /// Values of triple.alpha: a contact arc has theta_c < ALPHA * theta_i
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    alpha: Option<String>,
    /// Values of triple.beta: an intersection arc has theta_c > BETA * theta_i
    #[arg(
        long,
        value_name = "VALUES",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    beta: Option<String>,
    /// Values of triple.gamma, degrees: gate on the smaller angle
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    gamma: Option<String>,
    /// Values of frames.step, metres: way that opens a new frame
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    step: Option<String>,
    /// Values of frames.step_angle, degrees: turn that opens a new frame
    #[arg(
        long,
        value_name = "VALUES",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    step_angle: Option<String>,
    /// Values of map.match_distance, metres: points nearer than this are one
    #[arg(
        long,
        value_name = "VALUES",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    match_distance: Option<String>,
    /// Values of any other key, repeatable: sonar.front.yaw=-5:5:1
    ///
    /// A text or a switch holds for all cells: rule=paper, noise_aware.merge=false
    #[arg(long, value_name = "KEY=VALUES")]
    set: Vec<String>,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let (csv_path, output) = (self.csv.as_deref(), self.output.as_deref());
        let stdout = self.json.then_some(Path::new("-"));
        let inputs = std::iter::once(self.log.as_path()).chain(self.selection.file());
        refuse_collisions(&inputs.collect::<Vec<_>>(), &[csv_path, output, stdout])?;
        let grid = self.grid()?;
        let config = self
            .selection
            .configuration(&self.axes.request()?.settings)?;
        for path in [csv_path, output].into_iter().flatten() {
            Output::try_out(path)?;
        }
        let progress = ReplaysProgress::new(grid.cells(), "cells", !self.quiet.is_set());
        let plan = Plan {
            log: &self.log,
            config: &config,
            grid,
            truth: match (self.no_truth, self.truth.clone()) {
                (true, _) => TruthSource::None,
                (false, None) => TruthSource::Log,
                (false, Some(world)) => TruthSource::World(world),
            },
            agreeing_range: self.agree,
            threads: self.threads,
            sort: self.sort.clone(),
        };
        let sweep = plan.run(&|| progress.tick())?;
        drop(progress);

        let mut outputs = Vec::new();
        if let Some(path) = csv_path {
            let mut out = Output::create(path)?;
            files::csv(&mut out, &sweep).map_err(|source| out.failed(source))?;
            outputs.push(out);
        }
        if let Some(path) = output {
            let mut out = Output::create(path)?;
            let grid = files::drawn(&sweep).map_err(|source| out.failed(source))?;
            write_grid(&mut out, &grid)?;
            outputs.push(out);
        }
        let outputs = Settled::new(outputs)?;
        if self.json {
            Output::whole(Path::new("-"), |out| files::json(out, &sweep))?;
        } else if !outputs.to_stdout() {
            show(&text::text(&sweep, self.rows), false)?;
        }
        show(&self.quiet.less(text::problems(&sweep)), true)?;
        outputs.commit()?;
        Ok(Exit::of_whole(sweep.log.is_complete() && sweep.has_arcs()))
    }

    fn grid(&self) -> Result<Grid, SweepError> {
        let axes = self.axes.request()?.axes;
        let twice = axes.iter().find(|axis| self.selection.gives(&axis.key()));
        if let Some(axis) = twice {
            return Err(AxisError::SweptTwice { key: axis.key() }.into());
        }
        Ok(Grid::new(axes)?)
    }
}

impl Axes {
    fn request(&self) -> Result<Request, SweepError> {
        let flags = [
            ("triple.alpha", &self.alpha),
            ("triple.beta", &self.beta),
            ("triple.gamma", &self.gamma),
            ("frames.step", &self.step),
            ("frames.step_angle", &self.step_angle),
            ("map.match_distance", &self.match_distance),
        ];
        let flags = flags.map(|(key, values)| (key, values.as_deref()));
        Ok(Request::new(&flags, &self.set)?)
    }
}
