//! The triple widened: how many readings to either side it takes to tell a line from a point.

use std::collections::VecDeque;

use super::arc::{Arc, ArcId};
use super::hypothesis::{Gate, HypothesisTest, Support};
use super::label::Kind;
use super::oblique::ObliqueWall;
use crate::core::config;

/// What the windows around an arc came to.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowResult {
    /// The arc in the middle.
    pub arc: ArcId,
    /// The test of the last window that was looked at; `None` where the arc has no neighbour on one side.
    pub test: Option<HypothesisTest>,
    /// The readings of that window, where they decided: `k-m ..= k+m`.
    pub readings: Vec<Arc>,
    /// Where neither a line nor a point explains them: the rough wall that explains them and those before
    /// them at an angle.
    pub oblique: Option<ObliqueWall>,
    /// How far the chi2 of some window looked at is from another outcome; `None` where there is no
    /// test, or no other outcome is near.
    pub margin: Option<f64>,
}

/// What the windows so far, which did not end the search, lacked to end it, as chi2.
#[derive(Debug, Clone, Copy)]
struct Lacking {
    /// To decide for a line.
    line: f64,
    /// To decide for a point.
    point: f64,
    /// To find that neither explains the readings.
    neither: f64,
}

/// An arc whose window still grows.
#[derive(Debug, Clone)]
struct Growing {
    /// Its place in the stretch, counted from the stretch's first arc.
    at: usize,
    /// The test of the widest window so far.
    test: Option<HypothesisTest>,
    done: bool,
    decided: bool,
    oblique: Option<ObliqueWall>,
    lacking: Lacking,
    margin: f64,
    /// Where circles are asked for: the first test that decided for a point, and the margin of that. Wider windows
    /// may still tell a circle.
    point: Option<(HypothesisTest, f64)>,
}

impl Lacking {
    const NOTHING_SEEN: Self = Self {
        line: f64::INFINITY,
        point: f64::INFINITY,
        neither: f64::INFINITY,
    };
}

/// Widens the triples of one sonar's unbroken stretch of readings.
///
/// The window of arc k is `k-m ..= k+m`. It widens from the triple on, until a line or a point
/// alone explains its readings, neither does, or there are no more of them.
#[derive(Debug, Clone, Default)]
pub struct AdaptiveWindow {
    /// The newest arcs of the stretch.
    arcs: VecDeque<Arc>,
    /// The place of the first of them in the stretch.
    first: usize,
    growing: VecDeque<Growing>,
}

impl AdaptiveWindow {
    /// Takes the stretch's next arc, with the test of the triple that it completes where that was
    /// made; gives the arcs that are settled now, in order.
    pub fn push(
        &mut self,
        arc: Arc,
        triple: Option<HypothesisTest>,
        bounds: &config::TestBounds,
        circles: bool,
        gate: &Gate,
    ) -> Vec<WindowResult> {
        let newest = self.first + self.arcs.len();
        self.arcs.push_back(arc);
        self.arcs.make_contiguous();
        self.growing.push_back(Growing {
            at: newest,
            test: None,
            done: false,
            decided: false,
            oblique: None,
            lacking: Lacking::NOTHING_SEEN,
            margin: f64::INFINITY,
            point: None,
        });
        let mut growing = std::mem::take(&mut self.growing);
        for one in growing.iter_mut().filter(|one| !one.done) {
            self.widen(one, newest, triple, bounds, circles, gate);
        }
        self.growing = growing;
        let settled = self.settled(|one| one.done);
        self.forget(bounds.max_half_width);
        settled
    }

    /// The stretch has ended: settles what still grows.
    pub fn end(&mut self) -> Vec<WindowResult> {
        let settled = self.settled(|_| true);
        *self = Self::default();
        settled
    }

    /// Looks at the window that the newest arc completes.
    fn widen(
        &self,
        one: &mut Growing,
        newest: usize,
        triple: Option<HypothesisTest>,
        bounds: &config::TestBounds,
        circles: bool,
        gate: &Gate,
    ) {
        let half = newest - one.at;
        if half == 0 {
            return;
        }
        if half > one.at || half > bounds.max_half_width {
            one.done = true;
            return;
        }
        let triple = triple.filter(|_| half == 1);
        let test = triple.unwrap_or_else(|| {
            HypothesisTest::with_circles(circles, self.window(one.at, half), gate)
        });
        one.done = test.is_final(bounds.decisive);
        if test.support == Support::Neither && one.done && one.point.is_none() {
            // The last reading is the newest there is: the stretch before it tells more.
            let width = 2 * half + 1;
            one.oblique = ObliqueWall::behind(self.stretch(), width, gate, bounds.decisive);
        }
        let (gate, least) = (test.gate, test.chi2_line.min(test.chi2_point));
        let kind = test.decided(bounds.decisive);
        one.decided = kind.is_some();
        let [line, point] =
            [Kind::Line, Kind::Point].map(|kind| test.beyond(kind, bounds.decisive));
        let before = one.lacking;
        one.lacking = Lacking {
            line: before.line.min(-line),
            point: before.point.min(-point),
            neither: before.neither.min(gate - least),
        };
        one.margin = match kind {
            Some(Kind::Line) => line.min(before.point).min(before.neither),
            Some(Kind::Point) => point.min(before.line).min(before.neither),
            Some(Kind::Circle) => test.beyond(Kind::Circle, bounds.decisive),
            None => {
                let nearest = one.lacking.line.min(one.lacking.point);
                let could_grow = half < one.at && half < bounds.max_half_width;
                // With a wider gate the search would have gone on, to whatever end.
                if one.done && could_grow {
                    nearest.min(least - gate)
                } else {
                    nearest
                }
            }
        };
        one.test = Some(test);
        one.point = match kind {
            Some(Kind::Circle) => None,
            Some(Kind::Point) if circles => one.point.or(Some((test, one.margin))),
            _ => one.point,
        };
        if let Some((_, margin)) = one.point {
            (one.decided, one.margin) = (true, margin);
        }
    }

    /// The newest arcs, which lie side by side.
    fn stretch(&self) -> &[Arc] {
        self.arcs.as_slices().0
    }

    fn window(&self, at: usize, half: usize) -> &[Arc] {
        let from = (at - half).saturating_sub(self.first);
        let newest = self.stretch().get(from..).unwrap_or_default();
        newest.get(..2 * half + 1).unwrap_or(newest)
    }

    fn settled(&mut self, may_go: impl Fn(&Growing) -> bool) -> Vec<WindowResult> {
        let mut settled = Vec::new();
        while let Some(one) = self.growing.pop_front_if(|one| may_go(one)) {
            let Some(arc) = self.arcs.get(one.at - self.first) else {
                continue;
            };
            // What turned out to be no circle is the point that it was.
            let test = one.point.map(|(test, _)| test).or(one.test);
            let deciding = test.filter(|_| one.decided);
            let readings = deciding.map(|test| self.window(one.at, test.half_width()).to_vec());
            settled.push(WindowResult {
                arc: arc.id,
                test,
                readings: readings.unwrap_or_default(),
                oblique: one.oblique,
                margin: Some(one.margin).filter(|margin| test.is_some() && margin.is_finite()),
            });
        }
        settled
    }

    /// Forgets arcs that no window can reach any more.
    fn forget(&mut self, max_half_width: usize) {
        let oldest = self.growing.front().map_or(self.first, |one| one.at);
        let needed = oldest.saturating_sub(max_half_width);
        while self.first < needed && self.arcs.pop_front().is_some() {
            self.first += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::{Pose2, Vec2, unit};
    use crate::core::tmam::fit::testing::Gauss;

    const GATE: f64 = 6.63;

    /// What becomes of a stretch of noisy arcs along a wall with a corner in front of its end.
    fn kinds(seed: u64, decisive: f64, gate: f64) -> Vec<Became> {
        let (mut noise, gate) = (Gauss::new(seed), Gate::new(gate));
        let bounds = config::TestBounds {
            decisive,
            ..config::TestBounds::default()
        };
        let mut widening = AdaptiveWindow::default();
        let mut settled = Vec::new();
        for frame in 0..24_u32 {
            let sensor = Vec2::new(f64::from(frame) * 0.1, 0.0);
            let wall = 2.0 - unit(1.6).dot(&sensor);
            let range = if frame < 12 {
                wall
            } else {
                (Vec2::new(1.8, 1.9) - sensor).norm()
            };
            let arc = Arc {
                id: ArcId {
                    frame,
                    sonar: SonarId(0),
                },
                stamp_ns: 0,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, 1.6),
                range: range + 0.003 * noise.sample(),
                beam_width: 0.5,
                variance: 9e-6,
            };
            settled.extend(widening.push(arc, None, &bounds, false, &gate));
        }
        settled.extend(widening.end());
        let became = |window: &WindowResult| Became {
            kind: window.test.and_then(|test| test.decided(decisive)),
            margin: window.margin,
            test: window.test,
        };
        settled.iter().map(became).collect()
    }

    struct Became {
        kind: Option<Kind>,
        margin: Option<f64>,
        test: Option<HypothesisTest>,
    }

    /// The gate with one degree of freedom, moved so far that no gate for so many readings or fewer
    /// moves by more than `by`.
    fn moved(by: f64, readings: usize) -> f64 {
        let at = |gate: f64| {
            let gate = Gate::new(gate);
            (1..=readings - 2).map(move |freedom| gate.at(freedom))
        };
        let most = |to: f64| {
            let pairs = at(GATE).zip(at(to));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (mut within, mut beyond) = (0.0, 1.0);
        for _ in 0..40 {
            let share = (within + beyond) / 2.0;
            if most(GATE + share * by) <= by.abs() {
                within = share;
            } else {
                beyond = share;
            }
        }
        GATE + within * by
    }

    #[test]
    fn nothing_within_the_margin_changes_a_label_and_something_beyond_it_does() {
        let (decisive, mut held, mut changed) = (13.0, 0, 0);
        for seed in 1..12 {
            let all = kinds(seed, decisive, GATE);
            for (at, Became { kind, margin, .. }) in all.iter().enumerate() {
                let Some(margin) = *margin else { continue };
                assert!(margin >= 0.0, "{margin}");
                for moved in [-margin, margin] {
                    let by = |share: f64| kinds(seed, decisive + share * moved, GATE)[at].kind;
                    assert_eq!(by(0.999), *kind, "seed {seed}, arc {at}, margin {margin}");
                    held += 1;
                    changed += u32::from(by(1.001) != *kind);
                }
            }
        }
        assert!(held > 200 && changed > 10, "{held} held, {changed} changed");
    }

    #[test]
    fn a_search_that_ended_because_neither_explained_is_as_far_from_a_label_as_from_going_on() {
        let (decisive, mut held, mut changed) = (13.0, 0, 0);
        for seed in 1..150 {
            let all = kinds(seed, decisive, GATE);
            for (at, one) in all.iter().enumerate() {
                let neither = |test: &HypothesisTest| test.support == Support::Neither;
                let (Some(test), Some(margin)) = (one.test.filter(neither), one.margin) else {
                    continue;
                };
                for by in [-margin.min(0.9 * GATE), margin] {
                    let becomes = |share: f64| {
                        let gate = moved(share * by, test.readings);
                        kinds(seed, decisive, gate)[at].kind
                    };
                    assert_eq!(becomes(0.999), None, "seed {seed}, arc {at}, by {by}");
                    held += 1;
                    changed += u32::from(becomes(1.001).is_some());
                }
            }
        }
        assert!(held > 200 && changed > 0, "{held} held, {changed} changed");
    }
}
