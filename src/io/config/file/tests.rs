use super::super::keys::KEYS;
use super::super::render::render;
use super::*;
use crate::core::config::channel::Given;

fn message(text: &str) -> String {
    match parse(text).and_then(|config| check(&config)) {
        Ok(()) => panic!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_is_shown_reads_back_the_same() {
    let default = Config::default();
    assert_eq!(parse(&render(&default)).unwrap(), default);
    let text = "rule = 'paper'\n[triple]\ngamma = 7.3\n[input]\nstart = 1\nsonars = ['a*']\n\
                [sonar.'odd name[3]']\nx = 0.1\ny = 0\nyaw = -33.3\nmax_range = 4";
    let config = parse(text).unwrap();
    check(&config).unwrap();
    assert_eq!(parse(&render(&config)).unwrap(), config);
    assert!((config.triple.gamma - 7.3_f64.to_radians()).abs() < 1e-15);
    assert!(
        render(&config).contains("\ngamma = 7.3 "),
        "{}",
        render(&config)
    );
}

#[test]
fn every_key_of_the_configuration_is_in_the_table_and_the_other_way_round() {
    let everything = "[input]\nstart=0\nend=1\nrobot_frame='r'\nworld_frame='w'\nmounts_from='f'\nodometry_track=1\nodometry_jumps='keep'\n[noise]\nsigma_abs=0.01\nodometry_distance=0.01\nodometry_heading=0.2\nodometry_turn=0.5\n[sonars]\nbeam_width=9\nrange_scale=1\nrange_offset=0\nmin_range=0.1\nmax_range=4\nno_echo=3\n[noise_aware]\ncircles=true\ncrossings=false\n\
        [sonar.s]\nx=0\ny=0\nyaw=0\nbeam_width=9\nmin_range=0\nmax_range=1\nrange_scale=1\nrange_offset=0\nrange_delay=0\n\
        [channel.'/t']\ntype='t'\nrange='r'\nstamp='s'\nstamp_unit='ms'\nframe='f'\nframe_name='n'\n\
        min_range='a.b'\nmax_range=3\nbeam_width=9\nvariance=0\nx='x'\ny='y'\nyaw='yaw'\n\
        position='p'\norientation='o'\nangle_unit='deg'\nmetres_per_unit=0.01\nup='y'\nheading='compass'";
    let mut table = to_table(&parse(everything).unwrap());
    let mut seen = 0;
    each_leaf(&mut table, &mut Vec::new(), &mut |path, _| {
        assert!(keys::find(path).is_some(), "{path:?} is not documented");
        seen += 1;
        Ok(())
    })
    .unwrap();
    assert_eq!(seen, KEYS.len());
}

#[test]
fn a_misspelt_key_is_named_with_the_right_one() {
    assert!(message("[triple]\nalhpa = 0.4").contains("did you mean `triple.alpha`?"));
    assert!(message("[sonar.left]\nbeamwidth = 15").contains("`sonar.left.beam_width`"));
    assert!(message("gamma = 10").contains("did you mean `triple.gamma`?"));
    assert!(message("[zzz]\nq = 1").contains("`tmam config` lists every key"));
}

#[test]
fn numbers_outside_their_bounds_are_refused_with_the_bounds() {
    assert_eq!(
        message("[triple]\nalpha = 1"),
        "triple.alpha is 1; it must be above 0 and below 1"
    );
    assert_eq!(
        message("[triple]\nbeta = 1.0"),
        "triple.beta is 1; it must be above 1"
    );
    assert!(message("[triple]\ngamma = -3").ends_with("below 360 degrees"));
    assert!(message("[frames]\nstep = nan").contains("frames.step is NaN"));
    assert!(message("[input]\nodometry_track = 3").ends_with("it must be 1 or 2"));
    assert!(message("[input]\nsonars = ['[']").contains("is not a glob"));
    assert!(message("[input]\nstart = 5\nend = 3").contains("before its start"));
}

#[test]
fn messages_by_field_paths() {
    let text = "[channel.'/us']\nrange = 'echoes[].cm'\nmetres_per_unit = 0.01\n\
                beam_width = 15\nmax_range = 'limits.far'";
    let config = parse(text).unwrap();
    check(&config).unwrap();
    assert_eq!(parse(&render(&config)).unwrap(), config);
    assert_eq!(
        config.channel["/us"].beam_width,
        Some(Given::Constant(15_f64.to_radians()))
    );
    assert!(message("[channel.'/us']\nrnage = 'r'").contains("`channel./us.range`"));
    assert!(message("[channel.'/us']\nframe = 'f'").contains("neither where the range is"));
    assert!(message("[channel.'/us']\nrange = 'r'\nx = 'x'").contains("one or the other"));
    assert!(message("[channel.'/o']\nx = 'x'\ny = 'y'").contains("without yaw"));
    assert!(message("[channel.'/us']\nrange='r'\nbeam_width=400").contains("below 360"));
    assert!(message("[channel.'/us']\nrange='r'\nmax_range=[1]").contains("path, or m"));
}

#[test]
fn later_layers_stand_before_earlier_ones() {
    let layers = [
        "[triple]\nalpha = 0.4\nbeta = 3",
        "triple.alpha = 0.3",
        "map.match_distance = 1",
    ];
    let config = parse_layers(&layers).unwrap();
    assert_eq!((config.triple.alpha, config.triple.beta), (0.3, 3.0));
    assert_eq!(config.map.match_distance, 1.0);
}

#[test]
fn a_value_of_the_wrong_kind_is_told_by_its_key_and_what_that_means() {
    for (text, said) in [
        ("input.odometry_jumps = true", "\"take-out\""),
        ("triple.alpha = 'x'", "triple.alpha = \"x\" is no value"),
        ("rule = 'papr'", "\"paper\" or \"noise-aware\""),
        ("sonar.left.yaw = [1]", "sonar.left.yaw = [1] is no value"),
        ("input.range_topics = 'a'", "globs"),
        ("triple = 3", "unknown key"),
    ] {
        let message = message(text);
        assert!(message.contains(said), "{text}: {message}");
        assert!(!message.contains("variant"), "{message}");
    }
}

#[test]
fn a_text_needs_no_quotes() {
    let line = assignment("rule=paper").unwrap();
    assert_eq!(line, "rule = \"paper\"");
    let line = assignment("input.robot_frame = base/link 'a'").unwrap();
    assert_eq!(
        line.parse::<Table>().unwrap()["input"]["robot_frame"].as_str(),
        Some("base/link 'a'")
    );
    for line in ["rule='paper'", "triple.gamma=8", "input.sonars=[\"a\"]"] {
        assert_eq!(assignment(line).unwrap(), line);
    }
    assert!(assignment("nonsense").unwrap_err().contains("KEY=VALUE"));
}
