//! A big suite in parts that run beside each other.

use std::str::FromStr;

/// Part `index` of `count`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Partition {
    index: usize,
    count: usize,
}

/// Not `I/N`.
#[derive(Debug, thiserror::Error)]
#[error("--partition `{text}` is no part of a suite; give I/N with 1 <= I <= N, such as 2/4")]
pub struct PartitionError {
    text: String,
}

impl FromStr for Partition {
    type Err = PartitionError;

    fn from_str(text: &str) -> Result<Self, PartitionError> {
        let part = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            (1..=count)
                .contains(&index)
                .then_some(Self { index, count })
        });
        part.ok_or_else(|| PartitionError {
            text: text.to_owned(),
        })
    }
}

impl Partition {
    /// Whether it is the first part, which speaks for the whole.
    pub fn is_first(self) -> bool {
        self.index == 1
    }

    /// Every `count`-th of a sorted list, beginning with the `index`-th: parts differ by one log at
    /// most, whatever order the logs are named in.
    pub fn of<T>(self, sorted: Vec<T>) -> Vec<T> {
        let chosen = sorted.into_iter().skip(self.index - 1);
        chosen.step_by(self.count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_make_the_whole_and_share_nothing() {
        let parts = (1..=4).flat_map(|i| Partition { index: i, count: 4 }.of((0..10).collect()));
        let mut all: Vec<i32> = parts.collect();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!(
            "2/4".parse::<Partition>().unwrap(),
            Partition { index: 2, count: 4 }
        );
        for text in ["0/4", "5/4", "1/0", "1", "a/b", "-1/4", ""] {
            assert!(text.parse::<Partition>().is_err(), "{text}");
        }
    }
}
