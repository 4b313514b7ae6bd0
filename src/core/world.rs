//! The world a sonar looks at: walls, points and pillars in the plane, and what echoes from them.
//!
//! A file is JSON, metres, in the odometry frame: `{"walls": [[x1, y1, x2, y2], ...],
//! "points": [[x, y], ...], "diffuse": [wall, ...], "pillars": [[x, y, radius], ...]}`. Walls are seen from both
//! sides, pillars from without.
//!
//! Echo model: a smooth wall is a mirror and echoes only from the foot of the perpendicular, where
//! that lies on the wall and in the beam. A diffuse one, which is rough, echoes from its nearest place
//! in the beam: beside the foot, that is where an edge of the beam meets it. A point diffracts and
//! echoes wherever the beam covers it. A pillar, which is round and smooth, echoes from its nearest place, where the
//! beam covers the bearing of its axis. The nearest reflector in line of sight gives the echo.
//!
//! Wall ends diffract as well. Point indices count the file's `points` first, in their order, then
//! the wall ends that the file does not list, wall by wall.

use serde::{Deserialize, Serialize};

use crate::core::geometry::{Pose2, Vec2, angle_between, direction, unit};

/// Two places nearer than this are the same, metres.
const SAME_PLACE: f64 = 1e-9;

/// The shortest wall that has a direction, metres.
const MIN_WALL_LENGTH: f64 = 1e-6;

/// The thinnest pillar, metres.
const MIN_RADIUS: f64 = 1e-3;

/// The most walls, pillars and listed points of a world: an echo is looked for among all of them.
const LARGEST: usize = 5_000;

/// Why a world cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file cannot be read.
    #[error("cannot read the world: {0}")]
    Read(#[from] std::io::Error),
    /// Not JSON, or not of the right form.
    #[error(
        "not a world file: {0}; expected {{\"walls\": [[x1,y1,x2,y2], ...], \"points\": [[x,y], ...], \"pillars\": [[x,y,radius], ...]}} in metres"
    )]
    Format(#[from] serde_json::Error),
    /// Nothing to see.
    #[error("the world is empty; give it at least one wall, point or pillar")]
    Empty,
    /// More than can be looked through for every reading.
    #[error(
        "the world has {things} walls, points and pillars, more than {LARGEST}; leave out what no sonar can see"
    )]
    TooLarge {
        /// How many.
        things: usize,
    },
    /// A wall end or a point is infinite or not a number.
    #[error("{kind} {index} has a coordinate that is not finite")]
    NotFinite {
        /// `wall`, `point` or `pillar`.
        kind: &'static str,
        /// Which, from 0.
        index: usize,
    },
    /// A wall without a direction.
    #[error(
        "wall {index} is {length} m long; a wall needs at least {MIN_WALL_LENGTH} m, use a point for less"
    )]
    ShortWall {
        /// Which, from 0.
        index: usize,
        /// Its length, metres.
        length: f64,
    },
    /// A diffuse wall that is none of the walls.
    #[error("wall {index} is called diffuse, but there are {walls} walls, counted from 0")]
    NoSuchWall {
        /// Which, from 0.
        index: usize,
        /// How many there are.
        walls: usize,
    },
    /// A pillar without a radius.
    #[error(
        "pillar {index} has the radius {radius} m; a pillar needs at least {MIN_RADIUS} m, use a point for less"
    )]
    ThinPillar {
        /// Which, from 0.
        index: usize,
        /// Metres.
        radius: f64,
    },
    /// Two points in one place could not be told apart.
    #[error("points {first} and {second} are in the same place; remove one")]
    SamePoint {
        /// The earlier one, from 0.
        first: usize,
        /// The later one, from 0.
        second: usize,
    },
}

/// A straight wall between two ends, metres in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// One end.
    pub start: Vec2,
    /// The other end.
    pub end: Vec2,
    /// Whether it is rough, so that it echoes at any angle.
    pub diffuse: bool,
}

impl Wall {
    /// The smooth wall between two points, metres in the world.
    pub fn new(start: Vec2, end: Vec2) -> Self {
        Self {
            start,
            end,
            diffuse: false,
        }
    }

    /// Where the perpendicular from `point` meets the wall, if it does between its ends; at an end
    /// it is the end that echoes, as a point.
    fn foot_of_perpendicular(&self, point: Vec2) -> Option<Vec2> {
        let along = self.end - self.start;
        let t = (point - self.start).dot(&along) / along.norm_squared();
        let foot = self.start + along * t;
        let inside = t > 0.0 && t < 1.0;
        let at_an_end = same_place(&foot, &self.start) || same_place(&foot, &self.end);
        (inside && !at_an_end).then_some(foot)
    }

    /// The nearer of the places where the edges of a beam (`half` of its width) meet the wall between its
    /// ends.
    fn nearest_on_edges(&self, world_from_sensor: Pose2, half: f64) -> Option<Vec2> {
        let (sensor, along) = (world_from_sensor.position(), self.end - self.start);
        let met = |edge: f64| {
            let ray = unit(world_from_sensor.yaw + edge);
            let parted = ray.perp(&along);
            let to_start = self.start - sensor;
            let (way, share) = (to_start.perp(&along) / parted, to_start.perp(&ray) / parted);
            // Parallel ones give infinities or NaN.
            let meets = way > 0.0 && way.is_finite() && share > 0.0 && share < 1.0;
            meets.then_some((way, sensor + ray * way))
        };
        let places = [-half, half].into_iter().filter_map(met);
        let nearest = places.min_by(|(a, _), (b, _)| a.total_cmp(b));
        nearest.map(|(_, place)| place)
    }

    /// A place on the other side, as in a mirror.
    fn mirrored(&self, place: Vec2) -> Vec2 {
        let along = (self.end - self.start).normalize();
        let from_start = place - self.start;
        self.start + along * (2.0 * from_start.dot(&along)) - from_start
    }

    /// Whether the wall stands between `from` and `to`. Touching it is not crossing it, so a
    /// wall does not hide its own ends nor what leans on it.
    fn hides(&self, from: Vec2, to: Vec2) -> bool {
        let along = self.end - self.start;
        let side = |point: Vec2| along.perp(&(point - self.start)) / along.norm();
        let (near, far) = (side(from), side(to));
        let parted =
            (near > SAME_PLACE && far < -SAME_PLACE) || (near < -SAME_PLACE && far > SAME_PLACE);
        let sight = to - from;
        let (a, b) = (
            sight.perp(&(self.start - from)),
            sight.perp(&(self.end - from)),
        );
        parted && ((a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0))
    }
}

/// A round, smooth pillar, metres in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pillar {
    /// Its axis.
    pub center: Vec2,
    pub radius: f64,
}

impl Pillar {
    /// The place that echoes to a sensor outside of it.
    fn nearest(&self, sensor: Vec2) -> Option<Vec2> {
        let away = sensor - self.center;
        let distance = away.norm();
        (distance > self.radius).then(|| self.center + away * (self.radius / distance))
    }

    /// Whether it stands between `from` and `to`. Touching it is not crossing it.
    fn hides(&self, from: Vec2, to: Vec2) -> bool {
        let sight = to - from;
        let share = (self.center - from).dot(&sight) / sight.norm_squared();
        let nearest = from + sight * share.clamp(0.0, 1.0);
        (self.center - nearest).norm() < self.radius - SAME_PLACE
    }
}

/// What an echo came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reflector {
    /// A wall, by its index in [`World::walls`].
    Line(usize),
    /// A point, by its index in [`World::points`].
    Point(usize),
    /// A pillar, by its index in [`World::pillars`].
    Circle(usize),
}

impl Reflector {
    /// Its place among the world's walls, points or pillars.
    pub fn index(self) -> usize {
        match self {
            Self::Line(index) | Self::Point(index) | Self::Circle(index) => index,
        }
    }
}

/// The first thing that echoes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// Distance from the sensor, metres, without noise.
    pub range: f64,
    /// What it is.
    pub reflector: Reflector,
    /// Whether it is a diffuse wall beside the foot of the perpendicular.
    pub oblique: bool,
    /// Where it echoed, metres in the world.
    pub place: Vec2,
}

/// Walls, diffracting points and pillars; always valid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WorldFile", into = "WorldFile")]
pub struct World {
    walls: Vec<Wall>,
    points: Vec<Vec2>,
    pillars: Vec<Pillar>,
}

impl World {
    /// A world of `walls` and free-standing `points`, metres; wall ends are added to the points.
    pub fn new(walls: Vec<Wall>, points: Vec<Vec2>) -> Result<Self, WorldError> {
        Self::with_pillars(walls, points, Vec::new())
    }

    /// The same with pillars.
    pub fn with_pillars(
        walls: Vec<Wall>,
        points: Vec<Vec2>,
        pillars: Vec<Pillar>,
    ) -> Result<Self, WorldError> {
        let things = walls.len() + points.len() + pillars.len();
        if things == 0 {
            return Err(WorldError::Empty);
        }
        if things > LARGEST {
            return Err(WorldError::TooLarge { things });
        }
        let finite = |p: &Vec2| p.iter().all(|coordinate| coordinate.is_finite());
        for (index, wall) in walls.iter().enumerate() {
            if !(finite(&wall.start) && finite(&wall.end)) {
                return Err(WorldError::NotFinite {
                    kind: "wall",
                    index,
                });
            }
            let length = (wall.end - wall.start).norm();
            if length < MIN_WALL_LENGTH {
                return Err(WorldError::ShortWall { index, length });
            }
        }
        for (second, point) in points.iter().enumerate() {
            if !finite(point) {
                return Err(WorldError::NotFinite {
                    kind: "point",
                    index: second,
                });
            }
            let mut earlier = points.iter().take(second);
            if let Some(first) = earlier.position(|other| same_place(other, point)) {
                return Err(WorldError::SamePoint { first, second });
            }
        }
        for (index, Pillar { center, radius }) in pillars.iter().enumerate() {
            if !(finite(center) && radius.is_finite()) {
                return Err(WorldError::NotFinite {
                    kind: "pillar",
                    index,
                });
            }
            let radius = *radius;
            if radius < MIN_RADIUS {
                return Err(WorldError::ThinPillar { index, radius });
            }
        }
        let mut world = Self {
            walls,
            points,
            pillars,
        };
        for end in world.walls.iter().flat_map(|wall| [wall.start, wall.end]) {
            if !world.points.iter().any(|point| same_place(point, &end)) {
                world.points.push(end);
            }
        }
        Ok(world)
    }

    /// Reads the text of a world file.
    pub fn from_json(text: &str) -> Result<Self, WorldError> {
        let file: WorldFile = serde_json::from_str(text)?;
        Self::try_from(file)
    }

    /// The L-shaped room of the paper's Table I, 8 m by 5 m: six walls and their six corners.
    pub fn room() -> Self {
        let corners = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 2.0),
            (8.0, 2.0),
            (8.0, 5.0),
            (0.0, 5.0),
        ]
        .map(|(x, y)| Vec2::new(x, y));
        let next = corners.iter().cycle().skip(1);
        let walls = corners.iter().zip(next).map(|(a, b)| Wall::new(*a, *b));
        Self {
            walls: walls.collect(),
            points: corners.to_vec(),
            pillars: Vec::new(),
        }
    }

    /// The walls, in the file's order.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// All that diffracts: the file's points, then the wall ends it does not list. Metres.
    pub fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// The pillars, in the file's order.
    pub fn pillars(&self) -> &[Pillar] {
        &self.pillars
    }

    /// The same world in another frame.
    pub fn moved(&self, other_from_world: &Pose2) -> Self {
        let there = |place: Vec2| other_from_world.transform(place);
        let walls = self.walls.iter().map(|wall| Wall {
            start: there(wall.start),
            end: there(wall.end),
            ..*wall
        });
        let pillars = self.pillars.iter().map(|pillar| Pillar {
            center: there(pillar.center),
            ..*pillar
        });
        Self {
            walls: walls.collect(),
            points: self.points.iter().copied().map(there).collect(),
            pillars: pillars.collect(),
        }
    }

    /// The world with some of its walls diffuse, by their indices.
    ///
    /// # Errors
    /// An index that is no wall's.
    pub fn with_diffuse(mut self, walls: &[usize]) -> Result<Self, WorldError> {
        let count = self.walls.len();
        for index in walls.iter().copied() {
            let no_such = WorldError::NoSuchWall {
                index,
                walls: count,
            };
            self.walls.get_mut(index).ok_or(no_such)?.diffuse = true;
        }
        Ok(self)
    }

    /// Where a reflector echoes to a sensor that looks at it; of a wall the foot of the perpendicular, also beyond its
    /// ends. `None` from within a pillar.
    pub fn place_of(&self, reflector: Reflector, sensor: Vec2) -> Option<Vec2> {
        match reflector {
            Reflector::Line(index) => {
                let wall = self.walls.get(index)?;
                let along = (wall.end - wall.start).normalize();
                Some(wall.start + along * (sensor - wall.start).dot(&along))
            }
            Reflector::Point(index) => self.points.get(index).copied(),
            Reflector::Circle(index) => self.pillars.get(index)?.nearest(sensor),
        }
    }

    /// What a sonar hears first nearer than `max_range` (metres) with its full `beam_width`
    /// (radians), its beam along the x axis of `world_from_sensor`.
    pub fn echo(&self, world_from_sensor: Pose2, beam_width: f64, max_range: f64) -> Option<Echo> {
        let sensor = world_from_sensor.position();
        let in_beam = |place: &Vec2| {
            let bearing = direction(place - sensor);
            angle_between(bearing, world_from_sensor.yaw) <= beam_width / 2.0
        };
        let walls = self.walls.iter().enumerate().filter_map(|(index, wall)| {
            let reflector = Reflector::Line(index);
            if let Some(foot) = wall.foot_of_perpendicular(sensor).filter(in_beam) {
                return Some((foot, reflector, false));
            }
            let edge = || wall.nearest_on_edges(world_from_sensor, beam_width / 2.0);
            let place = wall.diffuse.then(edge).flatten()?;
            Some((place, reflector, true))
        });
        let points = self.points.iter().enumerate();
        let points = points.filter(|(_, point)| in_beam(point));
        let points = points.map(|(index, point)| (*point, Reflector::Point(index), false));

        let pillars = self.pillars.iter().enumerate();
        let pillars = pillars.filter_map(|(index, pillar)| {
            let place = pillar.nearest(sensor).filter(in_beam)?;
            Some((place, Reflector::Circle(index), false))
        });

        let mut first: Option<Echo> = None;
        for (place, reflector, oblique) in walls.chain(points).chain(pillars) {
            let range = (place - sensor).norm();
            let nearest = range < first.map_or(max_range, |echo| echo.range);
            if nearest && self.in_sight(sensor, place, reflector) {
                first = Some(Echo {
                    range,
                    reflector,
                    oblique,
                    place,
                });
            }
        }
        first
    }

    /// Half the way of the sound that a sonar hears by way of two walls, metres: to one, as in a mirror,
    /// from there to the foot of the perpendicular on another one, and back.
    pub fn double_reflection(
        &self,
        world_from_sensor: Pose2,
        beam_width: f64,
        max_range: f64,
    ) -> Option<f64> {
        let sensor = world_from_sensor.position();
        let ahead = sensor + unit(world_from_sensor.yaw);
        let mut first = None;
        for (index, mirror) in self.walls.iter().enumerate() {
            let image = mirror.mirrored(sensor);
            let axis = direction(mirror.mirrored(ahead) - image);
            for (other, wall) in self.walls.iter().enumerate().filter(|(k, _)| *k != index) {
                let Some(foot) = wall.foot_of_perpendicular(image) else {
                    continue;
                };
                let range = (foot - image).norm();
                let in_beam = angle_between(direction(foot - image), axis) <= beam_width / 2.0;
                if !(in_beam && range < first.unwrap_or(max_range) && mirror.hides(image, foot)) {
                    continue;
                }
                let along = mirror.end - mirror.start;
                let [near, far] = [image, foot].map(|p| along.perp(&(p - mirror.start)));
                let turn = image + (foot - image) * (near / (near - far));
                if self.in_sight(sensor, turn, Reflector::Line(index))
                    && self.in_sight(turn, foot, Reflector::Line(other))
                {
                    first = Some(range);
                }
            }
        }
        first
    }

    /// Whether no wall and no pillar but the reflector itself stands between `sensor` and `target`.
    fn in_sight(&self, sensor: Vec2, target: Vec2, reflector: Reflector) -> bool {
        let mut others = self
            .walls
            .iter()
            .enumerate()
            .filter(|(index, _)| Reflector::Line(*index) != reflector);
        let mut pillars = self.pillars.iter().enumerate();
        others.all(|(_, wall)| !wall.hides(sensor, target))
            && pillars.all(|(index, pillar)| {
                Reflector::Circle(index) == reflector || !pillar.hides(sensor, target)
            })
    }
}

fn same_place(a: &Vec2, b: &Vec2) -> bool {
    (a - b).norm() < SAME_PLACE
}

/// A world as it is written in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldFile {
    walls: Vec<[f64; 4]>,
    #[serde(default)]
    points: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    diffuse: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pillars: Vec<[f64; 3]>,
}

impl TryFrom<WorldFile> for World {
    type Error = WorldError;

    fn try_from(file: WorldFile) -> Result<Self, WorldError> {
        let walls = file
            .walls
            .iter()
            .map(|[x1, y1, x2, y2]| Wall::new(Vec2::new(*x1, *y1), Vec2::new(*x2, *y2)));
        let points = file.points.iter().map(|[x, y]| Vec2::new(*x, *y));
        let pillars = file.pillars.iter().map(|[x, y, radius]| Pillar {
            center: Vec2::new(*x, *y),
            radius: *radius,
        });
        let world = Self::with_pillars(walls.collect(), points.collect(), pillars.collect())?;
        world.with_diffuse(&file.diffuse)
    }
}

impl From<World> for WorldFile {
    fn from(world: World) -> Self {
        let walls = world.walls.iter();
        let diffuse = walls.clone().enumerate().filter(|(_, wall)| wall.diffuse);
        Self {
            diffuse: diffuse.map(|(index, _)| index).collect(),
            walls: walls
                .map(|wall| [wall.start.x, wall.start.y, wall.end.x, wall.end.y])
                .collect(),
            points: world
                .points
                .iter()
                .map(|point| [point.x, point.y])
                .collect(),
            pillars: (world.pillars.iter())
                .map(|Pillar { center, radius }| [center.x, center.y, *radius])
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests;
