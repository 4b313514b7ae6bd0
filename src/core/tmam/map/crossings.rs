//! Points in which arcs of several sonars cross.
//!
//! A run is of one sonar. A post that each sonar hears once in passing, or a corner whose triples outliers break, gives
//! none; but the arcs of all sonars that hear it cross in one place, which is what triangulation-based fusion (Wijk and
//! Christensen 2000, `methods/tbf.rs`) goes by. Here only arcs vote that no feature of the map explains, and a place
//! counts where neither chance nor a wall, smooth or rough, gives as much.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Matrix2;

use super::refine::GATE;
use crate::core::config;
use crate::core::event::SonarId;
use crate::core::geometry::{Vec2, angle_between, direction, unit, wrap_angle};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Point, Shape, Status};
use crate::core::tmam::fit::refit;
use crate::core::tmam::hypothesis::Gate;
use crate::core::tmam::oblique::STEEPEST;
use crate::core::tmam::pair::Points;
use crate::core::tmam::prediction::{MapPrediction, Reach, SIGMAS};

/// The cells in which arcs are counted are this wide, metres.
const CELL: f64 = 0.05;
/// Of more arcs than this, evenly spread ones are counted.
const MOST_ARCS: usize = 50_000;
/// An arc longer than this says nothing of a place, metres.
const LONGEST: f64 = 10.0;
/// Arcs of a cell whose crossings are tried, evenly spread.
const TRIED: usize = 8;
/// Arcs that cross at a smaller angle hardly say where, radians.
const TRANSVERSAL: f64 = 15.0 * PI / 180.0;
/// Rounds of gathering readings and fitting anew.
const ROUNDS: usize = 4;

/// Sonars that hear a point, at least.
const SONARS: usize = 3;
/// Bearings from which it is heard are at least so far apart, opposite ones being one: radians. A single wall has
/// its echoes from one bearing, and the one opposite to it.
const SWEPT: f64 = 45.0 * PI / 180.0;
/// So many readings must be of the point for each that speaks against it: outliers do.
const FITTING: usize = 5;
/// A range that is longer by this, and by three standard deviations, went through it: metres.
const THROUGH: f64 = 0.05;
/// One that is shorter by less than this, and that nothing explains, is of something beside it: metres.
const BESIDE: f64 = 0.15;
/// Directions of walls that are tried, over half a turn.
const DIRECTIONS: u32 = 180;

/// A point, and the readings that it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossingPoint {
    pub point: Point,
    pub arcs: Vec<Arc>,
}

/// The points in which arcs cross that the confirmed features of a map do not explain, in the order in which they were
/// first heard; none near a confirmed point. Sonars of which hardly a triple is explained are not asked.
pub fn find(
    features: &[MapFeature],
    arcs: &[Arc],
    hardly: &BTreeSet<SonarId>,
    bounds: &config::Map,
) -> Vec<CrossingPoint> {
    let prediction = MapPrediction::new(features, &Reach::of(bounds.max_wall_gap));
    let mut heard = Heard {
        fewest: bounds.confirm_readings as usize,
        ..Heard::default()
    };
    for arc in arcs.iter().filter(|arc| !hardly.contains(&arc.id.sonar)) {
        if prediction.associate(arc).all().is_empty() {
            heard.unexplained.push(arc);
        } else {
            heard.explained.push(arc);
        }
    }
    let confirmed = features.iter().filter(|f| f.status == Status::Confirmed);
    let mut taken: Vec<Vec2> = confirmed
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => Some(point.position),
            Shape::Line(_) | Shape::Circle(_) => None,
        })
        .collect();
    let cells = Cells::of(&heard.unexplained);
    let mut found = Vec::new();
    for cell in cells.fullest(heard.fewest / 2) {
        let is_taken = |place: Vec2| {
            let near = |known: &Vec2| (known - place).norm() < bounds.match_distance;
            taken.iter().any(near)
        };
        if is_taken(cell.middle()) {
            continue;
        }
        let around = cells.around(cell, &heard.unexplained);
        let crossing = crossing(cell, &cells.arcs(cell, &heard.unexplained), &around);
        let Some(crossing) = crossing.and_then(|place| heard.point_at(place, cell, &around)) else {
            continue;
        };
        if !is_taken(crossing.point.position) {
            taken.push(crossing.point.position);
            found.push(crossing);
        }
    }
    found.sort_by_key(|crossing| crossing.arcs.first().map(|arc| arc.id));
    found
}

/// The crossing in or beside a cell of two arcs of different sonars, out of a few, that most arcs pass.
fn crossing(cell: Cell, of: &[&Arc], around: &[&Arc]) -> Option<Vec2> {
    let stride = of.len().div_ceil(TRIED).max(1);
    let tried: Vec<&Arc> = of.iter().copied().step_by(stride).collect();
    let pairs = tried.iter().enumerate().flat_map(|(at, a)| {
        let others = tried.iter().skip(at + 1);
        others.map(move |b| (*a, *b))
    });
    let crossings = pairs
        .filter(|(a, b)| a.id.sonar != b.id.sonar)
        .flat_map(|(a, b)| Points::of(a, b).intersection.into_iter().flatten())
        .filter(|point| {
            let angle = angle_between(point.bearing_a, point.bearing_b);
            angle.min(PI - angle) >= TRANSVERSAL && cell.is_near(point.on_a)
        });
    let near = |place: Vec2| {
        let passes = |arc: &&&Arc| agrees(place, arc, 2.0 * SIGMAS * SIGMAS);
        around.iter().filter(passes).count()
    };
    let best = crossings.fold((0, None), |best, point| match near(point.on_a) {
        count if count > best.0 => (count, Some(point.on_a)),
        _ => best,
    });
    best.1
}

/// How much longer a range is than the way to a place, metres.
fn beyond(place: Vec2, arc: &Arc) -> f64 {
    arc.range - (place - arc.center()).norm()
}

/// Whether the beam of a reading holds a place.
fn holds(place: Vec2, arc: &Arc) -> bool {
    arc.beam_nearly_holds(direction(place - arc.center()), ties::ANGLE)
}

/// Whether a reading is of a place, its chi2 being below the gate.
fn agrees(place: Vec2, arc: &Arc, gate: f64) -> bool {
    let beyond = beyond(place, arc);
    // Most end elsewhere, which needs no bearing.
    beyond * beyond < gate * arc.variance && holds(place, arc)
}

/// What was heard, apart by whether the map explains it.
#[derive(Debug, Default)]
struct Heard<'a> {
    unexplained: Vec<&'a Arc>,
    explained: Vec<&'a Arc>,
    /// Readings that a point needs.
    fewest: usize,
}

impl Heard<'_> {
    /// The point near a place in a cell, where enough speaks for one. What passes `around` tells at once of most places
    /// that there is none.
    fn point_at(&self, place: Vec2, cell: Cell, around: &[&Arc]) -> Option<CrossingPoint> {
        let near = self.gathered(place, around)?;
        let beside = around.len() - near.arcs.len();
        if near.arcs.len() < FITTING * beside || !cell.is_near(near.point.position) {
            return None;
        }
        let found = self.gathered(near.point.position, &self.unexplained)?;
        let is_point = found.is_seen_round()
            && found.arcs.len() >= FITTING * self.against(&found)
            && found.beside_a_wall() >= (self.fewest / 2).max(found.arcs.len() / FITTING);
        is_point.then_some(found)
    }

    /// The point that readings near a place are of, all of them together.
    fn gathered(&self, place: Vec2, arcs: &[&Arc]) -> Option<CrossingPoint> {
        let mut found = CrossingPoint {
            point: Point {
                position: place,
                covariance: Matrix2::zeros(),
            },
            arcs: Vec::new(),
        };
        for _ in 0..ROUNDS {
            let place = found.point.position;
            let agrees = |arc: &&Arc| agrees(place, arc, SIGMAS * SIGMAS);
            let agreeing: Vec<Arc> = arcs.iter().copied().filter(agrees).copied().collect();
            if agreeing.len() < self.fewest.max(SONARS) {
                return None;
            }
            let is_settled = agreeing == found.arcs;
            let fitted = refit(&Shape::Point(found.point), &agreeing)?;
            let Shape::Point(point) = fitted.shape else {
                return None;
            };
            found = CrossingPoint {
                point,
                arcs: agreeing,
            };
            if is_settled {
                let gate = Gate::new(GATE).at(found.arcs.len() - 2);
                return (fitted.chi2 < gate).then_some(found);
            }
        }
        None
    }

    /// How many readings speak against a point: those that went through it, and those of something beside it.
    fn against(&self, found: &CrossingPoint) -> usize {
        let place = found.point.position;
        let through = self.explained.iter().filter(|arc| {
            let least = THROUGH + SIGMAS * arc.variance.sqrt();
            beyond(place, arc) > least && holds(place, arc)
        });
        let beside = self.unexplained.iter().filter(|arc| {
            let is_near = beyond(place, arc) > -BESIDE && holds(place, arc);
            is_near && !agrees(place, arc, SIGMAS * SIGMAS)
        });
        through.count() + beside.count()
    }
}

impl CrossingPoint {
    /// Whether enough sonars hear it, from bearings far enough apart.
    fn is_seen_round(&self) -> bool {
        let sonars: BTreeSet<SonarId> = self.arcs.iter().map(|arc| arc.id.sonar).collect();
        let mut bearings: Vec<f64> = (self.arcs.iter())
            .map(|arc| direction(self.point.position - arc.center()).rem_euclid(PI))
            .collect();
        bearings.sort_by(f64::total_cmp);
        let around = bearings.first().zip(bearings.last());
        let around = around.map(|(first, last)| PI - (last - first));
        let gaps = bearings.array_windows().map(|[a, b]| b - a).chain(around);
        sonars.len() >= SONARS && PI - gaps.fold(0.0, f64::max) >= SWEPT
    }

    /// How many of its readings no single wall explains along with the others: a smooth one from the foot of the
    /// perpendicular, a rough one from its nearest place in the beam.
    fn beside_a_wall(&self) -> usize {
        let directions = (0..DIRECTIONS).map(|k| PI * f64::from(k) / f64::from(DIRECTIONS));
        let most = directions.map(|theta| most_on_one_wall(&self.arcs, theta));
        self.arcs.len() - most.max().unwrap_or(0)
    }
}

/// How many readings a single wall whose normal has the direction `theta` explains, wherever it is: its nearest place
/// in the beam is where the range ends.
fn most_on_one_wall(arcs: &[Arc], theta: f64) -> usize {
    let normal = unit(theta);
    let mut ends: Vec<(f64, i32)> = Vec::new();
    for arc in arcs {
        let to_normal = wrap_angle(theta - arc.world_from_sensor.yaw);
        let (to_foot, side) = if to_normal.abs() <= FRAC_PI_2 {
            (to_normal.abs(), 1.0)
        } else {
            (PI - to_normal.abs(), -1.0)
        };
        let beside = (to_foot - arc.beam_width / 2.0).max(0.0);
        if beside < STEEPEST {
            let shortened = libm::cos(beside);
            let rho = normal.dot(&arc.center()) + side * arc.range * shortened;
            let spread = SIGMAS * arc.variance.sqrt() * shortened;
            ends.extend([(rho - spread, 1), (rho + spread, -1)]);
        }
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut explained = 0_i32;
    let counts = ends.iter().map(|(_, change)| {
        explained += change;
        explained.unsigned_abs() as usize
    });
    counts.max().unwrap_or(0)
}

/// Where arcs pass, in cells of [`CELL`].
struct Cells {
    /// Cells with the places of the arcs that pass through them, in order.
    passing: Vec<(Cell, u32)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell(i32, i32);

impl Cell {
    fn of(place: Vec2) -> Self {
        Self(
            (place.x / CELL).floor() as i32,
            (place.y / CELL).floor() as i32,
        )
    }

    fn middle(self) -> Vec2 {
        Vec2::new(f64::from(self.0) + 0.5, f64::from(self.1) + 0.5) * CELL
    }

    /// Whether a place lies in it or in one of its neighbours, or hardly beyond.
    fn is_near(self, place: Vec2) -> bool {
        (place - self.middle()).norm() < 2.0 * CELL
    }
}

impl Cells {
    fn of(arcs: &[&Arc]) -> Self {
        let stride = arcs.len().div_ceil(MOST_ARCS).max(1);
        let places = (0..).zip(arcs).step_by(stride);
        let mut passing: Vec<(Cell, u32)> = places
            .filter(|(_, arc)| arc.range * arc.beam_width <= LONGEST)
            .flat_map(|(at, arc)| {
                let steps = (2.0 * arc.range * arc.beam_width / CELL).ceil().max(1.0) as u32;
                let shares = (0..=steps).map(move |k| f64::from(k) / f64::from(steps) - 0.5);
                let bearings =
                    shares.map(|share| arc.world_from_sensor.yaw + share * arc.beam_width);
                bearings.map(move |bearing| (Cell::of(arc.point_at(bearing)), at))
            })
            .collect();
        passing.sort_unstable();
        passing.dedup();
        Self { passing }
    }

    /// The cells through which so many arcs pass at least, those with most first.
    fn fullest(&self, fewest: usize) -> Vec<Cell> {
        let cells = self.passing.chunk_by(|(a, _), (b, _)| a == b);
        let counted = cells.filter_map(|cell| Some((cell.len(), cell.first()?.0)));
        let mut full: Vec<(usize, Cell)> = counted.filter(|(count, _)| *count >= fewest).collect();
        full.sort_by(|(a, first), (b, second)| b.cmp(a).then(first.cmp(second)));
        full.into_iter().map(|(_, cell)| cell).collect()
    }

    fn places(&self, cell: Cell) -> impl Iterator<Item = u32> {
        let from = self.passing.partition_point(|(other, _)| *other < cell);
        let rest = self.passing.get(from..).unwrap_or_default();
        let here = rest.iter().take_while(move |(other, _)| *other == cell);
        here.map(|(_, at)| *at)
    }

    /// The arcs that pass through a cell.
    fn arcs<'a>(&self, cell: Cell, arcs: &[&'a Arc]) -> Vec<&'a Arc> {
        at(arcs, self.places(cell))
    }

    /// Those that pass through it or through one of its neighbours.
    fn around<'a>(&self, Cell(x, y): Cell, arcs: &[&'a Arc]) -> Vec<&'a Arc> {
        let beside = |at: i32| [-1, 0, 1].map(|step| at.saturating_add(step));
        let cells = beside(x).map(|x| beside(y).map(|y| Cell(x, y)));
        let places = cells.as_flattened().iter();
        let mut places: Vec<u32> = places.flat_map(|cell| self.places(*cell)).collect();
        places.sort_unstable();
        places.dedup();
        at(arcs, places)
    }
}

/// The arcs at some places.
fn at<'a>(arcs: &[&'a Arc], places: impl IntoIterator<Item = u32>) -> Vec<&'a Arc> {
    let arcs = |place| arcs.get(usize::try_from(place).ok()?).copied();
    places.into_iter().filter_map(arcs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};
    use crate::core::world::World;

    const BEAM: f64 = 22.5 * PI / 180.0;

    /// What sixteen sonars hear in a world on the way along x, each of them every so often.
    fn drive(world: &World, noise: &mut Gauss) -> Vec<Arc> {
        let one = |k: u32| {
            let sonar = k * 5 % 16;
            let sensor = Vec2::new(0.02 * f64::from(k), 0.0);
            let yaw = wrap_angle(PI / 8.0 * f64::from(sonar));
            let placed = arc(k, sensor, yaw, 1.0);
            let echo = world.echo(placed.world_from_sensor, BEAM, 4.0)?;
            let mut heard = arc(k, sensor, yaw, echo.range + SIGMA * noise.sample());
            heard.beam_width = BEAM;
            heard.id.sonar = SonarId(sonar as u16);
            Some(heard)
        };
        (0..150).filter_map(one).collect()
    }

    fn found(arcs: &[Arc], features: &[MapFeature]) -> Vec<CrossingPoint> {
        find(features, arcs, &BTreeSet::new(), &config::Map::default())
    }

    fn world(walls: &str, points: &str, diffuse: &str) -> World {
        let text =
            format!("{{\"walls\": [{walls}], \"points\": [{points}], \"diffuse\": [{diffuse}]}}");
        World::from_json(&text).unwrap()
    }

    #[test]
    fn a_post_that_many_sonars_hear_is_where_their_arcs_cross() {
        let post = Vec2::new(1.5, 1.0);
        let arcs = drive(&world("", "[1.5, 1.0]", ""), &mut Gauss::new(3));
        let all = found(&arcs, &[]);
        let [one] = all.as_slice() else {
            panic!("{all:?}");
        };
        let away = one.point.position - post;
        let inverse = one.point.covariance.try_inverse().unwrap();
        assert!(away.dot(&(inverse * away)) < 13.8, "{away}");
        let known = MapFeature {
            id: 0,
            shape: Shape::Point(one.point),
            readings: 8,
            runs: 1,
            status: Status::Confirmed,
        };
        assert!(found(&arcs, &[known]).is_empty(), "it is there already");
        let one_sonar: Vec<Arc> = (arcs.iter())
            .map(|arc| {
                let mut arc = *arc;
                arc.id.sonar = SonarId(0);
                arc
            })
            .collect();
        assert!(found(&one_sonar, &[]).is_empty(), "of one sonar runs are");
    }

    #[test]
    fn few_readings_and_readings_that_see_through_it_make_no_point() {
        let arcs = drive(&world("", "[1.5, 1.0]", ""), &mut Gauss::new(3));
        assert!(found(arcs.get(..7).unwrap(), &[]).is_empty());
        let longer = |arc: &Arc| Arc {
            range: arc.range + 0.5,
            ..*arc
        };
        let through: Vec<Arc> = arcs.iter().step_by(4).map(longer).collect();
        assert!(found(&[arcs.clone(), through].concat(), &[]).is_empty());
        let outlier: Vec<Arc> = arcs.iter().step_by(40).map(longer).collect();
        assert_eq!(found(&[arcs, outlier].concat(), &[]).len(), 1);
    }

    #[test]
    fn no_wall_is_a_point_smooth_or_rough_or_between_two() {
        for seed in 0..20 {
            let noise = &mut Gauss::new(seed);
            let smooth = drive(&world("[-9, 1, 9, 1]", "", ""), noise);
            let rough = drive(&world("[-9, 1, 9, 1]", "", "0"), noise);
            let both = drive(
                &world("[-9, 1, 9, 1], [-9, -1.3, 9, -1.3]", "", "0, 1"),
                noise,
            );
            for arcs in [smooth, rough, both] {
                assert_eq!(found(&arcs, &[]), []);
            }
        }
    }

    #[test]
    fn the_last_bit_decides_neither_which_points_there_are_nor_their_readings() {
        let posts = "[0.6, 1.0], [1.5, 1.0], [2.4, -1.2]";
        for sigma in [0.0, 1.0] {
            let mut noise = Gauss::new(3);
            let mut arcs = drive(&world("", posts, ""), &mut noise);
            for arc in arcs.iter_mut().filter(|_| sigma == 0.0) {
                let echo = world("", posts, "").echo(arc.world_from_sensor, BEAM, 4.0);
                arc.range = echo.unwrap().range;
            }
            let expected = found(&arcs, &[]);
            assert!(expected.len() >= 2, "{expected:?}");
            for most in [1e-12, 1e-9] {
                let mut moved = || most * noise.sample().clamp(-1.0, 1.0);
                let mut perturbed = arcs.clone();
                for arc in &mut perturbed {
                    arc.range += moved();
                    arc.world_from_sensor.x += moved();
                    arc.world_from_sensor.yaw += moved();
                }
                let again = found(&perturbed, &[]);
                assert_eq!(expected.len(), again.len());
                for (a, b) in expected.iter().zip(&again) {
                    let ids = |of: &CrossingPoint| -> Vec<_> {
                        of.arcs.iter().map(|arc| arc.id).collect()
                    };
                    assert_eq!(ids(a), ids(b));
                    assert!((a.point.position - b.point.position).norm() < 1e-7);
                }
            }
        }
    }
}
