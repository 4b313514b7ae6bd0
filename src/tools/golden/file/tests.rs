use super::*;
use crate::tools::golden::results::Feature;

#[test]
fn any_configuration_is_recorded_to_the_last_bit_that_is_read_back() {
    for tenths in 1..400 {
        let mut config = Config::default();
        config.triple.gamma = (f64::from(tenths) / 10.0).to_radians();
        let asked = config.triple.gamma;
        config = as_recorded(&config).unwrap();
        assert!((config.triple.gamma - asked).abs() <= 2.0 * f64::EPSILON * asked);
        let results = Results::of_map([Feature::point(1.0, 2.0)]);
        let golden = Golden::new(Some(config), Tolerance::default(), results);
        let bytes = golden.render().unwrap();
        let (back, unrecorded) = Golden::parse(&bytes, Path::new("golden")).unwrap();
        assert_eq!(back, golden);
        assert!(unrecorded.is_empty());
    }
}

#[test]
fn what_json_cannot_hold_is_refused() {
    let mut config = Config::default();
    config.sonar.entry("left".to_owned()).or_default().max_range = Some(f64::INFINITY);
    assert!(
        as_recorded(&config)
            .unwrap_err()
            .to_string()
            .contains("not finite")
    );
}

#[test]
fn only_what_is_not_default_is_recorded() {
    let mut config = Config::default();
    config.triple.gamma = 0.15;
    config.sonar.entry("left".to_owned()).or_default().max_range = Some(4.0);
    let recorded = not_default(&config);
    let expected =
        serde_json::json!({"triple": {"gamma": 0.15}, "sonar": {"left": {"max_range": 4.0}}});
    assert_eq!(recorded, expected);
    assert_eq!(Config::deserialize(&recorded).unwrap(), config);
    assert_eq!(not_default(&Config::default()), serde_json::json!({}));
}

#[test]
fn a_tolerance_that_a_file_does_not_record_is_named() {
    let results = Results::of_map([Feature::point(1.0, 2.0)]);
    let golden = Golden::new(Some(Config::default()), Tolerance::default(), results);
    let text = String::from_utf8(golden.render().unwrap()).unwrap();
    let without = text.replace("    \"borderline_chi2\": 0.1,\n", "");
    assert!(without.len() < text.len());
    let (_, unrecorded) = Golden::parse(without.as_bytes(), Path::new("golden")).unwrap();
    assert_eq!(unrecorded, ["tolerances.borderline_chi2"]);
}
