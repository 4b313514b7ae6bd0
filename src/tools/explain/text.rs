//! An explanation for a person: degrees, millimetres and metres, within 100 columns.

use std::fmt::Write as _;

use super::Explanation;
use super::changes::Change;
use super::history::{Doubt, Echoed, Place, Registered, RunStory, TruthStory};
use super::pairs::{Candidate, Candidates, Pair};
use super::situation::{Comparison, Neighbour, Obstacle, Reading, Situation, Window};
use super::suspects::command;
use crate::core::observer::Setting;
use crate::core::tmam::report::Between;
use crate::core::wording::counted;
use crate::tools::tables::{render, table};

/// An arc that passes farther from a place than this is hardly the one that was meant, metres.
const FAR: f64 = 0.3;

/// The whole story of an arc. `log` is how the log was named on the command line.
pub fn text(setting: &Setting<'_>, log: &str, told: &Explanation) -> String {
    let mut text = head(setting, told);
    section(&mut text, "READINGS", &readings(told));
    if !told.pairs.is_empty() {
        let title = "PAIRS (bearings off the beam's axis, left is positive)";
        section(&mut text, title, &pairs(told));
    }
    if told.angles.is_some() {
        section(&mut text, angles_title(told), &angles(told));
    }
    if !told.windows.is_empty() {
        section(
            &mut text,
            "SECOND OPINION (squares that remain of the best line and of the best point)",
            &windows(told),
        );
    }
    if !told.changes.is_empty() {
        section(&mut text, "WHAT WOULD CHANGE IT", &changes(told));
    }
    section(&mut text, "RUN AND FEATURE", &runs(told));
    if let Some(truth) = &told.truth {
        section(&mut text, "TRUTH", &what_echoed(truth));
    }
    if !told.also_near.is_empty() {
        section(&mut text, "OTHER ARCS THAT PASS NEAR", &near(log, told));
    }
    text
}

/// Writing into a string cannot fail.
fn section(text: &mut String, title: &str, body: &str) {
    let _ = write!(text, "\n{title}\n{body}");
}

fn degrees(angle: f64) -> String {
    format!("{:.2} deg", angle.to_degrees())
}

fn place([x, y]: [f64; 2]) -> String {
    format!("({x:.3}, {y:.3})")
}

fn head(setting: &Setting<'_>, told: &Explanation) -> String {
    let arc = &told.arc;
    let what = match (told.label, told.reason) {
        ("contact", _) => "CONTACT: taken for part of a wall".to_owned(),
        ("intersection", _) => "INTERSECTION: taken for a point".to_owned(),
        (_, reason) => format!("UNIDENTIFIED: {}", why(reason.unwrap_or_default())),
    };
    let mut text = format!(
        "{}, frame {}, {:.3} s after the first reading of {}{}\n{what}\n",
        told.sensor,
        arc.frame,
        arc.seconds,
        setting.source.file,
        if setting.source.complete {
            ""
        } else {
            " (INCOMPLETE)"
        },
    );
    if let Some(distance) = told.distance {
        let millimetres = distance * 1e3;
        let _ = if distance > FAR {
            writeln!(
                text,
                "No arc passes near the place asked for: this one, the nearest, passes {millimetres:.1} mm from it."
            )
        } else {
            writeln!(
                text,
                "It passes {millimetres:.1} mm from the place asked for."
            )
        };
    }
    // What one types has three decimals at most.
    if let Some(late) = told.late.filter(|late| late.abs() > 1e-3) {
        let when = if late > 0.0 { "after" } else { "before" };
        let _ = writeln!(
            text,
            "It was measured {:.3} s {when} the time asked for: none of this sonar is nearer.",
            late.abs()
        );
    }
    for doubt in &told.doubts {
        let _ = writeln!(text, "SUSPECT: {}", contradiction(doubt));
    }
    if told.label != "unidentified" && !told.suspect {
        text.push_str("Not suspect: neither its readings nor the map contradict the label.\n");
    }
    if let Some(right) = told.truth.as_ref().and_then(|truth| truth.right) {
        let verdict = if right { "right" } else { "WRONG" };
        let _ = writeln!(text, "In truth the label is {verdict}.");
    }
    text
}

/// What a doubt says, in words.
fn contradiction(doubt: &Doubt) -> String {
    let says = match doubt.says {
        "line" => "only a line explains",
        "point" => "only a point explains",
        _ => "neither a line nor a point explains",
    };
    match (doubt.by, doubt.readings) {
        ("triple", _) => format!("{says} its three readings"),
        ("window", Some(n)) => format!("{says} the {n} readings around it"),
        ("run", Some(n)) => format!("{says} all {n} readings of its run"),
        _ => format!(
            "in the map of all readings it is a {} that explains it",
            doubt.says
        ),
    }
}

/// Why an arc is unidentified, in words.
fn why(reason: &str) -> &'static str {
    match reason {
        "missing" => "no echo before or after it, so no triple",
        "gap" => "a neighbour is too far in time or distance, so no triple",
        "turning" => "the sensor turned, or its path bent, so no triple",
        "no-points" => "neither contact nor intersection points on a common side",
        "wide" => "the smaller angle is not below gamma",
        "ambiguous" => "a line and a point explain it too nearly equally well",
        "neither" => "its readings come from neither one line nor one point",
        _ => "no reason is known",
    }
}

fn readings(told: &Explanation) -> String {
    let mut rows = table(
        &[
            "", "frame", "time s", "x m", "y m", "yaw deg", "range m", "sigma mm", "beam deg",
        ],
        1,
    );
    let mut row = |name: &str, reading: &Reading| {
        rows.add_row([
            name.to_owned(),
            reading.frame.to_string(),
            format!("{:.3}", reading.seconds),
            format!("{:.4}", reading.x),
            format!("{:.4}", reading.y),
            format!("{:.2}", reading.yaw.to_degrees()),
            format!("{:.4}", reading.range),
            format!("{:.2}", reading.sigma * 1e3),
            format!("{:.1}", reading.beam_width.to_degrees()),
        ]);
    };
    let situation = &told.situation;
    if let Neighbour::Echo(reading) = &situation.before {
        row("before", reading);
    }
    row("this arc", &told.arc);
    if let Neighbour::Echo(reading) = &situation.after {
        row("after", reading);
    }
    let mut text = render(&rows);
    for (neighbour, side) in [(&situation.before, "before"), (&situation.after, "after")] {
        match neighbour {
            Neighbour::Echo(_) => {}
            Neighbour::NoEcho { frame } => {
                let _ = writeln!(
                    text,
                    "  The sonar's reading {side} it, in frame {frame}, had no echo."
                );
            }
            Neighbour::End => {
                let _ = writeln!(text, "  The sonar has no reading {side} it.");
            }
        }
    }
    for obstacle in &situation.obstacles {
        let _ = writeln!(text, "  Not a triple: {}.", broken(obstacle, situation));
    }
    text
}

fn broken(obstacle: &Obstacle, situation: &Situation) -> String {
    let from = match (obstacle.between, &situation.before, &situation.after) {
        (Between::Before, Neighbour::Echo(other), _) => {
            format!("from the reading before (frame {})", other.frame)
        }
        (Between::After, _, Neighbour::Echo(other)) => {
            format!("to the reading after (frame {})", other.frame)
        }
        _ => "between the way to it and the way on".to_owned(),
    };
    let (found, allowed) = (obstacle.found, obstacle.allowed);
    let key = obstacle.key;
    match key {
        "sequence.max_gap" => format!("{found:.3} s {from}; {key} is {allowed:.3}"),
        "sequence.max_baseline" => format!("{found:.3} m {from}; {key} is {allowed:.3}"),
        "triple.turn_tolerance" => format!(
            "the beam turned by {} {from}; {key} is {:.2}",
            degrees(found),
            allowed.to_degrees()
        ),
        _ => format!(
            "the path bends by {} {from}; {key} is {:.2}",
            degrees(found),
            allowed.to_degrees()
        ),
    }
}

fn near(log: &str, told: &Explanation) -> String {
    told.also_near.iter().fold(String::new(), |mut text, near| {
        let _ = writeln!(
            text,
            "  {:8.1} mm  tmam explain {log} {}",
            near.distance.unwrap_or_default() * 1e3,
            command(&near.sensor, near.frame)
        );
        text
    })
}

/// What the rule's part is called.
fn angles_title(told: &Explanation) -> &'static str {
    match (is_triple(told), told.decided_by) {
        (false, _) => "ANGLES THAT IT WOULD HAVE AS THE MIDDLE OF A TRIPLE",
        (true, "angles") => "THE RULE",
        (true, _) => "WHAT THE PAPER'S RULE WOULD SAY",
    }
}

fn is_triple(told: &Explanation) -> bool {
    !matches!(told.reason, Some("missing" | "gap" | "turning"))
}

/// Both angles and the rule on them.
fn angles(told: &Explanation) -> String {
    let mut text = String::new();
    let Some(angles) = &told.angles else {
        return text;
    };
    let full = format!(
        "{}: the full beam width, for want of such points on a common side",
        degrees(told.arc.beam_width)
    );
    for (name, what, angle, sigma, has) in [
        (
            "theta_c",
            "contact",
            angles.theta_c,
            angles.theta_c_sigma,
            angles.has_contact,
        ),
        (
            "theta_i",
            "intersection",
            angles.theta_i,
            angles.theta_i_sigma,
            angles.has_intersection,
        ),
    ] {
        let said = match (has, sigma) {
            (false, _) => full.clone(),
            (true, None) => format!("{} between {what} points", degrees(angle)),
            (true, Some(sigma)) => format!(
                "{} +- {} between {what} points",
                degrees(angle),
                degrees(sigma)
            ),
        };
        let _ = writeln!(text, "  {name}  {said}");
    }
    for condition in &angles.conditions {
        let _ = writeln!(text, "  {}", comparison(condition));
    }
    let margin = degrees(angles.margin);
    let _ = match angles.reason {
        None => writeln!(text, "  so {}, with {margin} to spare", angles.label),
        Some(reason) => writeln!(
            text,
            "  so unidentified ({reason}); {margin} short of the nearer label"
        ),
    };
    let apart = (angles.theta_c - angles.theta_i).abs();
    if let (Some(c), Some(i)) = (angles.theta_c_sigma, angles.theta_i_sigma)
        && angles.has_contact
        && angles.has_intersection
        && apart < (c * c + i * i).sqrt()
    {
        text.push_str(
            "  The two angles differ by less than noise spreads them: too short a base line to decide.\n",
        );
    }
    text
}

fn comparison(condition: &Comparison) -> String {
    let bound = degrees(condition.bound);
    let bound = match condition.times {
        Some(times) if times > 0.0 => format!(
            "{} * theta_i = {:.3} * {} = {bound}",
            condition.parameter,
            condition.bound / times,
            degrees(times)
        ),
        Some(_) => format!("{} * theta_i = {bound}", condition.parameter),
        None => format!("{} = {bound}", condition.parameter),
    };
    let left = format!(
        "{} {} {} {bound}",
        condition.angle,
        degrees(condition.value),
        condition.relation
    );
    format!(
        "{:<13} {left:<66} {}",
        condition.label,
        if condition.holds { "yes" } else { "no" }
    )
}

/// The second opinion, window by window.
fn windows(told: &Explanation) -> String {
    let mut rows = table(
        &[
            "readings",
            "frames",
            "chi2 line",
            "chi2 point",
            "gate",
            "supports",
        ],
        0,
    );
    for window in &told.windows {
        rows.add_row([
            (2 * window.half_width + 1).to_string(),
            format!("{}-{}", window.first_frame, window.last_frame),
            chi2(window.chi2_line),
            chi2(window.chi2_point),
            chi2(window.gate),
            window.support.to_owned(),
        ]);
    }
    let mut text = render(&rows);
    if let Some(last) = told.windows.last() {
        let _ = writeln!(text, "  {}", windows_end(told, last));
    }
    text
}

/// A chi2; infinite where the beams have no place for the model.
fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.2}")
    } else {
        "none".to_owned()
    }
}

fn windows_end(told: &Explanation, last: &Window) -> String {
    let readings = 2 * last.half_width + 1;
    let lead = (last.chi2_line - last.chi2_point).abs();
    let decisive = told.decisive;
    match (told.windows_end, last.decides) {
        (_, Some(kind)) if lead.is_finite() => format!(
            "{readings} readings decide: a {kind}, ahead by {lead:.2} (opinion.decisive is {decisive})"
        ),
        (_, Some(kind)) => {
            format!("{readings} readings decide: a {kind}; the beams have no place for the other")
        }
        (Some("neither"), _) => {
            format!("{readings} readings fit neither a line nor a point: no wider window is asked")
        }
        (Some("max-half-width"), _) => format!(
            "undecided within opinion.max_half_width: a lead of {lead:.2}, {decisive} is needed"
        ),
        _ => format!(
            "undecided, and the sequence has no more readings: a lead of {lead:.2}, {decisive} is \
             needed"
        ),
    }
}

/// What would have given another label.
fn changes(told: &Explanation) -> String {
    told.changes.iter().fold(String::new(), |mut text, change| {
        let _ = writeln!(text, "  {:<13} {}", change.label, how(told, change));
        text
    })
}

fn how(told: &Explanation, change: &Change) -> String {
    if let Some(why) = change.impossible {
        return format!("not here: {why}");
    }
    // Windows may change their mind more than once; the rule's bounds and the sequence's do not.
    let by_windows = told.decided_by == "opinion" && is_triple(told);
    let needs: Vec<String> = change
        .needs
        .iter()
        .filter_map(|need| {
            let flag = need.flag()?;
            Some(match (by_windows, need.relation.is_upward()) {
                (true, _) => flag,
                (false, true) => format!("{flag} or more"),
                (false, false) => format!("{flag} or less"),
            })
        })
        .collect();
    format!("with {}", needs.join(" and "))
}

/// The two pairs.
fn pairs(told: &Explanation) -> String {
    let mut text = String::new();
    let half = told.arc.beam_width / 2.0;
    for (name, pair) in ["before - this arc", "this arc - after"]
        .iter()
        .zip(&told.pairs)
    {
        let _ = writeln!(
            text,
            "  {name}: base line {:.1} mm towards {}",
            pair.base_line * 1e3,
            degrees(pair.direction)
        );
        if pair.too_short {
            text.push_str("    the sensor stood still: no base line, so no points\n");
            continue;
        }
        kind(&mut text, "contact     ", &pair.contact, pair, half);
        kind(&mut text, "intersection", &pair.intersection, pair, half);
    }
    text
}

fn kind(text: &mut String, name: &str, candidates: &Candidates, pair: &Pair, half: f64) {
    if candidates.sides.is_empty() {
        let _ = writeln!(
            text,
            "    {name}  cos {:.4} is beyond 1: the ranges differ by more than {:.1} mm allow",
            candidates.cosine,
            pair.base_line * 1e3
        );
        return;
    }
    for candidate in &candidates.sides {
        let _ = writeln!(
            text,
            "    {name}  cos {:+.4}  {:5}  {}",
            candidates.cosine,
            candidate.side,
            where_it_lies(candidate, half)
        );
    }
}

fn where_it_lies(candidate: &Candidate, half: f64) -> String {
    let [a, b] = candidate.seen;
    let off = |angle: f64| format!("{:+.2}", angle.to_degrees());
    let bearings = format!("{:>7}, {:>7}", off(a.off_axis), off(b.off_axis));
    let half = half.to_degrees();
    match (a.held, b.held) {
        (true, true) => format!("{bearings}  at {}", place(b.at)),
        (false, false) => format!("{bearings}  outside both beams (+-{half:.2})"),
        (false, true) => format!("{bearings}  outside the first beam (+-{half:.2})"),
        (true, false) => format!("{bearings}  outside the second beam (+-{half:.2})"),
    }
}

/// The runs that the arc stands behind, and what the map says of it.
fn runs(told: &Explanation) -> String {
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
fn what_echoed(truth: &TruthStory) -> String {
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
