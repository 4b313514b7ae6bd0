use super::*;

fn report(topic: &str, role: Option<Role>, messages: u64) -> ChannelReport {
    ChannelReport {
        id: 0,
        topic: topic.into(),
        type_name: "t".into(),
        encoding: "cdr".into(),
        role,
        used: true,
        messages,
        undecoded: 0,
        problem: None,
        wanted: false,
    }
}

#[test]
fn of_several_odometries_the_busiest_is_shown() {
    let odometry = Some(Role::Odometry);
    let channels = [
        report("/b", odometry, 5),
        report("/c", odometry, 9),
        report("/d", odometry, 9),
        report("/a", Some(Role::Pose), 99),
        report("/range", Some(Role::Range), 99),
        report("/x", None, 99),
    ];
    assert_eq!(odometry_topic(&channels).as_deref(), Some("/c"));
    assert_eq!(odometry_topic(&[]), None);
}

#[test]
fn publishers_of_one_topic_are_one_channel() {
    let two = vec![
        report("/a", None, 2),
        report("/a", None, 3),
        report("/b", None, 1),
    ];
    let (channels, clocks) = together(two, Clocks::default());
    assert_eq!((channels.len(), clocks.len()), (2, 2));
    assert_eq!(channels[0].messages, 5);
}

#[test]
fn the_robots_frame_is_guessed_from_the_frames_there_are() {
    assert_eq!(
        likely_robot_frame(&["base_footprint", "sonar"]),
        "base_footprint"
    );
    assert_eq!(likely_robot_frame(&["robot_base", "x"]), "robot_base");
    assert_eq!(likely_robot_frame(&["x"]), "base_link");
}

#[test]
fn an_empty_log_has_neither_ranges_nor_odometry() {
    let mending = Mending {
        has_described: false,
        file: "f".into(),
        config: Config::default(),
        gatherer: Gatherer::default(),
        obstacles: Vec::new(),
        odometry_topic: None,
        no_ranges: false,
        no_odometry: false,
        in_part: false,
    };
    let survey = mending.finish(&[], &[], Vec::new()).unwrap();
    assert!(matches!(
        survey.obstacles.as_slice(),
        [LogError::NoRanges { .. }, LogError::NoOdometry { .. }]
    ));
    assert!(survey.log.events.sonars.is_empty() && survey.log.events.odometry.is_empty());
    assert!(survey.config.sonar.is_empty());
}

fn clock(messages: &[(i64, Option<i64>)]) -> ChannelClock {
    let mut running = Running::default();
    for (logged, stamp) in messages {
        running.take(*logged, *stamp);
    }
    running.finish()
}

#[test]
fn what_is_odd_about_stamps_is_counted() {
    let clock = clock(&[
        (100, Some(90)),
        (200, Some(90)),
        (150, Some(80)),
        (300, Some(0)),
        (400, Some(500)),
        (600, None),
    ]);
    assert_eq!((clock.messages, clock.stamped, clock.unstamped), (6, 4, 1));
    assert_eq!((clock.backward, clock.repeated), (1, 1));
    assert_eq!(clock.out_of_order, 1);
    assert_eq!((clock.first_logged_ns, clock.last_logged_ns), (100, 600));
    assert_eq!(clock.median_delay_ns, Some(70));
    assert_eq!(clock.extreme_delay_ns, Some(110));
    assert!((clock.rate().unwrap() - 1e7).abs() < 1e-3);
}

#[test]
fn a_single_message_has_no_rate() {
    assert_eq!(clock(&[(5, None)]).rate(), None);
    assert_eq!(clock(&[(5, None)]).median_delay_ns, None);
}

#[test]
fn two_publishers_of_a_topic_count_together() {
    let one = clock(&[(0, Some(1)), (10, Some(5))]);
    let two = clock(&[(5, Some(-100))]);
    let both = one.together(two);
    assert_eq!((both.messages, both.last_logged_ns), (3, 10));
    assert_eq!(both.median_delay_ns, Some(5));
    assert_eq!(both.extreme_delay_ns, Some(105));
}
