#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| tmam_fuzz::log::fuzzing::custom(input));
