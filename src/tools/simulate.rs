//! A robot with a sonar ring in a world of walls and points, written as a ROS 2 log with the truth
//! in it.
//!
//! Same parameters, same bytes, on every platform: random numbers come from ChaCha8 with a stream
//! each for the ranges, the odometry, false echoes and rough walls, so changing one leaves the others
//! alone.

mod error;
mod false_echoes;
mod late;
mod motion;
mod noise;
mod path;
mod random;
mod ring;
mod untold;

use std::io::{Seek, Write};

use crate::core::truth::{PoseTruth, ReadingTruth};
use crate::core::world::World;
use crate::io::log::writer::{LogWriter, RangeMessage};

pub use error::SimulateError;
use error::{known, require};
pub use false_echoes::FalseEchoes;
use false_echoes::Listener;
pub use late::LateStretch;
use motion::Action;
pub use motion::{Driving, Motion, Stepwise};
use noise::{DriftingOdometry, NoisySonar};
pub use noise::{OdometryNoise, RangeNoise};
pub use path::Path;
use random::Random;
pub use ring::Ring;
pub use untold::Untold;

/// When every simulated log starts: 2015-01-01T00:00:00Z, nanoseconds.
pub const START_NS: i64 = 1_420_070_400_000_000_000;

/// All that a simulated log depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// What there is to hear.
    pub world: World,
    /// Share of its walls that are made diffuse, besides those that are, 0 to 1.
    pub diffuse: f64,
    /// Where the robot goes.
    pub path: Path,
    /// How it goes there and when its sonars fire.
    pub motion: Motion,
    /// The sonars.
    pub ring: Ring,
    /// What goes wrong with their ranges.
    pub range_noise: RangeNoise,
    /// What they hear in place of an echo.
    pub false_echoes: FalseEchoes,
    /// What goes wrong with the odometry.
    pub odometry_noise: OdometryNoise,
    /// What the log says otherwise than it is.
    pub untold: Untold,
    /// When its ranges are stamped late.
    pub late: Option<LateStretch>,
    /// Sonars that give no echo, by name.
    pub silent: Vec<String>,
    /// The log does not say what really was.
    pub without_truth: bool,
    /// Chooses the noise; equal seeds give equal noise.
    pub seed: u64,
}

/// The paper's room in its steps, without noise.
impl Default for Simulation {
    fn default() -> Self {
        Self {
            world: World::room(),
            diffuse: 0.0,
            path: Path::room(),
            motion: Motion::Stepwise(Stepwise::default()),
            ring: Ring::default(),
            range_noise: RangeNoise::default(),
            false_echoes: FalseEchoes::default(),
            odometry_noise: OdometryNoise::default(),
            untold: Untold::default(),
            late: None,
            silent: Vec::new(),
            without_truth: false,
            seed: 1,
        }
    }
}

impl Simulation {
    /// Drives the path and writes the log; gives the output back.
    pub fn write<W: Write + Seek>(&self, output: W) -> Result<W, SimulateError> {
        self.ring.validate()?;
        self.range_noise.validate()?;
        self.false_echoes.validate()?;
        self.odometry_noise.validate()?;
        let world = self.roughened()?;
        let told = self.ring.mounts();
        self.untold.validate(&told)?;
        for mount in &told {
            let least = self.untold.range(&mount.name, self.ring.min_range as f32);
            require(
                least >= 0.0,
                "the smallest range that a sonar says, metres,",
                f64::from(least),
                "0 or more: give a larger --min-range or a smaller offset",
            )?;
        }
        for name in &self.silent {
            known(name, told.iter().map(|mount| mount.name.as_str()))?;
        }
        let mut ticks = self.motion.schedule(&self.path, self.ring.sonars)?;
        if let Some(late) = &self.late {
            let readings = ticks
                .iter()
                .filter(|tick| matches!(tick.action, Action::Fire(_)));
            late.validate(readings.map(|tick| tick.after_ns).max().unwrap_or_default())?;
        }
        for tick in &mut ticks {
            if let Action::Fire(sonar) = tick.action {
                let name = told.get(sonar).map_or("", |mount| mount.name.as_str());
                let delay_ns = (self.late.as_ref()).map_or(0, |late| late.delay_ns(tick.after_ns));
                tick.after_ns = self
                    .untold
                    .stamp_after_ns(tick.after_ns.saturating_add(delay_ns), name);
            }
        }
        ticks.sort_by_key(|tick| tick.after_ns);
        let mounts = self.untold.mounts(&told);

        let mut log = LogWriter::new(output)?;
        let mounted: Vec<_> = told.iter().map(ring::Mount::transform).collect();
        log.static_transforms(START_NS, &mounted)?;
        if !self.without_truth {
            log.world(START_NS, &world)?;
        }

        let mut listener = Listener::new(self.false_echoes, &world, &self.ring, &mounts, self.seed);
        let mut sonar_noise = NoisySonar::new(self.range_noise, self.seed);
        let mut odometry =
            DriftingOdometry::new(self.odometry_noise, self.untold.odometry(), self.seed);
        for tick in ticks {
            let stamp_ns = START_NS.saturating_add(tick.after_ns);
            match tick.action {
                Action::Odometry(twist) => {
                    let odom_from_robot = odometry.sample(tick.world_from_robot);
                    log.odometry(stamp_ns, odom_from_robot, twist)?;
                    if odometry.drifts() && !self.without_truth {
                        log.true_pose(&PoseTruth::new(stamp_ns, tick.world_from_robot))?;
                    }
                }
                Action::Fire(sonar) => {
                    let Some(mount) = mounts.get(sonar) else {
                        continue;
                    };
                    let heard = listener.hear(sonar, mount, tick.world_from_robot);
                    let heard_range = heard.range.filter(|_| !self.silent.contains(&mount.name));
                    let measured = sonar_noise.measure(heard_range, &self.ring);
                    log.range(&self.message(stamp_ns, &mount.name, measured.range))?;
                    if self.without_truth {
                        continue;
                    }
                    let truth =
                        ReadingTruth::new(stamp_ns, &mount.name, heard.echo, measured.outlier);
                    log.truth(&ReadingTruth {
                        false_echo: heard.false_echo.filter(|_| !measured.outlier),
                        ..truth
                    })?;
                }
            }
        }
        Ok(log.finish()?)
    }

    /// The world with as many of its walls diffuse as asked for, chosen by the seed.
    fn roughened(&self) -> Result<World, SimulateError> {
        let share = self.diffuse;
        let allowed = (0.0..=1.0).contains(&share);
        require(allowed, "the share of diffuse walls", share, "0 to 1")?;
        let mut random = Random::new(self.seed, 3);
        let walls = 0..self.world.walls().len();
        let mut drawn: Vec<(f64, usize)> = walls.map(|wall| (random.uniform(), wall)).collect();
        drawn.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let rough = libm::round(share * drawn.len() as f64) as usize;
        let rough: Vec<usize> = drawn.iter().take(rough).map(|(_, wall)| *wall).collect();
        Ok(self.world.clone().with_diffuse(&rough)?)
    }

    fn message<'a>(&self, stamp_ns: i64, sonar: &'a str, range: f32) -> RangeMessage<'a> {
        let said = |distance: f32| self.untold.range(sonar, distance);
        RangeMessage {
            stamp_ns,
            sonar,
            field_of_view: self.ring.beam_width as f32,
            min_range: said(self.ring.min_range as f32),
            max_range: said(self.ring.max_range as f32),
            range: said(range),
            variance: self.range_noise.variance() as f32,
        }
    }
}

#[cfg(test)]
mod tests;
