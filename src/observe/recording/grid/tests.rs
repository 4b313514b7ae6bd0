use rerun::external::re_sdk_types::blueprint::archetypes::ContainerBlueprint;
use rerun::{Points2D, StoreKind};

use crate::observe::drawing::{DrawnAxis, DrawnCell, DrawnColumn, DrawnGrid};
use crate::observe::recording::tests::chunks;

/// A grid over some keys whose number is the sum of its values along all of them but `alpha` and `beta`.
pub fn grid(axes: &[(&str, &[f64])]) -> DrawnGrid {
    let axis = |(key, values): &(&str, &[f64])| DrawnAxis {
        short: (*key).to_owned(),
        name: (*key).to_owned(),
        heading: (*key).to_owned(),
        values: values.to_vec(),
        configured: None,
    };
    let mut places: Vec<Vec<usize>> = vec![Vec::new()];
    for (_, values) in axes {
        let longer = |place: &Vec<usize>| {
            let place = place.clone();
            (0..values.len()).map(move |next| [place.as_slice(), &[next]].concat())
        };
        places = places.iter().flat_map(longer).collect();
    }
    let number = |places: &[usize]| -> f64 {
        let told = axes.iter().zip(places);
        let told = told.filter(|((key, _), _)| !["alpha", "beta"].contains(key));
        told.map(|((_, values), place)| values[*place]).sum()
    };
    let cells = places.into_iter().map(|places| DrawnCell {
        numbers: Some(vec![Some(number(&places))]),
        places,
    });
    DrawnGrid {
        file: "log.mcap".to_owned(),
        content: Vec::new(),
        conclusion: String::new(),
        ranked_by: "without the truth",
        axes: axes.iter().map(axis).collect(),
        columns: vec![DrawnColumn {
            heading: "bits".to_owned(),
            low_is_better: true,
            decimals: 3,
            scale: 1.0,
        }],
        cells: cells.collect(),
        best: 1,
    }
}

fn written(grid: &DrawnGrid) -> Vec<u8> {
    let mut bytes = Vec::new();
    super::write_grid(&mut bytes, grid).unwrap();
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
    let grid = grid(&[
        ("alpha", &[0.4, 0.5]),
        ("beta", &[2.0, 3.0]),
        ("step", &[0.1, 0.5]),
    ]);
    let names = texts(
        &written(&grid),
        StoreKind::Blueprint,
        "/container/",
        ContainerBlueprint::descriptor_display_name().component,
    );
    assert_eq!(names, ["alpha and step", "beta and step", "alpha and beta"]);
}

#[test]
fn numbers_without_room_are_read_by_pointing_at_them() {
    let labels = Points2D::descriptor_labels().component;
    let of = |grid: &DrawnGrid, name: &str| {
        let entity = format!("/pictures/0/{name}");
        texts(&written(grid), StoreKind::Recording, &entity, labels)
    };
    let few = grid(&[("step", &[0.4, 0.5]), ("gamma", &[6.0, 10.0])]);
    assert_eq!(of(&few, "values").len(), 0);
    // Four cells, two values on each side and two keys.
    assert_eq!(of(&few, "texts").len(), 10);
    let steps: Vec<f64> = (0..11).map(|n| 0.3 + 0.04 * f64::from(n)).collect();
    let wide = grid(&[("step", &steps), ("gamma", &[6.0, 8.0])]);
    assert_eq!(of(&wide, "values").len(), 22);
    assert!(of(&wide, "texts").len() < 2 + 11 + 2);
}

#[test]
fn columns_that_would_be_cut_are_left_out() {
    let row = |widths: &[usize]| widths.iter().map(|n| "x".repeat(*n)).collect::<Vec<_>>();
    assert_eq!(super::fitting(&[row(&[20, 20, 20]), row(&[1, 1, 1])]), 3);
    assert_eq!(super::fitting(&[row(&[20, 20, 20]), row(&[1, 30, 1])]), 2);
    assert_eq!(super::fitting(&[row(&[200, 1])]), 1);
}
