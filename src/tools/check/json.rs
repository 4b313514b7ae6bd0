//! The report for programs.

use serde_json::{Value as Json, json};

use super::{Report, exit};
use crate::core::exit::Exit;
use crate::core::rounding::rounded;
use crate::tools::golden::{
    Change, Difference, FeatureDifference, LabelChange, LabelRun, Margin, Set, State, Value,
    describe,
};

/// The format's name and version.
pub const SCHEMA: &str = "tmam.check/1";

/// The report as JSON.
pub fn json(reports: &[Report], notes: &[String]) -> Json {
    json!({
        "schema": SCHEMA,
        "tool": {"name": "tmam", "version": env!("CARGO_PKG_VERSION")},
        "exit_code": exit(reports).code(),
        "notes": notes,
        "logs": reports.iter().map(log).collect::<Vec<_>>(),
    })
}

/// The report of a run that did not begin.
pub fn refused(why: &impl std::fmt::Display) -> Json {
    json!({
        "schema": SCHEMA,
        "tool": {"name": "tmam", "version": env!("CARGO_PKG_VERSION")},
        "exit_code": Exit::Unusable.code(),
        "reason": why.to_string(),
        "notes": [],
        "logs": [],
    })
}

fn log(report: &Report) -> Json {
    let comparison = report.found.as_ref().map(|found| &found.comparison);
    let differences = comparison.into_iter().flat_map(|found| &found.differences);
    let borderline = comparison.into_iter().flat_map(|found| &found.borderline);
    let files = report
        .artifacts
        .iter()
        .map(|path| path.display().to_string());
    json!({
        "log": report.log.display().to_string(),
        "golden": report.golden.display().to_string(),
        "verdict": report.verdict.name(),
        "reason": report.verdict.reason(),
        "notes": report.notes,
        "first_frame": comparison.and_then(|found| found.first_frame()),
        "differences": differences.map(difference).collect::<Vec<_>>(),
        "borderline": borderline.map(labels).collect::<Vec<_>>(),
        "artifacts": files.collect::<Vec<_>>(),
    })
}

/// One difference: its kind, its numbers, and its text.
pub fn difference(one: &Difference) -> Json {
    let mut json = match one {
        Difference::Log { golden, actual } => {
            json!({"kind": "log", "golden": golden, "actual": actual})
        }
        Difference::Noise(noise) => json!({"kind": "noise", "changes": [change(noise)]}),
        Difference::Sonar(sonar) => json!({
            "kind": "sonar", "sensor": sonar.sensor,
            "changes": sonar.changes.iter().map(change).collect::<Vec<_>>(),
        }),
        Difference::Feature(feature) => self::feature(feature),
        Difference::Labels(run) => labels(run),
    };
    if let Some(fields) = json.as_object_mut() {
        fields.insert("text".to_owned(), describe(one, None).into());
    }
    json
}

fn feature(one: &FeatureDifference) -> Json {
    let feature = one.feature();
    json!({
        "kind": match one.set {
            Set::Map => "map",
            Set::Extracted => "extracted",
        },
        "state": match one.state() {
            State::Changed => "changed",
            State::Missing => "missing",
            State::New => "new",
        },
        "feature": feature.map(|feature| feature.kind.name()),
        "golden_id": one.golden.as_ref().map(|feature| feature.id),
        "actual_id": one.actual.as_ref().map(|feature| feature.id),
        "sensor": feature.and_then(|feature| feature.sensor.clone()),
        "frames": one.frames(),
        "changes": one.changes.iter().map(change).collect::<Vec<_>>(),
    })
}

fn change(change: &Change) -> Json {
    let (unit, golden, actual, delta, tolerance): (_, Json, Json, Json, Json) = match &change.value
    {
        Value::Length {
            golden,
            actual,
            delta,
            tolerance,
        } => (
            "m",
            rounded(*golden).into(),
            rounded(*actual).into(),
            rounded(*delta).into(),
            (*tolerance).into(),
        ),
        Value::Angle {
            golden,
            actual,
            delta,
            tolerance,
        } => (
            "rad",
            rounded(*golden).into(),
            rounded(*actual).into(),
            rounded(*delta).into(),
            (*tolerance).into(),
        ),
        Value::Deviation {
            golden,
            actual,
            delta,
            tolerance,
        } => (
            "relative",
            rounded(*golden).into(),
            rounded(*actual).into(),
            rounded(*delta).into(),
            (*tolerance).into(),
        ),
        Value::Count {
            golden,
            actual,
            tolerance,
        } => (
            "count",
            (*golden).into(),
            (*actual).into(),
            (i64::from(*actual) - i64::from(*golden)).into(),
            (*tolerance).into(),
        ),
        Value::Word { golden, actual } => (
            "word",
            golden.clone().into(),
            actual.clone().into(),
            Json::Null,
            Json::Null,
        ),
    };
    json!({
        "what": change.what, "unit": unit,
        "golden": golden, "actual": actual, "delta": delta, "tolerance": tolerance,
    })
}

/// Labels that changed alike, arc by arc.
pub fn labels(run: &LabelRun) -> Json {
    let (state, golden, actual, reason) = match run.change {
        LabelChange::Flipped {
            golden,
            actual,
            reason,
        } => ("changed", Some(golden), Some(actual), reason),
        LabelChange::Gone(mark) => ("missing", Some(mark), None, None),
        LabelChange::New(mark) => ("new", None, Some(mark), None),
    };
    let arcs = run.arcs.iter().map(|arc| {
        let unit = arc.margin.map(|margin| match margin {
            Margin::Angle(_) => "rad",
            Margin::Chi2(_) => "chi2",
        });
        json!({
            "stamp_ns": arc.stamp_ns, "frame": arc.frame,
            "margin": arc.margin.map(|margin| rounded(margin.value())), "margin_unit": unit,
        })
    });
    json!({
        "kind": "labels", "state": state, "sensor": run.sensor,
        "golden": golden.map(|mark| mark.name()), "actual": actual.map(|mark| mark.name()), "reason": reason,
        "frames": run.frames(), "arcs": arcs.collect::<Vec<_>>(),
    })
}
