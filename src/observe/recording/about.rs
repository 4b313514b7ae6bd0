//! The page that says what the recording is and how to read it.

use std::fmt::Write as _;

use rerun::TextDocument;

use super::plane::Origin;
use crate::core::observer::Setting;
use crate::io::config::render::render;

/// The about page; `overlay` says what is drawn over the run.
pub fn page(setting: &Setting<'_>, overlay: &str, origin: Origin) -> TextDocument {
    let source = setting.source;
    let seconds = (source.end_ns.saturating_sub(source.start_ns)) as f64 * 1e-9;
    let mut text = format!(
        "# {file}\n\n\
         Every step of the three measurements association model (TMAM) over a sonar log: \
         which arcs were taken for walls, which for points, and why.\n\n\
         | | |\n|---|---|\n\
         | log | `{file}`{state} |\n\
         | stamps | {start} ns to {end} ns ({seconds:.1} s) |\n\
         | messages used | {messages} |\n\
         | sonars | {count} |\n\
         | made by | tmam {version} |\n{shifted}\n",
        file = source.file,
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

const HOW_TO_READ: &str = "\
## How to read it

**Map** - seen from above, x to the right, y up, metres. Drag the time cursor to see the run frame by frame.

| colour | what |
|---|---|
| blue | contact: arcs taken for a wall, and where common tangents touch them |
| orange | intersection: arcs taken for a point, and where neighbours cross them |
| grey | unidentified arcs |
| white | walls of the map so far |
| pale yellow | points of the map so far |
| grey, in the map | features that too little speaks for (noise-aware rule): tentative |
| lime, wide | suspects: arcs whose label is contradicted; select one to see by what |
| violet | three standard deviations of map features, at true scale: thin where the map is sure |
| red | a feature that was extracted and rejected |
| green | the robot, its heading and its way so far |

Point at an arc to read what it was judged by. Select it, and the selection panel (top right) lists its evidence: both angles and chi2 with what they say, the widest window, its run and the feature of that, what the map says, and whether it is a suspect. All are named as in the trace.

A feature flashes bold, with the arcs of its run, in the frame in which its run closed: the frame after the first reading that no longer belongs to it.

**theta_c, theta_i** - a dot per sonar and frame, radians. A small theta_c says wall, a small theta_i says point; both must lie below gamma, the red line. Dots at the full beam width are triples without common points. No dot: the arc is not the middle of a triple.

**chi2** (behind the angles, as tabs) - how badly a line, or a point, fits the three readings of a triple, in squares of sigma. Below the gate, the red line, it explains them. Both low: too short a base line for the noise to tell. Values beyond the plot are off its top.

**Labels** - a lane per sonar. Blue is contact, orange intersection; else a letter and a shade say why there is no label:

| | shade | unidentified because |
|---|---|---|
| `a` | light grey | ambiguous: line and point cannot be told apart |
| `n` | brown | neither: no line and no point fits, the readings come from different targets |
| `o` | olive | oblique: no line and no point fits, but a rough wall that is seen at an angle does |
| `w` | grey | wide: the smaller angle is not below gamma (paper's rule) |
| `p` | dark grey | no-points: the arcs touch and cross nowhere inside the beams (paper's rule) |
| `t` | dark green | turning: the robot turned, or its path bent, between the readings |
| `m` | black | missing: no echo before or after it |
| `g` | violet black | gap: the reading before or after is too far away in time or distance |

A label holds until the sonar's next reading; a gap is a reading without echo. A dark stretch that says `n states` holds that many labels too short to draw: zoom in, or see the tab **Labels by sonar number**, which has them as dots: contact above, intersection on, unidentified below the line of the sonar's number (the numbers are those of the table of sonars below).

**Events** - a line per closed run: what was fitted and what became of it. Warnings are fits that were not used, and suspects.

**For programs** there are the features file and the labels of the run in it, as text: `/run/features`, `/run/labels`. `tmam diff A.rrd B.rrd` compares them.
";
