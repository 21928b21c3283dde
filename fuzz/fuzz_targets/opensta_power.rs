#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| raypath_fuzz::parse("opensta_power", data));
