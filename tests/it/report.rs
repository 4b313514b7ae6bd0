//! `tmam report`: one page that needs nothing else.

use crate::support::{Bench, sample};

#[test]
fn a_page_shows_the_map_the_worst_suspect_and_needs_nothing_else() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    for name in ["one.html", "two.html"] {
        let run = bench.tmam(&log, &format!("report {{}} --rule paper -o {name}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    assert_eq!(bench.bytes("one.html"), bench.bytes("two.html"));
    let page = String::from_utf8(bench.bytes("one.html")).unwrap();
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for foreign in ["http:", "https:", "<script", "<link", "url("] {
        assert!(!outside.contains(foreign), "{foreign}");
    }
    let picture = &page[page.find("<svg").unwrap()..page.find("</svg>").unwrap() + 6];
    let picture = roxmltree::Document::parse(picture).unwrap();
    let of_class = |class: &str| {
        let nodes = picture.descendants();
        nodes
            .filter(|node| node.attribute("class") == Some(class))
            .count()
    };
    let suspects = bench.tmam(&log, "explain {} --rule paper --suspects=1 --json");
    let suspects: serde_json::Value = serde_json::from_str(&suspects.stdout).unwrap();
    assert_eq!(
        suspects["suspects"],
        of_class("suspect") + of_class("worst")
    );
    assert_eq!((of_class("worst"), of_class("path")), (1, 1));
    assert!(of_class("wall") > 0 && of_class("corner") > 0);
    let worst = &suspects["worst"][0];
    let said = format!(
        "Worst: {}, frame {}: ",
        worst["sensor"].as_str().unwrap(),
        worst["frame"]
    );
    assert!(page.contains(&said), "{said}");
    let flags = worst["explain"].as_str().unwrap();
    let story = bench.tmam(&log, &format!("explain {{}} --rule paper {flags}"));
    let decided = story.stdout.lines().nth(2).unwrap().trim_end_matches('.');
    let decided = quick_xml::escape::escape(decided).into_owned();
    assert_eq!(
        page.matches(&decided).count(),
        2,
        "{decided} in the headline and in the table"
    );
}

#[test]
fn without_suspects_the_page_says_what_was_looked_at() {
    let bench = Bench::new();
    let run = bench.tmam(&sample("room_drive.mcap"), "report {} -o -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout
            .contains("held against every label; none is contradicted")
    );
    assert!(!run.stdout.contains("Worst:"));
}

#[test]
fn what_is_off_is_said_before_what_it_does() {
    let bench = Bench::new();
    let log = sample("room_trouble.mcap");
    let page = bench.tmam(&log, "report {} -o -").stdout;
    let at = |said: &str| page.find(said).unwrap_or_else(|| panic!("{said}: {page}"));
    assert!(at("Cause 1: sonar_02 is turned by +6.0 deg") < at("Worst: sonar_02"));
    assert!(at("arcs from 44.3 to 51.6 s") < at("Worst: sonar_02"));
    let page = bench.tmam(&log, "report {} -o - --no-causes").stdout;
    assert!(!page.contains("Cause 1"));
}

#[test]
fn a_folder_of_several_drives_is_refused_where_one_is_asked_for() {
    let bench = Bench::new();
    for name in ["one", "two"] {
        let run = bench.sh(&format!("tmam simulate -o logs_{name}.mcap --steps 20"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let run = bench.sh("mkdir drives && mv logs_*.mcap drives && tmam report drives -o r.html");
    assert_eq!(run.code, 2, "{}", run.stdout);
    assert!(
        run.stderr.contains("drives holds 2 logs") && run.stderr.contains("logs_one.mcap"),
        "{}",
        run.stderr
    );
}
