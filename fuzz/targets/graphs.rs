//! Graph files: nothing panics, and what was read is written as text that reads as the same graph.
#![no_main]

use boxplus::io::{self, Format};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for format in [None, Some(Format::G2o), Some(Format::Toro), Some(Format::Isam), Some(Format::Pyfg)] {
        let Ok(parsed) = io::read(bytes, "fuzz", format) else { continue };
        let _ = (parsed.graph.faults(), parsed.graph.statistics(), parsed.graph.loop_closures());
        let Ok(text) = io::write(&parsed.graph, Format::G2o) else { continue };
        let again = io::read(text.as_bytes(), "again", Some(Format::G2o)).expect("what was written can be read");
        assert_eq!(io::write(&again.graph, Format::G2o).as_ref(), Ok(&text));
        for other in [Format::Toro, Format::Isam, Format::Pyfg] {
            let Ok(text) = io::write(&parsed.graph, other) else { continue };
            io::read(text.as_bytes(), "again", Some(other)).expect("what was written can be read");
        }
    }
});
