//! What a key bears on under the method and the rule that a configuration asks for.

use super::file::changes;
use crate::core::config::{Config, Method, Poses, Rule};

/// What a key bears on in a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bearing {
    /// On nothing.
    Nothing,
    /// Only on which labels are suspect, by the noise-aware map that predicts beside the paper's rule.
    Suspects,
    /// On labels, features or what is read.
    Results,
}

/// What a key bears on.
pub fn bearing(key: &str, config: &Config) -> Bearing {
    use Bearing::{Nothing, Results, Suspects};
    let (section, _) = key.split_once('.').unwrap_or((key, ""));
    let is_drift = key.starts_with("noise.odometry_");
    let is_by_angles = ["triple.alpha", "triple.beta", "triple.gamma"].contains(&key);
    match (config.method, config.rule) {
        (Method::Tmam, Rule::NoiseAware) => match section {
            _ if is_by_angles && config.noise_aware.label_by_opinion => Nothing,
            _ if is_drift && config.poses == Poses::Odometry => Nothing,
            _ => Results,
        },
        (Method::Tmam, Rule::Paper) => match section {
            _ if is_drift => Nothing,
            "poses" => Nothing,
            "opinion" | "noise_aware" => Suspects,
            "map" if key != "map.match_distance" => Suspects,
            _ => Results,
        },
        (method, _) => {
            let is_run = matches!(method, Method::TwoMeasurement | Method::Crowley);
            match section {
                _ if is_drift => Nothing,
                "rule" | "poses" | "triple" | "opinion" | "noise_aware" => Nothing,
                "sequence" if !is_run => Nothing,
                "map" if key == "map.gate" && !is_run => Nothing,
                _ => Results,
            }
        }
    }
}

/// What of a configuration bears on no label and no feature; `None` where all of it does.
pub fn idle(config: &Config) -> Option<String> {
    let rule = match (config.method, config.rule) {
        (Method::Tmam, Rule::Paper) => "rule = \"paper\"".to_owned(),
        (Method::Tmam, Rule::NoiseAware) => "rule = \"noise-aware\"".to_owned(),
        (method, _) => format!("method = \"{}\"", method.name()),
    };
    let keys = changes(&Config::default(), config).into_iter();
    // Poses of odometry are what there is, then.
    let keys: Vec<String> = (keys.map(|(key, _)| key))
        .filter(|key| key != "poses")
        .collect();
    let of = |wanted| {
        let of = keys.iter().filter(|key| bearing(key, config) == wanted);
        of.map(String::as_str).collect::<Vec<_>>().join(", ")
    };
    let [nothing, suspects] = [Bearing::Nothing, Bearing::Suspects].map(of);
    let mut said = Vec::new();
    if !nothing.is_empty() {
        said.push(format!("{nothing}: no effect under {rule}"));
    }
    if !suspects.is_empty() {
        let only = "only for what is suspect, not for labels and features";
        said.push(format!("{suspects}: under {rule} {only}"));
    }
    (!said.is_empty()).then(|| said.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::config::file::parse;

    fn said(text: &str) -> Option<String> {
        idle(&parse(text).unwrap())
    }

    #[test]
    fn what_bears_on_nothing_is_told() {
        assert_eq!(said(""), None);
        assert_eq!(
            said("rule = 'paper'\ntriple.gamma = 8\nposes = 'odometry'"),
            None
        );
        let gamma = said("triple.gamma = 8\ntriple.turn_tolerance = 4").unwrap();
        assert_eq!(
            gamma,
            "triple.gamma: no effect under rule = \"noise-aware\""
        );
        assert_eq!(
            said("triple.gamma = 8\nnoise_aware.label_by_opinion = false"),
            None
        );
        let paper = said("rule = 'paper'\nopinion.gate = 5\nnoise.odometry_turn = 1").unwrap();
        assert_eq!(
            paper,
            "noise.odometry_turn: no effect under rule = \"paper\"; opinion.gate: under rule = \"paper\" \
             only for what is suspect, not for labels and features"
        );
        let rival = said("method = 'tbf'\nrule = 'paper'\nmap.max_wall_gap = 2").unwrap();
        assert_eq!(rival, "rule: no effect under method = \"tbf\"");
    }
}
