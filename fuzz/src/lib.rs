//! The part of `tmam` that reads bytes from files, without the rest.

/// The room `log/`, as far as it is fuzzed.
#[path = "../../src/log"]
pub mod log {
    pub mod container;
    pub mod fuzzing;
    mod ros2;
    #[allow(dead_code, reason = "only decoding is fuzzed")]
    mod value;
}
