//! `tmam replay` into an open viewer, and without one.

use std::fs;
use std::io::Write as _;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{Bench, sample};

/// Longer than anything here may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A port that nobody listens at.
fn free_port() -> u16 {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    listener.local_addr().unwrap().port()
}

/// `tmam` with a `PATH` of one folder; the test fails where it does not end.
fn tmam(bench: &Bench, path: &Path, arguments: &[&str]) -> (i32, String) {
    let run = assert_cmd::Command::cargo_bin("tmam")
        .unwrap()
        .arg("replay")
        .arg(sample("room_step.mcap"))
        .args(arguments)
        .env("PATH", path)
        .current_dir(bench.path(""))
        .timeout(PATIENCE)
        .output()
        .unwrap();
    let code = run.status.code().expect("it ends by itself");
    (code, String::from_utf8_lossy(&run.stderr).into_owned())
}

fn refuses(arguments: &[&str], says: &[&str]) {
    let bench = Bench::new();
    let empty = tempfile::tempdir().unwrap();
    let (code, stderr) = tmam(&bench, empty.path(), arguments);
    assert_eq!(code, 2, "{stderr}");
    for part in says {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
fn where_no_viewer_answers_nothing_is_written() {
    let url = format!("rerun+http://127.0.0.1:{}/proxy", free_port());
    let says = ["no viewer answers at", url.as_str(), "--spawn"];
    refuses(&[&format!("--connect={url}"), "-o", "run.rrd"], &says);
    refuses(&["--connect=127.0.0.1"], &["no viewer's address"]);
}

#[test]
fn one_that_listens_and_never_answers_is_no_viewer() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let url = format!("rerun+http://127.0.0.1:{port}/proxy");
    // Connections are taken by the system, and nobody reads from them.
    refuses(
        &[&format!("--connect={url}")],
        &["the viewer at", "not all messages were sent"],
    );
    drop(listener);
}

#[test]
fn without_a_viewer_spawn_says_how_to_get_one() {
    let url = format!("rerun+http://127.0.0.1:{}/proxy", free_port());
    let says = ["`rerun` is not on the PATH", "pip install rerun-sdk=="];
    refuses(&["--spawn", &format!("--connect={url}")], &says);
}

#[cfg(unix)]
#[test]
fn a_viewer_that_ends_at_once_is_told_of() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let viewer = folder.path().join("rerun");
    fs::write(&viewer, "#!/bin/sh\nexit 7\n").unwrap();
    fs::set_permissions(&viewer, fs::Permissions::from_mode(0o755)).unwrap();
    let bench = Bench::new();
    let url = format!("rerun+http://127.0.0.1:{}/proxy", free_port());
    let (code, stderr) = tmam(
        &bench,
        folder.path(),
        &["--spawn", &format!("--connect={url}")],
    );
    assert_eq!(code, 2, "{stderr}");
    assert!(
        stderr.contains("ended at once (exit status: 7)"),
        "{stderr}"
    );
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

/// The installed viewer, if it is the one that reads our recordings.
fn viewer() -> Option<Command> {
    let version = Command::new("rerun").arg("--version").output().ok();
    let version = version.map(|run| String::from_utf8_lossy(&run.stdout).into_owned());
    if version.is_some_and(|text| text.contains("0.36.3")) {
        let mut viewer = Command::new("rerun");
        viewer.env("RERUN_ANALYTICS", "0");
        return Some(viewer);
    }
    // Written past the test harness, which hides what passing tests print.
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED: no viewer 0.36.3 here; this test needs `rerun` on the PATH"
    );
    None
}

fn start(mut command: Command, arguments: &[&str]) -> Running {
    let child = command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    Running(child.unwrap())
}

/// Waits until `what` is something.
fn wait_for<T>(what: impl Fn() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = what() {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "it never came");
        thread::sleep(Duration::from_millis(200));
    }
}

#[test]
fn an_open_viewer_gets_the_layout_first_and_then_the_whole_run() {
    let (Some(server), Some(reader)) = (viewer(), viewer()) else {
        return;
    };
    let bench = Bench::new();
    let port = free_port().to_string();
    let url = format!("rerun+http://127.0.0.1:{port}/proxy");
    let arguments = ["--serve-grpc", "--bind", "127.0.0.1", "--port", &port];
    let _server = start(server, &arguments);
    let address = (Ipv4Addr::LOCALHOST, port.parse().unwrap());
    wait_for(|| TcpStream::connect(address).ok());

    // What the viewer gets, it passes on to another one.
    let got = bench.path("got.rrd");
    let unused = free_port().to_string();
    let save = ["--save", got.to_str().unwrap(), "--port", &unused, &url];
    let _reader = start(reader, &save);
    wait_for(|| got.exists().then_some(()));

    let (code, stderr) = tmam(
        &bench,
        Path::new(""),
        &[&format!("--connect={url}"), "-o", "live.rrd"],
    );
    assert_eq!((code, stderr.as_str()), (0, ""));
    let (code, stderr) = tmam(&bench, Path::new(""), &["-o", "file.rrd"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert_eq!(bench.bytes("live.rrd"), bench.bytes("file.rrd"));

    let printed = |path: &Path| {
        let mut print = viewer()?;
        let run = print.args(["rrd", "print"]).arg(path).output().ok()?;
        let text = String::from_utf8_lossy(&run.stdout).into_owned();
        Some(text.lines().map(str::to_owned).collect::<Vec<String>>())
    };
    let activations = |lines: &[String]| -> Vec<usize> {
        let found = lines.iter().enumerate();
        found
            .filter(|(_, line)| line.contains("BlueprintActivationCommand"))
            .map(|(at, _)| at)
            .collect()
    };
    let lines = wait_for(|| printed(&got).filter(|lines| activations(lines).len() == 2));
    let arcs = lines
        .iter()
        .position(|line| line.contains("/world/contact_points") && line.contains("positions"));
    assert!(activations(&lines)[0] < arcs.unwrap(), "{lines:#?}");
    // Chunks may be cut otherwise on their way, so their rows are counted.
    let rows = |lines: &[String]| -> u64 {
        let of_run = lines.iter().filter(|line| line.contains("- /world/"));
        let rows = of_run.filter_map(|line| {
            let (_, rest) = line.split_once(" with ")?;
            rest.split_whitespace().next()?.parse::<u64>().ok()
        });
        rows.sum()
    };
    let file = printed(&bench.path("file.rrd")).unwrap();
    assert!(rows(&file) > 1000, "{file:#?}");
    assert_eq!(rows(&lines), rows(&file));
}
