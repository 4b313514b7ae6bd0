#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| tmam_replay::io::log::fuzzing::custom(input));
