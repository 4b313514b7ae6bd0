//! Where the lines of a metric grid lie.

/// Lines along the longer side, at most.
const MOST_LINES: f64 = 12.0;

/// Between lines, metres: one, two or five times a power of ten, with which few enough lines cross the side.
pub fn spacing(side: f64) -> f64 {
    let decades = std::iter::successors(Some(0.1), |decade| Some(decade * 10.0)).take(14);
    let mut steps = decades.flat_map(|decade| [decade, 2.0 * decade, 5.0 * decade]);
    let fits = steps.find(|step| side / step <= MOST_LINES);
    fits.unwrap_or(f64::INFINITY)
}

/// The multiples of a step from `min` to `max`.
pub fn multiples(min: f64, max: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((min / step).ceil(), (max / step).floor());
    let count = (last - first).clamp(0.0, 2.0 * MOST_LINES) as u32;
    (0..=count).map(|i| (first + f64::from(i)) * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_lie_at_round_numbers_and_are_few() {
        for (side, step) in [
            (0.9, 0.1),
            (8.8, 1.0),
            (13.0, 2.0),
            (95.0, 10.0),
            (480.0, 50.0),
        ] {
            assert!(
                (spacing(side) - step).abs() < 1e-9,
                "{side}: {}",
                spacing(side)
            );
        }
        assert_eq!(multiples(-0.4, 2.3, 1.0), [0.0, 1.0, 2.0]);
        assert!(multiples(-1e12, 1e12, spacing(2e12)).len() <= 13);
    }
}
