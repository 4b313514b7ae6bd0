//! The table of `docs/calibrate.md`: logs in each of which one thing is off, and what is found.
//!
//! It takes long, so it runs when asked for: `TMAM_SEEDS` says with how many seeds, `TMAM_CASES` which
//! rows. It fails where the page does not hold what it finds, and puts it there under `TMAM_UPDATE_DOCS=1`.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;

use tmam_replay::Log;
use tmam_replay::core::calibrate::change::Change;
use tmam_replay::core::calibrate::parameter::{Parameter, Quantity, Whose};
use tmam_replay::core::calibrate::search::{Effort, Search, search};
use tmam_replay::core::config::Config;
use tmam_replay::core::event::SonarId;
use tmam_replay::core::replay::Replay;
use tmam_replay::core::world::World;
use tmam_replay::io::log::read_with_truth_in;
use tmam_replay::tools::simulate::{
    Driving, FalseEchoes, Motion, OdometryNoise, Path, RangeNoise, Ring, Simulation, Untold,
};

use crate::study::drives::{path_of, world_of};

/// Where the table stands on the page.
const TABLE: [&str; 2] = ["<!-- seeded: begin -->\n", "<!-- seeded: end -->\n"];

/// The sonar that is wrong.
const WRONG: SonarId = SonarId(6);

/// The rows that an office has, too.
const IN_THE_OFFICE: [&str; 12] = [
    "clean",
    "drift",
    "clutter",
    "yaw 3 deg",
    "yaw 5 deg",
    "mount 5 cm",
    "delay 100 ms",
    "clock rate 1 %",
    "range scale 5 %",
    "range offset 3 cm",
    "odometry scale 2 %",
    "beams half as wide",
];

/// What is wrong with a log.
#[derive(Debug, Clone, Copy, Default)]
struct Wrong {
    /// What a configuration could mend.
    value: Option<(Parameter, f64)>,
    /// Odometry drifts by 1 cm and 0.2 deg after a metre.
    drift: bool,
    /// A twentieth of the readings is of another sonar's sound, and a twentieth anything.
    clutter: bool,
    /// A sonar hears nothing.
    dead: bool,
    /// In the office of the sample logs instead of the paper's room.
    office: bool,
}

fn of(quantity: Quantity) -> Parameter {
    Parameter::Sonar(Whose::One(WRONG), quantity)
}

fn of_all(quantity: Quantity) -> Parameter {
    Parameter::Sonar(Whose::All, quantity)
}

/// Every row, by what it is called. A value is what the configuration is off by.
fn cases() -> Vec<(String, Wrong)> {
    let clean = Wrong::default();
    let drift = Wrong {
        drift: true,
        ..clean
    };
    let clutter = Wrong {
        clutter: true,
        ..clean
    };
    let dead = Wrong {
        dead: true,
        ..clean
    };
    let mut cases = vec![
        ("clean".to_owned(), clean),
        ("drift".to_owned(), drift),
        ("clutter".to_owned(), clutter),
        ("dead sonar".to_owned(), dead),
    ];
    let with = |wrong: Wrong, parameter, value: f64| Wrong {
        value: Some((parameter, value)),
        ..wrong
    };
    let mut add = |name: String, parameter, value: f64| {
        cases.push((name, with(clean, parameter, value)));
    };
    for degrees in [1.0_f64, 2.0, 3.0, 5.0] {
        add(
            format!("yaw {degrees} deg"),
            of(Quantity::Yaw),
            degrees.to_radians(),
        );
    }
    for centimetres in [2.0, 5.0] {
        add(
            format!("mount {centimetres} cm"),
            of(Quantity::X),
            centimetres / 100.0,
        );
    }
    for milliseconds in [-100.0, 50.0, 100.0, 300.0] {
        add(
            format!("delay {milliseconds} ms"),
            Parameter::RangeDelay,
            milliseconds / 1e3,
        );
    }
    for percent in [0.3, 1.0] {
        add(
            format!("clock rate {percent} %"),
            Parameter::ClockRate,
            percent / 100.0,
        );
    }
    for percent in [1.0, 5.0] {
        add(
            format!("range scale {percent} %"),
            of(Quantity::RangeScale),
            percent / 100.0,
        );
    }
    add(
        "range offset 3 cm".to_owned(),
        of(Quantity::RangeOffset),
        0.03,
    );
    add(
        "all range scale 5 %".to_owned(),
        of_all(Quantity::RangeScale),
        0.05,
    );
    add(
        "odometry scale 2 %".to_owned(),
        Parameter::OdometryScale,
        0.02,
    );
    let half = Ring::default().beam_width / 2.0;
    add(
        "beams half as wide".to_owned(),
        of_all(Quantity::BeamWidth),
        -half,
    );
    add(
        "beams half wider".to_owned(),
        of_all(Quantity::BeamWidth),
        half,
    );
    let pairs = [
        ("yaw 5 deg", of(Quantity::Yaw), 5.0_f64.to_radians()),
        ("mount 5 cm", of(Quantity::X), 0.05),
        ("range offset 3 cm", of(Quantity::RangeOffset), 0.03),
        ("delay 100 ms", Parameter::RangeDelay, 0.1),
        ("odometry scale 2 %", Parameter::OdometryScale, 0.02),
    ];
    for (beside, wrong) in [("drift", drift), ("clutter", clutter)] {
        for (name, parameter, value) in pairs {
            let wrong = with(wrong, parameter, value);
            cases.push((format!("{name} and {beside}"), wrong));
        }
    }
    let office = cases
        .iter()
        .filter(|(name, _)| IN_THE_OFFICE.contains(&&**name));
    let office = office.map(|(name, wrong)| {
        let wrong = Wrong {
            office: true,
            ..*wrong
        };
        (format!("office: {name}"), wrong)
    });
    let office: Vec<_> = office.collect();
    cases.extend(office);
    cases
}

fn log(wrong: Wrong, sigma: f64, seed: u64) -> (Log, Config) {
    let clutter = if wrong.clutter { 0.05 } else { 0.0 };
    let simulation = Simulation {
        world: if wrong.office {
            world_of("office")
        } else {
            World::room()
        },
        diffuse: 0.0,
        path: if wrong.office {
            path_of("office")
        } else {
            Path::room()
        },
        motion: Motion::Driving(Driving::default()),
        ring: Ring::default(),
        range_noise: RangeNoise {
            sigma,
            outliers: clutter,
            ..RangeNoise::default()
        },
        false_echoes: FalseEchoes {
            cross_talk: clutter,
            ..FalseEchoes::default()
        },
        odometry_noise: if wrong.drift {
            OdometryNoise {
                distance: 0.01,
                heading: 0.2_f64.to_radians(),
                turn: 0.5_f64.to_radians(),
            }
        } else {
            OdometryNoise::default()
        },
        untold: Untold::default(),
        late: None,
        silent: Vec::new(),
        without_truth: false,
        seed,
    };
    let bytes = simulation.write(Cursor::new(Vec::new())).unwrap();
    let mut config = Config::default();
    let read = read_with_truth_in(Cursor::new(bytes.into_inner()), "seeded.mcap", &config);
    let mut log = read.unwrap().0;
    if let Some((parameter, value)) = wrong.value {
        let mut change = Change::default();
        change.add(parameter, value);
        change.apply(&mut log.events);
        change.apply_clocks(&mut config);
    }
    if wrong.dead {
        log.events.readings.change(|reading| {
            if reading.sonar == WRONG {
                reading.range = f64::INFINITY;
            }
        });
    }
    (log, config)
}

/// What became of the logs of a row.
#[derive(Default)]
struct Row {
    logs: u32,
    first: u32,
    in_three: u32,
    wrong: u32,
    /// Of the values found: how far off, in their standard deviations.
    errors: Vec<f64>,
}

impl Row {
    fn take(&mut self, wrong: Wrong, found: &Search) {
        self.logs += 1;
        let seeded = wrong.value.map(|(parameter, _)| parameter);
        let is_it = |parameter: Parameter| seeded == Some(parameter);
        let told = |at: usize| {
            let cause = found.causes.get(at)?;
            // What is said to explain as much is said.
            let rivals = cause.rivals.iter().flatten();
            let mut all = cause.values.iter().chain(rivals);
            all.find(|one| is_it(one.parameter)).copied()
        };
        let at = (0..3).find_map(|at| Some((at, told(at)?)));
        self.first += u32::from(at.is_some_and(|(at, _)| at == 0));
        self.in_three += u32::from(at.is_some());
        let first = found.causes.first();
        self.wrong += u32::from(first.is_some() && at.is_none_or(|(at, _)| at > 0));
        if let (Some((_, one)), Some((seeded, value))) = (at, wrong.value) {
            let truth = match seeded {
                Parameter::Sonar(_, Quantity::RangeScale) | Parameter::OdometryScale => {
                    1.0 / (1.0 + value) - 1.0
                }
                _ => -value,
            };
            self.errors.push((one.value - truth).abs() / one.deviation);
        }
    }

    fn text(&mut self, name: &str) -> String {
        self.errors.sort_by(f64::total_cmp);
        let middle = self.errors.get(self.errors.len() / 2);
        let middle = middle.map_or("-".to_owned(), |error| format!("{error:.1}"));
        let Self {
            logs,
            first,
            in_three,
            wrong,
            ..
        } = self;
        format!("| {name} | {logs} | {first} | {in_three} | {wrong} | {middle} |\n")
    }
}

fn number(name: &str, default: u64) -> u64 {
    let given = env::var(name).ok();
    given.map_or(default, |given| given.parse().unwrap())
}

#[test]
#[ignore = "takes long; docs/calibrate.md says how to run it"]
fn the_page_holds_what_is_found_of_seeded_causes() {
    let only = env::var("TMAM_CASES").unwrap_or_default();
    let mut table = "| off | logs | found first | in three | wrong one first | error / sigma |\n\
                     |---|---:|---:|---:|---:|---:|\n"
        .to_owned();
    for (name, wrong) in cases() {
        for sigma in [0.003, 0.010] {
            let name = format!("{name}, {:.0} mm", sigma * 1e3);
            if !name.contains(&only) {
                continue;
            }
            let mut row = Row::default();
            for seed in 1..=number("TMAM_SEEDS", 3) {
                let (log, config) = log(wrong, sigma, seed);
                let replay = Replay::new(&log, &config).unwrap();
                let outcome = replay.run(&mut []).unwrap();
                let found = search(&replay, &outcome, Effort::AFTER_REPLAY);
                println!("{name}, seed {seed}: {} replays", found.replays);
                for cause in &found.causes {
                    let [without, with] = &cause.standings;
                    let gain = with.gain_over(without);
                    println!(
                        "    {gain:.0} bits: {:?}, or {:?}",
                        cause.values, cause.rivals
                    );
                }
                row.take(wrong, &found);
            }
            let text = row.text(&name);
            print!("{text}");
            let _ = write!(table, "{text}");
        }
    }
    if only.is_empty() {
        hold(&table);
    }
}

/// Holds the page to the table that was found, or puts it there if that is asked for.
fn hold(found: &str) {
    let [begin, end] = TABLE;
    let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/calibrate.md");
    let text = fs::read_to_string(&page).unwrap();
    let (head, rest) = text.split_once(begin).unwrap();
    let (held, tail) = rest.split_once(end).unwrap();
    if env::var_os("TMAM_UPDATE_DOCS").is_some() {
        fs::write(&page, format!("{head}{begin}{found}{end}{tail}")).unwrap();
    } else {
        assert!(held == found, "docs/calibrate.md holds another table");
    }
}

#[test]
fn clean_logs_and_odometry_that_drifts_have_no_cause() {
    let drift = Wrong {
        drift: true,
        ..Wrong::default()
    };
    for (wrong, sigma) in [
        (Wrong::default(), 0.003),
        (Wrong::default(), 0.010),
        (drift, 0.003),
    ] {
        let (log, config) = log(wrong, sigma, 3);
        let replay = Replay::new(&log, &config).unwrap();
        let outcome = replay.run(&mut []).unwrap();
        let found = search(&replay, &outcome, Effort::AFTER_REPLAY);
        assert_eq!(found.causes, [], "{wrong:?}");
    }
}

#[test]
fn a_turned_sonar_is_found_although_odometry_drifts() {
    let turned = Wrong {
        value: Some((of(Quantity::Yaw), 5.0_f64.to_radians())),
        drift: true,
        ..Wrong::default()
    };
    let (log, config) = log(turned, 0.003, 1);
    let replay = Replay::new(&log, &config).unwrap();
    let outcome = replay.run(&mut []).unwrap();
    assert!(outcome.joint().is_some());
    let found = search(&replay, &outcome, Effort::AFTER_REPLAY);
    let [cause] = found.causes.as_slice() else {
        panic!("{:?}", found.causes);
    };
    let [yaw] = cause.values.as_slice() else {
        panic!("{cause:?}");
    };
    assert_eq!(yaw.parameter, of(Quantity::Yaw));
    assert!((yaw.value.to_degrees() + 5.0).abs() < 1.0, "{yaw:?}");
}

#[test]
fn a_scale_of_odometry_that_drifts_is_told_although_the_path_makes_up_for_it() {
    let short = Wrong {
        value: Some((Parameter::OdometryScale, 0.02)),
        drift: true,
        ..Wrong::default()
    };
    let (log, config) = log(short, 0.003, 2);
    let replay = Replay::new(&log, &config).unwrap();
    let outcome = replay.run(&mut []).unwrap();
    let found = search(&replay, &outcome, Effort::AFTER_REPLAY);
    let [cause] = found.causes.as_slice() else {
        panic!("{:?}", found.causes);
    };
    let [scale] = cause.values.as_slice() else {
        panic!("{cause:?}");
    };
    assert_eq!(scale.parameter, Parameter::OdometryScale);
    let off = scale.value - (1.0 / 1.02 - 1.0);
    assert!(
        off.abs() < 3.0 * scale.deviation && scale.deviation < 0.005,
        "{scale:?}"
    );
    let [before, after] = cause.by_odometry.unwrap();
    assert!(after > before + 0.05, "{before} {after}");
}
