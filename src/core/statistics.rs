//! Small sums that several tools need.

/// The middle of sorted values; the upper one of two.
pub fn median(sorted: &[f64]) -> Option<f64> {
    sorted.get(sorted.len() / 2).copied()
}

/// The value below which a share of the sorted values lies.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((share * last as f64) as usize).copied()
}

/// `part / whole`; `None` of nothing.
pub fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// `part / whole`; 0 of nothing.
pub fn fraction(part: u64, whole: u64) -> f64 {
    share(part, whole).unwrap_or(0.0)
}

/// Events per second; `None` where no time passed.
pub fn rate(count: usize, first_ns: i64, last_ns: i64) -> Option<f64> {
    let seconds = seconds(first_ns, last_ns);
    (seconds > 0.0).then(|| count.saturating_sub(1) as f64 / seconds)
}

/// Seconds between two stamps, nanoseconds.
pub fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(quantile(&[], 0.9), None);
        assert_eq!(median(&[1.0, 2.0]), Some(2.0));
        let eleven: Vec<f64> = (0..=10).map(f64::from).collect();
        assert_eq!(quantile(&eleven, 0.9), Some(9.0));
        assert_eq!(rate(5, 3, 3), None);
        assert_eq!((fraction(1, 0), share(1, 0)), (0.0, None));
    }
}
