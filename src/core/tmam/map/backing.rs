//! Who stands behind a feature of the map: which sonars saw it, and on how many visits.

use std::collections::BTreeSet;

use crate::core::event::SonarId;
use crate::core::tmam::arc::Arc;

/// A sonar that sees a feature again after as long a time is on another visit, nanoseconds.
const VISIT: i64 = 20_000_000_000;

/// The sonars that saw a feature, and when.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Backing {
    sonars: BTreeSet<SonarId>,
    visits: u32,
    last_ns: i64,
}

impl Backing {
    /// Of the readings of one run.
    pub fn of(associated: &[Arc]) -> Self {
        Self {
            sonars: associated.iter().map(|arc| arc.id.sonar).collect(),
            visits: 1,
            last_ns: associated.last().map_or(0, |arc| arc.stamp_ns),
        }
    }

    /// Takes another run, or another feature's.
    pub fn join(&mut self, other: &Self) {
        let is_another = other.last_ns.saturating_sub(self.last_ns).saturating_abs() > VISIT;
        self.sonars.extend(&other.sonars);
        self.visits = self.visits.max(other.visits) + u32::from(is_another && self.visits > 0);
        self.last_ns = self.last_ns.max(other.last_ns);
    }

    /// The sonar that alone saw it, on one visit.
    pub fn alone(&self) -> Option<SonarId> {
        let sonar = self.sonars.first().copied();
        sonar.filter(|_| self.sonars.len() == 1 && self.visits <= 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::fit::testing::arc;

    fn run(sonar: u16, seconds: i64) -> Backing {
        let mut arc = arc(0, Vec2::zeros(), 0.0, 1.0);
        arc.id.sonar = SonarId(sonar);
        arc.stamp_ns = seconds * 1_000_000_000;
        Backing::of(&[arc; 3])
    }

    #[test]
    fn another_sonar_or_another_visit_agrees() {
        let joined = |runs: &[Backing]| {
            let mut all = Backing::default();
            runs.iter().for_each(|run| all.join(run));
            all.alone()
        };
        assert_eq!(joined(&[run(3, 0)]), Some(SonarId(3)));
        assert_eq!(
            joined(&[run(3, 0), run(3, 5), run(3, 20)]),
            Some(SonarId(3))
        );
        assert_eq!(joined(&[run(3, 0), run(3, 21)]), None, "another visit");
        assert_eq!(joined(&[run(3, 0), run(4, 0)]), None, "another sonar");
    }
}
