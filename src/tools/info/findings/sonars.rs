//! What is wrong with the sonars and what came back to them.

use super::{Finding, Info, Weight, percent, which_sonars};
use crate::io::log::WIDEST_BEAM;
use crate::tools::info::sonars::SonarFacts;
use crate::tools::info::statistics::fraction;

/// A sonar in the air reaches no farther, metres.
const FARTHEST: f64 = 50.0;
/// Repeats of a sonar with a fine raster are no chance from this share on ...
const REPEATS: f64 = 0.05;
/// ... and with a coarse one, which sees a wall beside it as the same for long, from this on.
const QUANTISED_REPEATS: f64 = 0.5;
/// A raster finer than this is fine, metres.
const FINE: f64 = 0.002;
/// A share of invalid readings, or of neighbours too far apart, that matters.
const MANY: f64 = 0.25;

impl SonarFacts {
    /// Limits between which no echo can lie.
    pub fn limits_are_senseless(&self) -> bool {
        self.max_range <= self.min_range || self.max_range <= 0.0
    }
}

/// Whatever is wrong with the sonars.
pub fn findings(info: &Info, findings: &mut Vec<Finding>) {
    let all = info.sonars.len();
    let mut tell = |weight,
                    code,
                    test: &dyn Fn(&SonarFacts) -> bool,
                    say: &dyn Fn(&str, &SonarFacts) -> [String; 3]| {
        let some: Vec<&SonarFacts> = info.sonars.iter().filter(|s| test(s)).collect();
        let which: Vec<&str> = some.iter().map(|s| s.name.as_str()).collect();
        if let Some(first) = some.first() {
            let [what, effect, mend] = say(&which_sonars(&which, all), first);
            findings.push(Finding::new(weight, code, what, effect, mend));
        }
    };
    tell(
        Weight::Serious,
        "limits",
        &SonarFacts::limits_are_senseless,
        &|which, sonar| {
            [
        format!("{which}: no echo fits between min_range {} m and max_range {} m", sonar.min_range, sonar.max_range),
        "every reading counts as no echo or as invalid".into(),
        "set min_range and max_range under [sonar.\"NAME\"] from the data sheet; the skeleton below has the keys".into(),
    ]
        },
    );
    tell(
        Weight::Serious,
        "beam-width",
        &|s| s.beam_width.is_some_and(|w| w >= WIDEST_BEAM),
        &|which, sonar| {
            [
                format!(
                    "{which}: the beam is {:.0} deg wide",
                    sonar.beam_width.unwrap_or(0.0).to_degrees()
                ),
                "points anywhere around the robot count, and labels mean little".into(),
                "field_of_view is in radians: does the driver write degrees? sonars.beam_width (deg) overrules it; mend the driver".into(),
            ]
        },
    );
    tell(
        Weight::Serious,
        "units",
        &|s| s.median.is_some_and(|m| m > FARTHEST),
        &|which, sonar| {
            [
        format!("{which}: half of the echoes are farther than {:.0} m", sonar.median.unwrap_or(0.0)),
        "the map is as much too large".into(),
        "ranges are metres: does the driver write centimetres or millimetres? Mend it there".into(),
    ]
        },
    );
    tell(
        Weight::Serious,
        "repeats",
        &repeats_too_often,
        &|which, sonar| {
            [
        format!("{which}: {} of the echoes repeat the last one although the sensor moved", percent(sonar.repeated())),
        "equal ranges from different places look like a wall along the path".into(),
        "look whether the driver publishes faster than the sonar measures; record only new readings".into(),
    ]
        },
    );
    tell(
        Weight::Serious,
        "too-far-apart",
        // Times that come twice put readings of two places next to each other.
        &|s| fraction(s.too_far_apart, s.readings) > MANY && info.clock_set.is_none(),
        &|which, sonar| {
            let bounds = &info.trial.config.sequence;
            [
            format!(
                "{which}: {} of the neighbouring readings lie more than {} m or {} s apart",
                percent(fraction(sonar.too_far_apart, sonar.readings)), bounds.max_baseline, bounds.max_gap
            ),
            "these break the sequence, and arcs at a break are not labelled (gap)".into(),
            "drive slower, let the sonars fire more often, or raise sequence.max_baseline or max_gap".into(),
        ]
        },
    );
    tell(
        Weight::Notable,
        "invalid",
        &|s| fraction(s.invalid, s.readings) > MANY,
        &|which, sonar| {
            [
        format!("{which}: {} of the readings mean nothing (NaN, -inf or below min_range)", percent(fraction(sonar.invalid, sonar.readings))),
        "they are left out".into(),
        "look at min_range and at what the driver writes when nothing comes back (+inf would be right)".into(),
    ]
        },
    );
    tell(
        Weight::Notable,
        "silent",
        &|s| s.echoes == 0,
        &|which, _| {
            [
                format!("{which}: not a single echo"),
                "the map has nothing from there".into(),
                "look at the wiring, or leave it out with --sensor".into(),
            ]
        },
    );
    tell(Weight::Notable, "varies", &|s| s.varies, &|which, _| {
        [
            format!("{which}: beam width or range limits change during the log"),
            "each reading is taken with its own".into(),
            String::new(),
        ]
    });
    one_mount(info, findings);
    resolution(info, findings);
}

fn repeats_too_often(sonar: &SonarFacts) -> bool {
    const ENOUGH: u64 = 20;
    let coarse = sonar
        .resolution
        .is_none_or(|r| r.quantised && r.step > FINE);
    let bound = if coarse { QUANTISED_REPEATS } else { REPEATS };
    sonar.moved >= ENOUGH && sonar.repeated() > bound
}

fn one_mount(info: &Info, findings: &mut Vec<Finding>) {
    let mounts: Vec<_> = info.sonars.iter().filter_map(|s| s.mount).collect();
    let same = mounts.array_windows().all(|[a, b]| a == b);
    if mounts.len() > 1 && same {
        findings.push(Finding::new(
            Weight::Serious,
            "one-mount",
            format!(
                "all {} sonars sit at the same place and look the same way",
                mounts.len()
            ),
            "a map from wrong mounts is wrong everywhere",
            "give the true mounts under [sonar.\"NAME\"], or mend the robot's transforms",
        ));
    }
}

/// Whether the raster of the ranges hides what tells a wall from a corner: `d^2 / 2r`.
fn resolution(info: &Info, findings: &mut Vec<Finding>) {
    let step = info.trial.config.frames.step;
    let mut ratios: Vec<(f64, f64, f64, f64)> = info
        .sonars
        .iter()
        .filter_map(|sonar| {
            let raster = sonar.resolution.filter(|r| r.quantised)?.step;
            let (range, baseline) = (sonar.median?, sonar.baseline?.max(step));
            let sagitta = baseline * baseline / (2.0 * range);
            Some((raster / sagitta, raster, range, baseline))
        })
        .collect();
    if ratios.len() * 2 < info.sonars.len() {
        return;
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(_, raster, range, baseline)) = ratios
        .get(ratios.len() / 2)
        .filter(|(ratio, ..)| *ratio > 0.5)
    else {
        return;
    };
    let sagitta = baseline * baseline / (2.0 * range);
    // Where the difference is two steps of the raster.
    let wider = libm::sqrt(4.0 * raster * range);
    findings.push(Finding::new(
        Weight::Serious,
        "coarse-ranges",
        format!(
            "ranges come in steps of {:.1} mm; at {baseline:.2} m from arc to arc and {range:.2} m range, \
             a wall and a corner differ by {:.1} mm",
            raster * 1e3,
            sagitta * 1e3
        ),
        "many labels depend on rounding",
        format!(
            "try a wider frames.step, of some {:.2} m; a driver that publishes finer ranges is better",
            libm::ceil(wider * 20.0) / 20.0
        ),
    ));
}
