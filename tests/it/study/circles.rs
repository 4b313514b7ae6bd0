//! From which radius, noise and swept angle on a pillar can be told from a point and a wall; what comes of pillars
//! in a hall; and how often something else is taken for one.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use tmam_replay::core::event::SonarId;
use tmam_replay::core::geometry::{Pose2, Vec2};
use tmam_replay::core::tmam::arc::{Arc, ArcId};
use tmam_replay::core::tmam::hypothesis::{Gate, HypothesisTest};
use tmam_replay::core::tmam::label::Kind;
use tmam_replay::tools::evaluate::Evaluation;
use tmam_replay::tools::evaluate::map::KindScore;

use super::tables::{Row, each, mean, percent, sum, table as markdown};

/// Passes of each cell of the first table.
const PASSES: u32 = 100;
/// The nearest range of a pass, metres.
const RANGE: f64 = 1.0;
/// Bounds as they are by default.
const GATE: f64 = 6.63;
const DECISIVE: f64 = 13.0;

/// Of windows of 21 readings: what they decide for, by the radius and the angle that the bearing of the axis sweeps.
pub fn windows() -> String {
    let mut text = String::from(
        "| radius m | noise mm | 22.5 deg | 45 deg | 67.5 deg | 90 deg |\n|---:|---:|---|---|---|---|\n",
    );
    for radius in [0.0, 0.05, 0.1, 0.2, 0.4, 0.8] {
        for sigma in [0.001, 0.003, 0.010] {
            let _ = write!(text, "| {radius} | {:.0} |", sigma * 1e3);
            for swept in [22.5_f64, 45.0, 67.5, 90.0] {
                let [circle, point, line] = decided(radius, sigma, swept.to_radians());
                let _ = write!(text, " {circle} / {point} / {line} |");
            }
            text.push('\n');
        }
    }
    text
}

/// Per cent of passes that decide for a circle, a point and a line.
fn decided(radius: f64, sigma: f64, swept: f64) -> [u32; 3] {
    let mut noise = Noise(ChaCha8Rng::seed_from_u64(1));
    let gate = Gate::new(GATE);
    let mut counts = [0; 3];
    for _ in 0..PASSES {
        let arcs = pass(radius, sigma, swept, &mut noise);
        let test = HypothesisTest::with_circles(true, &arcs, &gate);
        if let Some(kind) = test.decided(DECISIVE) {
            let place = match kind {
                Kind::Circle => 0,
                Kind::Point => 1,
                Kind::Line => 2,
            };
            counts[place] += 1;
        }
    }
    counts.map(|count| (100 * count + PASSES / 2) / PASSES)
}

fn pass(radius: f64, sigma: f64, swept: f64, noise: &mut Noise) -> Vec<Arc> {
    let center = Vec2::new(0.0, RANGE + radius);
    let reach = center.y * libm::tan(swept / 2.0);
    let one = |k: u32| {
        let x = reach * (f64::from(k) / 10.0 - 1.0);
        Arc {
            id: ArcId {
                frame: k,
                sonar: SonarId(0),
            },
            stamp_ns: i64::from(k),
            world_from_sensor: Pose2::new(x, 0.0, FRAC_PI_2),
            range: (center - Vec2::new(x, 0.0)).norm() - radius + sigma * noise.normal(),
            beam_width: swept + 0.02,
            variance: sigma * sigma,
        }
    };
    (0..=20).map(one).collect()
}

/// Normal deviates, the same in every run.
struct Noise(ChaCha8Rng);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut uniform = || ((self.0.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        (-2.0 * libm::log(uniform())).sqrt() * libm::cos(std::f64::consts::TAU * uniform())
    }
}

/// What comes of drives with and without pillars.
pub fn drives(rows: &[Row]) -> String {
    let circles = |run: &Evaluation| run.confirmed.circles.clone();
    let count = |run: &Evaluation, of: fn(&KindScore) -> u64| circles(run).as_ref().map_or(0, of);
    let of_label = |run: &Evaluation, right: bool| {
        run.labels.circle.map_or(0, |class| match right {
            true => class.arcs.circle,
            false => class.arcs.total() - class.arcs.circle,
        })
    };
    markdown(
        rows,
        &[
            ("labels circle, right", &|r| each(r, |e| of_label(e, true))),
            ("wrong", &|r| each(r, |e| of_label(e, false))),
            ("wrong of all labels %", &|r| {
                percent(
                    sum(r, |e| e.labels.wrong_labels()),
                    sum(r, |e| e.labels.given()),
                )
            }),
            ("pillars found %", &|r| {
                percent(
                    sum(r, |e| count(e, |kind| kind.matched)),
                    sum(r, |e| count(e, |kind| kind.visible)),
                )
            }),
            ("circles that are none", &|r| {
                each(r, |e| count(e, KindScore::surplus))
            }),
            ("place off mm", &|r| {
                mean(r, |e| Some(circles(e)?.errors.position?.mean * 1e3), 1)
            }),
            ("radius off mm", &|r| {
                mean(r, |e| Some(circles(e)?.errors.radius?.mean * 1e3), 1)
            }),
            ("NEES", &|r| mean(r, |e| circles(e)?.errors.nees.mean, 2)),
            ("points that are none", &|r| {
                each(r, |e| e.confirmed.points.surplus())
            }),
            ("walls and points missed", &|r| {
                each(r, |e| {
                    (e.confirmed.lines.missed.len() + e.confirmed.points.missed.len()) as u64
                })
            }),
        ],
    )
}
