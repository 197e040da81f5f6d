//! Bundles: nothing panics, and what was read is written as text that reads as the same bundle.
#![no_main]

use boxplus::io::bal;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(parsed) = bal::read(bytes, "fuzz") else { return };
    let _ = parsed.faults();
    let Ok(text) = bal::write(&parsed) else { return };
    let again = bal::read(text.as_bytes(), "again").expect("what was written can be read");
    assert_eq!((again.points, again.observations.len()), (parsed.points, parsed.observations.len()));
});
