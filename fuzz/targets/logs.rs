//! Logs of sensors: nothing panics, times increase, and trajectories are written and read as the same.
#![no_main]

use boxplus::io::{
    read_euroc_imu, read_euroc_states, read_kitti_imu, read_mrclam_barcodes, read_mrclam_groundtruth,
    read_mrclam_landmarks, read_mrclam_measurements, read_mrclam_odometry, read_positions, read_tum, write_tum,
};
use boxplus::recording::Log;
use libfuzzer_sys::fuzz_target;

fn check<T, E>(log: Result<Log<T>, E>) {
    let Ok(log) = log else { return };
    assert!(log.samples.windows(2).all(|pair| pair[0].stamp_ns <= pair[1].stamp_ns));
}

fuzz_target!(|bytes: &[u8]| {
    check(read_euroc_imu(bytes, "fuzz"));
    check(read_euroc_states(bytes, "fuzz"));
    check(read_kitti_imu(bytes, "fuzz"));
    check(read_positions(bytes, "fuzz"));
    check(read_mrclam_odometry(bytes, "fuzz"));
    check(read_mrclam_measurements(bytes, "fuzz"));
    check(read_mrclam_groundtruth(bytes, "fuzz"));
    let _ = (read_mrclam_barcodes(bytes, "fuzz"), read_mrclam_landmarks(bytes, "fuzz"));
    let Ok(trajectory) = read_tum(bytes, "fuzz") else { return };
    let text = write_tum(&trajectory.samples);
    let again = read_tum(text.as_bytes(), "again").expect("what was written can be read");
    assert_eq!(write_tum(&again.samples), text);
});
