//! Random numbers that are the same on every platform.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// A generator of ChaCha8 numbers; its transcendental functions come from `libm`.
pub struct Random(ChaCha8Rng);

impl Random {
    /// Streams of one seed are independent of each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut key = [0; 32];
        for (byte, value) in key.iter_mut().zip(seed.to_le_bytes()) {
            *byte = value;
        }
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(stream);
        Self(generator)
    }

    /// Evenly from [0, 1).
    pub fn uniform(&mut self) -> f64 {
        const BITS: u32 = f64::MANTISSA_DIGITS;
        (self.0.next_u64() >> (u64::BITS - BITS)) as f64 / (1_u64 << BITS) as f64
    }

    /// Normal with deviation 1, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        radius * libm::cos(TAU * self.uniform())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Of a sample.
    pub(in crate::tools::simulate) fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        (mean, variance.sqrt())
    }

    #[test]
    fn normal_numbers_are_normal() {
        let mut random = Random::new(1, 0);
        let values: Vec<_> = (0..20_000).map(|_| random.normal()).collect();
        let (mean, deviation) = mean_and_deviation(&values);
        assert!(mean.abs() < 0.03 && (deviation - 1.0).abs() < 0.03);
        let beyond_two = values.iter().filter(|v| v.abs() > 2.0).count() as f64 / 20_000.0;
        assert!((beyond_two - 0.0455).abs() < 0.01);
    }

    #[test]
    fn streams_and_seeds_differ_and_repeat() {
        let draw = |seed, stream| Random::new(seed, stream).uniform();
        assert_eq!(draw(1, 0), draw(1, 0));
        assert_ne!(draw(1, 0), draw(1, 1));
        assert_ne!(draw(1, 0), draw(2, 0));
    }
}
