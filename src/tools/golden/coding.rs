//! Labels and stamps as short text: `12C 3I 40u` and `560x37 1120 560x3`.
//!
//! Labels are run-length coded. Stamps are the milliseconds from each arc to the next, exact to
//! the nanosecond, with repeats counted. Both are kept apart, so that a changed label changes the
//! one text, and a lost reading the other, and arcs are always found again by their stamp.

use super::results::Mark;

/// More arcs than this are refused: a few bytes of text must not fill the memory.
pub const MOST_ARCS: usize = 5_000_000;

const NS_PER_MS: i64 = 1_000_000;

/// The labels, run-length coded.
pub fn encode_marks(marks: impl IntoIterator<Item = Mark>) -> String {
    runs(marks)
        .into_iter()
        .map(|(mark, count)| format!("{count}{}", mark.letter()))
        .collect::<Vec<_>>()
        .join(" ")
}

/// The steps between stamps, milliseconds.
pub fn encode_steps(stamps: &[i64]) -> String {
    let steps = stamps
        .iter()
        .zip(stamps.iter().skip(1))
        .map(|(a, b)| b.saturating_sub(*a));
    runs(steps)
        .into_iter()
        .map(|(step, count)| match count {
            1 => milliseconds(step),
            _ => format!("{}x{count}", milliseconds(step)),
        })
        .collect::<Vec<_>>()
        .join(" ")
}

fn runs<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<(T, usize)> {
    let mut runs: Vec<(T, usize)> = Vec::new();
    for item in items {
        match runs.last_mut() {
            Some((last, count)) if *last == item => *count += 1,
            _ => runs.push((item, 1)),
        }
    }
    runs
}

fn milliseconds(ns: i64) -> String {
    let (whole, rest) = (ns / NS_PER_MS, ns % NS_PER_MS);
    if rest == 0 {
        return whole.to_string();
    }
    let digits = format!("{rest:06}");
    format!("{whole}.{}", digits.trim_end_matches('0'))
}

/// The labels behind a text.
///
/// # Errors
/// What is wrong with the text.
pub fn decode_marks(text: &str) -> Result<Vec<Mark>, String> {
    let mut marks = Vec::new();
    for word in text.split_whitespace() {
        let run = word.char_indices().next_back().and_then(|(at, letter)| {
            let mark = Mark::ALL.into_iter().find(|mark| mark.letter() == letter)?;
            let count: usize = word.get(..at)?.parse().ok()?;
            (count > 0).then_some((mark, count))
        });
        let (mark, count) =
            run.ok_or_else(|| format!("`{word}` is no run of labels like 12C, 3I or 40u"))?;
        extend(&mut marks, mark, count)?;
    }
    Ok(marks)
}

/// The stamps behind a text, from the first on.
///
/// # Errors
/// What is wrong with the text.
pub fn decode_steps(first_ns: i64, text: &str) -> Result<Vec<i64>, String> {
    let mut steps = Vec::new();
    for word in text.split_whitespace() {
        let (step, count) = word.split_once('x').unwrap_or((word, "1"));
        let run = nanoseconds(step).zip(count.parse().ok().filter(|count| *count > 0));
        let (step, count) =
            run.ok_or_else(|| format!("`{word}` is no step in milliseconds like 560 or 560x37"))?;
        extend(&mut steps, step, count)?;
    }
    let mut at = first_ns;
    let mut stamps = vec![first_ns];
    for step in steps {
        at = at
            .checked_add(step)
            .ok_or_else(|| "the steps lead beyond all time".to_owned())?;
        stamps.push(at);
    }
    Ok(stamps)
}

fn nanoseconds(text: &str) -> Option<i64> {
    let (whole, rest) = text.split_once('.').unwrap_or((text, "0"));
    if rest.len() > 6 || !(whole.bytes().chain(rest.bytes())).all(|b| b.is_ascii_digit()) {
        return None;
    }
    let whole: i64 = whole.parse().ok()?;
    let rest: i64 = format!("{rest:0<6}").parse().ok()?;
    whole.checked_mul(NS_PER_MS)?.checked_add(rest)
}

fn extend<T: Clone>(list: &mut Vec<T>, item: T, count: usize) -> Result<(), String> {
    if list.len().saturating_add(count) > MOST_ARCS {
        return Err(format!("more than {MOST_ARCS} arcs"));
    }
    list.extend(std::iter::repeat_n(item, count));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_labels_and_stamps_come_back(
            marks in prop::collection::vec(0..3_usize, 0..60),
            first in any::<i32>(),
            steps in prop::collection::vec(prop::sample::select(vec![0, 1, 560_000_000, 1_120_000_000, 560_000_001, 33_333_333]), 0..60),
        ) {
            let marks: Vec<Mark> = marks.into_iter().map(|i| Mark::ALL[i]).collect();
            let text = encode_marks(marks.iter().copied());
            prop_assert_eq!(decode_marks(&text).unwrap(), marks);
            let mut stamps = vec![i64::from(first)];
            for step in steps {
                stamps.push(stamps.last().unwrap() + step);
            }
            let text = encode_steps(&stamps);
            prop_assert_eq!(decode_steps(stamps[0], &text).unwrap(), stamps);
        }
    }

    #[test]
    fn the_text_is_short() {
        use Mark::{Contact, Intersection, Unidentified};
        let marks = [Contact, Contact, Intersection, Unidentified, Unidentified];
        assert_eq!(encode_marks(marks), "2C 1I 2u");
        let stamps = [5, 560_000_005, 1_120_000_005, 1_120_500_005];
        assert_eq!(encode_steps(&stamps), "560x2 0.5");
    }

    #[test]
    fn what_is_no_text_of_ours_is_refused() {
        for text in [
            "12",
            "C",
            "0C",
            "-1C",
            "3X",
            "99999999999C",
            "1C 4999999999I",
            "3\u{20ac}",
        ] {
            assert!(decode_marks(text).is_err(), "{text}");
        }
        for text in [
            "x",
            "5x",
            "x5",
            "5x0",
            "-5",
            "1.1234567",
            "9223372036855",
            "1x6000000",
            "1e3",
            "9223372036854x5",
        ] {
            assert!(decode_steps(0, text).is_err(), "{text}");
        }
    }
}
