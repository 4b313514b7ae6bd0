//! Tries what may be off: each candidate is applied, the log replayed, and kept where its own map explains
//! it in fewer bits.

use super::candidate::{Candidate, Estimated, Estimates, are_clear};
use super::change::Change;
use super::far_off::{TRIALS, far_off};
use super::parameter::Parameter;
use crate::core::bits::Bits;
use crate::core::config::{Config, Poses};
use crate::core::log::Log;
use crate::core::replay::{Outcome, Replay};
use crate::core::tmam::feature::{Kind, Status};

/// Causes that are looked for, at most.
const MOST_CAUSES: usize = 3;
/// Candidates that are tried for each of them, at most.
const TRIED_EACH: usize = 5;
/// How often a value is estimated anew with itself applied.
const REFINED: usize = 2;
/// What a cause must gain, bits altogether, and per parameter.
const LEAST_GAIN: f64 = 25.0;
const OF_PARAMETER: f64 = 8.0;
/// The same where poses are estimated, bits an arc: a path that settles otherwise gains up to 0.35 by chance.
const LEAST_GAIN_OF_A_PATH: f64 = 0.4;
/// A candidate with such a share of the gain of the best explains the log as well.
const AS_WELL: f64 = 0.9;
/// A candidate that is likelier by such a share of what the first one is explains the same trouble.
const RIVAL: f64 = 0.6;

/// A log of which less than this is explained may have something that is far off.
const TROUBLED: f64 = 0.8;

/// A path at which more than this is explained is what was off.
const WELL: f64 = 0.95;

/// How much is tried, at most: by work and not by time, so that the same log gives the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Replays.
    pub replays: usize,
    /// Arcs in all of them.
    pub arcs: u64,
}

impl Effort {
    /// After each replay, where nobody asked.
    pub const AFTER_REPLAY: Self = Self {
        replays: 15,
        arcs: 200_000,
    };
    /// Where it is asked for.
    pub const THOROUGH: Self = Self {
        replays: 60,
        arcs: 2_000_000,
    };
}

/// How well a replay stands by its own map.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Standing {
    /// How its map explains it.
    pub bits: Bits,
    /// Labels that are contradicted.
    pub suspects: u64,
    /// Confirmed lines and points.
    pub map: [u64; 2],
}

/// What is off, tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// The parameters, with how far they are off.
    pub values: Vec<Estimated>,
    /// Without it, and with it; the causes before it being mended.
    pub standings: [Standing; 2],
    /// What explains the log as well, tried as well.
    pub rivals: Vec<Vec<Estimated>>,
}

/// A log held against its configuration.
#[derive(Debug, Clone)]
pub struct Search {
    /// What is off, the weightiest first.
    pub causes: Vec<Cause>,
    /// All of it together.
    pub change: Change,
    /// As configured, and with all of it.
    pub standings: [Standing; 2],
    /// What the log says with all of it.
    pub estimates: Estimates,
    /// Replays that were made.
    pub replays: usize,
    /// Whether there was more to try than was allowed.
    pub is_cut_short: bool,
}

/// A replay of a changed log.
struct Tried {
    change: Change,
    standing: Standing,
    estimates: Estimates,
    /// Whether poses were estimated.
    is_joint: bool,
}

struct Searcher<'a> {
    log: &'a Log,
    /// With the noise that the ranges have as configured: chi2 compares only so.
    config: Config,
    effort: Effort,
    replays: usize,
    work: u64,
    is_cut_short: bool,
}

impl Standing {
    /// Of a replay.
    pub fn of(outcome: &Outcome) -> Self {
        let confirmed = |kind| {
            let features = outcome.map.iter();
            let of_kind =
                features.filter(|f| f.status == Status::Confirmed && f.shape.kind() == kind);
            of_kind.count() as u64
        };
        Self {
            bits: Bits::of(outcome),
            suspects: outcome.suspects,
            map: [confirmed(Kind::Line), confirmed(Kind::Point)],
        }
    }

    /// Bits that it takes fewer than another one, altogether: the same number of arcs being assumed.
    pub fn gain_over(&self, other: &Self) -> f64 {
        let per_arc = other.bits.per_arc().zip(self.bits.per_arc());
        let arcs = self.bits.arcs.min(other.bits.arcs) as f64;
        per_arc.map_or(0.0, |(other, own)| (other - own) * arcs)
    }
}

/// Looks for what is off. `replay` and `outcome` are those of the log as configured.
pub fn search(replay: &Replay<'_>, outcome: &Outcome, effort: Effort) -> Search {
    let mut searcher = Searcher {
        log: replay.log(),
        config: replay.config().clone(),
        effort,
        replays: 0,
        work: 0,
        is_cut_short: false,
    };
    let first = Standing::of(outcome);
    let mut now = Tried {
        change: Change::default(),
        standing: first,
        estimates: Estimates::new(replay, outcome),
        is_joint: outcome.joint().is_some(),
    };
    let mut causes = Vec::new();
    while causes.len() < MOST_CAUSES {
        let candidates = searcher.candidates(&now);
        if candidates.is_empty() {
            break;
        }
        let Some((cause, then)) = searcher.best(&now, &candidates) else {
            searcher.is_cut_short |= searcher.is_spent();
            break;
        };
        causes.push(cause);
        now = then;
    }
    Search {
        causes,
        change: now.change,
        standings: [first, now.standing],
        estimates: now.estimates,
        replays: searcher.replays,
        is_cut_short: searcher.is_cut_short,
    }
}

impl Searcher<'_> {
    fn is_spent(&self) -> bool {
        self.replays >= self.effort.replays || self.work > self.effort.arcs
    }

    /// Replays the log with a change.
    fn replayed(&mut self, change: Change) -> Option<Tried> {
        if self.is_spent() {
            return None;
        }
        self.replays += 1;
        self.with(&change, |replay, outcome| Tried {
            change: change.clone(),
            standing: Standing::of(outcome),
            estimates: Estimates::new(replay, outcome),
            is_joint: outcome.joint().is_some(),
        })
    }

    /// How well a replay with a change stands.
    fn standing(&mut self, change: &Change) -> Option<Standing> {
        self.with(change, |_, outcome| Standing::of(outcome))
    }

    fn with<T>(
        &mut self,
        change: &Change,
        of: impl FnOnce(&Replay<'_>, &Outcome) -> T,
    ) -> Option<T> {
        let mut log = self.log.clone();
        change.apply(&mut log.events);
        let mut config = self.config.clone();
        change.apply_clocks(&mut config);
        let replay = Replay::new(&log, &config).ok()?;
        let outcome = replay.run(&mut []).ok()?;
        self.work += Bits::of(&outcome).arcs;
        Some(of(&replay, &outcome))
    }

    /// What may be off, the likeliest first. Poses that were estimated have taken a part of what is off for
    /// drift: what the poses of odometry say stands between.
    fn candidates(&mut self, now: &Tried) -> Vec<Candidate> {
        let mut both = self.far_off(now);
        let first = now.estimates.candidates();
        let share = now.standing.bits.explained_share();
        if !now.is_joint || share.is_some_and(|share| share > WELL) {
            both.extend(first);
            return both;
        }
        let poses = std::mem::replace(&mut self.config.poses, Poses::Odometry);
        let by_odometry = self.replayed(now.change.clone());
        self.config.poses = poses;
        let mut second = by_odometry.map_or_else(Vec::new, |tried| tried.estimates.candidates());
        second.reverse();
        for candidate in first {
            both.extend(second.pop());
            both.push(candidate);
        }
        both.extend(second.into_iter().rev());
        both
    }

    /// What all sonars share and is far off, by the poses of odometry.
    fn far_off(&mut self, now: &Tried) -> Vec<Candidate> {
        let share = now.standing.bits.explained_share();
        if share.is_none_or(|share| share > TROUBLED) {
            return Vec::new();
        }
        let work = TRIALS as u64 * now.standing.bits.arcs;
        if self.work + work > self.effort.arcs {
            self.is_cut_short = true;
            return Vec::new();
        }
        let poses = std::mem::replace(&mut self.config.poses, Poses::Odometry);
        let mut found = Vec::new();
        if let Some(before) = self.standing(&now.change) {
            found = far_off(&mut |parameter, value| {
                let mut change = now.change.clone();
                change.add(parameter, value);
                Some(self.standing(&change)?.gain_over(&before))
            });
        }
        self.config.poses = poses;
        found
    }

    /// The candidate that gains most, as far as one gains enough.
    fn best(&mut self, now: &Tried, candidates: &[Candidate]) -> Option<(Cause, Tried)> {
        // Odometry's own poses may drift, and what fits them then fits by chance, too.
        let may_drift = self.config.poses == Poses::Odometry;
        let least = |group: &[Parameter], found: &Tried| {
            let of_path = LEAST_GAIN_OF_A_PATH * now.standing.bits.arcs as f64;
            let of_path = if may_drift || now.is_joint || found.is_joint {
                of_path
            } else {
                0.0
            };
            of_path.max(LEAST_GAIN + OF_PARAMETER * group.len() as f64)
        };
        let mut tried: Vec<(Vec<Parameter>, Tried, f64)> = Vec::new();
        let mut worth: Option<f64> = None;
        let mut failed = Vec::new();
        let mut trials = 0;
        for candidate in candidates {
            // What is much less likely than one that gains is no rival of it, and what is off of the same sonar
            // by much the same readings as what did not gain does not either.
            if worth.is_some_and(|worth| candidate.worth() < RIVAL * worth)
                || failed.contains(&candidate.origin())
            {
                continue;
            }
            let group: Vec<Parameter> = candidate.values.iter().map(|one| one.parameter).collect();
            if tried.iter().any(|(done, ..)| *done == group) {
                continue;
            }
            if trials == TRIED_EACH {
                break;
            }
            trials += 1;
            let Some((found, gain)) = self.settled(now, candidate) else {
                continue;
            };
            let values = found.values(&group, now);
            if gain > least(&group, &found) && are_clear(&values, found.estimates.seconds) {
                worth = worth.or(Some(candidate.worth()));
                tried.push((group, found, gain));
            } else {
                failed.push(candidate.origin());
            }
        }
        let most = tried.iter().map(|(_, _, gain)| *gain).fold(0.0, f64::max);
        // Of those that gain as much, the likelier one.
        tried.retain(|(_, _, gain)| *gain > AS_WELL * most);
        let mut tried = tried.into_iter();
        let (group, best, _) = tried.next()?;
        let values = |group: &[Parameter], tried: &Tried| tried.values(group, now);
        let rivals = tried
            .map(|(group, tried, _)| values(&group, &tried))
            .collect();
        Some((
            Cause {
                values: values(&group, &best),
                standings: [now.standing, best.standing],
                rivals,
            },
            best,
        ))
    }

    /// A candidate, estimated anew as long as that gains.
    fn settled(&mut self, now: &Tried, candidate: &Candidate) -> Option<(Tried, f64)> {
        let with = |change: &Change, values: &[Estimated]| {
            let mut change = change.clone();
            values
                .iter()
                .for_each(|one| change.add(one.parameter, one.value));
            change
        };
        let mut best = self.replayed(with(&now.change, &candidate.values))?;
        let group: Vec<Parameter> = candidate.values.iter().map(|one| one.parameter).collect();
        for _ in 0..REFINED {
            let Some(more) = best.estimates.of(&group) else {
                break;
            };
            if more
                .values
                .iter()
                .all(|one| one.value.abs() < 1.5 * one.deviation)
            {
                break;
            }
            let Some(found) = self.replayed(with(&best.change, &more.values)) else {
                break;
            };
            if found.standing.gain_over(&best.standing) <= 0.0 {
                break;
            }
            best = found;
        }
        let gain = best.standing.gain_over(&now.standing);
        Some((best, gain))
    }
}

impl Tried {
    /// What was changed of some parameters since `before`, with what the log says now of how sure that is.
    fn values(&self, group: &[Parameter], before: &Self) -> Vec<Estimated> {
        let now = self.estimates.of(group);
        let values = group.iter().enumerate().map(|(at, parameter)| Estimated {
            parameter: *parameter,
            value: self.change.of(*parameter) - before.change.of(*parameter),
            deviation: now
                .as_ref()
                .and_then(|now| now.values.get(at))
                .map_or(0.0, |one| one.deviation),
        });
        values.collect()
    }
}
