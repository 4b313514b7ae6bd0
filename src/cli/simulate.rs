//! `tmam simulate`

use std::io::{Cursor, Write as _};
use std::path::PathBuf;

use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::world::{World, WorldError};
use crate::io::config::file::{assignment, check, parse_layers};
use crate::io::output::Output;
use crate::io::outputs::refuse_collisions;
use crate::io::text_file::read_text;
use crate::tools::simulate::{
    Driving, FalseEchoes, LateStretch, Motion, OdometryNoise, Path, RangeNoise, Ring,
    SimulateError, Simulation, Stepwise, Untold,
};

/// Simulate a robot with a sonar ring and write a ROS 2 MCAP log with the truth in it
///
/// The log holds sensor_msgs/Range, nav_msgs/Odometry, /tf and /tf_static as a robot would record
/// them. What really echoed is on /truth, the world itself on /truth/world, and where odometry is noisy
/// the true poses are on /truth/pose, all in JSON. Equal options give equal bytes.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  tmam simulate -o room.mcap                       the paper's room in 150 steps, without noise
  tmam simulate -o room.mcap --drive --noise 0.003
  tmam simulate -o rough.mcap --drive --noise 0.003 --diffuse 0.3 --cross-talk 0.05
  tmam simulate -o turned.mcap --drive --noise 0.003 --needs sonar.sonar_04.yaw=93
  tmam simulate -o late.mcap --drive --noise 0.003 --needs input.range_delay=0.1
  tmam simulate -o hall.mcap --world hall.json --waypoints \"0,0 5,0 5,3 0,0\" --sonars 8"
)]
pub struct Args {
    /// Where the log goes; - is standard output
    #[arg(short, long, value_name = "FILE.mcap", value_parser = ending_in("mcap"))]
    output: PathBuf,

    /// World in JSON [default: the paper's L-shaped room]
    ///
    /// Metres: {"walls": [[x1,y1,x2,y2], ...], "points": [[x,y], ...], "pillars": [[x,y,radius], ...],
    /// "diffuse": [wall, ...]}
    #[arg(long, value_name = "FILE", value_parser = world_file, requires = "waypoints", help_heading = "World")]
    world: Option<WorldFile>,

    /// Way-points in metres, "x,y x,y ..." [default: a loop of 18 m through the room]
    ///
    /// End where you begin for a loop.
    #[arg(
        long,
        value_name = "POINTS",
        allow_hyphen_values = true,
        help_heading = "World"
    )]
    waypoints: Option<Path>,

    /// How often the way-points are driven round, where they end where they begin
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        help_heading = "World",
        hide_short_help = true
    )]
    laps: u16,

    /// How long the way-points are driven round, hours
    #[arg(
        long,
        value_name = "H",
        requires = "drive",
        conflicts_with_all = ["laps", "steps"],
        help_heading = "World", hide_short_help = true)]
    hours: Option<f64>,

    /// Share of the walls that are rough, 0 to 1
    ///
    /// Beside the foot of the perpendicular they echo from their nearest place in the beam.
    #[arg(long, value_name = "P", default_value_t = 0.0, help_heading = "World")]
    diffuse: f64,

    /// Drive without stopping, instead of stopping at each step for all to fire
    ///
    /// One sonar fires at a time.
    #[arg(long, help_heading = "Motion")]
    drive: bool,

    /// Distance between steps, metres
    #[arg(long, value_name = "M", default_value_t = Stepwise::default().step, conflicts_with = "drive", help_heading = "Motion", hide_short_help = true)]
    step: f64,

    /// Number of steps [default: once along the way-points]
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "drive",
        help_heading = "Motion",
        hide_short_help = true
    )]
    steps: Option<usize>,

    /// Time between steps, seconds
    #[arg(long, value_name = "S", default_value_t = Stepwise::default().interval, conflicts_with = "drive", help_heading = "Motion", hide_short_help = true)]
    step_interval: f64,

    /// At each step turn once round, and let all sonars fire after each turn by this, degrees: a dense scan
    #[arg(
        long,
        value_name = "DEG",
        conflicts_with = "drive",
        help_heading = "Motion",
        hide_short_help = true
    )]
    scan: Option<f64>,

    /// Driving speed, metres per second
    #[arg(long, value_name = "M/S", default_value_t = Driving::default().speed, requires = "drive", help_heading = "Motion", hide_short_help = true)]
    speed: f64,

    /// Speed of turning in place, degrees per second
    #[arg(long, value_name = "DEG/S", default_value_t = Driving::default().turn_rate.to_degrees(), requires = "drive", help_heading = "Motion", hide_short_help = true)]
    turn_rate: f64,

    /// Time from one sonar's shot to the next one's while driving, seconds
    #[arg(long, value_name = "S", default_value_t = Driving::default().firing_interval, requires = "drive", help_heading = "Motion", hide_short_help = true)]
    firing_interval: f64,

    /// Odometry samples per second while driving
    #[arg(long, value_name = "HZ", default_value_t = Driving::default().odometry_rate, requires = "drive", help_heading = "Motion", hide_short_help = true)]
    odometry_rate: f64,

    /// Number of sonars, evenly round the robot and facing outward
    #[arg(long, value_name = "N", default_value_t = Ring::default().sonars, help_heading = "Sonars")]
    sonars: usize,

    /// Distance of the sonars from the robot's origin, metres
    #[arg(long, value_name = "M", default_value_t = Ring::default().radius, help_heading = "Sonars", hide_short_help = true)]
    ring_radius: f64,

    /// Full opening angle of a beam, degrees
    #[arg(long, value_name = "DEG", default_value_t = Ring::default().beam_width.to_degrees(), help_heading = "Sonars", hide_short_help = true)]
    beam_width: f64,

    /// Closest distance that a sonar measures, metres; closer is -inf
    #[arg(long, value_name = "M", default_value_t = Ring::default().min_range, help_heading = "Sonars", hide_short_help = true)]
    min_range: f64,

    /// Farthest distance that a sonar measures, metres; farther is +inf
    #[arg(long, value_name = "M", default_value_t = Ring::default().max_range, help_heading = "Sonars", hide_short_help = true)]
    max_range: f64,

    /// Standard deviation of a range, metres
    #[arg(long, value_name = "M", default_value_t = 0.0, help_heading = "Noise")]
    noise: f64,

    /// Probability that an echo is not heard, 0 to 1
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    no_echo: f64,

    /// Probability that a reading is replaced by a random range, 0 to 1
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    outliers: f64,

    /// Probability that a reading is of another sonar's sound, 0 to 1
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    cross_talk: f64,

    /// Probability that a reading is of sound that came by way of two walls, where it can, 0 to 1
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    double_reflections: f64,

    /// Standard deviation of the odometry's distance after 1 m, metres
    ///
    /// It grows with the square root.
    #[arg(long, value_name = "M", default_value_t = 0.0, help_heading = "Noise")]
    odometry_noise: f64,

    /// Standard deviation of the odometry's heading after 1 m, degrees; grows with the square root
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    heading_noise: f64,

    /// Standard deviation of the odometry's heading after turning by 1 rad, degrees; grows with
    /// the square root
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        help_heading = "Noise",
        hide_short_help = true
    )]
    turn_noise: f64,

    /// A key of the configuration that the log will need to be right, repeatable
    ///
    /// The robot is as it says, and the log says what it would without.
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment, help_heading = "Faults")]
    needs: Vec<String>,

    /// Stamp ranges of FROM to TO seconds after the start DELAY seconds late
    #[arg(long, value_name = "FROM:TO:DELAY", help_heading = "Faults")]
    late: Option<LateStretch>,

    /// A sonar that never gives an echo, repeatable
    #[arg(
        long,
        value_name = "NAME",
        help_heading = "Faults",
        hide_short_help = true
    )]
    silent: Vec<String>,

    /// Leave out of the log what really was
    #[arg(long, help_heading = "World", hide_short_help = true)]
    no_truth: bool,

    /// Chooses the noise: equal seeds give equal noise
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Noise")]
    seed: u64,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let path = self.output.clone();
        let inputs: Vec<_> = self.world.iter().map(|file| file.path.as_path()).collect();
        refuse_collisions(&inputs, &[Some(&path)])?;
        Output::try_out(&path)?;
        let layers: Vec<&str> = self.needs.iter().map(String::as_str).collect();
        let needed = parse_layers(&layers).map_err(|source| Error::Needs { source })?;
        check(&needed).map_err(|source| Error::Needs { source })?;
        let simulation = Simulation {
            untold: Untold(needed),
            ..Simulation::try_from(self)?
        };
        let log = simulation.write(Cursor::new(Vec::new()))?;
        Output::whole(&path, |out| out.write_all(log.get_ref()))?;
        Ok(Exit::Done)
    }
}

impl TryFrom<Args> for Simulation {
    type Error = SimulateError;

    fn try_from(args: Args) -> Result<Self, SimulateError> {
        let motion = if args.drive {
            Motion::Driving(Driving {
                speed: args.speed,
                turn_rate: args.turn_rate.to_radians(),
                firing_interval: args.firing_interval,
                odometry_rate: args.odometry_rate,
                duration: args.hours.map(|hours| 3600.0 * hours),
            })
        } else {
            Motion::Stepwise(Stepwise {
                step: args.step,
                steps: args.steps,
                interval: args.step_interval,
                scan: args.scan.map(f64::to_radians),
            })
        };
        let path = args.waypoints.unwrap_or_else(Path::room);
        Ok(Self {
            world: args.world.map_or_else(World::room, |file| file.world),
            diffuse: args.diffuse,
            path: path.repeated(args.laps)?,
            motion,
            ring: Ring {
                sonars: args.sonars,
                radius: args.ring_radius,
                beam_width: args.beam_width.to_radians(),
                min_range: args.min_range,
                max_range: args.max_range,
            },
            range_noise: RangeNoise {
                sigma: args.noise,
                no_echo: args.no_echo,
                outliers: args.outliers,
            },
            false_echoes: FalseEchoes {
                cross_talk: args.cross_talk,
                double_reflections: args.double_reflections,
            },
            odometry_noise: OdometryNoise {
                distance: args.odometry_noise,
                heading: args.heading_noise.to_radians(),
                turn: args.turn_noise.to_radians(),
            },
            untold: Untold::default(),
            late: args.late,
            silent: args.silent,
            without_truth: args.no_truth,
            seed: args.seed,
        })
    }
}

/// A world that a flag names.
#[derive(Debug, Clone)]
pub(super) struct WorldFile {
    pub path: PathBuf,
    pub world: World,
}

/// Reads a world, to keep its file's name beside it.
pub(super) fn world_file(path: &str) -> Result<WorldFile, WorldError> {
    let world = read_world(path)?;
    let path = PathBuf::from(path);
    Ok(WorldFile { path, world })
}

/// Reads a world that a flag names.
pub(super) fn read_world(path: &str) -> Result<World, WorldError> {
    World::from_json(&read_text(path)?)
}
