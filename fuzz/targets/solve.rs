//! Whatever a graph file says, solving and diagnosing it end with an answer or an error.
#![no_main]

use boxplus::io;
use boxplus::pose_graph::solve::{SolveSettings, solve};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(parsed) = io::read(bytes, "fuzz", None) else { return };
    // Large graphs take their time, which is no fault.
    if parsed.graph.vertex_count() > 64 {
        return;
    }
    let mut settings = SolveSettings::default();
    settings.options.max_iterations = 5;
    settings.options.threads = 1;
    if let Ok(solved) = solve(&parsed.graph, &settings) {
        assert!(solved.cost.is_finite());
    }
    let _ = parsed.graph.diagnose();
});
