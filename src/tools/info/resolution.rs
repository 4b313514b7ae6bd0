//! How finely a sonar tells ranges apart.

use serde::Serialize;

use crate::core::rounding::number;

/// Ranges come as 32-bit numbers; what lies closer together than this is dust, metres.
const DUST: f64 = 2e-6;
/// Steps finer than this are no steps, metres.
const FINEST_STEP: f64 = 1e-4;
/// So many different ranges are needed to speak of a common step.
const ENOUGH: usize = 8;
/// A difference may miss a multiple of the step by this fraction of it.
const MISS: f64 = 0.02;

/// How finely a sonar tells ranges apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// The common step of all ranges, or else the smallest difference between two of them, metres.
    #[serde(serialize_with = "number")]
    pub step: f64,
    /// Whether all ranges are multiples of the step apart.
    pub quantised: bool,
}

/// The resolution of sorted ranges; `None` where they are all the same.
pub fn resolution(sorted: &[f64]) -> Option<Resolution> {
    let differences: Vec<f64> = sorted
        .array_windows()
        .map(|[a, b]| b - a)
        .filter(|d| *d > DUST)
        .collect();
    let smallest = differences.iter().copied().min_by(f64::total_cmp)?;
    let step = common_step(&differences, smallest);
    Some(Resolution {
        step: step.unwrap_or(smallest),
        quantised: step.is_some(),
    })
}

/// The step of which all differences are multiples.
fn common_step(differences: &[f64], smallest: f64) -> Option<f64> {
    if differences.len() < ENOUGH || smallest < FINEST_STEP {
        return None;
    }
    let mut steps = 0.0;
    let mut telling = 0;
    for difference in differences {
        let multiple = libm::round(difference / smallest);
        let allowed = (MISS * smallest).max(DUST) * multiple.max(1.0);
        // A multiple so large that anything is near one says nothing.
        if allowed < smallest / 4.0 {
            if (difference - multiple * smallest).abs() > allowed {
                return None;
            }
            telling += 1;
        }
        steps += multiple;
    }
    (telling >= ENOUGH).then(|| differences.iter().sum::<f64>() / steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(ranges: impl IntoIterator<Item = f64>) -> Option<Resolution> {
        let mut ranges: Vec<f64> = ranges.into_iter().map(|r| f64::from(r as f32)).collect();
        ranges.sort_by(f64::total_cmp);
        resolution(&ranges)
    }

    #[test]
    fn centimetres_in_32_bits_are_centimetres() {
        let found = of([
            0.25, 0.26, 0.4, 0.41, 0.46, 0.49, 0.77, 1.3, 1.31, 1.33, 1.34, 2.48, 3.0, 3.9, 3.95,
            4.33, 4.33,
        ])
        .unwrap();
        assert!(found.quantised, "{found:?}");
        assert!((found.step - 0.01).abs() < 1e-6);
    }

    #[test]
    fn the_ticks_of_a_timer_are_found_too() {
        let ticks = [
            100, 101, 103, 104, 110, 160, 161, 163, 190, 192, 240, 300, 301, 303, 500,
        ];
        let found = of(ticks.map(|k| f64::from(k) * 0.001_715)).unwrap();
        assert!(found.quantised && (found.step - 0.001_715).abs() < 1e-7);
    }

    #[test]
    fn ranges_on_no_raster_have_a_smallest_difference() {
        let found = of((1..200).map(|k| 1.0 + 3.0 * (f64::from(k) * 0.618_034).fract())).unwrap();
        assert!(!found.quantised && found.step < 0.02, "{found:?}");
    }

    #[test]
    fn two_ranges_close_together_by_chance_make_no_raster() {
        let mut ranges: Vec<f64> = (1..40)
            .map(|k| 1.0 + 5.0 * (f64::from(k) * 0.618_034).fract())
            .collect();
        ranges.push(ranges[0] + 0.001_2);
        assert!(!of(ranges).unwrap().quantised);
    }

    #[test]
    fn too_few_ranges_show_no_step() {
        assert_eq!(of([]), None);
        assert_eq!(of([1.0, 1.0]), None);
        let two = of([1.0, 1.25]).unwrap();
        assert_eq!((two.step, two.quantised), (0.25, false));
    }
}
