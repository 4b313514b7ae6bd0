//! The noise that the ranges tell themselves is held, too: all of the noise-aware rule hangs on it.

use super::{report, tmam};
use crate::support::{Bench, Message, rewrite, sample};

/// The sample without the variances in its messages, so that the ranges must tell the noise; `spread`:
/// how far they are moved at random, metres.
fn untold(spread: f32) -> Vec<u8> {
    /// Where range and variance lie in a `sensor_msgs/Range` in CDR.
    const RANGE_FROM_END: usize = 8;
    const VARIANCE_FROM_END: usize = 4;
    let seen = std::cell::Cell::new(0_u32);
    let change = |mut message: Message| {
        if message.topic.starts_with("/sonar/") {
            let next = seen.get().wrapping_mul(1_664_525);
            seen.set(next.wrapping_add(1_013_904_223));
            let at = message.data.len() - RANGE_FROM_END;
            let range = &mut message.data[at..at + 4];
            let measured = f32::from_le_bytes(range.try_into().unwrap());
            let error = ((seen.get() >> 8) as f32 / (1 << 24) as f32 - 0.5) * spread;
            range.copy_from_slice(&(measured + error).to_le_bytes());
            let at = message.data.len() - VARIANCE_FROM_END;
            message.data[at..].fill(0);
        }
        vec![message]
    };
    rewrite(
        &sample("room_drive.mcap"),
        mcap::WriteOptions::new(),
        change,
    )
}

const CHECK: [&str; 4] = ["check", "untold.mcap", "--golden", "golden"];
const GOLDEN: &str = "golden/untold.golden.json";

/// A directory with such a log and its golden file.
fn blessed() -> Bench {
    let bench = Bench::new();
    bench.put("untold.mcap", untold(0.0));
    let run = tmam(&bench, &[&CHECK[..], &["--bless"]].concat(), &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    bench
}

#[test]
fn noise_that_is_measured_otherwise_is_a_difference_that_says_so() {
    let bench = blessed();
    let golden = bench.json(GOLDEN);
    let sigma = golden["measured_sigma"].as_f64().unwrap();
    for (factor, code) in [(1.0, 0), (1.03, 0), (1.2, 1), (0.5, 1)] {
        let mut file = golden.clone();
        file["measured_sigma"] = (sigma * factor).into();
        bench.put(GOLDEN, file.to_string());
        let (found, said) = report(&bench, &bench.path("untold.mcap"));
        assert_eq!(found, code, "{factor}: {said:#}");
        let all = said["logs"][0]["differences"].as_array().unwrap();
        let kinds: Vec<_> = all
            .iter()
            .map(|one| one["kind"].as_str().unwrap())
            .collect();
        assert_eq!(kinds, vec!["noise"; usize::from(code == 1)]);
        if let Some(one) = all.first() {
            let text = one["text"].as_str().unwrap();
            assert!(text.starts_with("range noise: measured sigma "), "{text}");
            assert_eq!(one["changes"][0]["unit"], "relative");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn noise_that_messages_begin_or_cease_to_say_is_a_difference() {
    for (then, now, words) in [
        (
            None,
            Some(0.0),
            "said by messages or configuration -> measured ",
        ),
        (Some(0.0), None, " mm -> said by messages or configuration"),
    ] {
        let log = |spread: Option<f32>| match spread {
            Some(spread) => untold(spread),
            None => std::fs::read(sample("room_drive.mcap")).unwrap(),
        };
        let bench = Bench::new();
        let path = bench.put("untold.mcap", log(then));
        let run = tmam(&bench, &[&CHECK[..], &["--bless"]].concat(), &[]);
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        assert_eq!(
            bench.json(GOLDEN)["measured_sigma"].is_null(),
            then.is_none()
        );
        assert!(
            bench
                .json(GOLDEN)
                .as_object()
                .unwrap()
                .contains_key("measured_sigma")
        );
        tmam(
            &bench,
            &[
                "replay",
                "untold.mcap",
                "-q",
                "-o",
                "then.rrd",
                "--features",
                "then.json",
            ],
            &[],
        );
        bench.put("untold.mcap", log(now));
        let (code, said) = report(&bench, &path);
        assert_eq!(code, 1);
        let all = said["logs"][0]["differences"].as_array().unwrap();
        let noise: Vec<_> = all.iter().filter(|one| one["kind"] == "noise").collect();
        assert_eq!(noise.len(), 1, "{all:#?}");
        let text = noise[0]["text"].as_str().unwrap();
        assert!(
            text.starts_with("range noise: ") && text.contains(words),
            "{text}"
        );
        // A recording knows it, too, and of a features.json that does not, that is said.
        let run = tmam(&bench, &["diff", "then.rrd", "untold.mcap"], &[]);
        assert!(run.stdout.contains(words), "{}", run.stdout);
        let run = tmam(&bench, &["diff", "then.json", "untold.mcap"], &[]);
        let note = "the noise of the ranges is not compared: then.json does not record";
        assert!(
            !run.stdout.contains(words) && run.stdout.contains(note),
            "{}",
            run.stdout
        );
    }
}

#[test]
fn a_log_that_became_noisier_is_said_to_be() {
    let bench = blessed();
    let (code, said) = report(&bench, &bench.put("untold.mcap", untold(0.02)));
    assert_eq!(code, 1);
    let all = said["logs"][0]["differences"].as_array().unwrap();
    let noise: Vec<_> = all.iter().filter(|one| one["kind"] == "noise").collect();
    assert_eq!(noise.len(), 1, "{all:#?}");
    let [then, now] = ["golden", "actual"].map(|key| noise[0]["changes"][0][key].as_f64().unwrap());
    assert!(now > 1.5 * then, "{then} {now}");
}
