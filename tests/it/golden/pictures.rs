//! The picture of what differs: beside the artefacts of a check, and of what a blessing changed.

use super::{bench_with, path_of, tmam};
use crate::support::Bench;

/// How many nodes of a class a picture has.
fn of_class(bench: &Bench, picture: &str, class: &str) -> usize {
    let text = String::from_utf8(bench.bytes(picture)).unwrap();
    let picture = roxmltree::Document::parse(&text).unwrap();
    let nodes = picture.descendants();
    nodes
        .filter(|node| node.attribute("class") == Some(class))
        .count()
}

#[test]
fn what_differs_and_what_a_blessing_changes_is_drawn() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_drive.mcap");
    let picture = "golden/room_drive.golden.svg";
    let bless = |more: &[&str]| {
        let bless = ["check", &log, "--golden", "golden", "--bless"];
        let run = tmam(&bench, &[&bless[..], more].concat(), &[]);
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        run.stdout
    };
    let said = bless(&["--rule", "noise-aware"]);
    assert!(said.contains(&format!("wrote {picture}\n")), "{said}");
    let named = "- the map before and after: `room_drive.golden.svg`\n";
    assert!(said.contains(named), "{said}");
    // The words above have a sample of each.
    for class in ["as", "before", "now", "label"] {
        assert!(of_class(&bench, picture, class) > 2, "{class}");
    }
    assert_eq!(of_class(&bench, picture, "worst"), 1);
    let first = bench.bytes(picture);

    // The other way round, a check draws what the blessing drew.
    bench.put("paper.toml", "rule = 'paper'\n");
    let check = [
        "check",
        &log,
        "--golden",
        "golden",
        "--config",
        "paper.toml",
    ];
    let files = ["--artifacts", "out", "--summary", "s.md"];
    let run = tmam(&bench, &[&check[..], &files].concat(), &[]);
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    let drawn = |class| of_class(&bench, "out/room_drive.check.svg", class);
    assert_eq!(drawn("before"), of_class(&bench, picture, "now"));
    assert_eq!(drawn("now"), of_class(&bench, picture, "before"));
    assert_eq!(drawn("label"), of_class(&bench, picture, "label"));
    let summary = String::from_utf8(bench.bytes("s.md")).unwrap();
    let named = "- the map before and after: `room_drive.check.svg`\n";
    assert!(summary.contains(named), "{summary}");

    // Of a blessing that moves nothing there is none, and the one before would be another's.
    assert_eq!(bench.bytes(picture), first);
    bless(&["--tolerance", "rho=0.02"]);
    assert!(!bench.path(picture).exists());
}

#[test]
fn a_report_does_not_take_the_place_of_a_picture() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_drive.mcap");
    let check = ["check", &log, "--golden", "golden"];
    for more in [
        &["--bless", "--summary", "golden/room_drive.golden.svg"][..],
        &["--artifacts", "out", "--junit", "out/room_drive.check.svg"],
    ] {
        let run = tmam(&bench, &[&check[..], more].concat(), &[]);
        assert_eq!(run.code, 2, "{}", run.stdout);
        assert!(run.stderr.contains("is named twice"), "{}", run.stderr);
    }
}
