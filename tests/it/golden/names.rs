//! Names from a log are shown, and neither steer a terminal nor speak to the runner of a CI service.

use super::{bench_with, golden, tmam};
use crate::support::{rewrite, sample};

#[test]
fn a_sonar_name_is_no_command_and_no_line_of_its_own() {
    let bench = bench_with("room_step", |_| {});
    // As long as the names that they replace, so that the messages stay as they are otherwise.
    for name in [b"\n::foo::", b"::error:", b"\x1b[2J\x1b[H\x07"] {
        let log = rewrite(
            &sample("room_step.mcap"),
            mcap::WriteOptions::new(),
            |mut one| {
                for at in 0..one.data.len().saturating_sub(7) {
                    if &one.data[at..at + 8] == b"sonar_03" {
                        one.data[at..at + 8].copy_from_slice(name);
                    }
                }
                vec![one]
            },
        );
        bench.put("room_step.mcap", log);
        let golden = golden().join("room_step.golden.json");
        let golden = golden.to_str().unwrap();
        let show = ["--show", "9999"];
        let check = [
            "check",
            "room_step.mcap",
            "--golden",
            "golden",
            "--summary",
            "s.md",
        ];
        for (arguments, variables) in [
            ([&check[..], &show].concat(), vec![]),
            (
                [&check[..], &show].concat(),
                vec![("GITHUB_ACTIONS", "true")],
            ),
            (
                [&["diff", golden, "room_step.mcap"][..], &show].concat(),
                vec![],
            ),
        ] {
            let run = tmam(&bench, &arguments, &variables);
            assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
            let said = match name[0] {
                0x1b => "\\u001b[2J",
                b'\n' => "\\u000a::foo::",
                _ => "\\u003a:error:",
            };
            assert!(run.stdout.contains(said), "{}", run.stdout);
            let summary = bench.bytes("s.md");
            let texts = [run.stdout, String::from_utf8(summary).unwrap()];
            for line in texts.iter().flat_map(|text| text.split('\n')) {
                assert!(!line.chars().any(char::is_control), "{line:?}");
                let is_ours =
                    line.starts_with("::error file=") || line.starts_with("::error title=");
                assert!(!line.trim_start().starts_with("::") || is_ours, "{line:?}");
            }
        }
    }
}
