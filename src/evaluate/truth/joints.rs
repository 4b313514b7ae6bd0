//! Where surveyed walls go on or meet.
//!
//! A laser gives walls in pieces, with gaps where something stood before them, and not always up to
//! their corners.

use crate::geometry::Vec2;
use crate::world::{Reflector, Wall, World};

/// The ends of two pieces of a wall are at most this far apart, metres.
const SEAM_GAP: f64 = 0.20;
/// And the pieces are turned against each other by at most this, cosine of 10 degrees.
const SEAM_COSINE: f64 = 0.984_807_753_012_208;
/// Walls that meet in a corner reach it up to this, metres.
const CORNER_GAP: f64 = 0.50;
/// And are turned against each other by at least this, sine of 30 degrees.
const CORNER_SINE: f64 = 0.5;

/// Places nearer than this are one, metres.
const SAME_PLACE: f64 = 1e-9;
/// A corner and what is listed or surveyed as one are at most this far apart, metres.
const SAME_CORNER: f64 = 0.10;

/// What lies between walls.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Joints {
    // By point of the world: the wall that goes on there.
    seams: Vec<Option<usize>>,
    // By wall: the first piece of the wall that it is a piece of.
    firsts: Vec<usize>,
}

impl Joints {
    /// Those of a world.
    pub fn of(world: &World) -> Self {
        let walls = world.walls();
        let mut seams = vec![None; world.points().len()];
        let mut firsts: Vec<usize> = (0..walls.len()).collect();
        for (index, wall) in walls.iter().enumerate() {
            for (next, other) in walls.iter().enumerate().skip(index + 1) {
                let ends = seam(wall, other);
                if let (Some(a), Some(b)) = (firsts.get(index), firsts.get(next)) {
                    let (first, joined) = (*a.min(b), *a.max(b));
                    if ends.is_some() {
                        let pieces = firsts.iter_mut().filter(|piece| **piece == joined);
                        pieces.for_each(|piece| *piece = first);
                    }
                }
                for end in ends.into_iter().flatten() {
                    let place = world.points().iter().position(|p| (p - end).norm() < 1e-9);
                    if let Some(seam) = place.and_then(|place| seams.get_mut(place)) {
                        *seam = Some(index);
                    }
                }
            }
        }
        Self { seams, firsts }
    }

    /// What echoes for a surveyor of whole walls: where pieces go on, the wall and not their ends.
    pub fn whole(&self, reflector: Reflector) -> Reflector {
        match reflector {
            Reflector::Point(index) => match self.seams.get(index) {
                Some(Some(wall)) => Reflector::Line(*wall),
                _ => reflector,
            },
            Reflector::Line(_) => reflector,
        }
    }

    /// Whether two walls are pieces of one.
    pub fn is_one_wall(&self, a: usize, b: usize) -> bool {
        a == b
            || self
                .firsts
                .get(a)
                .is_some_and(|first| self.firsts.get(b) == Some(first))
    }
}

/// A surveyed world whose walls end in the corners that they are seen to make. Where a surveyor's
/// walls end short of each other, the true ones do not, and their ends would echo in the wrong place.
pub fn up_to_corners(world: &World) -> World {
    let walls = world.walls();
    let is_end = |place: &Vec2| {
        (walls.iter().flat_map(|wall| [wall.start, wall.end]))
            .any(|end| (end - place).norm() <= SAME_PLACE)
    };
    let listed: Vec<Vec2> = (world.points().iter().copied())
        .filter(|point| !is_end(point))
        .collect();
    let mut moved = Vec::new();
    let mut grown = Vec::new();
    for (index, wall) in walls.iter().enumerate() {
        let mut end_of = |from: Vec2, end: Vec2| {
            let others = walls
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != index);
            let others: Vec<&Wall> = others.map(|(_, other)| other).collect();
            let corner = corner_at(from, end, &others)?;
            moved.push(end);
            let near = |point: &&Vec2| (**point - corner).norm() <= SAME_CORNER;
            Some(listed.iter().find(near).copied().unwrap_or(corner))
        };
        let start = end_of(wall.end, wall.start).unwrap_or(wall.start);
        let end = end_of(wall.start, wall.end).unwrap_or(wall.end);
        grown.push(Wall::new(start, end));
    }
    let stays = |point: &&Vec2| !moved.iter().any(|end| (end - **point).norm() <= SAME_PLACE);
    let points = world.points().iter().filter(stays).copied().collect();
    World::new(grown, points).unwrap_or_else(|_| world.clone())
}

/// The corner at which a wall ends that was surveyed up to `end`; `None` where it ends there.
fn corner_at(from: Vec2, end: Vec2, others: &[&Wall]) -> Option<Vec2> {
    let wall = Wall::new(from, end);
    let joined = |other: &&&Wall| {
        [other.start, other.end]
            .iter()
            .any(|there| (there - end).norm() <= SAME_PLACE)
    };
    if others.iter().any(|other| joined(&other)) {
        return None;
    }
    let along = (end - from).normalize();
    let beyond = |corner: &Vec2| (corner - end).dot(&along);
    others
        .iter()
        .filter_map(|other| corner(&wall, other))
        .filter(|corner| (-SAME_CORNER..=CORNER_GAP).contains(&beyond(corner)))
        .min_by(|a, b| beyond(a).abs().total_cmp(&beyond(b).abs()))
}

/// The ends at which one wall goes on as the other.
fn seam(a: &Wall, b: &Wall) -> Option<[Vec2; 2]> {
    // Each way to walk along the one into the other.
    let ways = [
        (a.start, a.end, b.start, b.end),
        (a.start, a.end, b.end, b.start),
        (a.end, a.start, b.start, b.end),
        (a.end, a.start, b.end, b.start),
    ];
    let go_on = ways.into_iter().find(|(from, end, start, to)| {
        let (first, then) = ((end - from).normalize(), (to - start).normalize());
        (start - end).norm() <= SEAM_GAP && first.dot(&then) >= SEAM_COSINE
    });
    go_on.map(|(_, end, start, _)| [end, start])
}

/// Where two walls meet, going on a little where they must.
fn corner(a: &Wall, b: &Wall) -> Option<Vec2> {
    let (along_a, along_b) = (a.end - a.start, b.end - b.start);
    let (length_a, length_b) = (along_a.norm(), along_b.norm());
    let cross = along_a.perp(&along_b);
    if cross.abs() < CORNER_SINE * length_a * length_b {
        return None;
    }
    let between = b.start - a.start;
    // In lengths of each wall from its start.
    let (t, u) = (
        between.perp(&along_b) / cross,
        between.perp(&along_a) / cross,
    );
    let reaches = |t: f64, length: f64| (-t).max(t - 1.0) * length <= CORNER_GAP;
    (reaches(t, length_a) && reaches(u, length_b)).then(|| a.start + along_a * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(walls: &[[f64; 4]]) -> World {
        let wall =
            |[x1, y1, x2, y2]: &[f64; 4]| Wall::new(Vec2::new(*x1, *y1), Vec2::new(*x2, *y2));
        World::new(walls.iter().map(wall).collect(), Vec::new()).unwrap()
    }

    /// The points of a world whose echo is a wall's.
    fn seams(walls: &[[f64; 4]]) -> Vec<Vec2> {
        let world = world(walls);
        let joints = Joints::of(&world);
        let points = world.points().iter().enumerate();
        points
            .filter(|(index, _)| {
                matches!(joints.whole(Reflector::Point(*index)), Reflector::Line(_))
            })
            .map(|(_, point)| *point)
            .collect()
    }

    #[test]
    fn pieces_of_a_wall_have_seams_and_corners_have_none() {
        let gap = [[0.0, 2.0, 1.0, 2.0], [3.0, 2.01, 1.1, 2.01]];
        assert_eq!(seams(&gap), [Vec2::new(1.0, 2.0), Vec2::new(1.1, 2.01)]);
        let door = [[0.0, 2.0, 1.0, 2.0], [1.8, 2.0, 3.0, 2.0]];
        assert!(seams(&door).is_empty());
        let corner = [[0.0, 2.0, 1.0, 2.0], [1.0, 2.0, 1.0, 4.0]];
        assert!(seams(&corner).is_empty());
        // Side by side, with an end in common, neither goes on.
        let thin = [[0.0, 2.0, 1.0, 2.0], [0.5, 2.1, 1.0, 2.05]];
        assert!(seams(&thin).is_empty());
    }

    #[test]
    fn walls_that_end_short_of_each_other_meet_in_their_corner() {
        // Short by 30 cm and 20 cm, and a door jamb on the left.
        let short = world(&[[0.8, 2.0, 1.7, 2.0], [2.0, 2.2, 2.0, 4.0]]);
        let grown = up_to_corners(&short);
        let corner = Vec2::new(2.0, 2.0);
        assert!((grown.walls()[0].end - corner).norm() < 1e-12, "{grown:?}");
        assert!((grown.walls()[1].start - corner).norm() < 1e-12);
        assert_eq!(grown.walls()[0].start, Vec2::new(0.8, 2.0));
        assert_eq!(grown.points().len(), 3, "the false ends are gone");
        // What is closed, or meets nothing, stays as it is; so does a second pass.
        assert_eq!(up_to_corners(&World::room()), World::room());
        assert_eq!(up_to_corners(&grown), grown);
        // A corner that the surveyor lists is the corner.
        let listed = World::new(short.walls().to_vec(), vec![Vec2::new(2.02, 1.99)]).unwrap();
        let grown = up_to_corners(&listed);
        assert_eq!(grown.walls()[1].start, Vec2::new(2.02, 1.99));
        assert_eq!(grown.points().len(), 3);
    }

    #[test]
    fn pieces_that_go_on_in_turn_are_one_wall() {
        let joints = Joints::of(&world(&[
            [0.0, 2.0, 1.0, 2.0],
            [2.1, 2.0, 3.0, 2.0],
            [5.0, 0.0, 5.0, 2.0],
            [1.1, 2.0, 2.0, 2.0],
        ]));
        assert!(joints.is_one_wall(0, 1) && joints.is_one_wall(3, 0));
        assert!(!joints.is_one_wall(0, 2) && joints.is_one_wall(2, 2));
    }

    #[test]
    fn walls_meet_up_to_half_a_metre_beyond_their_ends() {
        let meets = |walls: &[[f64; 4]]| {
            let world = world(walls);
            let corner = corner(&world.walls()[0], &world.walls()[1]);
            corner.is_some_and(|corner| (corner - Vec2::new(2.0, 2.0)).norm() < 1e-9)
        };
        assert!(meets(&[[0.0, 2.0, 1.6, 2.0], [2.0, 2.4, 2.0, 4.0]]));
        assert!(!meets(&[[0.0, 2.0, 1.4, 2.0], [2.0, 2.4, 2.0, 4.0]]));
        assert!(meets(&[[0.0, 2.0, 5.0, 2.0], [2.0, 2.4, 2.0, 4.0]]), "T");
        assert!(!meets(&[[0.0, 2.0, 1.9, 2.0], [2.1, 2.0, 4.0, 2.0]]));
    }
}
