//! The map in files that other tools read: GeoJSON, CSV, a picture, or an occupancy grid.

mod occupancy;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::core::geometry::Vec2;
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::core::rounding::{fixed, rounded};
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::tool::Tool;
use crate::io::output::{Output, is_stdout};
use crate::tools::report::map::draw;
use occupancy::Occupancy;

/// How a map is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapFormat {
    /// A collection of line strings and points.
    GeoJson,
    /// A row per feature.
    Csv,
    /// The drawing of a report.
    Svg,
    /// The image of an occupancy grid; what it means stands in a file of YAML beside it.
    Pgm,
}

impl MapFormat {
    /// What the name of a file asks for; standard output takes GeoJSON.
    pub fn of(file: &Path) -> Option<Self> {
        let extension = file.extension().and_then(|extension| extension.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("geojson") => Some(Self::GeoJson),
            Some("csv") => Some(Self::Csv),
            Some("svg") => Some(Self::Svg),
            Some("pgm") => Some(Self::Pgm),
            _ => is_stdout(file).then_some(Self::GeoJson),
        }
    }
}

/// The file beside a map that says what its image means; none beside a map that is no image.
pub fn beside(file: &Path) -> Option<PathBuf> {
    (MapFormat::of(file) == Some(MapFormat::Pgm)).then(|| file.with_extension("yaml"))
}

/// Writes the map that a replay made, and what is `beside` it; `path` is where the robot went.
///
/// # Errors
/// When one of them cannot be written.
pub fn write(
    out: &mut Output,
    beside: Option<&mut Output>,
    setting: &Setting<'_>,
    outcome: &Outcome,
    path: &[Vec2],
) -> io::Result<()> {
    match MapFormat::of(out.path()) {
        Some(MapFormat::Csv) => csv(out, &outcome.map),
        Some(MapFormat::Svg) => {
            let suspects = outcome.reports.iter().filter(|report| report.is_suspect());
            let mut suspects: Vec<_> = suspects.collect();
            suspects.sort_by(|a, b| a.worse_first(b));
            let arcs: Vec<_> = suspects.iter().map(|report| report.arc).collect();
            svg::write(out, &draw(path, &[], &outcome.map, &arcs, None))
        }
        Some(MapFormat::Pgm) => {
            let occupancy = Occupancy::of(outcome, path);
            let image = out.path().file_name().unwrap_or_default();
            let meaning = occupancy.meaning(&image.to_string_lossy());
            occupancy.write(out)?;
            beside.map_or(Ok(()), |beside| beside.write_all(meaning.as_bytes()))
        }
        Some(MapFormat::GeoJson) | None => geojson(out, setting, &outcome.map),
    }
}

fn geojson(mut out: impl Write, setting: &Setting<'_>, map: &[MapFeature]) -> io::Result<()> {
    let place = |place: Vec2| [rounded(place.x), rounded(place.y)];
    let features = map.iter().map(|feature| {
        let (kind, geometry, covariance) = match &feature.shape {
            Shape::Line(line) => (
                "line",
                json!({ "type": "LineString", "coordinates": line.ends().map(place) }),
                line.covariance,
            ),
            Shape::Point(point) => (
                "point",
                json!({ "type": "Point", "coordinates": place(point.position) }),
                point.covariance,
            ),
            Shape::Circle(circle) => (
                "circle",
                json!({
                    "type": "Polygon",
                    "coordinates": [circle.outline().map(place).collect::<Vec<_>>()],
                }),
                feature.shape.covariance().unwrap_or_default(),
            ),
        };
        let round = match &feature.shape {
            Shape::Circle(circle) => Some((place(circle.center), rounded(circle.radius))),
            Shape::Line(_) | Shape::Point(_) => None,
        };
        let mut properties = json!({
            "kind": kind,
            "status": feature.status,
            "readings": feature.readings,
            "runs": feature.runs,
            "covariance": [[covariance.m11, covariance.m12], [covariance.m21, covariance.m22]],
        });
        if let (Some((center, radius)), Some(properties)) = (round, properties.as_object_mut()) {
            properties.insert("center".to_owned(), json!(center));
            properties.insert("radius".to_owned(), json!(radius));
        }
        json!({
            "type": "Feature",
            "id": feature.id,
            "geometry": geometry,
            "properties": properties,
        })
    });
    let file = json!({
        "type": "FeatureCollection",
        "schema": "tmam.map/1",
        "tool": Tool::THIS,
        "source": setting.source.file,
        "frame": "odometry, metres",
        "features": features.collect::<Vec<Value>>(),
    });
    writeln!(out, "{file:#}")
}

fn csv(out: impl Write, map: &[MapFeature]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record([
        "id", "kind", "status", "x1", "y1", "x2", "y2", "rho", "theta", "var_1", "cov_12", "var_2",
        "readings", "runs",
    ])?;
    let number = |x: f64| fixed(x, 9);
    for feature in map {
        let (kind, places, covariance) = match &feature.shape {
            Shape::Line(line) => {
                let [from, to] = line.ends();
                let places = [from.x, from.y, to.x, to.y, line.rho, line.theta].map(number);
                ("line", places, line.covariance)
            }
            Shape::Point(point) => {
                let nothing = String::new;
                let [x, y] = [point.position.x, point.position.y].map(number);
                let places = [x, y, nothing(), nothing(), nothing(), nothing()];
                ("point", places, point.covariance)
            }
            // Its centre, and one of its places.
            Shape::Circle(circle) => {
                let nothing = String::new;
                let (x, y) = (circle.center.x, circle.center.y);
                let [x, y, beside] = [x, y, x + circle.radius].map(number);
                let places = [x, y.clone(), beside, y, nothing(), nothing()];
                let covariance = feature.shape.covariance().unwrap_or_default();
                ("circle", places, covariance)
            }
        };
        let variances = [covariance.m11, covariance.m12, covariance.m22];
        let row = [
            feature.id.to_string(),
            kind.into(),
            feature.status.name().into(),
        ]
        .into_iter()
        .chain(places)
        .chain(variances.map(|x| format!("{x:.9e}")))
        .chain([feature.readings, feature.runs].map(|n| n.to_string()));
        table.write_record(row)?;
    }
    table.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_says_the_format() {
        let of = |name: &str| MapFormat::of(Path::new(name));
        assert_eq!(of("a.b.geojson"), Some(MapFormat::GeoJson));
        assert_eq!(of("-"), Some(MapFormat::GeoJson));
        assert_eq!(of("MAP.PGM"), Some(MapFormat::Pgm));
        assert_eq!(of("a.csv/a.pgm"), Some(MapFormat::Pgm));
        assert_eq!((of("a"), of("a.png")), (None, None));
        assert_eq!(beside(Path::new("out/a.pgm")), Some("out/a.yaml".into()));
        assert_eq!(beside(Path::new("a.svg")), None);
    }
}
