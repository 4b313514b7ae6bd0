use super::*;
use crate::core::event::SonarId;
use crate::core::geometry::Pose2;

const S: i64 = 1_000_000_000;

fn clock(messages: impl IntoIterator<Item = (i64, i64)>) -> Clock {
    let mut clock = Clock::default();
    for (stamp, logged) in messages {
        clock.take(stamp, logged);
    }
    clock
}

/// Ten messages a second, stamped 10 ms before they are recorded.
fn steady(from: i64, to: i64, ahead: i64) -> impl Iterator<Item = (i64, i64)> {
    (from..to).map(move |k| (k * S / 10 + ahead - S / 100, k * S / 10))
}

#[test]
fn a_clock_that_was_set_is_told_from_messages_that_come_late() {
    let even = clock(steady(100, 200, 0));
    assert_eq!(jump(&[&even], &even), None);
    for (by, said) in [(3600 * S, "+3600.000 s"), (-30 * S, "-30.000 s")] {
        let set = clock(steady(1000, 1050, 0).chain(steady(1050, 1100, by)));
        let text = jump(&[&even, &set], &even).unwrap().text();
        assert!(
            text.contains("1 of 2 sonars") && text.contains(said),
            "{text}"
        );
    }
    // Held up for five seconds, then all at once.
    let late = (0..100).map(|k| (S + k * S / 10, S + (k * S / 10).max(5 * S)));
    let late = clock(late);
    assert_eq!((jump(&[&late], &late), late.backward), (None, 0));
}

#[test]
fn what_a_clock_set_back_does_to_the_stamps_is_told_once_with_what_to_replay() {
    let set = clock(steady(1000, 1500, 0).chain(steady(1500, 2000, -30 * S)));
    let found = jump(&[&set], &set).unwrap();
    assert_eq!(
        found.advice,
        "--end 19.9 replays what lies before these times, --start 50.0 what lies behind"
    );
    assert_eq!(found.twice, [(120 * S - S / 100, 149_890_000_000)]);
    assert_eq!(backward(&[&set], &set), None);
}

#[test]
fn stamps_that_go_back_are_counted() {
    let shuffled = clock([(5 * S, 5 * S), (3 * S, 3 * S), (4 * S, 4 * S)]);
    assert_eq!(backward(&[&shuffled], &shuffled), None);
    let set_back = clock([(5 * S, 1), (5 * S - S / 2, 2), (5 * S, 3), (0, 4)]);
    let text = backward(&[&set_back], &Clock::default()).unwrap();
    assert!(
        text.contains("1 of ranges, 0 of odometry, by up to 0.500 s"),
        "{text}"
    );
}

fn reading(stamp_ns: i64) -> RangeReading {
    RangeReading {
        stamp_ns,
        sonar: SonarId(0),
        range: 1.0,
        min_range: 0.1,
        max_range: 4.0,
        beam_width: 0.4,
        variance: 0.0,
    }
}

#[test]
fn what_gaps_of_the_odometry_cost() {
    let sample = |stamp_ns| OdometrySample {
        stamp_ns,
        world_from_robot: Pose2::new(0.0, 0.0, 0.0),
    };
    let readings: Readings = (0..100).map(|k| reading(k * S / 10)).collect();
    let bounds = Frames::default();
    let every = |step: i64| (0..=10 * S / step).map(move |k| sample(k * step));
    let covered: Vec<_> = every(S / 10).collect();
    assert_eq!(uncovered(&readings, &covered, &bounds, 0.0), None);
    let holed: Vec<_> = every(S / 10)
        .filter(|s| (S..=3 * S).contains(&s.stamp_ns) || s.stamp_ns >= 5 * S)
        .collect();
    let text = uncovered(&readings, &holed, &bounds, 0.0).unwrap();
    assert!(text.starts_with("29 of 100 readings"), "{text}");
    assert!(text.contains("10 before the first"), "{text}");
    assert!(
        text.contains("19 in 1 gap of the odometry wider than 0.5 s, the longest 2.0 s at 3.0 s"),
        "{text}"
    );
}

#[test]
fn a_clock_set_back_with_the_recorders_is_told_from_parts_in_another_order() {
    let both = |range: std::ops::Range<i64>| range.map(|k| (k * S / 10, k * S / 10));
    let set_back = clock(both(100..200).chain(both(150..260)));
    let found = returned(&[&set_back], &set_back).unwrap();
    assert_eq!(found.twice, [(15 * S, 199 * S / 10)]);
    let text = found.text();
    assert!(text.contains("once, by up to 4.900 s"), "{text}");
    assert!(
        text.contains("4.900 s of stamps and times of recording come twice"),
        "{text}"
    );
    assert!(text.contains("; --end "), "{text}");
    let far_back = clock(both(1000..1100).chain(both(100..200)));
    let text = returned(&[&far_back], &far_back).unwrap().text();
    assert!(text.contains("leave a hole of 80.100 s"), "{text}");
    let shuffled = clock(
        both(0..10)
            .chain(both(20..30))
            .chain(both(40..50))
            .chain(both(10..20))
            .chain(both(30..40)),
    );
    assert_eq!(returned(&[&shuffled], &shuffled), None);
    let swapped = clock(both(200..300).chain(both(100..200)));
    assert_eq!(returned(&[&swapped], &swapped), None);
}

#[test]
fn readings_that_come_twice() {
    let twins = |stamps: &[i64]| super::twins(&stamps.iter().copied().map(reading).collect());
    assert_eq!(twins(&[1, 2]), None);
    let text = twins(&[1, 1, 2]).unwrap();
    assert!(text.starts_with("1 of 3 readings"), "{text}");
}

#[test]
fn a_single_odd_stamp_is_no_clock_that_was_set() {
    for odd in [5 * S, 2_000_000 * S] {
        let mut messages: Vec<_> = steady(1000, 1100, 0).collect();
        messages[50].0 = odd;
        let clock = clock(messages);
        assert_eq!(jump(&[&clock], &clock), None);
        assert_eq!(returned(&[&clock], &clock), None);
        assert_eq!(clock.backward, 0);
    }
}

#[test]
fn a_clock_set_back_by_less_than_a_second_is_told_from_neighbours_that_changed_places() {
    let both = |range: std::ops::Range<i64>| range.map(|k| (k * S / 20, k * S / 20));
    let set_back = clock(both(100..200).chain(both(182..300)));
    let text = returned(&[], &set_back).unwrap().text();
    assert!(text.contains("once, by up to 0.850 s"), "{text}");
    // Every half second, two of them swapped.
    let swapped = [1, 2, 3, 5, 4, 6, 7, 8, 9, 10].map(|k| (k * S / 2, k * S / 2));
    let swapped = clock(swapped);
    assert_eq!(returned(&[&swapped], &swapped), None);
}
