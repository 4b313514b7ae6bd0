//! How good a result is, in a few numbers that can be held against those of another version.

use serde::{Deserialize, Serialize};

use crate::core::bits::Bits;
use crate::core::replay::Outcome;
use crate::core::rounding::micro;
use crate::core::statistics::fraction;

/// How good a result is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// Confirmed lines of the map.
    pub walls: u64,
    /// Confirmed points of the map.
    pub points: u64,
    /// Confirmed circles of the map, where it has any or they were looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub circles: Option<u64>,
    pub arcs: u64,
    /// Arcs with a label.
    pub labelled: u64,
    /// Labels that the map or the readings contradict; not known by other methods than TMAM, whose maps do not
    /// say what should have echoed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suspects: Option<u64>,
    /// Share of the arcs that the map explains; known as the suspects are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explained: Option<f64>,
    /// Share of the labels that are wrong, where the log carries the truth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wrong_labels: Option<f64>,
    /// Mean normalised error squared of the map's features, per degree of freedom, where the log carries the
    /// truth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nees: Option<f64>,
}

/// Whether a result got better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Trend {
    Better,
    Worse,
    /// Some of it better, some worse.
    Mixed,
    /// As good as it was.
    Same,
}

impl Trend {
    pub fn name(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
            Self::Mixed => "better and worse",
            Self::Same => "as good",
        }
    }
}

impl Quality {
    /// The measures that are shares, from 0 to 1.
    pub const SHARES: [&'static str; 2] = ["explained", "wrong_labels"];

    /// Of a replay whose map has so many confirmed lines, points and circles, where these are `sought`; nothing is
    /// known of the truth.
    pub fn of(outcome: &Outcome, [walls, points, circles]: [u64; 3], sought: bool) -> Self {
        let bits = Bits::of(outcome);
        let labelled = outcome.reports.iter();
        let labelled = labelled.filter(|report| report.label.kind().is_some());
        Self {
            walls,
            points,
            circles: (sought || circles > 0).then_some(circles),
            arcs: outcome.reports.len() as u64,
            labelled: labelled.count() as u64,
            suspects: outcome.suspects,
            explained: bits.map(|bits| micro(fraction(bits.explained, bits.arcs))),
            wrong_labels: None,
            nees: None,
        }
    }

    /// Of several results together.
    pub fn of_all(all: &[Self]) -> Self {
        let sum = |of: fn(&Self) -> u64| all.iter().map(of).sum::<u64>();
        let weighted = |weight: fn(&Self) -> u64, of: fn(&Self) -> Option<f64>| {
            let known = all
                .iter()
                .filter_map(|one| Some((weight(one) as f64, of(one)?)));
            let (weight, sum) = known.fold((0.0, 0.0), |(weights, sum), (weight, value)| {
                (weights + weight, sum + weight * value)
            });
            (weight > 0.0).then(|| sum / weight)
        };
        Self {
            walls: sum(|one| one.walls),
            points: sum(|one| one.points),
            circles: all
                .iter()
                .filter_map(|one| one.circles)
                .reduce(|a, b| a + b),
            arcs: sum(|one| one.arcs),
            labelled: sum(|one| one.labelled),
            suspects: all
                .iter()
                .filter_map(|one| one.suspects)
                .reduce(|a, b| a + b),
            explained: weighted(|one| one.arcs, |one| one.explained),
            wrong_labels: weighted(|one| one.labelled, |one| one.wrong_labels),
            nees: weighted(
                |one| one.walls + one.points + one.circles.unwrap_or_default(),
                |one| one.nees,
            ),
        }
    }

    /// Whether it is better than what was before.
    pub fn trend(&self, before: &Self) -> Trend {
        /// Shares that change by less are as they were.
        const SHARE: f64 = 0.005;
        let labels = |of: &Self| fraction(of.labelled, of.arcs);
        let suspects = |of: &Self| Some(fraction(of.suspects?, of.labelled));
        let fall = |then: Option<f64>, now: Option<f64>| {
            then.zip(now).map_or(0.0, |(then, now)| then - now)
        };
        let right = [
            fall(self.explained, before.explained),
            fall(suspects(before), suspects(self)),
            fall(before.wrong_labels, self.wrong_labels),
        ];
        let more = labels(self) - labels(before);
        let worse = more <= -SHARE || right.iter().any(|gain| *gain <= -SHARE);
        // More labels are no gain where more of them are wrong.
        let better = right.iter().any(|gain| *gain >= SHARE) || more >= SHARE && !worse;
        match (better, worse) {
            (true, true) => Trend::Mixed,
            (true, false) => Trend::Better,
            (false, true) => Trend::Worse,
            (false, false) => Trend::Same,
        }
    }

    /// Its numbers by the names that a suite file gives them.
    pub fn measures(&self) -> [(&'static str, Option<f64>); 9] {
        let count = |count: u64| Some(count as f64);
        [
            ("walls", count(self.walls)),
            ("points", count(self.points)),
            ("circles", count(self.circles.unwrap_or_default())),
            ("arcs", count(self.arcs)),
            ("labelled", count(self.labelled)),
            ("suspects", self.suspects.and_then(count)),
            ("explained", self.explained),
            ("wrong_labels", self.wrong_labels),
            ("nees", self.nees),
        ]
    }

    /// As columns of a table: walls, points, circles, labels, suspects, explained; and wrong labels.
    pub fn columns(&self) -> [String; 7] {
        let none = || "-".to_owned();
        let percent =
            |share: Option<f64>| share.map_or_else(none, |share| format!("{:.1} %", share * 100.0));
        [
            self.walls.to_string(),
            self.points.to_string(),
            self.circles.map_or_else(none, |count| count.to_string()),
            format!("{} of {}", self.labelled, self.arcs),
            self.suspects.map_or_else(none, |count| count.to_string()),
            percent(self.explained),
            percent(self.wrong_labels),
        ]
    }
}

/// `6 -> 5`, or `6` where it stayed.
pub fn from_to(then: &str, now: &str) -> String {
    match then == now {
        true => now.to_owned(),
        false => format!("{then} -> {now}"),
    }
}

/// How good a result was and is, in a line.
pub fn headline(then: &Quality, now: &Quality) -> String {
    let [walls, points, circles, labels, suspects, explained, wrong] = {
        let (then, now) = (then.columns(), now.columns());
        std::array::from_fn(|place| match (then.get(place), now.get(place)) {
            (Some(then), Some(now)) => from_to(then, now),
            _ => String::new(),
        })
    };
    let wrong = match (then.wrong_labels, now.wrong_labels) {
        (None, None) => String::new(),
        _ => format!(", wrong labels {wrong}"),
    };
    let circles = match (then.circles, now.circles) {
        (None, None) => String::new(),
        _ => format!(", circles {circles}"),
    };
    format!(
        "{}: explained {explained}, labelled {labels} arcs, suspects {suspects}{wrong}, walls {walls}, points {points}{circles}",
        now.trend(then).name()
    )
}
