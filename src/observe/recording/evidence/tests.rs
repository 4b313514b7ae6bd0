use std::collections::BTreeMap;

use rerun::StoreKind;
use rerun::external::arrow::array::Array;

use super::*;
use crate::core::config::Config;
use crate::core::tmam::Tmam;
use crate::observe::recording::tests::{chunks, drive, record, ring};

/// One number or word of the evidence, by frame and place in the frame's row.
fn read<T: Array + 'static, V>(
    bytes: &[u8],
    name: &str,
    of: impl Fn(&T, usize) -> V,
) -> BTreeMap<(i64, usize), Option<V>> {
    let mut found = BTreeMap::new();
    let component = descriptor(name).component;
    for chunk in &chunks(bytes, StoreKind::Recording)["/world/arcs"] {
        let frames = chunk.iter_component_indices("frame".into(), component);
        let rows = chunk.components().get(component).map(|c| &c.list_array);
        for ((frame, _), row) in frames.zip(rows.into_iter().flat_map(|rows| rows.iter())) {
            let row = row.unwrap();
            let values = row.as_any().downcast_ref::<T>().unwrap();
            for at in 0..values.len() {
                let value = (!values.is_null(at)).then(|| of(values, at));
                assert!(found.insert((frame.as_i64(), at), value).is_none());
            }
        }
    }
    found
}

fn words(bytes: &[u8], name: &str) -> BTreeMap<(i64, usize), Option<String>> {
    read(bytes, name, |a: &StringArray, at| a.value(at).to_owned())
}

#[test]
fn the_evidence_of_every_arc_is_at_its_place_among_the_arcs() {
    let sonars = ring(16);
    let frames = drive(&sonars, 300, None);
    let (bytes, _) = record(&sonars, &frames);

    let config = Config::default();
    let mut tmam = Tmam::new(&config);
    for frame in &frames {
        tmam.step(frame);
    }
    let reports = tmam.finish().reports;
    let mut expected: BTreeMap<(i64, usize), &ArcReport> = BTreeMap::new();
    for report in reports.iter() {
        let frame = i64::from(report.arc.id.frame);
        let place = expected.range((frame, 0)..=(frame, usize::MAX)).count();
        expected.insert((frame, place), report);
    }
    assert!(reports.iter().any(|report| report.run.is_some()));

    let word = |of: fn(&ArcReport) -> Option<&'static str>| -> BTreeMap<_, _> {
        let words = expected.iter();
        words
            .map(|(at, j)| (*at, of(j).map(str::to_owned)))
            .collect()
    };
    assert_eq!(words(&bytes, "label"), word(|j| Some(j.label.name())));
    assert_eq!(
        words(&bytes, "reason"),
        word(|j| Some(j.label.reason()?.name()))
    );
    assert_eq!(
        words(&bytes, "run_opinion"),
        word(|j| Some(j.run.as_ref()?.test.as_ref()?.support.name()))
    );
    let names = words(&bytes, "sensor");
    for (at, report) in &expected {
        let name = &sonars[report.arc.id.sonar.index()].name;
        assert_eq!(names[at].as_ref(), Some(name));
    }
    let features = read(&bytes, "feature", |a: &UInt32Array, at| a.value(at));
    let numbers = |name: &str| read(&bytes, name, |a: &Float32Array, at| a.value(at));
    let (theta_c, chi2) = (numbers("theta_c"), numbers("chi2_point"));
    for (at, report) in &expected {
        assert_eq!(features[at], report.run.as_ref().map(|run| run.extraction));
        let triple = report.triple;
        let angle = triple.map(|t| rounded(t.angles.theta_c) as f32);
        assert_eq!(theta_c[at], angle);
        let of_point = triple.map(|t| t.test.chi2_point);
        let of_point = of_point.filter(|chi2| chi2.is_finite());
        assert_eq!(chi2[at], of_point.map(|chi2| rounded(chi2) as f32));
    }
}
