//! [`anemo_tests::fuzz::frame`] by libFuzzer.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    anemo_tests::fuzz::frame::run(bytes);
});
