//! Ways to damage a file.

use std::ops::Range;

/// A seeded generator (SplitMix64): the same faults in every run.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.roll() % end as u64) as usize
    }
}

/// One fault, in places of the whole file.
#[derive(Debug, Clone)]
pub enum Fault {
    /// One bit of a byte.
    Flip(usize, u8),
    /// A range of zeros.
    Zero(Range<usize>),
    /// A range taken out.
    Delete(Range<usize>),
    /// Bytes put in.
    Insert(usize, Vec<u8>),
    /// A range that stands there twice.
    Duplicate(Range<usize>),
    /// Nothing from there on.
    Truncate(usize),
    /// Zeros from there on.
    ZeroTail(usize),
}

impl Fault {
    /// Any fault but the last two, behind the magic bytes.
    pub fn random(dice: &mut Dice, length: usize) -> Self {
        let at = 8 + dice.below(length - 8);
        let size = 1 + dice.below(120);
        let range = at..(at + size).min(length);
        match dice.below(5) {
            0 => Self::Flip(at, dice.below(8) as u8),
            1 => Self::Zero(range),
            2 => Self::Delete(range),
            3 => Self::Insert(at, (0..size).map(|_| dice.roll() as u8).collect()),
            _ => Self::Duplicate(range),
        }
    }

    pub fn apply(&self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        match self {
            Self::Flip(at, bit) => bytes[*at] ^= 1 << bit,
            Self::Zero(range) => bytes[range.clone()].fill(0),
            Self::Delete(range) => drop(bytes.drain(range.clone())),
            Self::Insert(at, more) => drop(bytes.splice(at..at, more.iter().copied())),
            Self::Duplicate(range) => {
                let copy = bytes[range.clone()].to_vec();
                bytes.splice(range.end..range.end, copy);
            }
            Self::Truncate(at) => bytes.truncate(*at),
            Self::ZeroTail(at) => bytes[*at..].fill(0),
        }
        bytes
    }

    /// Whether a record of the whole file is still there, byte for byte.
    pub fn spares(&self, record: &Range<usize>) -> bool {
        let apart = |range: &Range<usize>| range.end <= record.start || record.end <= range.start;
        match self {
            Self::Flip(at, _) => !record.contains(at),
            Self::Zero(range) | Self::Delete(range) => apart(range),
            Self::Insert(at, _) => *at <= record.start || record.end <= *at,
            Self::Duplicate(range) => range.end <= record.start || record.end <= range.end,
            Self::Truncate(at) | Self::ZeroTail(at) => record.end <= *at,
        }
    }
}
