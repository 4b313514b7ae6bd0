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
