//! Whole outputs, so that a word or a number that changes shows up in review.
//!
//! A snapshot is a session at a terminal: every command, what it says, and its exit code unless 0.
//! `cargo insta review`, or `INSTA_UPDATE=always cargo test --test it snapshots` and `git diff`.

use crate::support::{Bench, rewrite, sample, without};

/// A folder with the sample logs and some small ones.
fn folder() -> Bench {
    let bench = Bench::new();
    for log in ["room_step.mcap", "room_drive.mcap"] {
        bench.put(log, std::fs::read(sample(log)).unwrap());
    }
    bench.put(
        "hall.json",
        r#"{"walls": [[0,0,6,0],[6,0,6,3],[6,3,0,3],[0,3,0,0]], "points": [[0,0],[6,0],[6,3],[0,3]]}"#,
    );
    let simulate =
        "tmam simulate --world hall.json --sonars 8 --noise 0.003 --waypoints '1,1 5,1 5,2'";
    for (log, options) in [
        ("hall", ""),
        ("hall_drive", "--drive"),
        ("pillar", "--steps 4"),
    ] {
        let made = bench.sh(&format!("{simulate} -o {log}.mcap {options}"));
        assert_eq!(made.code, 0, "{}", made.stderr);
    }
    let chunks = mcap::WriteOptions::new().chunk_size(Some(4000));
    let whole = rewrite(&bench.path("hall.mcap"), chunks, |message| vec![message]);
    bench.put("cut.mcap", &whole[..whole.len() / 2]);
    for (log, topics) in [
        ("no_mounts.mcap", &["/tf"][..]),
        ("no_odometry.mcap", &["/odom"]),
        ("no_ranges.mcap", &["/sonar"]),
        ("no_truth.mcap", &["/truth"]),
    ] {
        bench.put(log, without(&bench.path("hall.mcap"), topics));
    }
    bench
}

/// Runs the commands, and holds everything that they say to a snapshot.
fn session(bench: &Bench, name: &str, commands: &[&str]) {
    let mut said = String::new();
    for command in commands {
        let run = bench.sh(command);
        said += &format!("$ {command}\n{}{}", run.stdout, run.stderr);
        if run.code != 0 {
            said += &format!("[exit code {}]\n", run.code);
        }
        said.push('\n');
    }
    let version = env!("CARGO_PKG_VERSION");
    let said = said.replace(&format!("\"{version}\""), "\"[version]\"");
    let said = without_times(&said);
    insta::with_settings!({prepend_module_to_snapshot => false, omit_expression => true}, {
        insta::assert_snapshot!(name, said);
    });
}

/// A text without the times that JUnit has: how long a check took is never the same.
fn without_times(said: &str) -> String {
    let mut parts = said.split(" time=\"");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
        text += &format!(" time=\"[seconds]{rest}");
    }
    text
}

#[test]
fn info() {
    let bench = folder();
    for log in ["room_step", "room_drive", "hall"] {
        session(
            &bench,
            &format!("info_{log}"),
            &[&format!("tmam info {log}.mcap")],
        );
    }
    session(&bench, "info_json", &["tmam info hall.mcap --json"]);
    session(
        &bench,
        "info_options",
        &[
            "tmam info hall.mcap --start 2 --end 8 --sensor 'sonar_0[0-2]'",
            "tmam info hall.mcap --set noise.trust_variance=false --set noise.sigma_abs=0.0005",
            "tmam info hall.mcap --skeleton",
        ],
    );
    session(
        &bench,
        "info_of_what_cannot_be_replayed",
        &[
            "tmam info no_mounts.mcap",
            "tmam info no_mounts.mcap --skeleton",
            "tmam info no_odometry.mcap",
            "tmam info no_ranges.mcap",
            "tmam info cut.mcap",
            "tmam info hall.json",
            "tmam info absent.mcap",
        ],
    );
}

#[test]
fn explain() {
    let bench = folder();
    let on = |arguments: &str| format!("tmam explain room_drive.mcap {arguments}");
    for (name, rule) in [
        ("explain_noise_aware", ""),
        ("explain_paper", "--rule paper"),
    ] {
        let arcs = [
            format!("--sensor sonar_04 --frame 57 {rule}"),
            format!("--sensor sonar_04 --frame 120 {rule}"),
            format!("--sensor sonar_00 --time 12.5 {rule}"),
            format!("--at 3.95,2.02 {rule}"),
            format!("--suspects=5 {rule}"),
        ];
        let commands = arcs.map(|arguments| on(&arguments));
        session(&bench, name, &commands.each_ref().map(String::as_str));
    }
    for (name, rule) in [
        ("explain_noise_aware_json", ""),
        ("explain_paper_json", "--rule paper"),
    ] {
        let commands = [
            on(&format!("--sensor sonar_04 --frame 57 --json {rule}")),
            on(&format!("--suspects=5 --json {rule}")),
        ];
        session(&bench, name, &commands.each_ref().map(String::as_str));
    }
    session(
        &bench,
        "explain_others",
        &[
            "tmam explain no_truth.mcap --sensor sonar_02 --frame 5",
            "tmam explain no_truth.mcap --truth hall.json --sensor sonar_02 --frame 5",
            "tmam explain hall_drive.mcap --sensor sonar_06 --time 6 --end 10",
            "tmam explain pillar.mcap --suspects",
            "tmam explain hall.mcap --sensor sonar_99 --frame 1",
            "tmam explain hall.mcap --sensor sonar_02 --frame 999",
            "tmam explain cut.mcap --sensor sonar_02 --frame 5",
        ],
    );
}

#[test]
fn check() {
    let bench = folder();
    let change = "sed -i 's/\"rho\": 4.77/\"rho\": 4.70/; s/ 1u 4C 1I / 1u 1I 4C /'";
    session(
        &bench,
        "check",
        &[
            "tmam check hall.mcap hall_drive.mcap --golden golden",
            "tmam check hall.mcap hall_drive.mcap --golden golden --bless --tolerance rho=0.02",
            "tmam check hall.mcap hall_drive.mcap --golden golden",
            "tmam check hall.mcap --golden golden --json",
            "tmam check hall.mcap hall_drive.mcap --golden golden --partition 2/2",
            "tmam check hall.mcap --golden golden --set triple.gamma=8",
            "cp no_truth.mcap hall_drive.mcap",
            "tmam check hall_drive.mcap --golden golden --show 3",
            "cp cut.mcap hall.mcap",
            "tmam check hall.mcap --golden golden --show 3",
        ],
    );
    session(
        &bench,
        "check_reports",
        &[
            "tmam simulate --world hall.json --sonars 8 --noise 0.003 --waypoints '1,1 5,1 5,2' --seed 2 -o hall.mcap",
            "tmam check hall.mcap --golden golden --show 3 --summary summary.md --junit junit.xml",
            "cat summary.md",
            "cat junit.xml",
            "tmam check hall.mcap --golden golden --show 3 --json",
            "tmam check hall.mcap --golden golden --bless",
            "CI=1 tmam check hall.mcap --golden golden --bless",
            "tmam check hall.mcap --golden golden --bless --rule paper",
            "tmam check hall.mcap --golden golden --strict",
        ],
    );
    session(
        &bench,
        "check_of_a_golden_file_that_was_changed",
        &[
            "tmam check room_step.mcap --golden golden --bless --rule paper",
            &format!("{change} golden/room_step.golden.json"),
            "tmam check room_step.mcap --golden golden --show 5",
            "echo '{' > golden/room_step.golden.json",
            "tmam check room_step.mcap --golden golden",
        ],
    );
}

#[test]
fn diff() {
    let bench = folder();
    session(
        &bench,
        "diff",
        &[
            "tmam diff room_drive.mcap --set-b 'rule=\"paper\"' --show 5",
            "tmam diff room_drive.mcap --rule paper --set-b triple.gamma=8 --show 5",
            "tmam diff room_drive.mcap --set-b frames.step=0.1",
            "tmam diff hall.mcap hall_drive.mcap --show 3",
            "tmam replay hall.mcap -q --features one.json",
            "tmam replay hall_drive.mcap -q --features two.json",
            "tmam diff one.json two.json --tolerance rho=0.05",
            "tmam diff one.json hall.mcap",
            "tmam diff cut.mcap hall.mcap --show 3",
            "tmam diff one.json absent.json",
            "tmam diff one.json",
        ],
    );
    session(
        &bench,
        "diff_json",
        &[
            "tmam diff hall.mcap --end 12 --rule paper --set-b triple.gamma=4 --json",
            "tmam diff one.json two.json --json",
        ],
    );
}

#[test]
fn sweep() {
    let bench = folder();
    session(
        &bench,
        "sweep",
        &[
            "tmam sweep hall.mcap --rule paper --alpha 0.3:0.7:0.2 --gamma 6,10",
            "tmam sweep hall.mcap --set sonar.sonar_02.yaw=85:95:5 --no-truth",
            "tmam sweep hall_drive.mcap --set input.range_delay=-0.2:0.2:0.2 --no-truth",
            "tmam sweep no_truth.mcap --truth hall.json --step 0.1,0.3 --sort wrong_share --rows 1",
            "tmam sweep hall.mcap --rule paper --gamma 6,10 --csv - --agree 0.1",
            "tmam sweep hall.mcap --gamma 6,10,40",
            "tmam sweep cut.mcap --rule paper --gamma 6,10",
        ],
    );
    session(
        &bench,
        "sweep_json",
        &["tmam sweep hall.mcap --rule paper --gamma 6,10 --json"],
    );
}

#[test]
fn evaluate() {
    let bench = folder();
    for log in ["room_step", "room_drive"] {
        for (rule, options) in [("noise_aware", ""), ("paper", "--rule paper")] {
            let command = format!("tmam evaluate {log}.mcap {options}");
            session(&bench, &format!("evaluate_{log}_{rule}"), &[&command]);
        }
    }
    session(
        &bench,
        "evaluate_others",
        &[
            "tmam evaluate no_truth.mcap --truth hall.json --agree 0.1",
            "tmam evaluate no_truth.mcap",
            "tmam evaluate cut.mcap",
            "tmam evaluate hall_drive.mcap --end 0.5",
        ],
    );
    session(
        &bench,
        "evaluate_json",
        &[
            "tmam evaluate hall.mcap --json",
            "tmam evaluate hall.mcap --json --rule paper",
        ],
    );
}

#[test]
fn replay() {
    let bench = folder();
    session(
        &bench,
        "replay",
        &[
            "tmam replay room_step.mcap --no-recording",
            "tmam replay room_step.mcap --no-recording --rule paper",
            "tmam replay room_drive.mcap --no-recording",
            "tmam replay room_drive.mcap --no-recording --rule paper",
            "tmam replay room_drive.mcap --trace t --start 20 --end 60 --sensor 'sonar_0*'",
            "tmam replay hall.mcap --no-recording --set noise_aware.merge=false",
            "tmam replay hall.mcap --no-recording --set noise.trust_variance=false --set noise.sigma_abs=0.0005",
            "tmam replay cut.mcap --no-recording",
            "tmam replay cut.mcap --no-recording --strict",
            "tmam replay no_mounts.mcap --no-recording",
            "tmam replay no_odometry.mcap --no-recording",
            "tmam replay no_ranges.mcap --no-recording",
            "tmam replay no_truth.mcap --no-recording --sensor nobody",
            "tmam replay hall.mcap --no-recording --set triple.gama=8",
            "tmam replay hall.mcap --no-recording --gamma -8",
            "ls",
        ],
    );
    session(
        &bench,
        "replay_features_and_trace",
        &[
            "tmam replay hall.mcap -q --features - --end 6",
            "tmam replay hall.mcap -q --trace - --end 3",
            "tmam replay hall.mcap -q --trace - --end 3 --rule paper",
        ],
    );
}

#[test]
fn simulate_and_config() {
    let bench = folder();
    session(
        &bench,
        "simulate_and_config",
        &[
            "tmam simulate -o a.mcap",
            "tmam simulate -o b.mcap --drive --noise 0.003 --no-echo 0.1 --outliers 0.05",
            "tmam simulate -o c.mcap --world absent.json",
            "tmam simulate -o c.mcap --beam-width 400",
            "tmam config",
            "tmam config --rule paper --gamma 8 --set sonar.front.yaw=5",
            "tmam config --set gamma=8",
        ],
    );
}

#[test]
#[cfg_attr(
    not(feature = "terminal"),
    ignore = "clap wraps lines with the feature terminal only"
)]
fn help() {
    let commands = [
        "--help",
        "replay --help",
        "replay --help-all",
        "info --help",
        "evaluate --help",
        "explain --help",
        "calibrate --help",
        "check --help",
        "diff --help",
        "report --help",
        "sweep --help",
        "simulate --help",
        "config --help",
        "completions --help",
        "man --help",
    ];
    let commands = commands.map(|command| format!("tmam {command}"));
    session(
        &Bench::new(),
        "help",
        &commands.each_ref().map(String::as_str),
    );
}
