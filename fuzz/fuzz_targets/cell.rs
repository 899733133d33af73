//! Any 60 bytes as a cell, an isovalue and a stretch of a ray.

#![no_main]

mod check;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some(case) = check::case(bytes) {
        check::check(&case);
    }
});
