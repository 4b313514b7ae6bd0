//! What the recording is: the page that says it and how to read it, and how the event log begins.

use std::fmt::Write as _;

use rerun::TextDocument;
use rerun::components::TextLogLevel;

use super::plane::PlaneOrigin;
use crate::core::config::Method;
use crate::core::observer::Setting;
use crate::core::wording::counted;
use crate::io::config::render::render;

/// The about page; `overlay` says what is drawn over the run.
pub fn page(setting: &Setting<'_>, overlay: &str, origin: PlaneOrigin) -> TextDocument {
    let (source, method) = (setting.source, setting.config.method);
    let seconds = (source.end_ns.saturating_sub(source.start_ns)) as f64 * 1e-9;
    let mut text = format!(
        "# {file}\n\n\
         {what} over a sonar log: \
         which arcs were taken for walls, which for points, and why.\n\n\
         | | |\n|---|---|\n\
         | log | `{file}`{state} |\n\
         | stamps | {start} ns to {end} ns ({seconds:.1} s) |\n\
         | messages used | {messages} |\n\
         | sonars | {count} |\n\
         | made by | tmam {version} |\n{shifted}\n",
        file = source.file,
        what = match method {
            Method::Tmam => "Every step of the three measurements association model (TMAM)".to_owned(),
            rival => format!("Every step of the method `{}`, for comparison with TMAM,", rival.name()),
        },
        state = if source.complete {
            ""
        } else {
            " - **incomplete or damaged: this is what could be read of it**"
        },
        start = source.start_ns,
        end = source.end_ns,
        messages = source.messages,
        count = setting.sonars.len(),
        version = env!("CARGO_PKG_VERSION"),
        shifted = origin.shift().map_or_else(String::new, |at| {
            format!(
                "| origin | **{}, {}** m in the odometry frame: add it to all places in the map here. A \
                 recording holds seven digits of a place, and the robot started that far out |\n",
                at.x, at.y
            )
        }),
    );
    // Writing to a string cannot fail.
    for loss in source.lost.iter().take(20) {
        let _ = writeln!(text, "- lost: {loss}");
    }
    text.push_str(overlay);
    text.push_str(if method != Method::Tmam {
        RIVAL
    } else if setting.config.departures().label_by_opinion {
        NOISE_AWARE
    } else {
        PAPER
    });
    text.push_str(HOW_TO_READ);
    let _ = write!(
        text,
        "\n## Configuration\n\n```toml\n{}```\n",
        render(setting.config)
    );
    text.push_str(
        "\n## Sonars\n\n| | name | topic | x, m | y, m | yaw, deg |\n|---|---|---|---|---|---|\n",
    );
    for (i, sonar) in setting.sonars.iter().enumerate() {
        let mount = sonar.robot_from_sensor;
        let _ = writeln!(
            text,
            "| {i} | {} | `{}` | {:.3} | {:.3} | {:.1} |",
            sonar.name,
            sonar.topic,
            mount.x,
            mount.y,
            mount.yaw.to_degrees()
        );
    }
    TextDocument::from_markdown(text)
}

const NOISE_AWARE: &str = include_str!("about_noise_aware.md");
const RIVAL: &str = include_str!("about_rival.md");
const PAPER: &str = include_str!("about_paper.md");
const HOW_TO_READ: &str = include_str!("about.md");

/// What the log says of the source.
pub fn opening(setting: &Setting<'_>) -> Vec<(&'static str, String)> {
    let source = setting.source;
    let start = format!(
        "start: {}, {}, {}",
        source.file,
        counted(setting.sonars.len() as u64, "sonar"),
        counted(source.messages, "message")
    );
    let mut said = vec![(TextLogLevel::INFO, start)];
    if !source.complete {
        let lost = source.lost.first().map_or("", String::as_str);
        let text = match source.lost.len() {
            0 | 1 => format!("the log is incomplete or damaged: {lost}"),
            n => format!("the log is incomplete or damaged in {n} places, first {lost}"),
        };
        said.push((TextLogLevel::WARN, text));
    }
    said
}
