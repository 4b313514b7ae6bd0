//! Outputs replace no input, appear together or not at all, and a full one is an error.

use std::fs;

use crate::support::{Bench, sample};

#[test]
fn no_output_takes_the_place_of_an_input() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let config = bench.put("settings", "rule = \"noise-aware\"\n");
    let world = fs::read(sample("office.world.json")).unwrap();
    bench.put("world", &world);
    for command in [
        "replay {} --config settings --features settings",
        "replay {} --config settings -o ./settings",
        "report {} --config settings -o settings",
        "sweep {} --config settings --gamma 8,10 --csv settings",
        "evaluate {} --truth world -o world",
        "check {} --golden . --config settings --junit settings",
        "check {} --golden . --suite settings --summary settings",
        "simulate -o world --world world --waypoints '1,1 2,1'",
    ] {
        let log = log.display().to_string();
        let run = bench.sh(&format!("tmam {}", command.replace("{}", &log)));
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("is named twice"), "{}", run.stderr);
        assert_eq!(
            fs::read_to_string(&config).unwrap(),
            "rule = \"noise-aware\"\n"
        );
        assert_eq!(bench.bytes("world"), world);
    }
    assert_eq!(bench.files().len(), 2, "{:?}", bench.files());
}

#[test]
fn a_path_does_not_take_the_place_of_the_log_that_has_the_mounts() {
    let bench = Bench::new();
    let log = fs::read(sample("room_step.mcap")).unwrap();
    bench.put("mounts.mcap", &log);
    let run = bench.tmam(
        &sample("room_step.mcap"),
        "replay {} --no-causes --set input.mounts_from='mounts.mcap' --path mounts.mcap",
    );
    assert_eq!(run.code, 2, "{}", run.stdout);
    assert!(run.stderr.contains("is named twice"), "{}", run.stderr);
    assert_eq!(bench.bytes("mounts.mcap"), log);
}

#[cfg(unix)]
#[test]
fn a_link_to_a_file_that_is_not_there_yet_keeps_pointing_there() {
    let bench = Bench::new();
    std::os::unix::fs::symlink("there.json", bench.path("link.json")).unwrap();
    let run = bench.tmam(
        &sample("room_step.mcap"),
        "replay {} --no-causes --no-recording --features link.json",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    let link = fs::symlink_metadata(bench.path("link.json")).unwrap();
    assert!(link.is_symlink());
    assert!(bench.files().contains("there.json"), "{:?}", bench.files());
}

#[cfg(unix)]
#[test]
fn what_is_typed_makes_no_line_of_its_own_in_an_error_of_usage() {
    let bench = Bench::new();
    let run = bench.sh("tmam replay --rule \"$(printf 'x\\n::error::y\\342\\200\\256z')\" q.mcap");
    assert_eq!(run.code, 2, "{}", run.stdout);
    assert!(
        run.stderr.contains("possible values: paper, noise-aware"),
        "{}",
        run.stderr
    );
    assert!(!run.stderr.contains("\n::error::"), "{}", run.stderr);
    assert!(!run.stderr.contains('\u{202e}'), "{}", run.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_an_error_and_leaves_none_of_the_others() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for command in ["info", "explain --suspects", "config"] {
        let log = if command == "config" {
            String::new()
        } else {
            log.display().to_string()
        };
        let mut words = command.split(' ');
        let name = words.next().unwrap();
        let rest = words.collect::<Vec<_>>().join(" ");
        let run = bench.sh(&format!("tmam {name} {log} {rest} > /dev/full"));
        assert_eq!(run.code, 2, "{command}: {}", run.stderr);
        assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
    }
    let run = bench.tmam(&log, "replay {} -o run.rrd --features /dev/full");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_told_of_is_not_written() {
    let bench = Bench::new();
    let log = sample("room_step.mcap").display().to_string();
    for command in [
        "replay {} --no-causes --features run.json --trace run.jsonl",
        "report {} --no-causes -o page.html",
        "sweep {} --gamma 8 --csv cells.csv",
        "calibrate {} --write tmam.toml",
        "reproduce -o docs",
    ] {
        let command = command.replace("{}", &log);
        let run = bench.sh(&format!("tmam {command} > /dev/full; echo $? >&2; ls docs"));
        assert!(
            run.stderr.contains("cannot write standard output"),
            "{command}: {}",
            run.stderr
        );
        assert!(run.stderr.contains("\n2\n"), "{command}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{command}");
        let mut files = bench.files();
        files.remove("docs");
        assert!(files.is_empty(), "{command}: {files:?}");
    }
}

#[test]
fn where_it_is_to_be_quiet_the_result_stands_alone() {
    let bench = Bench::new();
    // Without noise readings repeat, of which a note is made.
    assert_eq!(bench.sh("tmam simulate -o log.mcap --steps 40").code, 0);
    for command in [
        "info log.mcap --no-causes",
        "explain log.mcap --suspects",
        "evaluate log.mcap",
        "calibrate log.mcap",
        "sweep log.mcap --gamma 8",
        "report log.mcap --no-causes -o -",
    ] {
        let told = bench.sh(&format!("tmam {command}"));
        let quiet = bench.sh(&format!("tmam {command} -q"));
        assert_eq!(
            (quiet.code, quiet.stderr.as_str()),
            (told.code, ""),
            "{command}"
        );
        assert_eq!(quiet.stdout, told.stdout, "{command}");
        if !command.starts_with("info") {
            assert!(
                told.stderr.starts_with("note: "),
                "{command}: {}",
                told.stderr
            );
        }
    }
    let run = bench.sh("tmam report log.mcap --no-causes -o page.html -q");
    assert_eq!((run.code, run.stdout + &run.stderr), (0, String::new()));
}

#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(feature = "terminal"), ignore = "needs the feature terminal")]
fn an_interrupted_run_leaves_nothing() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for signal in ["INT", "TERM", "HUP"] {
        // Nobody reads the trace, so the run waits with its recording begun.
        let fifo = bench.path("trace.jsonl");
        assert!(
            Command::new("mkfifo")
                .arg(&fifo)
                .status()
                .unwrap()
                .success()
        );
        let mut run = Command::new(assert_cmd::cargo::cargo_bin("tmam"))
            .args(["replay", "-q", "-o", "run.rrd", "--trace", "trace.jsonl"])
            .arg(&log)
            .current_dir(bench.path(""))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let since = Instant::now();
        while bench.files().len() < 2 && since.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(bench.files().len(), 2, "{:?}", bench.files());
        let id = run.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-s", signal, &id])
                .status()
                .unwrap()
                .success()
        );
        let status = run.wait().unwrap();
        assert!(status.signal().is_some(), "{status}");
        fs::remove_file(&fifo).unwrap();
        assert!(bench.files().is_empty(), "{signal}: {:?}", bench.files());
    }
}

#[test]
fn an_output_is_called_what_it_is() {
    let bench = Bench::new();
    let log = sample("room_step.mcap").display().to_string();
    for command in [
        "replay {} -o out.mcap",
        "replay {} --features out.rrd",
        "replay {} --trace out.json",
        "evaluate {} -o out.json",
        "report {} -o out.rrd",
        "simulate -o out.rrd",
        "replay {} -o out.txt",
        "replay {} -o OUT.MCAP",
    ] {
        let run = bench.sh(&format!("tmam {}", command.replace("{}", &log)));
        assert_eq!(run.code, 2, "{command}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("a name that ends in"), "{}", run.stderr);
    }
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
#[cfg_attr(not(feature = "terminal"), ignore = "needs the feature terminal")]
fn completions_and_man_pages_are_made() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish"] {
        let run = bench.sh(&format!("tmam completions {shell}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(run.stdout.contains("no-causes"), "{shell}");
    }
    let run = bench.sh("tmam man -o man1");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = String::from_utf8(bench.bytes("man1/tmam-replay.1")).unwrap();
    assert!(page.contains("tmam\\-replay"), "{page}");
    assert!(page.contains("\\-\\-match\\-distance"), "{page}");
}

#[cfg(target_os = "linux")]
#[test]
fn what_clap_says_is_an_error_on_a_full_output_too() {
    let bench = Bench::new();
    for command in ["--help", "replay -h", "--version"] {
        let run = bench.sh(&format!("tmam {command} > /dev/full"));
        assert_eq!(run.code, 2, "{command}: {}", run.stderr);
        assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
        let read = bench.sh(&format!("tmam {command} | head -1"));
        assert_eq!(read.stderr, "", "{command}");
    }
    assert_eq!(bench.sh("tmam replay --nonsense 2> /dev/full").code, 2);
}

#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(feature = "terminal"), ignore = "needs the feature terminal")]
fn a_file_that_may_not_be_so_long_is_an_error_and_leaves_nothing() {
    let bench = Bench::new();
    let log = sample("room_step.mcap").display().to_string();
    let run = bench.sh(&format!(
        "ulimit -f 4; tmam replay {log} --no-causes --features run.json --trace run.jsonl"
    ));
    assert_eq!(run.code, 2, "{}", run.stderr);
    let said = "cannot write run.json: File too large (os error 27)\n";
    assert!(run.stderr.ends_with(said), "{}", run.stderr);
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
fn the_version_says_from_which_commit_it_was_built() {
    let run = Bench::new().sh("tmam --version");
    let commit = option_env!("TMAM_COMMIT").unwrap_or("not told by whoever built this");
    assert!(run.stdout.contains(commit), "{}", run.stdout);
    let short = Bench::new().sh("tmam -V").stdout;
    assert_eq!(short, format!("tmam {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
#[cfg_attr(not(feature = "terminal"), ignore = "needs the feature terminal")]
fn colours_are_for_terminals_and_for_those_who_ask() {
    let bench = Bench::new();
    let run = bench.sh("tmam replay none.mcap");
    assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    let run = bench.sh("CLICOLOR_FORCE=1 tmam replay none.mcap");
    assert!(
        run.stderr.starts_with("\u{1b}[1;31merror:\u{1b}[0m "),
        "{}",
        run.stderr
    );
    let run = bench.sh("NO_COLOR=1 CLICOLOR_FORCE=1 tmam replay none.mcap");
    assert!(run.stderr.contains("error: "), "{}", run.stderr);
}
