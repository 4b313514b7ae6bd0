//! A surveyed world made whole.
//!
//! A laser gives walls in pieces, with gaps where something stood before them, and not always up to
//! their corners. The ends of such pieces would echo where nothing is, and hide what is behind.

use crate::core::geometry::Vec2;
use crate::core::world::{Wall, World};

/// The ends of two pieces of a wall are at most this far apart, metres.
const SEAM_GAP: f64 = 0.20;
/// And the pieces are turned against each other by at most this, cosine of 10 degrees.
const SEAM_COSINE: f64 = 0.984_807_753_012_208;
/// Pieces lie within this of the wall that they make, metres.
const STRAIGHT: f64 = 0.05;
/// Walls that meet in a corner reach it up to this, metres.
const CORNER_GAP: f64 = 0.50;
/// And are turned against each other by at least this, sine of 30 degrees.
const CORNER_SINE: f64 = 0.5;
/// A wall that goes on beyond its corner by less than this ends there; a point that is listed so near
/// to it is the corner, metres.
const SAME_CORNER: f64 = 0.10;
/// Places nearer than this are one, metres.
const SAME_PLACE: f64 = 1e-9;

/// The world with pieces of walls as one, and walls up to their corners; its own points that are no
/// ends of walls stay, but for those that are such a corner.
pub fn whole(world: &World) -> World {
    let walls = up_to_corners(&joined(world.walls()));
    let surveyed: Vec<Vec2> = ends(world.walls()).collect();
    let corners: Vec<Vec2> = ends(&walls)
        .filter(|end| !surveyed.iter().any(|there| same(there, end)))
        .collect();
    let listed = world.points().iter().copied().filter(|point| {
        let is_end = surveyed.iter().any(|end| same(end, point));
        let is_corner = corners.iter().any(|c| (c - point).norm() <= SAME_CORNER);
        !is_end && !is_corner
    });
    let pillars = world.pillars().to_vec();
    World::with_pillars(walls, listed.collect(), pillars).unwrap_or_else(|_| world.clone())
}

fn same(a: &Vec2, b: &Vec2) -> bool {
    (a - b).norm() <= SAME_PLACE
}

fn ends(walls: &[Wall]) -> impl Iterator<Item = Vec2> {
    walls.iter().flat_map(|wall| [wall.start, wall.end])
}

/// Walls with the pieces that go on as one, in the order of their first pieces.
fn joined(walls: &[Wall]) -> Vec<Wall> {
    let mut rest: Vec<Wall> = walls.to_vec();
    let mut whole = Vec::new();
    while !rest.is_empty() {
        let first = rest.remove(0);
        let (mut wall, mut pieces) = (first, vec![first]);
        while let Some((next, longer)) = rest
            .iter()
            .enumerate()
            .find_map(|(next, piece)| Some((next, gone_on(&wall, piece, &pieces)?)))
        {
            pieces.push(rest.remove(next));
            wall = longer;
        }
        whole.push(wall);
    }
    whole
}

/// The wall that goes on as a piece, where all its pieces lie on it.
fn gone_on(wall: &Wall, piece: &Wall, pieces: &[Wall]) -> Option<Wall> {
    // Each way to walk along the one into the other.
    let ways = [
        (wall.start, wall.end, piece.start, piece.end),
        (wall.start, wall.end, piece.end, piece.start),
        (wall.end, wall.start, piece.start, piece.end),
        (wall.end, wall.start, piece.end, piece.start),
    ];
    let (from, _, _, to) = ways.into_iter().find(|(from, end, start, to)| {
        let (first, then) = ((end - from).normalize(), (to - start).normalize());
        (start - end).norm() <= SEAM_GAP && first.dot(&then) >= SEAM_COSINE
    })?;
    let along = (to - from).normalize();
    let lies_on = |place: Vec2| along.perp(&(place - from)).abs() <= STRAIGHT;
    let straight = ends(pieces).chain([piece.start, piece.end]).all(lies_on);
    straight.then(|| Wall {
        diffuse: wall.diffuse,
        ..Wall::new(from, to)
    })
}

/// Walls whose ends are the corners that they make with others.
fn up_to_corners(walls: &[Wall]) -> Vec<Wall> {
    walls
        .iter()
        .enumerate()
        .map(|(index, wall)| {
            let others = || {
                let others = walls.iter().enumerate();
                others.filter(|(at, _)| *at != index).map(|(_, wall)| wall)
            };
            let start = corner_at(wall.end, wall.start, others());
            let end = corner_at(wall.start, wall.end, others());
            let moved = Wall {
                start: start.unwrap_or(wall.start),
                end: end.unwrap_or(wall.end),
                ..*wall
            };
            // A short wall across another one must not lose itself in it.
            let (before, after) = (wall.end - wall.start, moved.end - moved.start);
            if after.dot(&before) > before.norm_squared() / 2.0 {
                moved
            } else {
                *wall
            }
        })
        .collect()
}

/// The corner at which a wall ends that was surveyed up to `end`; `None` where it ends there.
fn corner_at<'a>(
    from: Vec2,
    end: Vec2,
    others: impl Iterator<Item = &'a Wall> + Clone,
) -> Option<Vec2> {
    let wall = Wall::new(from, end);
    if others
        .clone()
        .any(|other| same(&other.start, &end) || same(&other.end, &end))
    {
        return None;
    }
    let along = (end - from).normalize();
    let beyond = |corner: &Vec2| (corner - end).dot(&along);
    others
        .filter_map(|other| corner(&wall, other))
        .filter(|corner| (-SAME_CORNER..=CORNER_GAP).contains(&beyond(corner)))
        .min_by(|a, b| beyond(a).abs().total_cmp(&beyond(b).abs()))
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
        World::new(made(walls), Vec::new()).unwrap()
    }

    fn made(walls: &[[f64; 4]]) -> Vec<Wall> {
        let wall =
            |[x1, y1, x2, y2]: &[f64; 4]| Wall::new(Vec2::new(*x1, *y1), Vec2::new(*x2, *y2));
        walls.iter().map(wall).collect()
    }

    #[test]
    fn pieces_of_a_wall_are_one_and_doors_and_bends_part_them() {
        let gap = [[0.0, 2.0, 1.0, 2.0], [3.0, 2.01, 1.1, 2.01]];
        assert_eq!(joined(&made(&gap)), made(&[[0.0, 2.0, 3.0, 2.01]]));
        let chain = [
            [0.0, 2.0, 1.0, 2.0],
            [2.1, 2.0, 3.0, 2.0],
            [5.0, 0.0, 5.0, 2.0],
            [1.1, 2.0, 2.0, 2.0],
        ];
        let whole = joined(&made(&chain));
        assert_eq!(whole, made(&[[0.0, 2.0, 3.0, 2.0], [5.0, 0.0, 5.0, 2.0]]));
        for apart in [
            [[0.0, 2.0, 1.0, 2.0], [1.8, 2.0, 3.0, 2.0]],
            [[0.0, 2.0, 1.0, 2.0], [1.0, 2.0, 1.0, 4.0]],
            // Side by side, with an end in common, neither goes on.
            [[0.0, 2.0, 1.0, 2.0], [0.5, 2.1, 1.0, 2.05]],
            // A curve, of which the pieces lie far off the chord.
            [[0.0, 0.0, 2.0, 0.0], [2.0, 0.0, 4.0, 0.3]],
        ] {
            assert_eq!(joined(&made(&apart)), made(&apart));
        }
    }

    #[test]
    fn a_room_surveyed_in_pieces_is_the_room() {
        let mut pieces = Vec::new();
        for wall in World::room().walls() {
            let at = |share: f64| wall.start + (wall.end - wall.start) * share;
            // With 5 cm or more between them, and short of the corners.
            let shares = [(0.02, 0.4), (0.42, 0.7), (0.72, 0.98)];
            pieces.extend(shares.map(|(from, to)| Wall::new(at(from), at(to))));
        }
        let whole = whole(&World::new(pieces, Vec::new()).unwrap());
        assert_eq!(whole.walls().len(), 6);
        assert_eq!(whole.points().len(), 6);
        for (wall, true_wall) in whole.walls().iter().zip(World::room().walls()) {
            assert!((wall.start - true_wall.start).norm() < 1e-9, "{whole:?}");
            assert!((wall.end - true_wall.end).norm() < 1e-9, "{whole:?}");
        }
        assert_eq!(super::whole(&World::room()), World::room());
    }

    #[test]
    fn walls_that_end_short_of_each_other_meet_in_their_corner() {
        // Short by 30 cm and 20 cm, and a door jamb on the left.
        let short = world(&[[0.8, 2.0, 1.7, 2.0], [2.0, 2.2, 2.0, 4.0]]);
        let grown = whole(&short);
        let corner = Vec2::new(2.0, 2.0);
        assert!((grown.walls()[0].end - corner).norm() < 1e-12, "{grown:?}");
        assert!((grown.walls()[1].start - corner).norm() < 1e-12);
        assert_eq!(grown.walls()[0].start, Vec2::new(0.8, 2.0));
        assert_eq!(grown.points().len(), 3, "the false ends are gone");
        assert_eq!(whole(&grown), grown);
        // A corner that the surveyor lists is the corner, and the walls stay on their lines.
        let listed = World::new(short.walls().to_vec(), vec![Vec2::new(2.02, 1.99)]).unwrap();
        assert_eq!(whole(&listed), grown);
        // A stub across a wall stays, and so do the other walls' corners.
        let mut walls = short.walls().to_vec();
        walls.push(Wall::new(Vec2::new(1.2, 1.96), Vec2::new(1.2, 2.04)));
        let with_stub = whole(&World::new(walls, Vec::new()).unwrap());
        assert_eq!(with_stub.walls()[0], grown.walls()[0]);
        assert!((with_stub.walls()[2].end - with_stub.walls()[2].start).norm() > 0.07);
    }

    #[test]
    fn walls_meet_up_to_half_a_metre_beyond_their_ends() {
        let meets = |walls: &[[f64; 4]]| {
            let walls = made(walls);
            let corner = corner(&walls[0], &walls[1]);
            corner.is_some_and(|corner| (corner - Vec2::new(2.0, 2.0)).norm() < 1e-9)
        };
        assert!(meets(&[[0.0, 2.0, 1.6, 2.0], [2.0, 2.4, 2.0, 4.0]]));
        assert!(!meets(&[[0.0, 2.0, 1.4, 2.0], [2.0, 2.4, 2.0, 4.0]]));
        assert!(meets(&[[0.0, 2.0, 5.0, 2.0], [2.0, 2.4, 2.0, 4.0]]), "T");
        assert!(!meets(&[[0.0, 2.0, 1.9, 2.0], [2.1, 2.0, 4.0, 2.0]]));
    }
}
