//! Scratch harness.
use std::io::Cursor;
use tmam_replay::core::calibrate::{candidate::Estimates, change::Change, parameter::*};
use tmam_replay::core::config::Config;
use tmam_replay::core::event::SonarId;
use tmam_replay::core::replay::Replay;
use tmam_replay::core::world::World;
use tmam_replay::io::log::read_with_truth_in;
use tmam_replay::tools::calibrate::search::search;
use tmam_replay::tools::simulate::*;
use tmam_replay::tools::sweep::score::Score;

fn log(sigma: f64, seed: u64, office: bool, drift: bool) -> tmam_replay::Log {
    let (world, path) = if office {
        let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/sample_logs/");
        (
            World::from_json(&std::fs::read_to_string(format!("{dir}office.world.json")).unwrap())
                .unwrap(),
            std::fs::read_to_string(format!("{dir}office.waypoints"))
                .unwrap()
                .trim()
                .parse::<Path>()
                .unwrap(),
        )
    } else {
        (World::room(), Path::room())
    };
    let simulation = Simulation {
        world,
        diffuse: 0.0,
        path,
        motion: Motion::Driving(Driving::default()),
        ring: Ring::default(),
        range_noise: RangeNoise {
            sigma,
            ..RangeNoise::default()
        },
        false_echoes: FalseEchoes::default(),
        odometry_noise: if drift {
            OdometryNoise {
                distance: 0.01,
                heading: 0.0035,
                turn: 0.0087,
            }
        } else {
            OdometryNoise::default()
        },
        seed,
    };
    let bytes = simulation
        .write(Cursor::new(Vec::new()))
        .unwrap()
        .into_inner();
    read_with_truth_in(Cursor::new(bytes), "s.mcap", &Config::default())
        .unwrap()
        .0
}

#[test]
#[ignore]
fn probe() {
    let env = |k: &str, d: &str| std::env::var(k).unwrap_or(d.into());
    let sigma: f64 = env("S", "0.003").parse().unwrap();
    let seed: u64 = env("SEED", "1").parse().unwrap();
    let mut log = log(
        sigma,
        seed,
        env("OFFICE", "") == "1",
        env("DRIFT", "") == "1",
    );
    let s = Whose::One(SonarId(6));
    let v: f64 = env("V", "0").parse().unwrap();
    let p = match env("P", "delay").as_str() {
        "delay" => Parameter::RangeDelay,
        "rate" => Parameter::ClockRate,
        "odo" => Parameter::OdometryScale,
        "turn" => Parameter::OdometryTurnScale,
        "x" => Parameter::Sonar(s, Quantity::X),
        "y" => Parameter::Sonar(s, Quantity::Y),
        "yaw" => Parameter::Sonar(s, Quantity::Yaw),
        "scale" => Parameter::Sonar(s, Quantity::RangeScale),
        "offset" => Parameter::Sonar(s, Quantity::RangeOffset),
        "width" => Parameter::Sonar(Whose::All, Quantity::BeamWidth),
        "scaleall" => Parameter::Sonar(Whose::All, Quantity::RangeScale),
        _ => panic!(),
    };
    let mut change = Change::default();
    change.add(p, v);
    change.apply(&mut log.events);
    let mut config = Config::default();
    change.apply_clocks(&mut config);
    let t = std::time::Instant::now();
    let replay = Replay::new(&log, &config).unwrap();
    let outcome = replay.run(&mut []).unwrap();
    let tr = t.elapsed();
    let score = Score::new(&outcome, None);
    println!(
        "bits {:?} expl {} of {} susp {} joint {:?}",
        score.bits,
        score.explained,
        score.arcs,
        score.suspects,
        outcome.poses.as_ref().map(|p| p
            .as_ref()
            .map(|j| (j.drift, j.scales))
            .map_err(|e| e.to_string()))
    );
    let t = std::time::Instant::now();
    let e = Estimates::new(&replay, &outcome);
    let te = t.elapsed();
    if env("FULL", "") == "1" {
        for g in e.groups() {
            if let Some(c) = e.of(&g) {
                println!(
                    "  {:?} gain {:.1}",
                    c.values
                        .iter()
                        .map(|v| (v.parameter, v.value, v.deviation))
                        .collect::<Vec<_>>(),
                    c.gain
                );
            }
        }
    }
    for c in e.candidates().iter().take(8) {
        println!(
            "  cand {:?} gain {:.1}",
            c.values
                .iter()
                .map(|v| (v.parameter, v.value, v.deviation))
                .collect::<Vec<_>>(),
            c.gain
        );
    }
    let t = std::time::Instant::now();
    let found = search(&replay, &outcome);
    for c in &found.causes {
        println!(
            "CAUSE {:?} bits {:?} -> {:?}, expl {:?} -> {:?}, rivals {:?}",
            c.values
                .iter()
                .map(|v| (v.parameter, v.value, v.deviation))
                .collect::<Vec<_>>(),
            c.results[0].bits.per_arc(),
            c.results[1].bits.per_arc(),
            c.results[0].bits.explained_share(),
            c.results[1].bits.explained_share(),
            c.rivals
                .iter()
                .map(|r| r.iter().map(|v| (v.parameter, v.value)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        );
    }
    println!(
        "replay {tr:?} estimate {te:?} search {:?} {} replays",
        t.elapsed(),
        found.replays
    );
}
