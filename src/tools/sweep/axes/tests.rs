use super::*;

fn of(spec: &str) -> Vec<f64> {
    values("key", spec).unwrap()
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
    assert_eq!(axis.line(2.5), "sonar.\"/us front\".yaw = 2.5");
    assert_eq!(
        (axis.short().as_str(), axis.unit_name()),
        ("/us front.yaw", "deg")
    );
    assert!(axis.is_of_log() && !axis.is_decoding());
    let runs = Axis::parse("map.confirm_runs", "2:4:1").unwrap();
    assert_eq!(runs.line(2.0), "map.confirm_runs = 2");
    assert!(!runs.is_of_log());
}
