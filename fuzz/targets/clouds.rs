//! Files of point clouds: nothing panics; the points that are read are finite, and are written and read as the same points.
#![no_main]

use boxplus::io::cloud::{CloudFormat, read, write_ply};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let formats = [CloudFormat::Ply, CloudFormat::Pcd, CloudFormat::Text, CloudFormat::Kitti];
    for format in formats.into_iter().map(Some).chain([None]) {
        let Ok(cloud) = read(bytes, "fuzz", format) else { continue };
        assert!(cloud.points.iter().all(|p| p.iter().all(|x| x.is_finite())));
        let text = write_ply(&cloud.points).expect("they are finite");
        assert_eq!(read(&text, "again", None).map(|again| again.points).as_ref(), Ok(&cloud.points));
    }
});
