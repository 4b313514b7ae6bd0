//! The page: what was found at the top, then the map, the worst suspects, the sonars and how to look further.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::map;
use crate::core::bits::Bits;
use crate::core::config::{Method, Rule};
use crate::core::event::{SonarId, name_of};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::legible::legible;
use crate::core::observer::Setting;
use crate::core::replay::{Outcome, Stretch};
use crate::core::statistics::{fraction, seconds};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Kind, MapFeature, Status};
use crate::core::tmam::hearing::Hearing;
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::core::wording::counted;
use crate::observe::contradiction::{against, in_words, word};
use crate::tools::explain::decision;

/// Suspects that are listed, at most.
const MOST_ROWS: usize = 25;

const STYLE: &str = "\
body{font:16px/1.45 system-ui,sans-serif;color:#15181d;max-width:1060px;margin:1.5rem auto;padding:0 1rem}\
h1{font-size:1.5rem;margin:0}h2{font-size:1.15rem;margin:1.8rem 0 .5rem}p{margin:.4rem 0}\
.facts{color:#566}.numbers{display:flex;flex-wrap:wrap;gap:.6rem;margin:1rem 0}\
.numbers div{border:1px solid #d5dae1;border-radius:6px;padding:.4rem .8rem;min-width:6rem}\
.numbers b{display:block;font-size:1.5rem}.bad b{color:#d4002a}\
.said{border-left:4px solid #d4002a;padding:.3rem .8rem;background:#fdf1f3}\
figure{margin:.8rem 0;border:1px solid #d5dae1;border-radius:6px}svg{display:block;width:100%;height:auto}\
figcaption{padding:.4rem .8rem;color:#566;font-size:.9rem}\
.wide{overflow-x:auto}table{border-collapse:collapse;width:100%;font-size:.92rem}\
th,td{text-align:left;padding:.25rem .6rem;border-bottom:1px solid #e3e6ea;white-space:nowrap}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}td.words{white-space:normal;min-width:11rem}\
pre{background:#f3f5f7;padding:.6rem .8rem;border-radius:6px;overflow-x:auto;font-size:.88rem}\
h2{break-after:avoid}@media print{body{margin:0;max-width:none}figure,tr{break-inside:avoid}}\
@media(max-width:600px){th,td{padding:.25rem .35rem;font-size:.85rem}.numbers div{padding:.3rem .6rem;min-width:5rem}\
svg .number{font-size:24px}svg .id,svg .named{font-size:28px}}";

/// The page of a replay. `path` is where the robot went, by stamp; `named` is the log with the flags of the configuration,
/// as one types them; `problems` is what a person must know of the log.
pub fn page(
    setting: &Setting<'_>,
    outcome: &Outcome,
    path: &[(i64, Pose2)],
    named: &str,
    problems: &str,
) -> String {
    let mut suspects: Vec<&ArcReport> = outcome.reports.iter().filter(|r| r.is_suspect()).collect();
    suspects.sort_by(|a, b| a.worse_first(b));
    let source = setting.source;
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{file}: sonar map</title><style>{STYLE}</style></head><body>\n\
         <h1>{file}</h1>\n<p class=\"facts\">{:.1} s, {:.1} m, {}, {}, tmam {}</p>\n",
        seconds(source.start_ns, source.end_ns),
        outcome.distance,
        counted(setting.sonars.len() as u64, "sonar"),
        match (setting.config.method, setting.config.rule) {
            (Method::Tmam, Rule::NoiseAware) => "rule noise-aware".to_owned(),
            (Method::Tmam, Rule::Paper) => "rule paper".to_owned(),
            (rival, _) => format!("method {}", rival.name()),
        },
        env!("CARGO_PKG_VERSION"),
        file = shown(&source.file),
    );
    // Only TMAM's map predicts labels.
    let is_held = setting.config.method == Method::Tmam;
    html.push_str(&numbers(outcome, is_held.then_some(suspects.len())));
    for line in problems.lines() {
        // Writing to a string cannot fail.
        let _ = writeln!(html, "<p class=\"said\">{}</p>", shown(line));
    }
    for (place, cause) in outcome.causes.iter().flatten().enumerate() {
        let text = shown(&cause.text);
        let _ = writeln!(html, "<p class=\"said\">Cause {}: {text}.</p>", place + 1);
    }
    if let Some(stretch) = &outcome.stretch {
        let (arcs, text) = (stretch.arcs, stretch.in_words());
        let _ = writeln!(html, "<p class=\"said\">Stretch: {arcs} {text}.</p>");
    }
    if let Some(worst) = suspects.first() {
        let arc = worst.arc.id;
        let _ = writeln!(
            html,
            "<p class=\"said\">Worst: {}, frame {}: {}. What decided: {}.</p>",
            shown(name_of(setting.sonars, arc.sonar)),
            arc.frame,
            in_words(worst),
            shown(&decision(worst, setting.config).unwrap_or_default()),
        );
    }
    let arcs: Vec<Arc> = suspects.iter().map(|report| report.arc).collect();
    let places: Vec<Vec2> = path.iter().map(|(_, pose)| pose.position()).collect();
    let stretch = places_of(outcome.stretch.as_ref(), path, setting.origin_ns);
    let _ = writeln!(
        html,
        "<figure>{}<figcaption>Seen from above, metres in the odometry frame. Black: walls, orange: corners, both \
         with their ids where there is room; grey: tentative; green: the path from its dot on{}; red: arcs whose label \
         is contradicted.</figcaption></figure>",
        map::draw(&places, &stretch, &outcome.map, &arcs, None),
        if stretch.is_empty() {
            ""
        } else {
            ", dashed in red the stretch that is explained least"
        },
    );
    html.push_str(&table_of_suspects(&suspects, setting));
    html.push_str(&table_of_sonars(setting, outcome));
    let _ = write!(
        html,
        "<h2>To look further</h2>\n<pre>{}</pre>\n</body></html>\n",
        shown(&commands(named, suspects.first().copied(), setting))
    );
    html
}

/// Where the robot was in a stretch.
fn places_of(stretch: Option<&Stretch>, path: &[(i64, Pose2)], origin_ns: i64) -> Vec<Vec2> {
    let within = |at: f64| stretch.is_some_and(|of| (of.seconds[0]..=of.seconds[1]).contains(&at));
    let path = path.iter();
    path.filter(|(stamp, _)| within(seconds(origin_ns, *stamp)))
        .map(|(_, pose)| pose.position())
        .collect()
}

/// Text of a log as HTML shows it.
fn shown(text: &str) -> String {
    escape(legible(text).as_ref()).into_owned()
}

fn numbers(outcome: &Outcome, suspects: Option<usize>) -> String {
    let of = |kind: Kind, status: Status| {
        let is = |f: &&MapFeature| f.shape.kind() == kind && f.status == status;
        outcome.map.iter().filter(is).count()
    };
    let tentative = outcome.map.iter();
    let tentative = tentative.filter(|f| f.status == Status::Tentative).count();
    let labels = ["contact", "intersection", "circle"].map(|label| outcome.labelled(label));
    let labels: u64 = labels.iter().sum();
    let pillars = of(Kind::Circle, Status::Confirmed);
    let pillars = (pillars > 0).then(|| (pillars.to_string(), "pillars", false));
    let none = || "-".to_owned();
    let share = Bits::of(outcome).map_or_else(none, |bits| {
        format!("{:.1} %", 100.0 * fraction(bits.explained, bits.arcs))
    });
    let mut html = String::from("<div class=\"numbers\">");
    let numbers = [
        (
            of(Kind::Line, Status::Confirmed).to_string(),
            "walls",
            false,
        ),
        (
            of(Kind::Point, Status::Confirmed).to_string(),
            "corners",
            false,
        ),
        (tentative.to_string(), "tentative", false),
        (labels.to_string(), "labels", false),
        (
            suspects.map_or_else(none, |count| count.to_string()),
            "suspect",
            suspects > Some(0),
        ),
        (share, "of the arcs explained", false),
    ];
    for (number, name, is_bad) in numbers.into_iter().chain(pillars) {
        let class = if is_bad { " class=\"bad\"" } else { "" };
        let _ = write!(html, "<div{class}><b>{number}</b>{name}</div>");
    }
    html.push_str("</div>\n");
    html
}

fn table_of_suspects(suspects: &[&ArcReport], setting: &Setting<'_>) -> String {
    if setting.config.method != Method::Tmam {
        return format!(
            "<h2>Suspects</h2>\n<p>Not looked for: method {} has no map that predicts labels.</p>\n",
            setting.config.method.name()
        );
    }
    if suspects.is_empty() {
        return "<h2>Suspects</h2>\n<p>The map and the readings were held against every label; none is \
                contradicted.</p>\n"
            .to_owned();
    }
    // Under the paper's rule another map than that of the page predicts.
    let names = setting.config.rule == Rule::NoiseAware;
    let listed = suspects.len().min(MOST_ROWS);
    let mut html = format!(
        "<h2>Suspects: the worst {listed} of {}</h2>\n<div class=\"wide\"><table><tr><th class=\"n\">frame</th>\
         <th class=\"n\">time s</th><th>sonar</th><th>taken for a</th><th>but</th>{}<th>what decided</th></tr>\n",
        suspects.len(),
        if names { "<th>there is</th>" } else { "" }
    );
    for report in suspects.iter().take(MOST_ROWS) {
        let arc = &report.arc;
        let _ = writeln!(
            html,
            "<tr><td class=\"n\">{}</td><td class=\"n\">{:.2}</td><td>{}</td><td>{}</td>\
             <td class=\"words\">{}</td>{}<td class=\"words\">{}</td></tr>",
            arc.id.frame,
            seconds(setting.origin_ns, arc.stamp_ns),
            shown(name_of(setting.sonars, arc.id.sonar)),
            report.label.kind().map_or("", word),
            against(report),
            if names {
                feature_cell(report)
            } else {
                String::new()
            },
            shown(&decision(report, setting.config).unwrap_or_default()),
        );
    }
    html.push_str("</table></div>\n");
    html
}

/// The feature that the map has there, as its id in the picture.
fn feature_cell(report: &ArcReport) -> String {
    let feature = report
        .map
        .and_then(|map| Some((map.support.kind()?, map.feature?)));
    let named = feature.map(|(kind, id)| format!("{} {id}", word(kind)));
    format!("<td>{}</td>", named.unwrap_or_else(|| "-".to_owned()))
}

fn table_of_sonars(setting: &Setting<'_>, outcome: &Outcome) -> String {
    let hearing = Hearing::of_sonars(&outcome.reports, &outcome.map);
    let mut html = String::from("<h2>Sonars</h2>\n<div class=\"wide\"><table><tr><th>sonar</th>");
    for head in [
        "arcs",
        "walls",
        "corners",
        "unidentified",
        "suspect",
        "triples explained",
    ] {
        let _ = write!(html, "<th class=\"n\">{head}</th>");
    }
    html.push_str("</tr>\n");
    for (sonar, id) in setting.sonars.iter().zip(0..) {
        let id = SonarId(id);
        let of_sonar = || outcome.reports.iter().filter(|r| r.arc.id.sonar == id);
        let labelled = |label| of_sonar().filter(|r| r.label == label).count();
        let (contact, intersection) = (labelled(Label::Contact), labelled(Label::Intersection));
        let arcs = of_sonar().count();
        let suspects = of_sonar().filter(|r| r.is_suspect()).count();
        let explained = hearing.get(&id).map_or_else(
            || "-".to_owned(),
            |heard| format!("{:.0} %", 100.0 * fraction(heard.explained, heard.triples)),
        );
        let _ = write!(html, "<tr><td>{}</td>", shown(&sonar.name));
        let counts = [
            arcs,
            contact,
            intersection,
            of_sonar().filter(|r| r.label.kind().is_none()).count(),
            suspects,
        ];
        for cell in counts
            .map(|count| count.to_string())
            .iter()
            .chain([&explained])
        {
            let _ = write!(html, "<td class=\"n\">{cell}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str(
        "</table></div>\n<p class=\"facts\">triples explained: those around which a wall or a corner explains the \
         readings</p>\n",
    );
    html
}

fn commands(named: &str, worst: Option<&ArcReport>, setting: &Setting<'_>) -> String {
    let mut text = format!("tmam replay {named}              # the recording, frame by frame\n");
    if let Some(worst) = worst {
        let arc = worst.arc.id;
        let sonar = name_of(setting.sonars, arc.sonar);
        let _ = writeln!(
            text,
            "tmam explain {named} --sensor '{sonar}' --frame {}   # the whole story of the worst suspect\n\
             tmam explain {named} --suspects  # all of them",
            arc.frame
        );
    }
    let _ = write!(
        text,
        "tmam info {named}                # what the log holds, and what is wrong with it"
    );
    text
}
