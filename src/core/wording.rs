//! Numbers in sentences: one message, two messages.

use crate::core::rounding::fixed;

/// `1 gap`, `2 gaps`; the last word of `thing` is the one that is counted.
pub fn counted(count: u64, thing: &str) -> String {
    format!("{count} {}", plural(count, thing))
}

/// `1 message has`, `2 messages have`.
pub fn counted_with(count: u64, thing: &str, one: &str, many: &str) -> String {
    let verb = if count == 1 { one } else { many };
    format!("{} {verb}", counted(count, thing))
}

/// `gap`, or `gaps` where there is not exactly one.
pub fn plural(count: u64, thing: &str) -> String {
    if count == 1 {
        return thing.to_owned();
    }
    let stem = thing.strip_suffix('y').filter(|stem| {
        let before = stem.chars().last();
        before.is_some_and(|c| !matches!(c, 'a' | 'e' | 'i' | 'o' | 'u'))
    });
    match stem {
        Some(stem) => format!("{stem}ies"),
        None if ["s", "x", "o", "ch", "sh"]
            .iter()
            .any(|end| thing.ends_with(end)) =>
        {
            format!("{thing}es")
        }
        None => format!("{thing}s"),
    }
}

/// `once`, `2 times`.
pub fn times(count: u64) -> String {
    match count {
        1 => "once".to_owned(),
        n => format!("{n} times"),
    }
}

/// `a, b, c and 3 more`.
pub fn few(names: &[String]) -> String {
    const SHOWN: usize = 3;
    let shown = names.iter().take(SHOWN).map(String::as_str);
    let shown = shown.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The time from one stamp to another as seconds with so many decimals; zero has no sign.
pub fn seconds_between(from_ns: i64, to_ns: i64, decimals: usize) -> String {
    fixed(to_ns.saturating_sub(from_ns) as f64 * 1e-9, decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        assert_eq!(counted(1, "gap"), "1 gap");
        assert_eq!(counted(0, "gap"), "0 gaps");
        assert_eq!(counted(2, "echo"), "2 echoes");
        assert_eq!(counted(2, "range message"), "2 range messages");
        assert_eq!(counted(3, "entry"), "3 entries");
        assert_eq!(counted(3, "way"), "3 ways");
        assert_eq!(counted(3, "match"), "3 matches");
        assert_eq!((times(1), times(2)), ("once".into(), "2 times".into()));
    }

    #[test]
    fn many_names_are_counted() {
        let names = ["a", "b", "c", "d", "e"].map(str::to_owned);
        assert_eq!(few(&names), "a, b, c and 2 more");
        assert_eq!(few(&names[..2]), "a, b");
    }

    #[test]
    fn no_time_has_no_sign() {
        assert_eq!(seconds_between(1_000_000, 0, 1), "0.0");
        assert_eq!(seconds_between(100_000_000, 0, 1), "-0.1");
    }
}
