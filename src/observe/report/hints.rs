//! What to look into when a replay came out badly.

use crate::core::noise_estimate::VarianceFrom;
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::io::config::keys;

/// Of the triples that say something, more than this share fits neither model where something is
/// wrong with poses or mounts.
const FITTING_NEITHER: f64 = 1.0 / 3.0;
/// Fewer triples than this are no ground for advice.
const ENOUGH: u64 = 30;
/// Half a turn of a mount that is looked at, degrees.
const TURN: f64 = 10.0;

/// What of the configuration has no effect on this log.
pub fn without_effect(setting: &Setting<'_>, outcome: &Outcome) -> Option<String> {
    let given = setting.config.noise.sigma_abs?;
    (outcome.variance_from == VarianceFrom::Messages).then(|| {
        format!(
            "noise.sigma_abs = {given} has no effect: the messages carry a variance of their own; \
             noise.trust_variance = false takes sigma_abs in its place"
        )
    })
}

/// What to try where readings that follow each other belong to nothing. `named` is the log with the
/// flags of the configuration, as one types them.
pub fn fitting_neither(setting: &Setting<'_>, outcome: &Outcome, named: &str) -> Option<String> {
    let of_reason = |reason| outcome.reasons.get(reason).copied().unwrap_or_default();
    let neither = of_reason("neither");
    let labelled = outcome.labelled("contact") + outcome.labelled("intersection");
    let triples = labelled + neither + of_reason("ambiguous");
    let scatter = outcome.scattering.overall();
    if triples < ENOUGH
        || neither as f64 <= FITTING_NEITHER * triples as f64
        // What is wrong is the noise, and a note says so.
        || scatter.is_some_and(|scatter| !scatter.is_as_expected())
    {
        return None;
    }
    let share = 100.0 * neither as f64 / triples as f64;
    let mut text = format!(
        "hint: {share:.0} % of the triples fit neither a wall nor a point. Targets that change from reading to \
         reading do that, and outliers;\n\
         so do a late clock of the ranges and a sonar mounted otherwise than the log says, which would show \
         here as a clear lead of other values:\n  \
         tmam sweep {named} --set input.range_delay=-0.2:0.3:0.05\n"
    );
    if let Some(sonar) = setting.sonars.first() {
        let yaw = sonar.robot_from_sensor.yaw.to_degrees();
        let [low, high] = [yaw - TURN, yaw + TURN].map(|yaw| (yaw * 10.0).round() / 10.0 + 0.0);
        let key = format!("sonar.{}.yaw", keys::part(&sonar.name));
        let mark = if key.contains('"') { "'" } else { "" };
        text.push_str(&format!(
            "  tmam sweep {named} --set {mark}{key}={low}:{high}:2.5{mark}    # likewise the other sonars\n"
        ));
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::config::Config;
    use crate::core::event::Sonar;
    use crate::core::geometry::Pose2;
    use crate::core::observer::Source;

    fn hint(neither: u64, ambiguous: u64, name: &str) -> Option<String> {
        let sonars = [Sonar {
            name: name.into(),
            topic: "/a".into(),
            robot_from_sensor: Pose2::new(0.0, 0.0, -0.5),
        }];
        let source = Source {
            file: "f.mcap".into(),
            messages: 0,
            start_ns: 0,
            end_ns: 0,
            complete: true,
            lost: Vec::new(),
            notes: Vec::new(),
        };
        let setting = Setting {
            sonars: &sonars,
            config: &Config::default(),
            source: &source,
            start: crate::core::geometry::Vec2::zeros(),
        };
        let outcome = Outcome {
            reasons: [
                ("neither", neither),
                ("ambiguous", ambiguous),
                ("missing", 500),
            ]
            .into(),
            labels: [("contact", 10)].into(),
            ..Outcome::default()
        };
        fitting_neither(&setting, &outcome, "f.mcap")
    }

    #[test]
    fn a_third_of_the_triples_that_fit_neither_call_for_a_look_at_clock_and_mounts() {
        assert_eq!(hint(30, 50, "front"), None);
        assert_eq!(hint(9, 2, "front"), None, "too few");
        let text = hint(60, 50, "front").unwrap();
        assert!(text.contains("50 % of the triples"), "{text}");
        assert!(
            text.contains("tmam sweep f.mcap --set sonar.front.yaw=-38.6:-18.6:2.5 "),
            "{text}"
        );
        let text = hint(60, 50, "/us 1").unwrap();
        assert!(text.contains(r#"--set 'sonar."/us 1".yaw="#), "{text}");
    }
}
