//! What came of replays in JSON, a line for each log.

use serde_json::{Map, Value as Json, json};

use super::replayed::Replayed;
use super::{Failure, Fleet};
use crate::core::rounding::rounded;
use crate::core::tool::Tool;

/// The name and version of the JSON format.
const SCHEMA: &str = "tmam.replayed/1";

impl Fleet<Replayed> {
    /// A line for each log, the worst first.
    pub fn json_lines(&self) -> String {
        let lines = self.0.iter();
        let lines = lines.map(|of| json_line(&of.name, of.result.as_ref()));
        lines.collect()
    }
}

/// What came of the log that is called so.
pub fn json_line(name: &str, result: Result<&Replayed, &Failure>) -> String {
    let (exit, told) = match result {
        Ok(replayed) => (replayed.exit, of_replay(replayed)),
        Err(Failure { exit, text }) => (*exit, json!({ "error": text })),
    };
    let head = json!({
        "schema": SCHEMA,
        "tool": Tool::THIS,
        "log": name,
        "exit_code": exit.code(),
    });
    let parts = [head, told].into_iter();
    let fields = parts.filter_map(|part| part.as_object().cloned()).flatten();
    format!("{}\n", Json::Object(fields.collect::<Map<_, _>>()))
}

fn of_replay(replayed: &Replayed) -> Json {
    let score = &replayed.score;
    let stretch = replayed.stretch.map(|stretch| {
        json!({
            "seconds": stretch.seconds.map(rounded),
            "frames": stretch.frames,
            "arcs": stretch.arcs,
            "explained": rounded(stretch.explained),
            "elsewhere": rounded(stretch.elsewhere),
            "delay": stretch.delay.map(|(delay, _)| rounded(delay)),
            "by_odometry": stretch.by_odometry,
        })
    });
    let truth = score.truth.as_ref().map(|truth| {
        json!({
            "wrong": truth.wrong,
            "missed": truth.missed,
            "spurious": truth.spurious,
            "twice": truth.twice,
        })
    });
    json!({
        "seconds": rounded(replayed.seconds),
        "sonars": replayed.sonars,
        "frames": score.frames,
        "arcs": score.arcs,
        "contact": score.contact,
        "intersection": score.intersection,
        "suspects": score.suspects,
        "explained": score.explained,
        "bits": score.bits.map(rounded),
        "lines": score.lines,
        "points": score.points,
        "causes": replayed.causes,
        "stretch": stretch,
        "truth": truth,
        "problems": replayed.problems.lines().collect::<Vec<_>>(),
    })
}
