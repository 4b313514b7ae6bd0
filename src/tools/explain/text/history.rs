//! What became of an arc, and what it really was.

use std::fmt::Write as _;

use super::decision::chi2;
use super::place;
use crate::core::wording::counted;
use crate::tools::explain::Explanation;
use crate::tools::explain::outcome::{Place, Registered, RunStory};
use crate::tools::explain::truth::{Echoed, TruthStory};

/// The runs that the arc stands behind, and what the map says of it.
pub fn runs(told: &Explanation) -> String {
    let mut text = String::new();
    if told.runs.is_empty() {
        text.push_str("  It stands behind no feature.\n");
    }
    for run in &told.runs {
        run_and_feature(&mut text, run);
    }
    if let Some(map) = told.map {
        let says = match (map.says, map.feature) {
            ("line", Some(id)) => format!("a line explains this reading (its {id})"),
            ("point", Some(id)) => format!("a point explains this reading (its {id})"),
            ("ambiguous", _) => "it may be a wall or the point at its end".to_owned(),
            _ => "no confirmed feature explains this reading".to_owned(),
        };
        let _ = writeln!(text, "  The noise-aware map of the whole log says: {says}.");
    }
    text
}

fn run_and_feature(text: &mut String, run: &RunStory) {
    let part = match (run.labelled, run.left_out) {
        (_, true) => ", which leaves this one out",
        (true, false) => "",
        (false, false) => ", this one unlabelled",
    };
    let _ = writeln!(
        text,
        "  feature {}: a {} from {}, {} (frames {}-{}){part}",
        run.feature,
        run.kind,
        counted(run.arcs as u64, "labelled arc"),
        counted(run.readings as u64, "reading"),
        run.first_frame,
        run.last_frame,
    );
    let _ = writeln!(
        text,
        "    residual {:.2} mm rms; all its readings support: {} (chi2 line {}, point {})",
        run.residual_rms * 1e3,
        run.opinion,
        chi2(run.chi2_line),
        chi2(run.chi2_point),
    );
    let became = match (run.action, run.map_id, run.reason) {
        ("registered", Some(id), _) => format!("new in the map as {id}"),
        ("merged", Some(id), _) => format!("merged into {id} of the map"),
        (_, _, reason) => format!("rejected: {}", rejection(reason.unwrap_or_default())),
    };
    let _ = writeln!(text, "    {became}");
    if let Some(feature) = &run.in_the_end {
        let moved = run.map_id.is_some_and(|id| id != feature.id);
        let _ = writeln!(
            text,
            "    {}{}",
            if moved {
                "it turned out to be the same as another one; "
            } else {
                ""
            },
            registered(feature)
        );
    }
}

fn registered(feature: &Registered) -> String {
    let at = match feature.place {
        Place::Line { ends: [a, b], .. } => format!("line {} - {}", place(a), place(b)),
        Place::Point { x, y } => format!("point {}", place([x, y])),
    };
    format!(
        "in the end {} {}, {}, {} and {}",
        feature.id,
        at,
        feature.status,
        counted(feature.runs.into(), "run"),
        counted(feature.readings.into(), "reading"),
    )
}

fn rejection(reason: &str) -> &str {
    match reason {
        "no-start" => "no two of its arcs give a point to start the fit from (no-start)",
        "singular" => "its readings do not determine it (singular)",
        "diverged" => "the fit ran away (diverged)",
        "outside-beams" => "it lies outside the beams that it came from (outside-beams)",
        "misfit" => "its readings do not all come from one feature (misfit)",
        "mirrored" => "its mirror image at the robot's path fits as well (mirrored)",
        other => other,
    }
}

/// What echoed.
pub fn truth(truth: &TruthStory) -> String {
    let source = match truth.from {
        "log" => "the log says so",
        _ => "by the echo model",
    };
    let mut text = format!(
        "  this arc came from {} ({source})\n",
        echoed(&truth.echoed)
    );
    if let (Some(before), Some(after)) = (&truth.before, &truth.after) {
        let _ = writeln!(text, "  the one before from {}", echoed(before));
        let _ = writeln!(text, "  the one after from {}", echoed(after));
    }
    let sentence = match (truth.right, truth.one_target()) {
        (Some(true), _) => "so the label is right",
        (Some(false), Some(true)) => {
            "so the label is WRONG: all three saw one target, the noise misled the rule"
        }
        (Some(false), Some(false)) => "so the label is WRONG: the three saw different targets",
        (Some(false), None) => "so the label is WRONG",
        (None, _) => "it has no label to be right or wrong",
    };
    let _ = writeln!(text, "  {sentence}");
    text
}

fn echoed(echoed: &Echoed) -> String {
    match (echoed.what, echoed.index, echoed.at) {
        ("line", Some(index), [Some(a), Some(b)]) => {
            format!("wall {index}, {} - {}", place(a), place(b))
        }
        ("point", Some(index), [Some(at), _]) => format!("point {index} at {}", place(at)),
        ("outlier", ..) => "nowhere: its range was replaced by a random one".to_owned(),
        ("nothing", ..) => "something that the world does not have".to_owned(),
        _ => "something else: the world has its echo at another range".to_owned(),
    }
}
