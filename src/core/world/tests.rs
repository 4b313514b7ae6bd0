use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::*;

const BEAM: f64 = PI / 8.0;

fn wall(x1: f64, y1: f64, x2: f64, y2: f64) -> Wall {
    Wall::new(Vec2::new(x1, y1), Vec2::new(x2, y2))
}

fn look(world: &World, x: f64, y: f64, yaw: f64) -> Option<Reflector> {
    let echo = world.echo(Pose2::new(x, y, yaw), BEAM, 10.0);
    echo.map(|echo| echo.reflector)
}

#[test]
fn the_room_is_the_one_in_its_world_file() {
    let text = r#"{"walls": [[0,0,4,0],[4,0,4,2],[4,2,8,2],[8,2,8,5],[8,5,0,5],[0,5,0,0]],
                   "points": [[0,0],[4,0],[4,2],[8,2],[8,5],[0,5]]}"#;
    assert_eq!(World::from_json(text).unwrap(), World::room());
    let again = serde_json::to_string(&World::room()).unwrap();
    assert_eq!(World::from_json(&again).unwrap(), World::room());
}

#[test]
fn wall_ends_that_are_not_listed_follow_the_listed_points() {
    let listed = vec![Vec2::new(9.0, 9.0), Vec2::new(2.0, 0.0)];
    let walls = vec![wall(0.0, 0.0, 1.0, 0.0), wall(1.0, 0.0, 2.0, 0.0)];
    let world = World::new(walls, listed).unwrap();
    let expected = [(9.0, 9.0), (2.0, 0.0), (0.0, 0.0), (1.0, 0.0)];
    assert_eq!(world.points(), expected.map(|(x, y)| Vec2::new(x, y)));
}

#[test]
fn a_bad_world_is_refused_with_its_place() {
    for (text, part) in [
        (r#"{"walls": []}"#, "empty"),
        (r#"{"walls": [], "points": []}"#, "empty"),
        (r#"{"walls": [[0,0,1,0],[2,2,2,2]]}"#, "wall 1 is 0 m long"),
        (r#"{"walls": [[0,0,1e999,0]]}"#, "number out of range"),
        (r#"{"walls": [[0,0,1]]}"#, "expected"),
        (r#"{"walls": [[0,0,1,0]], "pionts": []}"#, "unknown field"),
        (
            r#"{"walls": [], "points": [[1,1],[2,2],[1,1]]}"#,
            "points 0 and 2",
        ),
    ] {
        let message = World::from_json(text).unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
    let endless = World::new(vec![wall(0.0, f64::NAN, 1.0, 0.0)], vec![]);
    assert!(matches!(
        endless,
        Err(WorldError::NotFinite {
            kind: "wall",
            index: 0
        })
    ));
}

#[test]
fn the_room_echoes_walls_corners_and_the_edge() {
    let room = World::room();
    assert_eq!(look(&room, 1.0, 1.0, 0.0), Some(Reflector::Line(1)));
    assert_eq!(look(&room, 1.0, 1.0, FRAC_PI_2), Some(Reflector::Line(4)));
    assert_eq!(look(&room, 1.0, 1.0, -0.75 * PI), Some(Reflector::Point(0)));
    // The convex corner, from both of its sides.
    assert_eq!(look(&room, 3.0, 1.0, 0.25 * PI), Some(Reflector::Point(2)));
    assert_eq!(look(&room, 5.0, 3.0, -0.75 * PI), Some(Reflector::Point(2)));
    // Its foot is the end of a wall, which is the corner.
    assert_eq!(look(&room, 3.0, 2.0, 0.0), Some(Reflector::Point(2)));
    // Oblique to every wall and no corner in the beam: the sound is mirrored away.
    assert_eq!(look(&room, 1.0, 1.0, 0.25 * PI), None);
}

#[test]
fn what_a_wall_hides_gives_nothing() {
    let world = World::new(
        vec![wall(1.0, -5.0, 1.0, 2.0)],
        vec![Vec2::new(2.0, 0.5), Vec2::new(2.0, 6.0)],
    )
    .unwrap();
    // The wall's own foot is outside the beam, so only the hidden point could answer.
    let beam = 0.1;
    let towards = |x: f64, y: f64| Pose2::new(0.0, 0.0, direction(Vec2::new(x, y)));
    assert_eq!(world.echo(towards(2.0, 0.5), beam, 10.0), None);
    let seen = world.echo(towards(2.0, 6.0), beam, 10.0).unwrap();
    assert_eq!(seen.reflector, Reflector::Point(1));
}

#[test]
fn max_range_is_no_echo() {
    let world = World::new(vec![wall(2.0, -5.0, 2.0, 5.0)], vec![]).unwrap();
    let pose = Pose2::IDENTITY;
    assert!(world.echo(pose, BEAM, 2.0).is_none());
    assert!(world.echo(pose, BEAM, 2.0001).is_some());
    assert!(world.echo(pose, BEAM, f64::NAN).is_none());
}

fn coordinate() -> impl Strategy<Value = f64> {
    -5.0..5.0
}

fn worlds() -> impl Strategy<Value = World> {
    let walls = prop::collection::vec(
        (coordinate(), coordinate(), coordinate(), coordinate()),
        1..6,
    );
    let points = prop::collection::vec((coordinate(), coordinate()), 0..4);
    (walls, points).prop_filter_map("degenerate", |(walls, points)| {
        let walls = walls.into_iter().map(|(a, b, c, d)| wall(a, b, c, d));
        let points = points.into_iter().map(|(x, y)| Vec2::new(x, y));
        World::new(walls.collect(), points.collect()).ok()
    })
}

/// The nearest crossing of a ray with a wall, by solving for both parameters: another way to
/// line of sight than the one under test.
fn ray_length(world: &World, from: Vec2, towards: Vec2) -> f64 {
    let ray = (towards - from).normalize();
    let mut nearest = f64::INFINITY;
    for wall in world.walls() {
        let along = wall.end - wall.start;
        let determinant = ray.perp(&along);
        let t = (wall.start - from).perp(&along) / determinant;
        let u = (wall.start - from).perp(&ray) / determinant;
        if t > 0.0 && (0.0..=1.0).contains(&u) {
            nearest = nearest.min(t);
        }
    }
    nearest
}

proptest! {
    #[test]
    fn an_echo_lies_on_its_reflector_in_the_beam_and_in_sight(
        world in worlds(), x in coordinate(), y in coordinate(), yaw in -4.0..4.0, beam in 0.05..1.5,
    ) {
        let sensor = Vec2::new(x, y);
        let pose = Pose2::new(x, y, yaw);
        let Some(echo) = world.echo(pose, beam, 20.0) else { return Ok(()) };
        let target = match echo.reflector {
            Reflector::Point(index) => world.points()[index],
            Reflector::Line(index) => {
                let wall = world.walls()[index];
                let along = (wall.end - wall.start).normalize();
                let offset = along.perp(&(sensor - wall.start));
                prop_assert!((echo.range - offset.abs()).abs() < 1e-9, "perpendicular distance");
                let foot = sensor - Vec2::new(-along.y, along.x) * offset;
                let t = (foot - wall.start).dot(&along);
                prop_assert!(t > -1e-9 && t < (wall.end - wall.start).norm() + 1e-9, "on the wall");
                foot
            }
            Reflector::Circle(_) => unreachable!("these worlds have no pillars"),
        };
        prop_assert!(((target - sensor).norm() - echo.range).abs() < 1e-9);
        prop_assert!(angle_between(direction(target - sensor), yaw) <= beam / 2.0 + 1e-9);
        prop_assert!(ray_length(&world, sensor, target) > echo.range - 1e-6, "in sight");
    }

    #[test]
    fn no_visible_point_in_the_beam_is_nearer_than_the_echo(
        world in worlds(), x in coordinate(), y in coordinate(), yaw in -4.0..4.0, beam in 0.05..1.5,
    ) {
        let sensor = Vec2::new(x, y);
        let heard = world.echo(Pose2::new(x, y, yaw), beam, 20.0).map_or(20.0, |echo| echo.range);
        for point in world.points() {
            let inside = angle_between(direction(point - sensor), yaw) < beam / 2.0 - 1e-9;
            let distance = (point - sensor).norm();
            if inside && ray_length(&world, sensor, *point) > distance - 1e-9 {
                prop_assert!(heard <= distance + 1e-9);
            }
        }
    }

    #[test]
    fn moving_world_and_sensor_together_changes_nothing(
        world in worlds(), x in coordinate(), y in coordinate(), yaw in -4.0..4.0,
        dx in coordinate(), dy in coordinate(), turn in -4.0..4.0,
    ) {
        let motion = Pose2::new(dx, dy, turn);
        let walls = world.walls().iter();
        let moved = World::new(
            walls.map(|w| Wall::new(motion.transform(w.start), motion.transform(w.end))).collect(),
            world.points().iter().map(|p| motion.transform(*p)).collect(),
        ).unwrap();
        let pose = Pose2::new(x, y, yaw);
        let here = world.echo(pose, BEAM, 20.0);
        let there = moved.echo(motion.compose(&pose), BEAM, 20.0);
        prop_assert_eq!(here.map(|e| e.reflector), there.map(|e| e.reflector));
        let range = |echo: Option<Echo>| echo.map_or(0.0, |e| e.range);
        prop_assert!((range(here) - range(there)).abs() < 1e-9);
    }
}

#[test]
fn a_world_that_is_too_large_is_refused() {
    let points = |count: u32| (0..count).map(|k| Vec2::new(f64::from(k), 0.0)).collect();
    assert!(World::new(Vec::new(), points(5_000)).is_ok());
    let refused = World::new(Vec::new(), points(5_001)).unwrap_err();
    assert!(matches!(refused, WorldError::TooLarge { things: 5_001 }));
}

#[test]
fn a_rough_wall_echoes_from_its_nearest_place_in_the_beam() {
    // Along y = 2, seen under 45 degrees: the foot lies outside the beam.
    let smooth = World::new(vec![wall(-9.0, 2.0, 9.0, 2.0)], vec![]).unwrap();
    let rough = smooth.clone().with_diffuse(&[0]).unwrap();
    let oblique = Pose2::new(0.0, 0.0, PI / 4.0);
    assert_eq!(smooth.echo(oblique, BEAM, 10.0), None);
    let echo = rough.echo(oblique, BEAM, 10.0).unwrap();
    assert!(echo.oblique && echo.reflector == Reflector::Line(0));
    let edge = PI / 4.0 + BEAM / 2.0;
    assert!(
        (echo.range - 2.0 / libm::sin(edge)).abs() < 1e-12,
        "{echo:?}"
    );
    assert!((echo.place - Vec2::new(2.0 / libm::tan(edge), 2.0)).norm() < 1e-12);
    // With the foot in the beam both are the same.
    let facing = Pose2::new(0.0, 0.0, FRAC_PI_2 + 0.1);
    assert_eq!(
        rough.echo(facing, BEAM, 10.0),
        smooth.echo(facing, BEAM, 10.0)
    );
    // Away from the wall there is nothing.
    let away = Pose2::new(0.0, 0.0, -PI / 4.0);
    assert_eq!(rough.echo(away, BEAM, 10.0), None);
}

#[test]
fn a_world_file_says_which_walls_are_rough() {
    let text = r#"{"walls":[[0.0,0.0,1.0,0.0],[1.0,0.0,1.0,1.0]],"points":[],"diffuse":[1]}"#;
    let world = World::from_json(text).unwrap();
    let rough: Vec<bool> = world.walls().iter().map(|wall| wall.diffuse).collect();
    assert_eq!(rough, [false, true]);
    let again = serde_json::to_string(&world).unwrap();
    assert_eq!(World::from_json(&again).unwrap(), world);
    let none = World::from_json(&text.replace("[1]}", "[2]}")).unwrap_err();
    assert!(
        none.to_string().contains("wall 2 is called diffuse"),
        "{none}"
    );
}

#[test]
fn sound_comes_back_by_way_of_two_walls() {
    // Off the wall x = 4 to the foot on the wall y = 3, as if that stood behind a mirror.
    let walls = vec![wall(4.0, -5.0, 4.0, 5.0), wall(-5.0, 3.0, 4.0, 3.0)];
    let world = World::new(walls, vec![]).unwrap();
    let up = Pose2::new(1.0, 0.0, FRAC_PI_2);
    assert_eq!(
        world.double_reflection(up, BEAM, 10.0),
        None,
        "straight up is the foot itself"
    );
    // A wall that leans by 30 degrees turns sound that comes along x to the one at 60 degrees.
    let leaning = wall(2.0, -2.0, 4.0, 2.0);
    let along = (leaning.end - leaning.start).normalize();
    let mirrored = Vec2::new(2.0 * along.x * along.x - 1.0, 2.0 * along.x * along.y);
    let turn = Vec2::new(3.0, 0.0);
    let middle = turn + mirrored * 1.5;
    let across = Vec2::new(-mirrored.y, mirrored.x);
    let (a, b) = (middle - across, middle + across);
    let world = World::new(vec![leaning, wall(a.x, a.y, b.x, b.y)], vec![]).unwrap();
    let ahead = Pose2::new(0.0, 0.0, 0.0);
    let way = world.double_reflection(ahead, BEAM, 10.0).unwrap();
    assert!((way - 4.5).abs() < 1e-12, "{way}");
    assert_eq!(
        world.double_reflection(ahead, BEAM, 4.0),
        None,
        "beyond its range"
    );
}

/// A pillar of 20 cm on the x axis, before a wall at x = 4, and a thinner one behind it.
fn with_pillars() -> World {
    let pillars = [[2.0, 0.0, 0.2], [3.0, 0.05, 0.1]].map(|[x, y, radius]| Pillar {
        center: Vec2::new(x, y),
        radius,
    });
    World::with_pillars(vec![wall(4.0, -5.0, 4.0, 5.0)], vec![], pillars.to_vec()).unwrap()
}

#[test]
fn a_pillar_echoes_from_its_nearest_place_and_hides_what_is_behind() {
    let world = with_pillars();
    let echo = world.echo(Pose2::IDENTITY, BEAM, 10.0).unwrap();
    assert_eq!(echo.reflector, Reflector::Circle(0));
    assert!((echo.range - 1.8).abs() < 1e-12, "{echo:?}");
    // Its axis must be in the beam, or what is behind it echoes where that is in sight.
    let aside = Pose2::new(0.0, 0.0, 0.3);
    assert_eq!(world.echo(aside, 0.4, 10.0), None);
    let below = Pose2::new(2.0, -1.0, 0.0);
    let echo = world.echo(below, 0.2, 10.0).unwrap();
    assert_eq!(echo.reflector, Reflector::Line(0));
    // From within it there is nothing to hear.
    assert_eq!(world.echo(Pose2::new(2.0, 0.1, 0.0), BEAM, 10.0), None);
}

#[test]
fn pillars_are_written_where_there_are_any_and_checked() {
    let text = serde_json::to_string(&with_pillars()).unwrap();
    assert!(
        text.contains("\"pillars\":[[2.0,0.0,0.2],[3.0,0.05,0.1]]"),
        "{text}"
    );
    assert_eq!(World::from_json(&text).unwrap(), with_pillars());
    assert!(
        !serde_json::to_string(&World::room())
            .unwrap()
            .contains("pillars")
    );
    assert!(World::from_json(r#"{"walls": [], "pillars": [[1, 2, 0.3]]}"#).is_ok());
    let thin = World::from_json(r#"{"walls": [], "pillars": [[1, 2, 0]]}"#);
    assert!(matches!(thin, Err(WorldError::ThinPillar { index: 0, .. })));
}

proptest! {
    #[test]
    fn the_echo_of_a_pillar_is_the_least_distance_to_it(
        x in -3.0..3.0f64, y in -3.0..3.0f64, radius in 0.05..0.8f64,
    ) {
        let center = Vec2::new(0.4, -0.2);
        let pillar = Pillar { center, radius };
        let world = World::with_pillars(vec![], vec![], vec![pillar]).unwrap();
        let sensor = Vec2::new(x, y);
        let towards = direction(center - sensor);
        let heard = world.echo(Pose2::new(x, y, towards), 0.3, 20.0);
        let distance = (center - sensor).norm();
        prop_assert_eq!(heard.is_some(), distance > radius);
        if let Some(echo) = heard {
            let around = (0..720).map(|k| center + unit(f64::from(k) * 0.5_f64.to_radians()) * radius);
            let least = around.map(|place| (place - sensor).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(echo.range <= least + 1e-12 && echo.range > least - 1e-3 * (1.0 + radius));
        }
    }
}
