//! The pairs, in words.

use std::fmt::Write as _;

use super::{degrees, place};
use crate::tools::explain::Explanation;
use crate::tools::explain::pairs::{Candidate, Candidates, Pair};

/// The two pairs.
pub fn pairs(told: &Explanation) -> String {
    let mut text = String::new();
    let half = told.arc.beam_width / 2.0;
    for (name, pair) in ["before - this arc", "this arc - after"]
        .iter()
        .zip(&told.pairs)
    {
        let _ = writeln!(
            text,
            "  {name}: base line {:.1} mm towards {}",
            pair.base_line * 1e3,
            degrees(pair.direction)
        );
        if pair.too_short {
            text.push_str("    the sensor stood still: no base line, so no points\n");
            continue;
        }
        kind(&mut text, "contact     ", &pair.contact, pair, half);
        kind(&mut text, "intersection", &pair.intersection, pair, half);
    }
    text
}

fn kind(text: &mut String, name: &str, candidates: &Candidates, pair: &Pair, half: f64) {
    if candidates.sides.is_empty() {
        let _ = writeln!(
            text,
            "    {name}  cos {:.4} is beyond 1: the ranges differ by more than {:.1} mm allow",
            candidates.cosine,
            pair.base_line * 1e3
        );
        return;
    }
    for candidate in &candidates.sides {
        let _ = writeln!(
            text,
            "    {name}  cos {:+.4}  {:5}  {}",
            candidates.cosine,
            candidate.side,
            where_it_lies(candidate, half)
        );
    }
}

fn where_it_lies(candidate: &Candidate, half: f64) -> String {
    let [a, b] = candidate.seen;
    let off = |angle: f64| format!("{:+.2}", angle.to_degrees());
    let bearings = format!("{:>7}, {:>7}", off(a.off_axis), off(b.off_axis));
    let half = half.to_degrees();
    match (a.held, b.held) {
        (true, true) => format!("{bearings}  at {}", place(b.at)),
        (false, false) => format!("{bearings}  outside both beams (+-{half:.2})"),
        (false, true) => format!("{bearings}  outside the first beam (+-{half:.2})"),
        (true, false) => format!("{bearings}  outside the second beam (+-{half:.2})"),
    }
}
