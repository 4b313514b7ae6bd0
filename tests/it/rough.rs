//! Rooms with rough walls: what echoes at an angle is not taken for a wall's foot, and says how far walls go
//! where that is asked for.

use serde_json::Value;

use crate::support::Bench;

fn evaluated(options: &str) -> Value {
    let bench = Bench::new();
    let made = bench.sh("tmam simulate -o rough.mcap --drive --diffuse 1 --noise 0.01 --seed 1");
    assert_eq!(made.code, 0, "{}", made.stderr);
    let run = bench.tmam(
        &bench.path("rough.mcap"),
        &format!("evaluate {{}} --json {options}"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn echoes_at_an_angle_get_no_label_and_extend_walls_where_that_is_asked_for() {
    let scores = evaluated("");
    assert_eq!(scores["labels"]["contact"]["other"], 0);
    let extended = evaluated("--set noise_aware.oblique_walls=true");
    let lines = |scores: &Value| scores["confirmed"]["lines"].clone();
    let covered = |scores: &Value| lines(scores)["covered"].as_f64().unwrap();
    assert!(
        covered(&extended) > covered(&scores) + 0.05,
        "{} {}",
        covered(&extended),
        covered(&scores)
    );
    assert_eq!(lines(&extended)["spurious"], lines(&scores)["spurious"]);
}
