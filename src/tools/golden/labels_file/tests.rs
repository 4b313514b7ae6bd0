use proptest::prelude::*;

use super::*;

proptest! {
    #[test]
    fn any_labels_and_stamps_come_back(
        marks in prop::collection::vec(0..3_usize, 0..60),
        first in any::<i32>(),
        steps in prop::collection::vec(prop::sample::select(vec![0, 1, 560_000_000, 1_120_000_000, 560_000_001, 33_333_333]), 0..60),
    ) {
        let marks: Vec<Mark> = marks.into_iter().map(|i| Mark::ALL[i]).collect();
        let text = encode_marks(marks.iter().copied());
        prop_assert_eq!(decode_marks(&text).unwrap(), marks);
        let mut stamps = vec![i64::from(first)];
        for step in steps {
            stamps.push(stamps.last().unwrap() + step);
        }
        let text = encode_steps(&stamps);
        prop_assert_eq!(decode_steps(stamps[0], &text).unwrap(), stamps);
    }
}

#[test]
fn the_text_is_short() {
    use Mark::{Contact, Intersection, Unidentified};
    let marks = [Contact, Contact, Intersection, Unidentified, Unidentified];
    assert_eq!(encode_marks(marks), "2C 1I 2u");
    let stamps = [5, 560_000_005, 1_120_000_005, 1_120_500_005];
    assert_eq!(encode_steps(&stamps), "560x2 0.5");
}

#[test]
fn what_is_no_text_of_ours_is_refused() {
    for text in [
        "12",
        "C",
        "0C",
        "-1C",
        "3X",
        "99999999999C",
        "1C 4999999999I",
        "3\u{20ac}",
    ] {
        assert!(decode_marks(text).is_err(), "{text}");
    }
    for text in [
        "x",
        "5x",
        "x5",
        "5x0",
        "-5",
        "1.1234567",
        "9223372036855",
        "1x6000000",
        "1e3",
        "9223372036854x5",
    ] {
        assert!(decode_steps(0, text).is_err(), "{text}");
    }
}

#[test]
fn many_sonars_cannot_fill_the_memory_either() {
    let row = r#"{"labels": "3000000u", "first_ns": 0, "steps_ms": "1x2999999"}"#;
    let table = |names: &[&str]| {
        let rows: Vec<String> = names
            .iter()
            .map(|name| format!("\"{name}\": {row}"))
            .collect();
        let count = 3_000_000 * names.len();
        let text = format!(
            "{{\"contact\": 0, \"intersection\": 0, \"unidentified\": {count}, \"sonars\": {{{}}}}}",
            rows.join(", ")
        );
        serde_json::from_str::<LabelTable>(&text).unwrap().open()
    };
    assert_eq!(
        table(&["a"]).ok().map(|labels| labels.len()),
        Some(3_000_000)
    );
    let refused = table(&["a", "b"]).err().unwrap();
    assert!(
        refused.contains("sonar `b`") && refused.contains("5000000"),
        "{refused}"
    );
}

#[test]
fn labels_come_back_with_the_frames_that_they_are_in() {
    let arc = |stamp_ns| LabelledArc {
        stamp_ns,
        mark: Mark::Contact,
        frame: None,
        margin: None,
        reason: None,
    };
    let labels = Labels {
        sonars: [("left".to_owned(), vec![arc(5), arc(25)])].into(),
        frame_stamps: vec![5, 20, 40],
    };
    let log = LogInfo {
        file: "a.mcap".to_owned(),
        events_sha256: "0".to_owned(),
        odometry: None,
        sonars: None,
    };
    let with = |noise| LabelsFile {
        log: log.clone(),
        noise,
        labels: labels.clone(),
    };
    for noise in [
        RangeSigma::Unknown,
        RangeSigma::Given,
        RangeSigma::Measured(0.0035),
    ] {
        let file = with(noise);
        assert_eq!(LabelsFile::parse(&file.render().unwrap()).unwrap(), file);
    }
    let file = with(RangeSigma::Given);
    let text = file.render().unwrap();
    assert_eq!(file.labels.frame_at(25), Some(1));
    let newer = text.replace("tmam.labels/1", "tmam.labels/2");
    assert!(
        LabelsFile::parse(&newer)
            .unwrap_err()
            .contains("tmam.labels/2")
    );
    let half = LabelsFile::parse(&text[..text.len() / 2]);
    assert!(half.unwrap_err().contains("cut off"));
}
