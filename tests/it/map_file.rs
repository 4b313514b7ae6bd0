//! The map in files for other tools, read back.

use crate::support::{Bench, sample};

#[test]
fn a_map_is_what_its_extension_says_and_the_same_in_all() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let features = "--features room.json --no-causes -q --map";
    for extension in ["geojson", "csv", "svg", "pgm"] {
        let run = bench.tmam(&log, &format!("replay {{}} {features} room.{extension}"));
        assert_eq!(run.code, 0, "{extension}: {}", run.stderr);
    }
    let map = &bench.json("room.json")["map"];
    let [lines, points] = ["lines", "points"].map(|kind| map[kind].as_array().unwrap());
    assert_eq!((lines.len(), points.len()), (6, 6));

    let geojson = bench.json("room.geojson");
    assert_eq!(geojson["type"], "FeatureCollection");
    let drawn = geojson["features"].as_array().unwrap();
    assert_eq!(drawn.len(), 12);
    let csv = String::from_utf8(bench.bytes("room.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 13);
    assert_eq!(rows[0][..4], ["id", "kind", "status", "x1"]);
    for point in points {
        let id = &point["id"];
        let drawn = drawn.iter().find(|one| one["id"] == *id).unwrap();
        assert_eq!(drawn["geometry"]["type"], "Point");
        let place = &drawn["geometry"]["coordinates"];
        assert_eq!((&place[0], &place[1]), (&point["x"], &point["y"]));
        let id = id.to_string();
        let row = rows.iter().find(|row| row[0] == id).unwrap();
        let x: f64 = row[3].parse().unwrap();
        assert!((x - point["x"].as_f64().unwrap()).abs() < 1e-8);
        assert_eq!((row[1], row[5], row[7]), ("point", "", ""));
    }
    let walls = drawn
        .iter()
        .filter(|one| one["geometry"]["type"] == "LineString");
    assert_eq!(walls.count(), 6);
    let svg = String::from_utf8(bench.bytes("room.svg")).unwrap();
    let svg = roxmltree::Document::parse(&svg).unwrap();
    let walls = svg
        .descendants()
        .filter(|node| node.attribute("class") == Some("wall"));
    assert_eq!(walls.count(), 6);
}

#[test]
fn a_grid_has_walls_where_they_are_and_is_free_between() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, "replay {} --no-causes --map 'room.pgm");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("room.yaml"), "{}", run.stdout);

    let yaml = String::from_utf8(bench.bytes("'room.yaml")).unwrap();
    let of = |key: &str| {
        yaml.lines()
            .find_map(|line| line.strip_prefix(key))
            .unwrap()
    };
    assert_eq!(of("image: "), "\"'room.pgm\"");
    let resolution: f64 = of("resolution: ").parse().unwrap();
    let origin: Vec<f64> = (of("origin: ").trim_matches(['[', ']']).split(", "))
        .map(|number| number.parse().unwrap())
        .collect();
    let image = bench.bytes("'room.pgm");
    let head: Vec<&str> = std::str::from_utf8(&image[..15])
        .unwrap()
        .split('\n')
        .collect();
    let (width, height) = head[1].split_once(' ').unwrap();
    let [width, height] = [width, height].map(|side| side.parse::<usize>().unwrap());
    assert_eq!((head[0], head[2]), ("P5", "255"));
    let cells = &image[image.len() - width * height..];
    let at = |x: f64, y: f64| {
        let column = ((x - origin[0]) / resolution) as usize;
        let row = ((y - origin[1]) / resolution) as usize;
        cells[(height - 1 - row) * width + column]
    };
    // Whichever side of a border between cells a wall lies on.
    let darkest = |x: f64, y: f64| {
        let near = [-0.03, 0.0, 0.03];
        let places = near.map(|dx| near.map(|dy| at(x + dx, y + dy)));
        *places.as_flattened().iter().min().unwrap()
    };
    assert_eq!(
        [darkest(2.0, 0.0), darkest(4.0, 5.0), darkest(0.0, 2.5)],
        [0; 3]
    );
    assert_eq!([darkest(4.0, 2.0), darkest(8.0, 5.0)], [0; 2], "corners");
    assert_eq!([at(1.0, 2.0), at(2.0, 2.0), at(5.0, 3.5)], [254; 3]);
    assert_eq!([at(-0.3, -0.3), at(6.0, 1.0), at(4.0, 5.3)], [205; 3]);
}

#[test]
fn other_extensions_are_refused() {
    let bench = Bench::new();
    let run = bench.tmam(&sample("room_step.mcap"), "replay {} --map room.png");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains(".geojson, .csv, .svg or .pgm"),
        "{}",
        run.stderr
    );
    let run = bench.tmam(
        &sample("room_step.mcap"),
        "replay {} --map a.pgm --features a.yaml",
    );
    assert_eq!(run.code, 2, "the file beside the image has a name, too");
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}
