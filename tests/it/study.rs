//! The tables of `docs/evaluation.md`: every rule in the paper's room, at several noises and over
//! many seeds; and those of `docs/methods.md`.
//!
//! The study takes a while, so it runs when asked for; the page says how. It fails where the page
//! does not hold what it finds, and puts it there under `TMAM_UPDATE_DOCS=1`.

mod circles;
pub mod drives;
mod methods;
mod table_one;
mod tables;

use std::fs;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use drives::{Case, Drive, Rules, run};
use tables::Row;

/// Seeds of the study.
const SEEDS: u64 = 20;

/// Seeds of the drives with and without pillars.
const SEEDS_OF_CIRCLES: u64 = 1;

/// Seeds of the drives that are not in the room's main tables, and of the switches.
const FEWER_SEEDS: u64 = 10;

/// Every drive and noise of the study.
fn cases() -> Vec<Case> {
    [Drive::Stepwise, Drive::Driven]
        .into_iter()
        .flat_map(|drive| [0.001, 0.003, 0.010].map(|sigma| Case { drive, sigma }))
        .collect()
}

/// Ten laps, and odometry that drifts.
fn other_cases() -> Vec<Case> {
    [Drive::TenLaps, Drive::LittleDrift, Drive::MuchDrift]
        .into_iter()
        .flat_map(|drive| [0.003, 0.010].map(|sigma| Case { drive, sigma }))
        .collect()
}

/// Where the noise-aware rule is tried without each of its switches.
fn cases_of_switches() -> Vec<Case> {
    [
        (Drive::Driven, 0.003),
        (Drive::Driven, 0.010),
        (Drive::TenLaps, 0.003),
        (Drive::LittleDrift, 0.003),
        (Drive::Outliers, 0.010),
    ]
    .map(|(drive, sigma)| Case { drive, sigma })
    .to_vec()
}

/// Rough walls, cross-talk and posts in a row.
fn cases_of_worlds() -> Vec<Case> {
    let rough = [0, 30, 100].map(Drive::Rough);
    let posts = [25, 50, 100].map(Drive::Posts);
    let in_the_room = rough.into_iter().chain([Drive::CrossTalk]).chain(posts);
    at_both(&in_the_room.collect::<Vec<Drive>>())
}

/// Where odometry and estimated poses are held against each other.
fn cases_of_poses() -> Vec<Case> {
    let drives = [
        Drive::Driven,
        Drive::LittleDrift,
        Drive::MuchDrift,
        Drive::ThreeLapsMuchDrift,
    ];
    let room = at_both(&drives);
    let office = Drive::Office {
        laps: 1,
        drifts: true,
    };
    let office = Case {
        drive: office,
        sigma: 0.003,
    };
    room.into_iter().chain([office]).collect()
}

/// The same where more is wrong, and farther round.
fn cases_of_harder_poses() -> Vec<Case> {
    let drives = [
        Drive::MuchDriftOutliers,
        Drive::ThriceMuchDrift,
        Drive::ThriceMuchDriftPosts,
    ];
    let office = [(1, false), (2, true)].map(|(laps, drifts)| Case {
        drive: Drive::Office { laps, drifts },
        sigma: 0.003,
    });
    at_both(&drives).into_iter().chain(office).collect()
}

/// Drives at 3 and at 10 mm.
fn at_both(drives: &[Drive]) -> Vec<Case> {
    let drives = drives.iter();
    drives
        .flat_map(|drive| {
            [0.003, 0.010].map(|sigma| Case {
                drive: *drive,
                sigma,
            })
        })
        .collect()
}

fn rows(cases: &[Case], seeds: u64, rules: &Rules) -> Vec<Row> {
    let mut rows = Vec::new();
    for case in cases {
        for (rule, runs) in rules.names().zip(run(*case, 1..=seeds, rules)) {
            rows.push((*case, rule, runs));
        }
    }
    rows
}

#[test]
#[ignore = "takes minutes; docs/evaluation.md says how to run it"]
fn the_page_holds_what_the_study_finds() {
    let rules = Rules::all();
    let mut found = tables::all(&rows(&cases(), SEEDS, &rules), SEEDS);
    let measured = rows(&cases(), SEEDS, &Rules::measuring());
    found.push_str(&tables::measured(&measured, SEEDS));
    let others = rows(&other_cases(), FEWER_SEEDS, &rules);
    found.push_str(&tables::others(&others, FEWER_SEEDS));
    let without = rows(&cases_of_switches(), FEWER_SEEDS, &Rules::without_each());
    found.push_str(&tables::switches(&without, FEWER_SEEDS));
    hold("tables", &found);
}

#[test]
#[ignore = "takes minutes; docs/evaluation.md says how to run it"]
fn the_page_holds_what_the_study_finds_in_other_worlds() {
    let mut found = rows(&cases_of_worlds(), FEWER_SEEDS, &Rules::noise_aware());
    let rough = at_both(&[30, 100].map(Drive::Rough));
    found.extend(rows(&rough, FEWER_SEEDS, &Rules::oblique_walls()));
    hold("worlds", &tables::worlds(&found, FEWER_SEEDS));
}

#[test]
#[ignore = "takes minutes; docs/evaluation.md says how to run it"]
fn the_page_holds_what_the_study_finds_of_poses() {
    let mut found = rows(&cases_of_poses(), FEWER_SEEDS, &Rules::poses());
    // Metres and degrees, as the drives have it.
    let told = [
        (Drive::LittleDrift, 0.010, [0.002, 0.05, 0.1]),
        (Drive::MuchDrift, 0.003, [0.01, 0.2, 0.5]),
        (Drive::MuchDrift, 0.010, [0.01, 0.2, 0.5]),
    ];
    for (drive, sigma, noise) in told {
        found.extend(rows(
            &[Case { drive, sigma }],
            FEWER_SEEDS,
            &Rules::told(noise),
        ));
    }
    hold("poses", &tables::poses(&found, FEWER_SEEDS));
}

#[test]
#[ignore = "takes minutes; docs/evaluation.md says how to run it"]
fn the_page_holds_what_the_study_finds_of_harder_drives() {
    let found = rows(&cases_of_harder_poses(), FEWER_SEEDS, &Rules::poses());
    hold("harder", &tables::harder(&found, FEWER_SEEDS));
}

/// Pillars, and the worlds without any in which circles would be wrong.
fn cases_of_circles() -> Vec<Case> {
    let pillars = [10, 20, 40].into_iter();
    let pillars = pillars.flat_map(|radius| {
        [0.001, 0.003, 0.010].map(|sigma| Case {
            drive: Drive::Pillars(radius),
            sigma,
        })
    });
    let none = [
        Drive::Stepwise,
        Drive::Driven,
        Drive::Posts(25),
        Drive::Pillars(0),
    ];
    let none = none.into_iter().map(|drive| Case {
        drive,
        sigma: 0.003,
    });
    pillars.chain(none).collect()
}

#[test]
#[ignore = "takes minutes; docs/evaluation.md says how to run it"]
fn the_page_holds_what_the_study_finds_of_circles() {
    let windows = circles::windows();
    println!("{windows}");
    let found = rows(&cases_of_circles(), SEEDS_OF_CIRCLES, &Rules::circles());
    let text = format!("{windows}\n{}", circles::drives(&found));
    hold("circles", &text);
}

/// The page of most studies, and what makes its tables anew.
const EVALUATION: [&str; 2] = [
    "docs/evaluation.md",
    "TMAM_UPDATE_DOCS=1 cargo test --release --test it -- --ignored study",
];

fn hold(table: &str, found: &str) {
    hold_on(EVALUATION, table, found);
}

/// Whether pages are made anew, not held.
fn updating() -> bool {
    std::env::var_os("TMAM_UPDATE_DOCS").is_some()
}

/// Holds a page to a table that was found, or puts it there if that is asked for.
fn hold_on([page, command]: [&str; 2], table: &str, found: &str) {
    /// Tests run beside each other.
    static PAGES: Mutex<()> = Mutex::new(());
    let _alone = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
    println!("{found}");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    let text = fs::read_to_string(&path).unwrap();
    let (begin, end) = (
        format!("<!-- {table}: begin -->\n"),
        format!("<!-- {table}: end -->\n"),
    );
    let (head, rest) = text.split_once(&begin).unwrap();
    let (held, tail) = rest.split_once(&end).unwrap();
    if updating() {
        fs::write(&path, format!("{head}{begin}{found}{end}{tail}")).unwrap();
        return;
    }
    assert!(text.contains(command), "{page} does not tell {command}");
    assert!(
        held == found,
        "{page} does not hold the table that was found, {table}. If that is meant, make the page anew and \
         look at git diff:\n{command}"
    );
}

/// The same study on one seed, so that it is known to run.
#[test]
fn a_study_of_one_seed_is_the_same_every_time() {
    let rules = Rules::all();
    let case = Case {
        drive: Drive::Driven,
        sigma: 0.003,
    };
    let table = || {
        let rows: Vec<_> = rules
            .names()
            .zip(run(case, 7..=7, &rules))
            .map(|(rule, runs)| (case, rule, runs))
            .collect();
        tables::all(&rows, 1)
    };
    let first = table();
    assert!(first.contains("| driven, 3 mm | paper |"), "{first}");
    assert_eq!(first, table());
}
