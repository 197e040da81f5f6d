//! The examples on public logs keep their errors, and their bands hold the truth. Without the public data these tests say so and pass.
#![allow(clippy::duplicate_mod, reason = "every example brings what they share")]
#![allow(dead_code, clippy::unwrap_used, reason = "an example's `main` is not called; a test may panic")]

#[path = "../examples/attitude.rs"]
mod attitude;
#[path = "../examples/euroc.rs"]
mod euroc;
#[path = "../examples/glass_of_milk.rs"]
mod glass_of_milk;
#[path = "../examples/kitti.rs"]
mod kitti;
#[path = "../examples/log/mod.rs"]
mod log;
#[path = "../examples/mrclam.rs"]
mod mrclam;
#[path = "../examples/plaza.rs"]
mod plaza;
#[path = "../examples/starry_night.rs"]
mod starry_night;

/// Upper bounds of position (m) and rotation (°) RMSE, lower bound of the share inside 3σ, upper bound of the NEES of a
/// coordinate; of every row.
type Bounds = (f64, f64, f64, f64);

/// The bounds have a margin of about a fifth over what was measured.
macro_rules! log {
    ($test:ident, $example:ident, $bounds:expr) => {
        #[test]
        fn $test() {
            let Some(folder) = log::folder(None) else { return };
            let report = $example::run(&folder).unwrap();
            let (position, rotation, inside, nees): Bounds = $bounds;
            assert!(!report.rows.is_empty() && report.picture.svg().len() > 5000);
            for row in &report.rows {
                // Of a camera that is lost for seconds, without the speeds that bridge them.
                let alone = row.name.contains("no speeds");
                let (position, rotation) = if alone { (0.08, 10.0) } else { (position, rotation) };
                assert!(row.position.is_none_or(|x| x < position), "{row:?}");
                assert!(row.rotation.is_none_or(|x| x < rotation), "{row:?}");
                assert!(row.inside > inside && row.nees < nees, "{row:?}");
            }
        }
    };
}

log!(robots_among_landmarks_stay_within_decimetres, mrclam, (0.35, 9.5, 0.94, 1.9));
log!(a_drone_with_a_position_a_second_stays_within_a_decimetre, euroc, (0.13, 4.8, 0.99, 1.45));
log!(a_car_is_found_between_its_positions, kitti, (0.37, 0.0, 0.96, 1.2));
log!(attitude_stays_within_two_degrees, attitude, (0.0, 2.1, 0.94, 1.9));
log!(a_stereo_camera_stays_within_centimetres, starry_night, (0.045, 4.0, 0.91, 6.7));
log!(a_robot_on_a_rail_stays_within_centimetres, glass_of_milk, (0.07, 0.0, 0.6, 9.0));
log!(a_mower_that_hears_ranges_stays_within_decimetres, plaza, (0.36, 2.3, 0.99, 0.4));
