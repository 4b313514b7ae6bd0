//! What a table says of a log that was replayed, and of one that was held against the truth.

use super::{Summary, off};
use crate::core::exit::Exit;
use crate::core::observer::Setting;
use crate::core::pattern::is_chosen;
use crate::core::replay::{CauseTold, Outcome, Stretch};
use crate::core::statistics::{fraction, seconds, share};
use crate::tools::sweep::score::{Score, TruthScore};
use crate::tools::tables::{TableColumn, percent};

/// What came of a replay.
#[derive(Debug)]
pub struct Replayed {
    pub exit: Exit,
    /// What a person should know of the log.
    pub problems: String,
    /// From the first reading to the last.
    pub seconds: f64,
    /// Those that were chosen.
    pub sonars: usize,
    pub score: Score,
    /// What is off; `None` where that was not looked for.
    pub causes: Option<Vec<CauseTold>>,
    /// The stretch in which something was off.
    pub stretch: Option<Stretch>,
}

impl Replayed {
    /// Of a replay that came to its end.
    pub fn new(
        setting: &Setting<'_>,
        outcome: &Outcome,
        truth: Option<TruthScore>,
        problems: String,
    ) -> Self {
        let source = setting.source;
        let asked = &setting.config.input.sonars;
        let sonars = setting.sonars.iter();
        Self {
            exit: Exit::of_whole(source.complete && outcome.tally.echoes > 0),
            problems,
            seconds: seconds(source.start_ns, source.end_ns),
            sonars: sonars.filter(|it| is_chosen(asked, &it.name)).count(),
            score: Score::new(outcome, truth),
            causes: outcome.causes.clone(),
            stretch: outcome.stretch,
        }
    }

    /// What the table has of it.
    pub const COLUMNS: [TableColumn<'static, Self>; 8] = [
        ("s", &|of| format!("{:.1}", of.seconds)),
        ("sonars", &|of| of.sonars.to_string()),
        ("arcs", &|of| of.score.arcs.to_string()),
        ("labelled\n%", &|of| {
            percent(share(of.score.labelled(), of.score.arcs))
        }),
        ("suspects", &|of| {
            let suspects = of.score.suspects;
            suspects.map_or_else(|| "-".to_owned(), |count| count.to_string())
        }),
        ("explained\n%", &|of| {
            let explained = of.score.explained;
            percent(explained.and_then(|explained| share(explained, of.score.arcs)))
        }),
        ("map", &|of| {
            (of.score.lines + of.score.points + of.score.circles).to_string()
        }),
        ("what is off", &|of| {
            off(of.causes.as_deref(), of.stretch.as_ref())
        }),
    ];

    /// What the table has of it where the truth is known.
    pub const AGAINST_TRUTH: [TableColumn<'static, Self>; 8] = [
        ("s", &|of| format!("{:.1}", of.seconds)),
        ("arcs", &|of| of.score.arcs.to_string()),
        ("labelled\n%", &|of| {
            percent(share(of.score.labelled(), of.score.arcs))
        }),
        ("wrong\nlabels", &|of| of.truth(|truth| truth.wrong)),
        ("map", &|of| {
            (of.score.lines + of.score.points + of.score.circles).to_string()
        }),
        ("missed", &|of| of.truth(|truth| truth.missed)),
        ("spurious", &|of| of.truth(|truth| truth.spurious)),
        ("twice", &|of| of.truth(|truth| truth.twice)),
    ];

    fn truth(&self, of: fn(&TruthScore) -> u64) -> String {
        let truth = self.score.truth.as_ref();
        truth.map_or_else(|| "-".to_owned(), |truth| of(truth).to_string())
    }
}

/// Worse is what is wrong with the map and the labels, where the truth is known; else what has more causes, more
/// suspects, or a map that explains less.
impl Summary for Replayed {
    fn exit(&self) -> Exit {
        self.exit
    }

    fn badness(&self) -> [f64; 3] {
        let score = &self.score;
        if let Some(truth) = &score.truth {
            let wrong = fraction(truth.wrong, score.labelled());
            return [truth.map_errors() as f64, wrong, 0.0];
        }
        let causes = self.causes.as_ref().map_or(0, Vec::len) + usize::from(self.stretch.is_some());
        let suspects = fraction(score.suspects.unwrap_or_default(), score.labelled());
        let explained = fraction(score.explained.unwrap_or_default(), score.arcs);
        [causes as f64, suspects, -explained]
    }

    fn problems(&self) -> &str {
        &self.problems
    }
}
