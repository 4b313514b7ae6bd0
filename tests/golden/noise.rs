//! The noise that the ranges tell themselves is held, too: all of the noise-aware rule hangs on it.

use serde_json::Value;

use crate::support::{Message, rewrite, sample};
use crate::{bench_with, path_of, report, tmam};

const SAMPLE: &str = "noise_aware/room_drive";

/// The sample's golden file, which must hold a measured noise, with another one in it.
fn with_sigma(change: impl Fn(f64) -> Value) -> (i32, Value) {
    let bench = bench_with(SAMPLE, |file| {
        let sigma = file["measured_sigma"].as_f64().unwrap();
        file["measured_sigma"] = change(sigma);
    });
    report(&bench, &sample("room_drive.mcap"))
}

#[test]
fn noise_that_is_measured_otherwise_is_a_difference_that_says_so() {
    for (factor, code) in [(1.04, 0), (1.2, 1), (0.5, 1)] {
        let (found, said) = with_sigma(|sigma| (sigma * factor).into());
        assert_eq!(found, code, "{factor}: {said:#}");
        let all = said["logs"][0]["differences"].as_array().unwrap();
        let kinds: Vec<_> = all
            .iter()
            .map(|one| one["kind"].as_str().unwrap())
            .collect();
        assert_eq!(kinds, vec!["noise"; usize::from(code == 1)]);
        if let Some(one) = all.first() {
            let text = one["text"].as_str().unwrap();
            assert!(
                text.starts_with("range noise: measured sigma 0.0"),
                "{text}"
            );
            assert_eq!(one["changes"][0]["unit"], "relative");
        }
    }
}

#[test]
fn a_golden_file_without_it_is_noted_and_gets_it_when_blessed() {
    let bench = bench_with(SAMPLE, |file| {
        file.as_object_mut()
            .unwrap()
            .remove("measured_sigma")
            .unwrap();
    });
    let log = path_of("room_drive.mcap");
    let run = tmam(&bench, &["check", &log, "--golden", "golden"], &[]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(
        run.stdout
            .contains("does not record the noise of the ranges"),
        "{}",
        run.stdout
    );
    let bless = ["check", &log, "--golden", "golden", "--bless"];
    assert_eq!(tmam(&bench, &bless, &[]).code, 0);
    assert!(bench.json("golden/room_drive.golden.json")["measured_sigma"].is_f64());
}

#[test]
fn a_log_that_became_noisier_is_said_to_be() {
    /// Where the range lies in a `sensor_msgs/Range` in CDR: before the variance.
    const RANGE_FROM_END: usize = 8;
    let bench = bench_with(SAMPLE, |_| {});
    let seen = std::cell::Cell::new(0_u32);
    let noisier = |mut message: Message| {
        if message.topic.starts_with("/sonar/") {
            seen.set(
                seen.get()
                    .wrapping_mul(1_664_525)
                    .wrapping_add(1_013_904_223),
            );
            let at = message.data.len() - RANGE_FROM_END;
            let range = &mut message.data[at..at + 4];
            let measured = f32::from_le_bytes(range.try_into().unwrap());
            let error = ((seen.get() >> 8) as f32 / (1 << 24) as f32 - 0.5) * 0.02;
            range.copy_from_slice(&(measured + error).to_le_bytes());
        }
        vec![message]
    };
    let log = rewrite(
        &sample("room_drive.mcap"),
        mcap::WriteOptions::new(),
        noisier,
    );
    let (code, said) = report(&bench, &bench.put("room_drive.mcap", log));
    assert_eq!(code, 1, "{said:#}");
    let all = said["logs"][0]["differences"].as_array().unwrap();
    let noise: Vec<_> = all.iter().filter(|one| one["kind"] == "noise").collect();
    assert_eq!(noise.len(), 1, "{all:#?}");
    let [then, now] = ["golden", "actual"].map(|key| noise[0]["changes"][0][key].as_f64().unwrap());
    assert!(now > 1.5 * then, "{then} {now}");
}
