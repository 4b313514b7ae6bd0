//! What a table says of a log that was looked into.

use super::{Summary, off};
use crate::core::exit::Exit;
use crate::core::statistics::seconds;
use crate::tools::findings::finding::{Finding, Weight};
use crate::tools::findings::trial::Replayable;
use crate::tools::info::Info;
use crate::tools::tables::TableColumn;

impl Info {
    /// What the table has of a log.
    pub const COLUMNS: [TableColumn<'static, Self>; 7] = [
        ("s", &|of| {
            let source = &of.facts.source;
            format!("{:.1}", seconds(source.start_ns, source.end_ns))
        }),
        ("messages", &|of| of.facts.source.messages.to_string()),
        ("sonars", &|of| of.facts.sonars.len().to_string()),
        ("replay", &|of| {
            possible(of.facts.replay.possible).to_owned()
        }),
        ("findings", &|of| of.findings.len().to_string()),
        ("the weightiest", &|of| {
            let first = of.findings.first();
            first.map_or("-", |finding| finding.code).to_owned()
        }),
        ("what is off", &|of| off(of.causes.as_deref(), of.stretch())),
    ];
}

fn possible(replay: Replayable) -> &'static str {
    match replay {
        Replayable::Yes => "yes",
        Replayable::InPart => "in part",
        Replayable::WithSkeleton => "with keys",
        Replayable::No => "no",
    }
}

/// Worse is what has more findings of the weightiest kind.
impl Summary for Info {
    fn exit(&self) -> Exit {
        Exit::of_whole(self.is_fine())
    }

    fn badness(&self) -> [f64; 3] {
        let count = |weight| {
            let is_it = |finding: &&Finding| finding.weight == weight;
            self.findings.iter().filter(is_it).count() as f64
        };
        [Weight::Blocking, Weight::Serious, Weight::Notable].map(count)
    }

    fn problems(&self) -> &str {
        ""
    }
}
