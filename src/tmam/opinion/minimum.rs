//! The least value of a function of one bearing.

/// Samples at which a minimum is looked for before it is refined. Both local minima, left and right
/// of the base line, are seen this way where the beams hold both.
const SAMPLES: u32 = 24;

/// Golden sections of the bracket around the best sample: to a millionth of the beam.
const REFINEMENTS: u32 = 24;

/// Where a function on `[low, high]` is least, and its value there; infinite where it is so
/// everywhere. The best of evenly spaced samples, refined by golden sections between its
/// neighbours.
pub fn least(low: f64, high: f64, function: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let step = (high - low) / f64::from(SAMPLES);
    let at = |k: u32| low + step * f64::from(k);
    let samples = (0..=SAMPLES).map(|k| (at(k), function(at(k))));
    let best = samples.min_by(|a, b| a.1.total_cmp(&b.1));
    let Some(mut best) = best.filter(|(_, value)| value.is_finite()) else {
        return (low, f64::INFINITY);
    };
    let (mut low, mut high) = ((best.0 - step).max(low), (best.0 + step).min(high));
    let probe = |place: f64, best: &mut (f64, f64)| {
        let value = function(place);
        if value < best.1 {
            *best = (place, value);
        }
        value
    };
    let mut left = high - GOLDEN * (high - low);
    let mut right = low + GOLDEN * (high - low);
    let (mut at_left, mut at_right) = (probe(left, &mut best), probe(right, &mut best));
    for _ in 0..REFINEMENTS {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = probe(left, &mut best);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = probe(right, &mut best);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::least;

    #[test]
    fn the_deeper_of_two_valleys_is_found_to_its_bottom() {
        let valley = |x: f64, bottom: f64| (x - bottom) * (x - bottom);
        let valleys = |x: f64| valley(x, -0.7).min(valley(x, 0.4) + 0.01);
        let (place, value) = least(-1.0, 1.0, valleys);
        assert!(
            (place + 0.7).abs() < 1e-5 && value < 1e-5,
            "{place} {value}"
        );
    }

    #[test]
    fn a_minimum_at_the_edge_is_found() {
        let (place, _) = least(-1.0, 1.0, |x| x);
        assert!((place + 1.0).abs() < 1e-5, "{place}");
    }

    #[test]
    fn where_nothing_is_finite_there_is_no_minimum() {
        assert_eq!(least(0.0, 1.0, |_| f64::INFINITY).1, f64::INFINITY);
    }
}
