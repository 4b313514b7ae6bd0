//! What one sonar is taken for and is not: it sits where another one is said to be (ros-naoqi/nao_robot#15), looks the
//! other way, sits on the ring and not at the robot's origin, or counts in another unit. Least squares do not see so
//! far; which of them brings its readings to what the others hear does.

use std::f64::consts::{FRAC_PI_2, PI};

use super::borne_out::{Fit, Heard};
use super::candidate::{Candidate, Estimated};
use super::parameter::{Parameter, Quantity, Whose};
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, unit, wrap_angle};
use crate::core::statistics::median;

/// Fewer echoes than this say nothing.
const FEWEST: usize = 12;
/// A sonar of whose echoes less than such a share of the usual one is of what others hear is not what it is taken for.
const STRANGE: f64 = 0.6;
/// What it is, is where it has such a share of the usual one at least.
const AT_HOME: f64 = 0.7;
/// What ranges are multiplied with where a sonar counts otherwise: half the way of the sound, feet, tenths.
const SCALES: [f64; 6] = [0.5, 2.0, 0.3048, 1.0 / 0.3048, 0.1, 10.0];
/// Otherwise turned.
const TURNS: [f64; 3] = [PI, FRAC_PI_2, -FRAC_PI_2];
/// Turned by less: two thirds of a usual beam, and more.
const SLIGHT_TURNS: [f64; 6] = [15.0, -15.0, 30.0, -30.0, 45.0, -45.0];
/// Moved along the beam, metres, which ranges that are off by as much do, too: in steps that its readings do not miss.
const AHEAD: f64 = 0.015;
/// So many steps either way.
const STEPS_AHEAD: i32 = 10;
/// A mount so near to the robot's origin is at it, metres.
const AT_ORIGIN: f64 = 0.01;

/// So many sonars that hear most are held against each other by replays.
const LOUDEST: usize = 5;
/// What their ranges are multiplied with then.
const HALF_OR_TWICE: [f64; 2] = [0.5, 2.0];
/// Trials that this takes at most.
pub const TRIALS: usize = LOUDEST * (LOUDEST - 1) / 2 + LOUDEST * HALF_OR_TWICE.len();

/// Pairs of the sonars that hear most exchanged, and each of them counting half or twice: such sonars draw most of the
/// map, so that it does not contradict them. To be tried by replays; their gain is not known.
pub fn of_the_loudest(echoes: &[usize], mounts: &[Pose2]) -> Vec<Candidate> {
    let mut loudest: Vec<(usize, SonarId, Pose2)> = (echoes.iter().zip(0..).zip(mounts))
        .map(|((echoes, sonar), mount)| (*echoes, SonarId(sonar), *mount))
        .filter(|(echoes, ..)| *echoes >= FEWEST)
        .collect();
    loudest.sort_by_key(|(echoes, sonar, _)| (std::cmp::Reverse(*echoes), *sonar));
    loudest.truncate(LOUDEST);
    loudest.sort_by_key(|(_, sonar, _)| *sonar);
    let of = |values| Candidate { values, gain: 0.0 };
    let exchanged = loudest.iter().enumerate().flat_map(|(at, (_, one, a))| {
        let others = loudest.iter().skip(at + 1);
        others.map(move |(_, other, b)| {
            let mut values = moved(*one, *a, *b);
            values.extend(moved(*other, *b, *a));
            of(values)
        })
    });
    let scaled = loudest.iter().flat_map(|(_, sonar, _)| {
        HALF_OR_TWICE.map(|scale| of(vec![value(*sonar, Quantity::RangeScale, scale - 1.0)]))
    });
    exchanged.chain(scaled).collect()
}

/// What a strange sonar may be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Guess {
    /// Mounted as another one is said to be.
    Other(SonarId),
    /// Mounted otherwise.
    Mounted(Pose2),
    /// Counting otherwise.
    Scaled(f64),
}

/// What sonars may be in place of what they are taken for, by the map of the others.
pub fn mistaken(heard: &Heard<'_>, mounts: &[Pose2]) -> Vec<Candidate> {
    let sonars = || (0..).map(SonarId).zip(mounts);
    let fits: Vec<Fit> = sonars()
        .map(|(sonar, mount)| heard.fit(sonar, &heard.of_others(sonar), *mount, 1.0))
        .collect();
    let heard_enough = fits.iter().filter(|fit| fit.echoes >= FEWEST);
    let mut shares: Vec<f64> = heard_enough.map(Fit::share).collect();
    shares.sort_by(f64::total_cmp);
    let Some(usual) = median(&shares) else {
        return Vec::new();
    };
    let strange = sonars().zip(&fits);
    let strange = strange.filter(|(_, fit)| fit.echoes >= FEWEST && fit.share() < STRANGE * usual);
    let mut guessed: Vec<(SonarId, Pose2, Guess, f64)> = strange
        .filter_map(|((sonar, told), as_it_is)| {
            let places = heard.of_others(sonar);
            let tried = guesses(sonar, mounts).into_iter().map(|guess| {
                let (mount, scale) = match guess {
                    Guess::Other(other) => (mounts.get(other.index()).copied(), 1.0),
                    Guess::Mounted(mount) => (Some(mount), 1.0),
                    Guess::Scaled(scale) => (Some(*told), scale),
                };
                (
                    guess,
                    heard.fit(sonar, &places, mount.unwrap_or(*told), scale),
                )
            });
            let at_home = tried.filter(|(_, fit)| fit.share() > AT_HOME * usual);
            let (guess, fit) = at_home.min_by(|(_, a), (_, b)| a.misfit.total_cmp(&b.misfit))?;
            Some((sonar, *told, guess, as_it_is.misfit - fit.misfit))
        })
        .collect();
    guessed.extend(returned(&guessed, heard, mounts));
    let alone = guessed.iter().filter_map(|(sonar, told, guess, gain)| {
        let values = match guess {
            Guess::Other(_) => return None,
            Guess::Mounted(mount) => moved(*sonar, *told, *mount),
            Guess::Scaled(scale) => vec![value(*sonar, Quantity::RangeScale, scale - 1.0)],
        };
        Some(Candidate {
            values,
            gain: *gain,
        })
    });
    let mut found: Vec<Candidate> = alone.collect();
    found.extend(exchanged(&guessed, mounts));
    found
}

/// Sonars that hear too little to be guessed at by themselves, but whose few echoes fit the place of the one that is in
/// theirs.
fn returned(
    guessed: &[(SonarId, Pose2, Guess, f64)],
    heard: &Heard<'_>,
    mounts: &[Pose2],
) -> Vec<(SonarId, Pose2, Guess, f64)> {
    let back = guessed.iter().filter_map(|(sonar, told, guess, _)| {
        let Guess::Other(other) = guess else {
            return None;
        };
        if guessed.iter().any(|(one, ..)| one == other) {
            return None;
        }
        let own = *mounts.get(other.index())?;
        let places = heard.of_others(*other);
        let [as_it_is, exchanged] =
            [own, *told].map(|mount| heard.fit(*other, &places, mount, 1.0));
        let gain = as_it_is.misfit - exchanged.misfit;
        (exchanged.near > as_it_is.near && gain > 0.0).then_some((
            *other,
            own,
            Guess::Other(*sonar),
            gain,
        ))
    });
    back.collect()
}

/// What a sonar may be.
fn guesses(sonar: SonarId, mounts: &[Pose2]) -> Vec<Guess> {
    let Some(told) = mounts.get(sonar.index()) else {
        return Vec::new();
    };
    let mut radii: Vec<f64> = mounts.iter().map(|mount| mount.position().norm()).collect();
    radii.sort_by(f64::total_cmp);
    let radius = median(&radii).unwrap_or(0.0);
    let on_ring = (told.position().norm() < AT_ORIGIN && radius > AT_ORIGIN).then(|| {
        let place = unit(told.yaw) * radius;
        Guess::Mounted(Pose2::new(place.x, place.y, told.yaw))
    });
    let turned = TURNS.map(|turn| Pose2::new(told.x, told.y, wrap_angle(told.yaw + turn)));
    let slightly = SLIGHT_TURNS.map(|turn| {
        let yaw = wrap_angle(told.yaw + turn.to_radians());
        Guess::Mounted(Pose2::new(told.x, told.y, yaw))
    });
    let ahead = (-STEPS_AHEAD..=STEPS_AHEAD).filter(|steps| *steps != 0);
    let ahead = ahead.map(|steps| {
        let place = told.position() + unit(told.yaw) * (AHEAD * f64::from(steps));
        Guess::Mounted(Pose2::new(place.x, place.y, told.yaw))
    });
    let others = (0..).map(SonarId).zip(mounts);
    let others = others.filter(|(other, _)| *other != sonar);
    (others.map(|(other, _)| Guess::Other(other)))
        .chain(turned.map(Guess::Mounted))
        .chain(on_ring)
        .chain(slightly)
        .chain(ahead)
        .chain(SCALES.map(Guess::Scaled))
        .collect()
}

/// Sonars each of which is where the next one is said to be, round to the first.
fn exchanged(guessed: &[(SonarId, Pose2, Guess, f64)], mounts: &[Pose2]) -> Vec<Candidate> {
    let next = |sonar: SonarId| {
        guessed
            .iter()
            .find_map(|(one, _, guess, gain)| match guess {
                Guess::Other(other) if *one == sonar => Some((*other, *gain)),
                _ => None,
            })
    };
    let mut found: Vec<Candidate> = Vec::new();
    for (first, ..) in guessed {
        let (mut at, mut candidate) = (
            *first,
            Candidate {
                values: Vec::new(),
                gain: 0.0,
            },
        );
        let mut passed = Vec::new();
        while let Some((other, gain)) = next(at)
            // Each ring is found once, from its first sonar.
            && other >= *first
            && !passed.contains(&other)
            && let (Some(told), Some(mount)) = (mounts.get(at.index()), mounts.get(other.index()))
        {
            candidate.values.extend(moved(at, *told, *mount));
            candidate.gain += gain;
            passed.push(other);
            at = other;
        }
        if at == *first && passed.len() > 1 {
            found.push(candidate);
        }
    }
    found
}

/// The change from one mount to another; what stays is left out.
fn moved(sonar: SonarId, from: Pose2, to: Pose2) -> Vec<Estimated> {
    let by = [
        (Quantity::Yaw, to.yaw - from.yaw),
        (Quantity::X, to.x - from.x),
        (Quantity::Y, to.y - from.y),
    ];
    let by = by.into_iter().filter(|(_, by)| *by != 0.0);
    by.map(|(quantity, by)| value(sonar, quantity, by))
        .collect()
}

fn value(sonar: SonarId, quantity: Quantity, value: f64) -> Estimated {
    Estimated {
        parameter: Parameter::Sonar(Whose::One(sonar), quantity),
        value,
        deviation: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sonars_in_each_others_place_are_exchanged_and_a_row_of_them_is_not() {
        let mounts = [0.0, 1.0, 2.0, 3.0].map(|x| Pose2::new(x, 0.0, x));
        let guessed = |places: &[(u16, u16)]| -> Vec<_> {
            let guess = |(sonar, other): &(u16, u16)| {
                let told = mounts[usize::from(*sonar)];
                (SonarId(*sonar), told, Guess::Other(SonarId(*other)), 50.0)
            };
            places.iter().map(guess).collect()
        };
        let found = exchanged(&guessed(&[(0, 2), (1, 3), (2, 0)]), &mounts);
        assert_eq!(found.len(), 1);
        let of = |value: &Estimated| (value.parameter, value.value);
        let by = |sonar, quantity, by| (Parameter::Sonar(Whose::One(SonarId(sonar)), quantity), by);
        let values: Vec<_> = found[0].values.iter().map(of).collect();
        assert_eq!(
            values,
            [
                by(0, Quantity::Yaw, 2.0),
                by(0, Quantity::X, 2.0),
                by(2, Quantity::Yaw, -2.0),
                by(2, Quantity::X, -2.0)
            ]
        );
        assert_eq!(found[0].gain, 100.0);
        assert_eq!(
            exchanged(&guessed(&[(0, 1), (1, 2), (2, 0)]), &mounts).len(),
            1
        );
        assert!(exchanged(&guessed(&[(0, 1), (1, 2)]), &mounts).is_empty());
    }
}
