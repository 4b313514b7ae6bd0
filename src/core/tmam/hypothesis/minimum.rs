//! The least value of a function of one bearing.

use crate::core::geometry::{Vec2, unit};

/// Samples at which a minimum is looked for before it is refined. Both local minima, left and right
/// of the base line, are seen this way where the beams hold both.
const SAMPLES: u32 = 24;
/// How many these are, both ends included.
pub const PLACES: usize = SAMPLES as usize + 1;

/// Probes of the refinement, at most; parabolas need about seven of them.
const PROBES: u32 = 40;

/// The refinement ends within this share of the distance between samples.
const TOLERANCE: f64 = 1e-7;

/// Bearings from `low` to `high` radians off an axis.
#[derive(Debug, Clone, Copy)]
pub struct Bearings {
    /// The axis, radians.
    pub axis: f64,
    /// From here.
    pub low: f64,
    /// To here.
    pub high: f64,
}

/// In which direction a function is least, and its value there; infinite where it is so everywhere.
/// The best of evenly spaced samples, refined between its neighbours.
///
/// `coarse` is the function at the samples, where it need not be exact: all at once, so that a processor
/// works at several side by side. `bottom` is where Newton's method leads from a sample, if anywhere; that is where
/// the function is least as long as it lies beside the sample and is no edge of what is allowed.
pub fn least(
    bearings: &Bearings,
    coarse: impl FnOnce(&[Vec2; PLACES]) -> [f64; PLACES],
    bottom: impl FnOnce(Vec2) -> Option<Vec2>,
    function: impl Fn(Vec2) -> f64,
) -> (Vec2, f64) {
    let step = (bearings.high - bearings.low) / f64::from(SAMPLES);
    // One direction from the other by turning: cheaper than a sine for each.
    let (mut direction, turn) = (unit(bearings.axis + bearings.low), unit(step));
    let samples: [Vec2; PLACES] = std::array::from_fn(|_| {
        let sample = direction;
        direction = Vec2::new(
            direction.x * turn.x - direction.y * turn.y,
            direction.x * turn.y + direction.y * turn.x,
        );
        sample
    });
    let (mut best, mut least, mut sample) = (0, f64::INFINITY, direction);
    for ((k, value), direction) in (0_u32..).zip(coarse(&samples)).zip(samples) {
        if value < least {
            (best, least, sample) = (k, value, direction);
        }
    }
    let at = |place: f64| unit(bearings.axis + place);
    if least.is_infinite() {
        return (at(bearings.low), least);
    }
    if let Some(bottom) = bottom(sample) {
        let off = sample.perp(&bottom);
        let is_beyond = (best == 0 && off < 0.0) || (best == SAMPLES && off > 0.0);
        let found = if is_beyond { sample } else { bottom };
        let value = function(found);
        if value <= least && (is_beyond || off.abs() < turn.y) {
            return (found, value);
        }
    }
    let place = bearings.low + step * f64::from(best);
    let (low, high) = (
        (place - step).max(bearings.low),
        (place + step).min(bearings.high),
    );
    let (place, value) = refine(low, place, high, |place| function(at(place)));
    (at(place), value)
}

/// Brent's method: parabolas through the three best places, golden sections where they lead astray.
fn refine(low: f64, start: f64, high: f64, function: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let tolerance = TOLERANCE * (high - low);
    let (mut low, mut high) = (low, high);
    let (mut best, mut second, mut third) = {
        let first = (start, function(start));
        (first, first, first)
    };
    let (mut step, mut step_before): (f64, f64) = (0.0, 0.0);
    for _ in 0..PROBES {
        let (x, middle) = (best.0, (low + high) / 2.0);
        if (x - middle).abs() <= 2.0 * tolerance - (high - low) / 2.0 {
            break;
        }
        let parabola = vertex(best, second, third)
            .filter(|to| *to > low && *to < high && (to - x).abs() < step_before.abs() / 2.0);
        step_before = step;
        step = if let Some(to) = parabola {
            let near_end = to - low < 2.0 * tolerance || high - to < 2.0 * tolerance;
            if near_end {
                tolerance.copysign(middle - x)
            } else {
                to - x
            }
        } else {
            step_before = if x >= middle { low - x } else { high - x };
            GOLDEN * step_before
        };
        let place = if step.abs() >= tolerance {
            x + step
        } else {
            x + tolerance.copysign(step)
        };
        let probe = (place, function(place));
        if probe.1 <= best.1 {
            if place >= x {
                low = x
            } else {
                high = x
            }
            (third, second, best) = (second, best, probe);
        } else {
            if place < x {
                low = place
            } else {
                high = place
            }
            if probe.1 <= second.1 || second.0 == best.0 {
                (third, second) = (second, probe);
            } else if probe.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
                third = probe;
            }
        }
    }
    best
}

/// Where the parabola through three places has its vertex, if it has one.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let (r, q) = ((a.0 - b.0) * (a.1 - c.1), (a.0 - c.0) * (a.1 - b.1));
    let down = 2.0 * (q - r);
    let to = a.0 - ((a.0 - c.0) * q - (a.0 - b.0) * r) / down;
    (down != 0.0 && to.is_finite()).then_some(to)
}

#[cfg(test)]
mod tests {
    use super::{Bearings, PLACES, least};
    use crate::core::geometry::{Vec2, direction, unit, wrap_angle};

    /// The least of a function of the bearing off an axis, and where it is.
    fn least_of(low: f64, high: f64, function: impl Fn(f64) -> f64) -> (f64, f64) {
        let axis = 2.5;
        let of = |towards: Vec2| function(wrap_angle(direction(towards) - axis));
        let bearings = Bearings { axis, low, high };
        let (towards, value) = least(&bearings, |all| all.map(of), |_| None, of);
        (wrap_angle(direction(towards) - axis), value)
    }

    #[test]
    fn the_deeper_of_two_valleys_is_found_to_its_bottom() {
        let valley = |x: f64, bottom: f64| (x - bottom) * (x - bottom);
        let valleys = |x: f64| valley(x, -0.7).min(valley(x, 0.4) + 0.01);
        let (place, value) = least_of(-1.0, 1.0, valleys);
        assert!(
            (place + 0.7).abs() < 1e-7 && value < 1e-13,
            "{place} {value}"
        );
    }

    #[test]
    fn a_valley_that_is_no_parabola_is_found() {
        for bottom in [-0.91, -0.3, 0.0, 0.123_456, 0.77] {
            let sharp = |x: f64| (x - bottom).abs().sqrt();
            let (place, _) = least_of(-1.0, 1.0, sharp);
            assert!((place - bottom).abs() < 1e-6, "{place} {bottom}");
        }
    }

    #[test]
    fn a_minimum_at_an_edge_is_found() {
        let (place, _) = least_of(-1.0, 1.0, |x| x);
        assert!((place + 1.0).abs() < 1e-6, "{place}");
        let (place, _) = least_of(-1.0, 1.0, |x| if x < 0.35 { f64::INFINITY } else { x });
        assert!((place - 0.35).abs() < 1e-5, "{place}");
    }

    #[test]
    fn newtons_method_is_followed_beside_the_best_sample_and_nowhere_else() {
        let bearings = Bearings {
            axis: 0.0,
            low: -1.0,
            high: 1.0,
        };
        let of = |towards: Vec2| {
            let off = direction(towards) - 0.3;
            off * off
        };
        let samples = |all: &[Vec2; PLACES]| all.map(of);
        for (bottom, found) in [(0.3001, 0.3001), (0.5, 0.3), (-2.0, 0.3)] {
            let (towards, _) = least(&bearings, samples, |_| Some(unit(bottom)), of);
            assert!((direction(towards) - found).abs() < 1e-7, "{bottom}");
        }
        let falling = |towards: Vec2| -direction(towards);
        let beyond = |_| Some(unit(1.2));
        let (towards, _) = least(&bearings, |all| all.map(falling), beyond, falling);
        assert!((direction(towards) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn where_nothing_is_finite_there_is_no_minimum() {
        assert_eq!(least_of(0.0, 1.0, |_| f64::INFINITY).1, f64::INFINITY);
    }
}
