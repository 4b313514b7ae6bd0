//! Tries what may be off: each candidate is applied, the log replayed, and kept where its own map explains
//! it in fewer bits.

use super::borne_out::Heard;
use super::candidate::{Candidate, Estimated, Estimates, are_clear};
use super::change::Change;
use super::far_off::{Scope, far_off};
use super::mistaken::{self, mistaken, of_the_loudest};
use super::parameter::{Parameter, Quantity, Whose};
use super::stretched::Stretched;
use crate::core::bits::Bits;
use crate::core::config::{Config, Poses};
use crate::core::event::OdometrySample;
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
/// The best of many candidates gains so much more by chance, bits for each doubling of their number.
const OF_CHOICE: f64 = 1.0;
/// The same of what all sonars share, bits an arc: it moves every reading a little, and some fit better by chance.
const LEAST_GAIN_OF_ALL: f64 = 0.04;
/// The same where poses are estimated: a path that settles otherwise gains up to 0.35 by chance.
const LEAST_GAIN_OF_A_PATH: f64 = 0.4;
/// A candidate with such a share of the gain of the best explains the log as well; of the same sonar one with less does.
const AS_WELL: f64 = 0.9;
const OF_THE_SAME: f64 = 0.8;
/// A value of which the log wants such a share back is none.
const TAKEN_BACK: f64 = 0.5;
/// A candidate that is likelier by such a share of what the first one is explains the same trouble.
const RIVAL: f64 = 0.6;

/// A log of which less than this is explained may have something that is far off.
const TROUBLED: f64 = 0.8;

/// What leaves a log troubled must explain this share of what was unexplained.
const TOLD_OF_TROUBLE: f64 = 0.25;

/// What is tried of the sonars that draw most of the map gains less by chance, bits an arc.
const OF_LOUDEST: f64 = 0.2;

/// What is far off may take such a share of what is allowed.
const OF_FAR_OFF: f64 = 2.0 / 3.0;

/// Of a log in which nothing is off more is explained ...
const SOUND: f64 = 0.995;
/// ... with a chi2 of no more than this for each reading.
const SOUND_CHI2: f64 = 1.2;

/// A path at which more than this is explained is what was off.
const WELL: f64 = 0.95;

/// What leaves more than half of a log unexplained is not what was off.
const HALF: f64 = 0.5;
/// Where less than this is explained, a wrong map leads least squares astray ...
const MOSTLY: f64 = 0.85;
/// ... and what they find of one sonar gains less by chance, bits an arc.
const LEAST_GAIN_IN_TROUBLE: f64 = 0.12;
/// A mount that least squares move by more is off the robot, metres.
const BEYOND: f64 = 0.3;
/// A range scale that is off by more is found by other means.
const FAR_OFF: f64 = 0.2;

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
    /// Shares of the arcs that odometry's own poses explain, without it and with it, where an estimated path makes up
    /// for it.
    pub by_odometry: Option<[f64; 2]>,
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
    /// The corrected path, where poses were estimated.
    path: Option<Vec<OdometrySample>>,
    /// What that path says of odometry.
    stretched: Option<Stretched>,
}

/// What changes are tried on.
struct Ground {
    log: Log,
    config: Config,
    /// What is changed of it first.
    base: Change,
    /// How well it stands then.
    standing: Standing,
    /// Whether its path is given, and cannot settle otherwise.
    is_held: bool,
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
            bits: Bits::of(outcome).unwrap_or_default(),
            suspects: outcome.suspects.unwrap_or_default(),
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

/// The samples of odometry at the poses of a corrected path.
fn corrected(replay: &Replay<'_>, outcome: &Outcome) -> Option<Vec<OdometrySample>> {
    let path = &outcome.joint()?.path;
    let samples = replay.log().events.odometry.iter();
    let corrected = samples.map(|sample| OdometrySample {
        world_from_robot: path.correct(sample.stamp_ns, &sample.world_from_robot),
        ..*sample
    });
    Some(corrected.collect())
}

fn is_of_one_sonar(values: &[Estimated]) -> bool {
    let is_one = |one: &Estimated| matches!(one.parameter, Parameter::Sonar(Whose::One(_), _));
    values.iter().all(is_one)
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
        path: corrected(replay, outcome),
        stretched: outcome.joint().map(Stretched::of),
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
    while causes.len() < MOST_CAUSES
        && let Some((cause, then)) = searcher.made_up_for(&now)
    {
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

    /// The log as it is now.
    fn ground(&self, now: &Tried) -> Ground {
        Ground {
            log: self.log.clone(),
            config: self.config.clone(),
            base: now.change.clone(),
            standing: now.standing,
            is_held: false,
        }
    }

    /// The log as it is now, at the poses of its corrected path, or of odometry where that stands; `None` where it is
    /// not asked whether it does.
    fn held(&mut self, now: &Tried) -> Option<Ground> {
        let mut held = self.ground(now);
        let Some(path) = now.path.as_ref() else {
            held.config.poses = Poses::Odometry;
            held.is_held = true;
            return (self.config.poses == Poses::Joint).then_some(held);
        };
        held.base.apply(&mut held.log.events);
        held.base.apply_clocks(&mut held.config);
        held.base = Change::default();
        held.log.events.odometry.clone_from(path);
        held.config.poses = Poses::Odometry;
        held.is_held = true;
        held.standing = self.replayed(&held, &held.base, |_, outcome| Standing::of(outcome))?;
        Some(held)
    }

    /// Replays the log with a change.
    fn replayed<T>(
        &mut self,
        ground: &Ground,
        change: &Change,
        of: impl FnOnce(&Replay<'_>, &Outcome) -> T,
    ) -> Option<T> {
        let mut log = ground.log.clone();
        let mut config = ground.config.clone();
        let change = ground.base.and(change);
        change.apply(&mut log.events);
        change.apply_clocks(&mut config);
        let replay = Replay::new(&log, &config).ok()?;
        let outcome = replay.run(&mut []).ok()?;
        self.work += outcome.reports.len() as u64;
        Some(of(&replay, &outcome))
    }

    /// The same, as far as it is allowed.
    fn tried(&mut self, now: &Tried, ground: &Ground, change: &Change) -> Option<Tried> {
        if self.is_spent() {
            return None;
        }
        self.replays += 1;
        self.replayed(ground, change, |replay, outcome| Tried {
            change: now.change.and(change),
            standing: Standing::of(outcome),
            estimates: Estimates::new(replay, outcome),
            path: corrected(replay, outcome),
            stretched: outcome.joint().map(Stretched::of),
        })
    }

    /// What may be off, the likeliest first. Poses that were estimated have taken a part of what is off for
    /// drift: what the poses of odometry say stands between.
    fn candidates(&mut self, now: &Tried) -> Vec<Candidate> {
        let mut both = self.far_off(now);
        let arcs = now.standing.bits.arcs as f64;
        both.extend(now.stretched.iter().flat_map(|path| path.candidates(arcs)));
        let first = candidates_of(&now.estimates);
        let share = now.standing.bits.explained_share();
        if now.path.is_none() || share.is_some_and(|share| share > WELL) {
            both.extend(first);
            return both;
        }
        let mut by_odometry = self.ground(now);
        by_odometry.config.poses = Poses::Odometry;
        let by_odometry = self.tried(now, &by_odometry, &Change::default());
        let mut second = by_odometry.map_or_else(Vec::new, |tried| candidates_of(&tried.estimates));
        second.reverse();
        for candidate in first {
            both.extend(second.pop());
            both.push(candidate);
        }
        both.extend(second.into_iter().rev());
        both
    }

    /// What all sonars share and is far off, by the poses of odometry; and what the sonars that draw most of the map are
    /// not.
    fn far_off(&mut self, now: &Tried) -> Vec<Candidate> {
        let bits = now.standing.bits;
        let Some(share) = bits.explained_share() else {
            return Vec::new();
        };
        let is_troubled = share < TROUBLED;
        let is_sound = share > SOUND && bits.chi2 < SOUND_CHI2 * bits.explained as f64;
        let scope = if is_troubled {
            Scope::All
        } else {
            Scope::Offset
        };
        let of_loudest = if is_troubled { mistaken::TRIALS } else { 0 };
        let work = (scope.trials() + of_loudest) as u64 * bits.arcs;
        let left = self.effort.arcs.saturating_sub(self.work);
        let most = self.work + (OF_FAR_OFF * left as f64) as u64;
        if is_sound || self.work + work > most {
            self.is_cut_short |= is_troubled;
            return Vec::new();
        }
        let mut ground = self.ground(now);
        ground.config.poses = Poses::Odometry;
        let mut standing = |change: &Change| {
            let is_within = self.work <= most;
            is_within.then(|| self.replayed(&ground, change, |_, outcome| Standing::of(outcome)))?
        };
        let Some(before) = standing(&Change::default()) else {
            return Vec::new();
        };
        let mut found = far_off(scope, &mut |parameter, value| {
            let mut change = Change::default();
            change.add(parameter, value);
            Some(standing(&change)?.gain_over(&before))
        });
        if is_troubled {
            let scene = now.estimates.scene();
            let mut loudest = of_the_loudest(&scene.echoes(), &scene.mounts);
            // In clutter some exchange fits a little better, too, but then the log stays troubled.
            for candidate in &mut loudest {
                let mut change = Change::default();
                for one in &candidate.values {
                    change.add(one.parameter, one.value);
                }
                let mended = standing(&change);
                let mended = mended.filter(|it| it.bits.explained_share() > Some(TROUBLED));
                let gained = mended.map_or(0.0, |it| it.gain_over(&before));
                candidate.gain = gained * std::f64::consts::LN_2;
            }
            let best = loudest.into_iter();
            let best = best.max_by(|a, b| a.gain.total_cmp(&b.gain));
            let least = OF_LOUDEST * bits.arcs as f64 * std::f64::consts::LN_2;
            found.extend(best.filter(|best| best.gain > least));
            found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        }
        found
    }

    /// The candidate that gains most, as far as one gains enough.
    fn best(&mut self, now: &Tried, candidates: &[Candidate]) -> Option<(Cause, Tried)> {
        let as_it_is = self.ground(now);
        let mut held = None;
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
            let group = candidate.parameters();
            if tried.iter().any(|(done, ..)| *done == group) {
                continue;
            }
            if trials == TRIED_EACH {
                break;
            }
            trials += 1;
            // What one sonar is off hardly moves the path, and where odometry's stands nothing does.
            let is_at_held = now.path.is_none() || is_of_one_sonar(&candidate.values);
            if is_at_held {
                held = held.or_else(|| self.held(now));
            }
            let at = held.as_ref().filter(|_| is_at_held);
            let Some((found, gain)) = self.settled(now, at.unwrap_or(&as_it_is), candidate) else {
                continue;
            };
            let values = found.values(&group, now);
            if gain > self.least(&values, at, [now, &found])
                && explains_more(&values, &now.standing.bits, &found.standing.bits)
                && are_clear(&values, found.estimates.seconds)
                && found.bears_out(&values)
            {
                worth = worth.or(Some(candidate.worth()));
                tried.push((group, found, gain));
            } else {
                failed.push(candidate.origin());
            }
        }
        let most = tried.iter().map(|(_, _, gain)| *gain).fold(0.0, f64::max);
        // Of those that gain as much, the likelier one.
        tried.retain(|(_, _, gain)| *gain > AS_WELL * most);
        // And of these one with which odometry stands as it is.
        if tried.iter().any(|(_, found, _)| found.path.is_none()) {
            tried.retain(|(_, found, _)| found.path.is_none());
        }
        let mut tried = tried.into_iter();
        let (group, best, _) = tried.next()?;
        let mut rivals: Vec<Vec<Estimated>> = tried
            .map(|(group, tried, _)| tried.values(&group, now))
            .collect();
        // Nor need what the same sonar may be off instead be clear by itself.
        for candidate in now.estimates.siblings(&group) {
            let other = candidate.parameters();
            let is_told = rivals.iter().any(|rival| {
                rival
                    .iter()
                    .map(|one| one.parameter)
                    .eq(other.iter().copied())
            });
            if is_told {
                continue;
            }
            let ground = held.as_ref().unwrap_or(&as_it_is);
            if let Some((found, gain)) = self.settled(now, ground, &candidate)
                && gain > OF_THE_SAME * most
            {
                rivals.push(found.values(&other, now));
            }
        }
        Some((
            Cause {
                values: best.values(&group, now),
                standings: [now.standing, best.standing],
                rivals,
                by_odometry: None,
            },
            best,
        ))
    }

    /// A scale of odometry that the estimated path makes up for.
    fn made_up_for(&mut self, now: &Tried) -> Option<(Cause, Tried)> {
        let path = now.stretched?;
        let ground = self.ground(now);
        for scale in path.off() {
            let mut mended: Vec<(Estimated, Tried)> = Vec::new();
            for one in Stretched::stands_for(&scale) {
                let mut change = Change::default();
                change.add(one.parameter, one.value);
                let found = self.tried(now, &ground, &change);
                let is_mended = |found: &Tried| match &found.stretched {
                    Some(later) => path.is_mended_in(later, &scale),
                    None => found.standing.bits.explained_share() > Some(path.explained),
                };
                mended.extend(found.filter(is_mended).map(|found| (one, found)));
            }
            // One with which odometry stands as it is is likelier.
            if mended.iter().any(|(_, found)| found.path.is_none()) {
                mended.retain(|(_, found)| found.path.is_none());
            }
            let mut mended = mended.into_iter();
            if let Some((value, found)) = mended.next() {
                let explained = match &found.stretched {
                    Some(later) => later.explained,
                    None => found.standing.bits.explained_share()?,
                };
                let cause = Cause {
                    values: vec![value],
                    standings: [now.standing, found.standing],
                    rivals: mended.map(|(rival, _)| vec![rival]).collect(),
                    by_odometry: Some([path.explained, explained]),
                };
                return Some((cause, found));
            }
        }
        None
    }

    /// What a cause must gain, bits.
    fn least(&self, values: &[Estimated], held: Option<&Ground>, both: [&Tried; 2]) -> f64 {
        let [now, found] = both;
        // Odometry's own poses may drift, and what fits them then fits by chance, too. With what makes a correction
        // needless they do not.
        let is_mended = now.path.is_some() && found.path.is_none();
        let may_drift = self.config.poses == Poses::Odometry || found.path.is_some();
        let is_troubled = found.standing.bits.explained_share() < Some(MOSTLY);
        let of_arc = match held {
            Some(_) if is_of_one_sonar(values) && is_troubled && is_fitted(values) => {
                LEAST_GAIN_IN_TROUBLE
            }
            Some(_) if is_of_one_sonar(values) => 0.0,
            Some(_) => LEAST_GAIN_OF_ALL,
            None if is_mended || !may_drift => LEAST_GAIN_OF_ALL,
            None => LEAST_GAIN_OF_A_PATH,
        };
        let of_arcs = of_arc * now.standing.bits.arcs as f64;
        let choice = OF_CHOICE * libm::log2(now.estimates.groups().len() as f64);
        of_arcs.max(LEAST_GAIN + OF_PARAMETER * values.len() as f64 + choice)
    }

    /// A candidate, estimated anew as long as that gains, and the gain. What gains at a held path must do so where
    /// the path is estimated, too.
    fn settled(
        &mut self,
        now: &Tried,
        ground: &Ground,
        candidate: &Candidate,
    ) -> Option<(Tried, f64)> {
        let mut change = Change::default();
        let add = |change: &mut Change, values: &[Estimated]| {
            for one in values {
                change.add(one.parameter, one.value);
            }
        };
        add(&mut change, &candidate.values);
        let mut best = self.tried(now, ground, &change)?;
        let group = candidate.parameters();
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
            let mut further = change.clone();
            add(&mut further, &more.values);
            let Some(found) = self.tried(now, ground, &further) else {
                break;
            };
            if found.standing.gain_over(&best.standing) <= 0.0 {
                break;
            }
            (best, change) = (found, further);
        }
        let gain = best.standing.gain_over(&ground.standing);
        if !ground.is_held || gain <= LEAST_GAIN {
            return Some((best, gain));
        }
        let found = self.tried(now, &self.ground(now), &change)?;
        (found.standing.gain_over(&now.standing) > 0.0).then_some((found, gain))
    }
}

/// Whether a log is explained better, and enough so of one that stays troubled where it is not one sonar's alone.
fn explains_more(values: &[Estimated], before: &Bits, after: &Bits) -> bool {
    let (Some(before), Some(after)) = (before.explained_share(), after.explained_share()) else {
        return false;
    };
    let is_unlikely = |one: &Estimated| match one.parameter {
        Parameter::Sonar(_, Quantity::Delay) => true,
        Parameter::Sonar(_, Quantity::X | Quantity::Y) => one.value.abs() > BEYOND,
        _ => false,
    };
    let least = match is_of_one_sonar(values) {
        true if is_fitted(values) && values.iter().any(is_unlikely) => MOSTLY,
        true => HALF,
        false => TROUBLED,
    };
    let is_enough = after > least || after - before >= TOLD_OF_TROUBLE * (1.0 - before);
    after > HALF && after >= before && is_enough
}

/// Whether least squares find it, and not beams or trials of what is far off.
fn is_fitted(values: &[Estimated]) -> bool {
    values.iter().all(|one| match one.parameter {
        Parameter::Sonar(_, Quantity::Yaw | Quantity::BeamWidth) => false,
        Parameter::Sonar(_, Quantity::RangeScale) => one.value.abs() < FAR_OFF,
        _ => true,
    })
}

/// What may be off by a replay: what is far off first, since it leads least squares astray.
fn candidates_of(estimates: &Estimates) -> Vec<Candidate> {
    let scene = estimates.scene();
    let mut all = mistaken(&Heard::new(scene), &scene.mounts);
    all.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
    all.extend(estimates.candidates());
    all
}

impl Tried {
    /// Whether the log, with values applied, does not ask to take them back.
    fn bears_out(&self, values: &[Estimated]) -> bool {
        let group: Vec<Parameter> = values.iter().map(|one| one.parameter).collect();
        let Some(more) = self.estimates.of(&group) else {
            return true;
        };
        let is_taken_back = |(one, more): (&Estimated, &Estimated)| {
            more.value.abs() > TAKEN_BACK * one.value.abs()
                && more.value * one.value < 0.0
                && more.is_sure()
        };
        !values.iter().zip(&more.values).any(is_taken_back)
    }

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
