//! The closing summary of a replay, for a person.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::core::bits::Bits;
use crate::core::config::{Method, Rule};
use crate::core::joint::JointEstimate;
use crate::core::joint::drift::Drift;
use crate::core::legible::{legible, one_line, quoted};
use crate::core::log::Log;
use crate::core::noise_estimate::VarianceFrom;
use crate::core::observer::Setting;
use crate::core::pattern::is_chosen;
use crate::core::replay::Outcome;
use crate::core::statistics::seconds;
use crate::core::tmam::feature::{Kind, MapFeature, Status};
use crate::core::tmam::hearing::Hearing;
use crate::core::tmam::map::duplicates;
use crate::core::wording::counted as plural;
use crate::io::config::idle::idle;
use crate::io::log::itemised;
use crate::observe::causes::LOOKED_AT;
use crate::observe::viewer::VERSION;

/// Odometry whose distances are further off than this, as a share, has another cause than its wheels.
const UNLIKELY_SCALE: f64 = 0.03;

/// What a replay came to, the files it wrote and how to open them.
///
/// `named` is the log with the flags of the configuration, as one types them.
pub fn closing(
    setting: &Setting<'_>,
    outcome: &Outcome,
    named: &str,
    written: &[PathBuf],
) -> String {
    let bits = Bits::of(outcome);
    let mut text = counts(setting, outcome, bits.as_ref());
    text.push_str(&causes(outcome));
    text.push_str(&self::written(written));
    if outcome.causes.as_ref().is_none_or(Vec::is_empty) {
        text.extend(fitting_neither(outcome, bits.as_ref(), named));
    }
    text
}

/// What is off, or what was looked at and is not.
fn causes(outcome: &Outcome) -> String {
    let mut text = String::new();
    let Some(causes) = &outcome.causes else {
        return text;
    };
    // Writing into a string cannot fail.
    for (place, cause) in causes.iter().enumerate() {
        let _ = writeln!(text, "cause {:<4} {}", place + 1, cause.text);
    }
    if causes.is_empty() {
        let _ = writeln!(text, "{:<10} none found among: {LOOKED_AT}", "causes");
    }
    text
}

/// The files that were written, and how to open them.
pub fn written(files: &[PathBuf]) -> String {
    let mut text = String::new();
    for path in files {
        let shown = path.display().to_string();
        let shown = one_line(&shown);
        let _ = writeln!(text, "wrote      {shown}");
        if path.extension().is_some_and(|extension| extension == "rrd") {
            let _ = writeln!(
                text,
                "open with  rerun {}    (viewer {VERSION} or newer: pip install rerun-sdk)",
                quoted(&path.display().to_string())
            );
        }
    }
    text
}

/// What a person must know of the log: notes, losses, and that there was nothing to judge.
pub fn problems(log: &Log, setting: &Setting<'_>, outcome: &Outcome) -> String {
    let mut text = String::new();
    for note in log.told() {
        let _ = writeln!(text, "note: {note}");
    }
    if !log.losses.is_empty() {
        let losses = itemised(&log.losses);
        let _ = writeln!(
            text,
            "warning: {} could not be read whole. Lost:{losses}",
            log.file
        );
    }
    if let Some(lacking) = &outcome.lacking {
        let _ = writeln!(text, "note: {lacking}");
    }
    for note in [without_effect(setting, outcome), idle(setting.config)]
        .into_iter()
        .flatten()
    {
        let _ = writeln!(text, "note: {note}");
    }
    let scatter = outcome.scattering.overall();
    if let Some(scatter) = scatter.filter(|s| s.ratio > 1.0 && !s.is_as_expected()) {
        let _ = writeln!(
            text,
            "note: {}, so that readings which belong together seem not to; {}",
            scatter.complaint(),
            scatter.mend(outcome.variance_from)
        );
    }
    if outcome.tally.echoes == 0 {
        text.push_str(
            "warning: not one reading is an echo; look at range, min_range and max_range\n",
        );
    }
    legible(&text).into_owned()
}

/// What was counted: a name, how many, and what is said of them.
type CountRow = (&'static str, u64, String);

fn counts(setting: &Setting<'_>, outcome: &Outcome, bits: Option<&Bits>) -> String {
    let (source, tally) = (setting.source, &outcome.tally);
    let asked = &setting.config.input.sonars;
    let chosen = setting
        .sonars
        .iter()
        .filter(|sonar| is_chosen(asked, &sonar.name));
    let mut text = format!(
        "{}: {:.1} s, {:.1} m, {}{}\n",
        source.file,
        seconds(source.start_ns, source.end_ns),
        outcome.distance,
        plural(chosen.count() as u64, "sonar"),
        if source.complete { "" } else { ", INCOMPLETE" },
    );
    let surplus = match tally.surplus {
        0 => String::new(),
        n if setting.config.frames.step > 0.0 => {
            format!("; {n} unused: a frame takes one reading of each sonar (--step 0 uses all)")
        }
        n => format!("; {n} unused: a frame takes one reading of each sonar"),
    };
    let (echoes, none) = (plural(tally.echoes, "echo"), tally.no_echoes);
    let [contact, intersection, unidentified] =
        ["contact", "intersection", "unidentified"].map(|label| outcome.labelled(label));
    let circles = outcome.labelled("circle");
    let arcs = contact + intersection + circles + unidentified;
    let round = match circles {
        0 => String::new(),
        count => format!("{count} circle, "),
    };
    let labels = format!(
        "{contact} contact, {intersection} intersection, {round}{unidentified} unidentified"
    );
    let reasons = format!("unidentified: {}", counted(&outcome.reasons));
    let suspects = "labels that are contradicted: tmam explain --suspects says by what";
    let dropped = tally.dropped.values().sum();
    let told = |row: &CountRow| row.1 > 0;
    let mut rows: Vec<CountRow> = vec![
        ("frames", outcome.frames.into(), String::new()),
        (
            "readings",
            tally.readings,
            format!("{echoes}, {none} without{surplus}"),
        ),
    ];
    rows.extend(Some(("dropped", dropped, counted(&tally.dropped))).filter(told));
    rows.push(("arcs", arcs, labels));
    rows.extend(Some(("", unidentified, reasons)).filter(told));
    let count = outcome.suspects.unwrap_or_default();
    rows.extend(Some(("suspects", count, suspects.to_owned())).filter(told));
    rows.into_iter().for_each(|row| tell(&mut text, row));
    text.push_str(method(setting.config.method));
    let from = match outcome.variance_from {
        VarianceFrom::Ranges => Some("measured from the ranges"),
        VarianceFrom::Nothing => Some("assumed: too little to measure it"),
        VarianceFrom::Messages | VarianceFrom::Configuration => None,
    };
    if let (Some(from), Some(sigma)) = (from, setting.config.noise.sigma_abs) {
        let (name, sigma) = ("noise", sigma * 1e3);
        let what = format!("{from}; noise.sigma_abs overrules it");
        let _ = writeln!(text, "{name:<10} {sigma:>4.1} mm  {what}");
    }
    match &outcome.poses {
        Some(Ok(joint)) => tell_joint(&mut text, joint),
        Some(Err(kept)) => {
            let _ = writeln!(text, "{:<10} not corrected: {kept}", "poses");
        }
        None => {}
    }
    for row in hearing(setting, outcome) {
        tell(&mut text, row);
    }
    for row in [features(outcome), map(setting, outcome)] {
        tell(&mut text, row);
    }
    let Some(bits) = bits else {
        return text;
    };
    if let (Some(share), Some(per_arc)) = (bits.explained_share(), bits.per_arc()) {
        let what = format!(
            "of the arcs ({:.1} %) by the map, in {per_arc:.2} bits an arc",
            100.0 * share
        );
        tell(&mut text, ("explained", bits.explained, what));
        if let Some(stretch) = &outcome.stretch {
            tell(&mut text, ("stretch", stretch.arcs, stretch.in_words()));
        }
    }
    text
}

/// What another method than TMAM goes without.
fn method(method: Method) -> &'static str {
    match method {
        Method::Tmam => "",
        Method::TwoMeasurement | Method::Crowley => {
            "method             poses are odometry's; no map predicts labels, no causes are looked for: TMAM alone does that\n"
        }
        Method::Tbf | Method::Atm | Method::Rcd => {
            "method             features have no covariances; poses are odometry's; no map predicts labels, no causes are \
             looked for: TMAM alone does that\n"
        }
    }
}

/// What became of the poses of odometry.
fn tell_joint(text: &mut String, joint: &JointEstimate) {
    let end = joint.path.covariances.last().copied().unwrap_or_default();
    let sigma = (end.m11 + end.m22).max(0.0).sqrt();
    // Writing into a string cannot fail.
    let _ = writeln!(
        text,
        "{:<10} corrected, the last one by {:.2} m (sigma {sigma:.3} m): {:.1} % of the arcs are explained by the features estimated \
         with them, {:.1} % were by those of odometry",
        "poses",
        joint.path.end_correction(),
        100.0 * joint.explained[1].share,
        100.0 * joint.explained[0].share,
    );
    let Drift {
        distance,
        heading,
        turn,
    } = joint.path.drift;
    let _ = writeln!(
        text,
        "{:<10} odometry is off by {:.1} cm and {:.2} deg after a metre, {:.2} deg after a radian; \
         its distances are {}, its turns {}",
        "",
        100.0 * distance,
        heading.to_degrees(),
        turn.to_degrees(),
        misjudged(joint.scales[0]),
        misjudged(joint.scales[1]),
    );
    if joint.scales[0].abs() > UNLIKELY_SCALE {
        let _ = writeln!(
            text,
            "{:<10} so much is no wear of wheels: ranges may be {} instead, which looks the same",
            "",
            misjudged(-joint.scales[0])
        );
    }
    let closures = joint.closures.len() as u64;
    if closures > 0 {
        let loops = plural(closures, "loop");
        let _ = writeln!(
            text,
            "{:<10} {loops} closed: what was seen again was in the map already",
            ""
        );
    }
}

/// `0.4 % too long`: a share by which something is too short, to a tenth of a percent.
fn misjudged(too_short: f64) -> String {
    let tenths = libm::rint(1e3 * too_short);
    let word = if tenths < 0.0 { "long" } else { "short" };
    if tenths == 0.0 {
        "right".to_owned()
    } else {
        format!("{:.1} % too {word}", tenths.abs() / 10.0)
    }
}

/// Rough walls and sonars of which hardly a triple is explained.
fn hearing(setting: &Setting<'_>, outcome: &Outcome) -> Vec<CountRow> {
    let mut rows = Vec::new();
    let hearings = Hearing::of_sonars(&outcome.reports, &outcome.map);
    let named = |told: &dyn Fn(&Hearing) -> Option<String>| {
        let sonars = hearings.iter().filter_map(|(sonar, hearing)| {
            let name = &setting.sonars.get(sonar.index())?.name;
            Some(format!("{name} {}", told(hearing)?))
        });
        sonars.collect::<Vec<_>>()
    };
    let oblique = hearings.values().map(|hearing| hearing.oblique).sum();
    if oblique > 0 {
        let of_sonars = named(&|hearing| {
            let beam = hearing.half_width.map(|half| {
                let degrees = half.to_degrees();
                format!(" (beam of +-{degrees:.1} deg)")
            });
            let count = hearing.oblique;
            (count > 0).then(|| format!("{count}{}", beam.unwrap_or_default()))
        });
        let what = format!(
            "heard from rough walls at an angle: {}",
            of_sonars.join(", ")
        );
        rows.push(("oblique", oblique, what));
    }
    if setting.config.method != Method::Tmam || setting.config.rule == Rule::Paper {
        return rows;
    }
    let hardly = named(&|hearing| {
        let share = 100.0 * hearing.explained as f64 / hearing.triples.max(1) as f64;
        hearing
            .is_hardly_explained()
            .then(|| format!("{share:.0} %"))
    });
    if hardly.is_empty() {
        return rows;
    }
    let what = format!(
        "of which a wall or a point explains few triples: {}; what one alone saw on one visit \
         stays tentative",
        hardly.join(", ")
    );
    rows.push(("sonars", hardly.len() as u64, what));
    rows
}

fn tell(text: &mut String, (name, count, what): CountRow) {
    let line = format!("{name:<10} {count:>7}  {what}");
    // Writing into a string cannot fail.
    let _ = writeln!(text, "{}", line.trim_end());
}

/// `3 lines, 1 point`.
fn kinds(kinds: impl Iterator<Item = Kind> + Clone) -> String {
    let of_kind = |kind| kinds.clone().filter(|one| *one == kind).count() as u64;
    let (lines, points) = (of_kind(Kind::Line), of_kind(Kind::Point));
    let both = format!("{}, {}", plural(lines, "line"), plural(points, "point"));
    match of_kind(Kind::Circle) {
        0 => both,
        circles => format!("{both}, {}", plural(circles, "circle")),
    }
}

fn features(outcome: &Outcome) -> CountRow {
    let extractions = &outcome.extractions;
    let mut actions = BTreeMap::<&str, u64>::new();
    for extraction in extractions {
        *actions.entry(extraction.action.fate()).or_default() += 1;
    }
    let actions = match extractions.len() {
        0 => String::new(),
        _ => format!(": {}", counted(&actions)),
    };
    let kinds = kinds(extractions.iter().map(|extraction| extraction.kind));
    let readings = plural(outcome.associated_readings, "reading");
    let what = format!("{kinds} from {readings}{actions}");
    ("features", extractions.len() as u64, what)
}

fn map(setting: &Setting<'_>, outcome: &Outcome) -> CountRow {
    let features = outcome.map.iter();
    let (confirmed, tentative): (Vec<&MapFeature>, Vec<&MapFeature>) =
        features.partition(|f| f.status == Status::Confirmed);
    let more = match tentative.len() {
        0 => String::new(),
        1 => "; 1 more is tentative: too little speaks for it".to_owned(),
        n => format!("; {n} more are tentative: too little speaks for them"),
    };
    let config = setting.config;
    let twice = match (config.method, config.rule) {
        (Method::Tmam, Rule::Paper) => duplicates(&outcome.map, config.map.match_distance),
        _ => 0,
    };
    let duplicates = match twice {
        0 => String::new(),
        1 => "; 1 of them looks like another one (the paper's gates leave duplicates)".to_owned(),
        n => format!("; {n} of them look like another one (the paper's gates leave duplicates)"),
    };
    let kinds = kinds(confirmed.iter().map(|feature| feature.shape.kind()));
    (
        "map",
        confirmed.len() as u64,
        format!("{kinds}{more}{duplicates}"),
    )
}

/// `3 gap, 2 missing`, the largest first.
fn counted(counts: &BTreeMap<&'static str, u64>) -> String {
    let mut counts: Vec<_> = counts.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let counts = counts.iter().map(|(what, n)| format!("{n} {what}"));
    counts.collect::<Vec<_>>().join(", ")
}

/// Of the triples that say something, more than this share fits neither model where something is
/// wrong with poses or mounts.
const FITTING_NEITHER: f64 = 1.0 / 3.0;
/// With a map that explains a larger share of the arcs those triples are of changing targets.
const WELL_EXPLAINED: f64 = 0.95;
/// Fewer triples than this are no ground for advice.
const ENOUGH: u64 = 30;

/// What of the configuration has no effect on this log.
fn without_effect(setting: &Setting<'_>, outcome: &Outcome) -> Option<String> {
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
fn fitting_neither(outcome: &Outcome, bits: Option<&Bits>, named: &str) -> Option<String> {
    let explained = bits.and_then(Bits::explained_share);
    let of_reason = |reason| outcome.reasons.get(reason).copied().unwrap_or_default();
    let neither = of_reason("neither");
    let labelled = outcome.labelled("contact") + outcome.labelled("intersection");
    let triples = labelled + neither + of_reason("ambiguous") + of_reason("oblique");
    let scatter = outcome.scattering.overall();
    if triples < ENOUGH
        || explained.is_some_and(|share| share > WELL_EXPLAINED)
        || neither as f64 <= FITTING_NEITHER * triples as f64
        // What is wrong is the noise, and a note says so.
        || scatter.is_some_and(|scatter| !scatter.is_as_expected())
    {
        return None;
    }
    let share = 100.0 * neither as f64 / triples as f64;
    Some(format!(
        "hint: {share:.0} % of the triples fit neither a wall nor a point. Targets that change from reading to \
         reading do that, rough\nwalls and outliers; so do late clocks and wrong mounts. What this log can say \
         of these:\n  tmam calibrate {named}\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint(neither: u64, ambiguous: u64, explained: u64) -> Option<String> {
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
        let bits = Bits {
            arcs: 100,
            explained,
            ..Bits::default()
        };
        fitting_neither(&outcome, Some(&bits), "f.mcap")
    }

    #[test]
    fn a_share_that_is_none_has_no_sign_of_its_own() {
        let shown = [-0.0004, 0.0004, -0.0006, 0.02].map(misjudged);
        assert_eq!(
            shown,
            ["right", "right", "0.1 % too long", "2.0 % too short"]
        );
    }

    #[test]
    fn a_third_of_the_triples_that_fit_neither_call_for_a_look_at_clock_and_mounts() {
        assert_eq!(hint(30, 50, 80), None);
        assert_eq!(hint(9, 2, 80), None, "too few");
        let text = hint(60, 50, 80).unwrap();
        assert!(text.contains("50 % of the triples"), "{text}");
        assert!(text.ends_with("\n  tmam calibrate f.mcap\n"), "{text}");
        assert_eq!(hint(60, 50, 98), None, "targets change");
    }
}
