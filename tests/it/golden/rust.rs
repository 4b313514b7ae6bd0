//! From Rust: how another crate holds features of its own.

use tmam_replay::golden::{Feature, Golden, Held, HoldError, Results, Tolerance, compare, hold};

use crate::support::Bench;

/// What some other program finds.
fn corridor(width: f64) -> Results {
    Results::of_map([
        Feature::wall([0.0, 0.0], [6.0, 0.0]),
        Feature::wall([0.0, width], [6.0, width]),
        Feature::point(6.0, width),
    ])
}

/// A test as it would stand in another crate: `UPDATE_GOLDEN=1 cargo test` writes the file.
#[test]
fn the_corridor_is_what_its_golden_file_says() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/golden/rust/corridor.golden.json"
    );
    hold(path, &corridor(1.8), &Tolerance::default()).unwrap_or_else(|differs| panic!("{differs}"));
}

#[test]
fn differences_are_found_whatever_the_order() {
    let found = compare(&corridor(1.8), &corridor(1.805), &Tolerance::default());
    assert!(found.matches(true), "{found:#?}");
    let mut turned = corridor(1.85);
    turned.map.reverse();
    let found = compare(&corridor(1.8), &turned, &Tolerance::default());
    assert_eq!(found.differences.len(), 2, "a wall and a point: {found:#?}");
}

#[test]
fn a_map_of_what_is_nowhere_is_no_result() {
    let bench = Bench::new();
    let path = bench.path("nowhere.golden.json");
    let nowhere = Results::of_map([Feature::point(f64::NAN, 1.0)]);
    assert!(nowhere.is_empty());
    let bytes = Golden::new(None, Tolerance::default(), nowhere.clone()).render();
    bench.put("nowhere.golden.json", bytes.unwrap());
    let refused = hold(&path, &nowhere, &Tolerance::default()).unwrap_err();
    assert!(matches!(refused, HoldError::Empty { .. }), "{refused}");
}

#[test]
fn a_test_that_fails_says_why_and_what_to_do() {
    let bench = Bench::new();
    let path = bench.path("corridor.golden.json");
    let missing = hold(&path, &corridor(1.8), &Tolerance::default()).unwrap_err();
    assert!(matches!(missing, HoldError::Missing { .. }));
    assert!(missing.to_string().contains("UPDATE_GOLDEN=1"), "{missing}");

    let kept = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/golden/rust/corridor.golden.json"
    );
    assert_eq!(
        hold(kept, &corridor(1.8), &Tolerance::default()).unwrap(),
        Held::Matches
    );
    let differs = hold(kept, &corridor(1.9), &Tolerance::default())
        .unwrap_err()
        .to_string();
    for said in [
        "2 differences",
        "line (0.00, 1.80) to (6.00, 1.80) m, now line 1: rho 1.8000 -> 1.9000 m",
        "point (6.00, 1.80) m, now point 2: y",
        "UPDATE_GOLDEN=1",
    ] {
        assert!(differs.contains(said), "no {said} in {differs}");
    }
}
