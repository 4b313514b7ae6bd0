use super::*;

fn of(spec: &str) -> Vec<f64> {
    values(spec).unwrap()
}

fn said(key: &str, spec: &str) -> String {
    Axis::parse(key, spec).unwrap_err().to_string()
}

#[test]
fn both_ends_belong_to_a_range_whatever_rounding_does() {
    assert_eq!(of("0.1:0.3:0.1"), [0.1, 0.2, 0.3]);
    assert_eq!(of("0:1:0.1").len(), 11);
    assert_eq!(of("0:1:0.1")[7], 0.7);
    assert_eq!(of("-25:-15:5"), [-25.0, -20.0, -15.0]);
    assert_eq!(of("0.3:-0.3:-0.3"), [0.3, 0.0, -0.3]);
    assert_eq!(of("1:2:0.4"), [1.0, 1.4, 1.8]);
    assert_eq!(of("5:5:1"), [5.0]);
    assert!(of("-0.3:0.3:0.1").contains(&0.0));
    assert!(
        of("-0.3:0.3:0.1")
            .iter()
            .all(|x| x.to_bits() != (-0.0_f64).to_bits())
    );
}

#[test]
fn lists_keep_their_order() {
    assert_eq!(of("0.7, 0.3,0.5"), [0.7, 0.3, 0.5]);
    assert_eq!(of("-4"), [-4.0]);
}

#[test]
fn what_is_no_axis_is_said() {
    assert!(said("triple.alpha", "0.1:0.5").contains("has no step"));
    assert!(said("triple.alpha", "0.5:0.1:0.1").contains("never arrives"));
    assert!(said("triple.alpha", "0.1:0.5:0").contains("never arrives"));
    assert!(said("triple.alpha", "a:b:c").contains("neither a number"));
    assert!(said("triple.alpha", "0.1:nan:1").contains("neither a number"));
    assert!(said("triple.alpha", "").contains("neither a number"));
    assert!(said("triple.alpha", "0.1,0.1").contains("0.1 twice"));
    assert!(said("triple.alpha", "0.1:0.9:1e-9").contains("800000001 cells"));
    assert!(said("triple.alpha", "0.5:1.5:0.5").contains("must be above 0 and below 1"));
    assert!(said("triple.alhpa", "0.5").contains("did you mean `triple.alpha`?"));
    assert!(said("triple alpha", "0.5").contains("--set triple alpha=0.5"));
}

#[test]
fn a_key_keeps_its_quotes_and_a_count_stays_whole() {
    let axis = Axis::parse("sonar.\"/us front\".yaw", "-5:5:2.5").unwrap();
    assert_eq!(axis.path, ["sonar", "/us front", "yaw"]);
    assert_eq!(axis.lines(2.5), ["sonar.\"/us front\".yaw = 2.5"]);
    assert_eq!(
        (axis.short().as_str(), axis.unit_name()),
        ("/us front.yaw", "deg")
    );
    assert!(axis.is_of_log() && !axis.is_decoding());
    let runs = Axis::parse("map.confirm_runs", "2:4:1").unwrap();
    assert_eq!(runs.lines(2.0), ["map.confirm_runs = 2"]);
    assert!(!runs.is_of_log());
}

fn grid(axes: &[(&str, &str)]) -> Result<Grid, AxisError> {
    Grid::new(
        axes.iter()
            .map(|(key, spec)| Axis::parse(key, spec).unwrap())
            .collect(),
    )
}

#[test]
fn the_last_axis_runs_fastest() {
    let grid = grid(&[("triple.alpha", "0.3,0.5"), ("triple.gamma", "5:15:5")]).unwrap();
    assert_eq!(grid.cells(), 6);
    assert_eq!(grid.values(0), [0.3, 5.0]);
    assert_eq!(grid.values(1), [0.3, 10.0]);
    assert_eq!(grid.values(5), [0.5, 15.0]);
    assert_eq!(
        grid.flags(4),
        "--set triple.alpha=0.5 --set triple.gamma=10"
    );
    let config = grid.configuration(&Config::default(), 5).unwrap();
    assert_eq!(config.triple.gamma, 15_f64.to_radians());
    assert_eq!((config.triple.alpha, config.triple.beta), (0.5, 2.0));
}

#[test]
fn one_part_of_a_mount_and_a_count_can_be_swept() {
    let grid = grid(&[("sonar.'/us front'.yaw", "90"), ("map.confirm_runs", "3")]).unwrap();
    let config = grid.configuration(&Config::default(), 0).unwrap();
    let sonar = &config.sonar["/us front"];
    assert_eq!((sonar.x, sonar.yaw), (None, Some(90_f64.to_radians())));
    assert_eq!(config.map.confirm_runs, 3);
    assert!(
        grid.flags(0)
            .starts_with("--set 'sonar.\"/us front\".yaw=90'")
    );
}

#[test]
fn what_is_too_much_or_too_little_is_refused() {
    let said = |axes: &[(&str, &str)]| grid(axes).unwrap_err().to_string();
    assert!(said(&[]).contains("nothing to sweep"));
    assert!(said(&[("triple.beta", "2"), ("triple.beta", "3")]).contains("given twice"));
    let many = [("triple.beta", "2:999:1"), ("map.gate", "1:999:1")];
    assert!(said(&many).contains("997002 cells, more than 100000"));
}

#[test]
fn values_that_do_not_go_together_fail_by_themselves() {
    let grid = grid(&[("input.start", "1,5"), ("input.end", "3")]).unwrap();
    assert!(grid.configuration(&Config::default(), 0).is_ok());
    assert!(grid.configuration(&Config::default(), 1).is_err());
}

#[test]
fn axes_and_settings_are_told_apart() {
    let set = [
        "triple.gamma=10:20:10",
        "noise_aware.merge=false",
        "map.gate = 9",
        "rule=paper",
        "input.sonars=a*",
    ];
    let request = Request::new(
        &[("triple.alpha", Some("0.3,0.5")), ("triple.beta", None)],
        &set.map(ToOwned::to_owned),
    )
    .unwrap();
    let keys: Vec<String> = request.axes.iter().map(Axis::key).collect();
    assert_eq!(keys, ["triple.alpha", "triple.gamma", "map.gate"]);
    assert_eq!(request.axes[1].values, [10.0, 20.0]);
    let settings = [
        "noise_aware.merge=false",
        "rule = \"paper\"",
        "input.sonars = \"a*\"",
    ];
    assert_eq!(request.settings, settings);
}

#[test]
fn what_is_neither_is_said() {
    let said = |text: &str| {
        let set = [text.to_owned()];
        Request::new(&[], &set).unwrap_err().to_string()
    };
    assert!(said("triple.gamma=10:20").contains("has no step"));
    assert!(said("triple.gamma").contains("neither a number"));
    assert!(said("triple.gama=1:2:1").contains("did you mean `triple.gamma`?"));
}

#[test]
fn a_pattern_stands_for_each_sonar_around_what_it_has() {
    let axis = Axis::parse("sonar.us*.yaw", "+-5:5").unwrap();
    assert_eq!(axis.pattern(), Some("us*"));
    let configured = |axis: &Axis| Some(if axis.path[1] == "us0" { 10.0 } else { 20.0 });
    let both = axis.for_each(&["us0", "us1"], &configured).unwrap();
    assert_eq!(both.pattern(), None);
    assert_eq!(
        both.lines(-5.0),
        ["sonar.us0.yaw = 5", "sonar.us1.yaw = 15"]
    );
    let flags = Grid::new(vec![both]).unwrap().flags(0);
    assert_eq!(flags, "--set sonar.us0.yaw=5 --set sonar.us1.yaw=15");
}
