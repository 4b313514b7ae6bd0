use std::path::Path;

use rerun::external::re_sdk_types::blueprint::archetypes::ContainerBlueprint;
use rerun::{Points2D, StoreKind};

use crate::core::config::Config;
use crate::observe::recording::tests::chunks;
use crate::tools::sweep::{Axis, Grid, Plan, Sweep, TruthSource};

/// A sweep of a sample.
pub fn sweep(axes: &[(&str, &str)]) -> Sweep {
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_logs/room_step.mcap");
    let axes = axes
        .iter()
        .map(|(key, spec)| Axis::parse(key, spec).unwrap());
    let plan = Plan {
        log: &log,
        config: &Config::default(),
        grid: Grid::new(axes.collect()).unwrap(),
        truth: TruthSource::None,
        threads: 1,
        sort: None,
    };
    plan.run(&|| ()).unwrap()
}

fn written(sweep: &Sweep) -> Vec<u8> {
    let mut bytes = Vec::new();
    super::write(&mut bytes, sweep).unwrap();
    bytes
}

/// Every text of a kind of store in a component.
fn texts(
    bytes: &[u8],
    kind: StoreKind,
    entity: &str,
    component: rerun::ComponentIdentifier,
) -> Vec<String> {
    let chunks = chunks(bytes, kind);
    let of_entity = chunks.iter().filter(|(path, _)| path.contains(entity));
    of_entity
        .flat_map(|(_, chunks)| chunks)
        .flat_map(|chunk| chunk.iter_slices::<String>(component))
        .flat_map(|row| {
            row.iter()
                .map(|text| text.as_str().to_owned())
                .collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn every_tab_is_named_by_its_keys_and_those_that_tell_nothing_come_last() {
    // Under the noise-aware rule nothing depends on alpha and beta.
    let sweep = sweep(&[
        ("triple.alpha", "0.4,0.5"),
        ("triple.beta", "2,3"),
        ("frames.step", "0.1,0.5"),
    ]);
    let names = texts(
        &written(&sweep),
        StoreKind::Blueprint,
        "/container/",
        ContainerBlueprint::descriptor_display_name().component,
    );
    assert_eq!(names, ["alpha and step", "beta and step", "alpha and beta"]);
}

#[test]
fn numbers_without_room_are_read_by_pointing_at_them() {
    let labels = Points2D::descriptor_labels().component;
    let of = |sweep: &Sweep, name: &str| {
        let entity = format!("/pictures/0/{name}");
        texts(&written(sweep), StoreKind::Recording, &entity, labels)
    };
    let few = sweep(&[("triple.alpha", "0.4,0.5"), ("triple.gamma", "6,10")]);
    assert_eq!(of(&few, "values").len(), 0);
    // Four cells, two values on each side and two keys.
    assert_eq!(of(&few, "texts").len(), 10);
    let wide = sweep(&[("triple.alpha", "0.3:0.7:0.04"), ("triple.gamma", "6,8")]);
    assert_eq!(of(&wide, "values").len(), 22);
    assert!(of(&wide, "texts").len() < 2 + 11 + 2);
}
