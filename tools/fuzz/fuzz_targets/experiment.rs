//! [`anemo_tests::fuzz::experiment`] by libFuzzer.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    anemo_tests::fuzz::experiment::run(bytes);
});
