//! A recording of a part of the frames shows nothing of them in the others.

use rerun::external::arrow::array::Array as _;

use super::*;

/// Of every component of an entity that has rows: the frame of each row, and how long the row is.
fn rows(chunks: &[Chunk]) -> Vec<(String, BTreeMap<i64, usize>)> {
    let mut found = BTreeMap::<String, BTreeMap<i64, usize>>::new();
    for chunk in chunks.iter().filter(|chunk| !chunk.is_static()) {
        for (name, column) in chunk.components().iter() {
            let frames = chunk.iter_component_indices("frame".into(), *name);
            for ((frame, _), row) in frames.zip(column.list_array.iter()) {
                let len = row.map_or(0, |row| row.len());
                let rows = found.entry(name.to_string()).or_default();
                rows.insert(frame.as_i64(), len);
            }
        }
    }
    found.into_iter().collect()
}

#[test]
fn what_a_window_shows_ends_with_it() {
    let sonars = ring(16);
    let frames = drive(&sonars, 200, None);
    let overlay = Overlay {
        only: Some(vec![[40, 60], [120, 140]]),
        labels: [(
            (50, "sonar_03".to_owned()),
            "contact -> intersection".to_owned(),
        )]
        .into(),
        ..Overlay::default()
    };
    let (bytes, _) = record_under(overlay, &sonars, &frames);
    let chunks = chunks(&bytes, StoreKind::Recording);
    let within = |frame: i64| (40..=60).contains(&frame) || (120..=140).contains(&frame);
    for path in [
        "/world/arcs",
        "/world/beams",
        "/world/contact_points",
        "/world/intersection_points",
        "/world/differences/labels",
        "/labels/sonar_03",
    ] {
        let all = rows(&chunks[path]);
        assert!(!all.is_empty(), "{path}");
        for (component, rows) in all {
            let seen: Vec<i64> = rows
                .keys()
                .copied()
                .filter(|frame| within(*frame))
                .collect();
            assert!(
                seen.contains(&60) && seen.contains(&140),
                "{path} {component}"
            );
            let outside = rows.iter().filter(|(frame, _)| !within(**frame));
            let outside: Vec<(i64, usize)> = outside.map(|(frame, len)| (*frame, *len)).collect();
            assert_eq!(outside, [(61, 0), (141, 0)], "{path} {component}");
        }
    }
    // Plots have no dots.
    for path in ["/chi2/lead/sonar_04", "/lanes/sonar_04"] {
        let frames = numbers(&chunks[path]);
        assert!(!frames.is_empty() && frames.keys().all(|frame| within(*frame)));
    }
    // The robot comes and goes with its outline, and its path does not jump from window to window.
    for (_, rows) in rows(&chunks["/world/robot/outline"]) {
        let robots: Vec<(i64, bool)> = rows.iter().map(|(frame, len)| (*frame, *len > 0)).collect();
        let expected = [(40, true), (61, false), (120, true), (141, false)];
        assert_eq!(robots, expected);
    }
    let held = chunks["/world/robot/outline"]
        .iter()
        .filter(|chunk| chunk.is_static());
    let strips = LineStrips2D::descriptor_strips().component;
    assert!(
        held.flat_map(|chunk| chunk.components().get(strips))
            .next()
            .is_none()
    );
    // What is suspect in a frame that is not shown is not drawn in it, either.
    if let Some(suspects) = chunks.get("/world/suspects") {
        for (_, rows) in rows(suspects) {
            assert!(rows.iter().all(|(frame, len)| within(*frame) || *len == 0));
        }
    }
}
