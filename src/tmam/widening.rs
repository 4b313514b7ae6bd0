//! The triple widened: how many readings to either side it takes to tell a line from a point.

use std::collections::VecDeque;

use super::arc::{Arc, ArcId};
use super::opinion::{Gate, Opinion};
use crate::config;

/// What the readings around an arc support, from as few of them as it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Wide {
    /// The arc in the middle.
    pub arc: ArcId,
    /// The opinion on the widest window that was looked at; `None` where the arc has no neighbour
    /// on one side.
    pub opinion: Option<Opinion>,
    /// The readings of that window, where they decided: `k-m ..= k+m`.
    pub window: Vec<Arc>,
}

/// An arc whose window still grows.
#[derive(Debug, Clone, Copy)]
struct Growing {
    /// Its place in the stretch, counted from the stretch's first arc.
    at: usize,
    opinion: Option<Opinion>,
    done: bool,
    decided: bool,
}

/// Widens the triples of one sonar's unbroken stretch of readings.
///
/// The window of arc k is `k-m ..= k+m`. It widens from the triple on, until a line or a point
/// alone explains its readings, neither does, or there are no more of them.
#[derive(Debug, Clone, Default)]
pub struct Widening {
    /// The newest arcs of the stretch.
    arcs: VecDeque<Arc>,
    /// The place of the first of them in the stretch.
    first: usize,
    growing: VecDeque<Growing>,
}

impl Widening {
    /// Takes the stretch's next arc; gives the arcs that are settled now, in order.
    pub fn push(&mut self, arc: Arc, bounds: &config::Opinion, gate: &Gate) -> Vec<Wide> {
        let newest = self.first + self.arcs.len();
        self.arcs.push_back(arc);
        self.growing.push_back(Growing {
            at: newest,
            opinion: None,
            done: false,
            decided: false,
        });
        let mut growing = std::mem::take(&mut self.growing);
        for one in growing.iter_mut().filter(|one| !one.done) {
            self.widen(one, newest, bounds, gate);
        }
        self.growing = growing;
        let settled = self.settled(|one| one.done);
        self.forget(bounds.max_half_width);
        settled
    }

    /// The stretch has ended: settles what still grows.
    pub fn end(&mut self) -> Vec<Wide> {
        let settled = self.settled(|_| true);
        *self = Self::default();
        settled
    }

    /// Looks at the window that the newest arc completes.
    fn widen(&self, one: &mut Growing, newest: usize, bounds: &config::Opinion, gate: &Gate) {
        let half = newest - one.at;
        if half == 0 {
            return;
        }
        if half > one.at || half > bounds.max_half_width {
            one.done = true;
            return;
        }
        let window = self.window(one.at, half);
        let opinion = Opinion::of(&window, gate);
        one.decided = opinion.decided(bounds.decisive).is_some();
        one.done =
            one.decided || opinion.chi2_line.min(opinion.chi2_point) >= gate.at(window.len() - 2);
        one.opinion = Some(opinion);
    }

    fn window(&self, at: usize, half: usize) -> Vec<Arc> {
        let from = (at - half).saturating_sub(self.first);
        self.arcs
            .iter()
            .skip(from)
            .take(2 * half + 1)
            .copied()
            .collect()
    }

    fn settled(&mut self, may_go: impl Fn(&Growing) -> bool) -> Vec<Wide> {
        let mut settled = Vec::new();
        while let Some(one) = self.growing.pop_front_if(|one| may_go(one)) {
            let Some(arc) = self.arcs.get(one.at - self.first) else {
                continue;
            };
            let half = one.opinion.map_or(0, |opinion| opinion.readings / 2);
            settled.push(Wide {
                arc: arc.id,
                opinion: one.opinion,
                window: if one.decided {
                    self.window(one.at, half)
                } else {
                    Vec::new()
                },
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
