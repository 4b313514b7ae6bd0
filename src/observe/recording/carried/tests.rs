use std::io::Cursor;

use rerun::external::re_log_encoding::{MessageHeader, StreamFooter, StreamHeader};

use super::*;
use crate::observe::recording::encode::{RrdWriter, named_ids};
use crate::observe::recording::plane::PlaneOrigin;

fn recording(carried: Option<&Carried>) -> Vec<u8> {
    let ids = named_ids("tmam", "a.mcap", "r".to_owned());
    let mut bytes = Vec::new();
    let file = RrdWriter::new(Some(&mut bytes), None, ids, 5).unwrap();
    let mut canvas = Canvas::new(file, 5, PlaneOrigin::default(), &[]);
    canvas.put("/about", &TextDocument::new("about")).unwrap();
    if let Some(carried) = carried {
        put(carried, &mut canvas).unwrap();
    }
    canvas.close().unwrap();
    bytes
}

fn results() -> Carried {
    Carried {
        features: format!(
            "{{\n  \"schema\": \"tmam.features/1\",\n  \"rows\": [{}\"\u{e4}\"]\n}}\n",
            "{\"rho\": 1.25}, ".repeat(50)
        ),
        labels: Some("{\"schema\": \"tmam.labels/1\"}\n".to_owned()),
    }
}

fn find(bytes: &[u8]) -> Result<Carried, CarriedError> {
    super::find(Cursor::new(bytes), bytes.len() as u64)
}

#[test]
fn what_is_carried_comes_back_to_the_byte() {
    assert_eq!(find(&recording(Some(&results()))).unwrap(), results());
}

#[test]
fn a_recording_that_was_cut_anywhere_is_said_to_be() {
    let whole = recording(Some(&results()));
    let ends = whole.len() - StreamFooter::ENCODED_SIZE_BYTES;
    for length in (12..whole.len()).filter(|length| length % 7 == 0 || *length == ends) {
        let cut = find(&whole[..length]);
        // Without its last frame it is as older encoders leave it: whole.
        assert_eq!(cut.is_ok(), length == ends, "{length}");
        if let Err(error) = cut {
            assert!(
                matches!(error, CarriedError::CutOff { .. }),
                "{length}: {error}"
            );
        }
    }
}

#[test]
fn damage_anywhere_is_an_error_or_still_a_text() {
    let whole = recording(Some(&results()));
    for at in (0..whole.len()).step_by(5) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        match find(&bytes) {
            // Text that is still JSON is taken at its word.
            Ok(found) => assert!(found.features.starts_with('{'), "{at}"),
            Err(error) => assert!(!error.to_string().is_empty(), "{at}"),
        }
    }
}

#[test]
fn lengths_that_the_file_does_not_have_are_not_believed() {
    let mut bytes = recording(Some(&results()));
    let at = StreamHeader::ENCODED_SIZE_BYTES + MessageHeader::ENCODED_SIZE_BYTES - 8;
    bytes[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(matches!(find(&bytes), Err(CarriedError::CutOff { .. })));
}

#[test]
fn recordings_without_results_are_told_apart() {
    let error = find(&recording(None)).unwrap_err();
    assert!(matches!(error, CarriedError::Nothing { .. }), "{error}");
    // Of this very tmam nobody need be told that it may be older.
    assert_eq!(
        error.to_string(),
        "it carries no results: it shows a sweep or a comparison"
    );

    let (stream, storage) = rerun::RecordingStreamBuilder::new("elsewhere")
        .memory()
        .unwrap();
    stream
        .log_static("/run/other", &TextDocument::new("hello"))
        .unwrap();
    let bytes = storage.drain_as_bytes().unwrap();
    let error = find(&bytes).unwrap_err();
    assert!(matches!(error, CarriedError::Foreign { .. }), "{error}");
    assert!(error.to_string().contains("Rust SDK"), "{error}");

    let error = find(&[recording(None), recording(None)].concat()).unwrap_err();
    assert!(matches!(error, CarriedError::Several), "{error}");
    let behind = [recording(Some(&results())), vec![0; 40]].concat();
    let error = find(&behind).unwrap_err();
    let goes_on = matches!(error, CarriedError::GoesOn { bytes: 40, .. });
    assert!(goes_on, "{error}");
    let error = find(b"RRF1\0\0\0\0\0\0\0\0").unwrap_err();
    assert!(matches!(error, CarriedError::Codec { .. }), "{error}");
}
