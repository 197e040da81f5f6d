//! Logs: what is read, what is refused with its place, what is odd and told; and no file, however broken, makes a reader panic.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a failing test may panic; a skipped one must say so

mod public_data;

use boxplus::io::{
    self, IoError, IoErrorKind, Layout, Stamp, Unit, read_euroc_imu, read_euroc_states, read_kitti_imu,
    read_log, read_mrclam_barcodes, read_mrclam_groundtruth, read_mrclam_landmarks, read_mrclam_measurements,
    read_mrclam_odometry, read_positions, read_tum, write_tum,
};
use boxplus::recording::{Log, Oddity};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PLAIN: Layout<2> = Layout {
    format: "plain rows",
    stamp: Stamp::Seconds,
    fields: "time angle rate",
    named: false,
    units: [Unit::Angle, Unit::Rate],
};

fn plain(text: &str) -> Result<Log<[f64; 2]>, IoError> {
    read_log(text.as_bytes(), "bad.csv", &PLAIN, Ok)
}

/// Checks the whole message, the text under the span, and that the help says something.
fn assert_refused(text: &str, message: &str, under_span: &str, help: &str) {
    let error = plain(text).unwrap_err();
    assert_eq!(error.to_string(), format!("bad.csv:{message}"));
    let span = error.place.as_ref().map_or(0..0, |place| place.span.clone());
    assert_eq!(&text[span], under_span, "{message}");
    assert!(error.help().contains(help), "{}", error.help());
}

#[test]
fn what_is_malformed_is_refused_at_its_place() {
    assert_refused(
        "0,1,2\n1,x,3\n",
        "2:3: `x` is not a number; expected angle in field 2 of plain rows",
        "x",
        "such a line reads: plain rows time angle rate",
    );
    assert_refused(
        "0 1 2\n1 2\n",
        "2:4: the line ends too early; expected rate in field 3 of plain rows",
        "",
        "time angle",
    );
    assert_refused("0;1;2;4", "1:7: the line goes on after its last field, with `4`", "4", "time angle rate");
    assert_refused(
        "0,1,2\nnow,1,3",
        "2:1: `now` is not a time; expected time in field 1 of plain rows",
        "now",
        "seconds",
    );
    assert_refused(
        "0,1,2\nnan,1,3",
        "2:1: `nan` is not a time; expected time in field 1 of plain rows",
        "nan",
        "seconds",
    );
    assert_refused(
        "5,1,2\n6.5,1,2\n5.5,1,2\n",
        "3:1: time runs back by 1.000 s",
        "5.5,1,2",
        "Cut the file there",
    );
    assert_refused(
        "",
        " no row of plain rows in this file (0 rows with NaN, infinite or absent numbers)",
        "",
        "right file",
    );
    assert_refused(
        "0,nan,1\n1,,2",
        " no row of plain rows in this file (2 rows with NaN, infinite or absent numbers)",
        "",
        "",
    );
    let named = Layout { named: true, ..PLAIN };
    let error = read_log(b"time,rate,heading\n0,1,2", "bad.csv", &named, Ok).unwrap_err();
    assert_eq!(error.to_string(), "bad.csv:1:1: no column is called angle");
    assert!(error.help().contains("time angle rate"));
    let error = read_tum(b"0 0 0 0 0 0 0 0", "bad.tum").unwrap_err();
    assert_eq!(error.to_string(), "bad.tum:1:1: the quaternion is zero");
    let error = read_mrclam_measurements(b"0 1.5 2 3", "m.dat").unwrap_err();
    assert_eq!(error.to_string(), "m.dat:1:1: `1.5` is not an id");
}

#[test]
fn what_is_odd_is_told_and_handled() {
    let oddities = |text| plain(text).unwrap().oddities;
    assert_eq!(oddities("0,1,2\n1,1,2\n2,1,2"), []);
    assert_eq!(oddities("0,1,2\n1,nan,2\n2,inf,2\n3,,1\n4,1,2"), [Oddity::Missing { rows: 3, line: 2 }]);
    let log = plain("0,1,2\n2,3,2\n1.5,2,2\n3,4,2").unwrap();
    assert_eq!(log.oddities, [Oddity::OutOfOrder { rows: 1, line: 3 }]);
    assert_eq!(log.samples.iter().map(|s| s.value[0]).collect::<Vec<_>>(), [1.0, 2.0, 3.0, 4.0]);
    let gap = Oddity::Gaps { count: 1, longest: 7.0, line: 4, usual: 1.0 };
    assert_eq!(oddities("0,1,2\n1,1,2\n2,1,2\n9,1,2\n10,1,2"), [gap]);
    let degrees = |field, line, value| [Oddity::Degrees { field, line, value }];
    assert_eq!(oddities("0,3,2\n1,-180,2\n2,200,2"), degrees("angle", 2, -180.0));
    assert_eq!(oddities("0,3,90\n1,3,2\n2,6,2"), degrees("rate", 1, 90.0));
    let in_g = "0,0,0,0,0,0,1.01\n5000000,0,0,0,0,0,0.99";
    assert_eq!(
        read_euroc_imu(in_g.as_bytes(), "").unwrap().oddities,
        [Oddity::MultiplesOfG { median: 1.01 }]
    );
    let rough = "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1.1";
    assert_eq!(
        read_tum(rough.as_bytes(), "").unwrap().oddities,
        [Oddity::QuaternionNorm { rows: 1, line: 2 }]
    );
}

#[test]
fn samples_of_one_time_keep_the_order_of_the_file() {
    let log = plain("1,1,0\n0.5,2,0\n1,3,0\n0.5,4,0\n").unwrap();
    assert_eq!(log.samples.iter().map(|s| s.value[0]).collect::<Vec<_>>(), [2.0, 4.0, 1.0, 3.0]);
}

#[test]
fn times_are_kept_to_the_nanosecond() {
    let stamp = |text: &str| plain(&format!("{text},0,0")).unwrap().samples[0].stamp_ns;
    assert_eq!(stamp("1403715274.302140001"), 1_403_715_274_302_140_001);
    assert_eq!(stamp("-0.000000001"), -1);
    assert_eq!(stamp("46534.47837579"), 46_534_478_375_790);
    assert_eq!(stamp("0.9999999996"), 1_000_000_000);
    assert_eq!(stamp("3.8570532019138336e+003"), 3_857_053_201_914);
    let nanoseconds = read_euroc_imu(b"1403715273262142976,0,0,0,0,0,9.8", "").unwrap();
    assert_eq!(nanoseconds.samples[0].stamp_ns, 1_403_715_273_262_142_976);
    for no_time in ["1e300", "99999999999", "inf", "", "0x10"] {
        let error = plain(&format!("0,0,0\n{no_time},0,0")).unwrap_err();
        assert!(matches!(error.kind, IoErrorKind::NotATime { .. }), "{no_time}: {error}");
    }
}

#[test]
fn columns_are_found_by_name_in_any_order() {
    let named = Layout { named: true, ..PLAIN };
    let text = "# a comment\nrate [no],x\n#rate , place, time,angle\n4,here,1.5,3\n5,there,2.5,2\n";
    let log = read_log(text.as_bytes(), "", &named, Ok).unwrap();
    assert_eq!(log.samples[0].value, [3.0, 4.0]);
    assert_eq!(log.samples[1].stamp_ns, 2_500_000_000);
}

#[test]
fn a_file_that_unpacks_without_end_is_refused() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![b' '; 1 << 20];
    for _ in 0..64 {
        std::io::Write::write_all(&mut encoder, &zeros).unwrap();
    }
    let error = read_tum(&encoder.finish().unwrap(), "bomb.gz").unwrap_err();
    assert!(matches!(error.kind, IoErrorKind::TooLarge { .. }), "{error}");
}

/// Reads with every reader; errors must point into the text.
fn read_with_all(text: &[u8]) -> usize {
    let named = Layout { named: true, fields: "Time X Y", ..PLAIN };
    let results: [Result<usize, IoError>; 13] = [
        read_tum(text, "f").map(|log| log.samples.len()),
        read_euroc_imu(text, "f").map(|log| log.samples.len()),
        read_euroc_states(text, "f").map(|log| log.samples.len()),
        read_kitti_imu(text, "f").map(|log| log.samples.len()),
        read_positions(text, "f").map(|log| log.samples.len()),
        read_mrclam_odometry(text, "f").map(|log| log.samples.len()),
        read_mrclam_measurements(text, "f").map(|log| log.samples.len()),
        read_mrclam_groundtruth(text, "f").map(|log| log.samples.len()),
        read_mrclam_landmarks(text, "f").map(|all| all.len()),
        read_mrclam_barcodes(text, "f").map(|all| all.len()),
        read_log(text, "f", &PLAIN, Ok).map(|log| log.samples.len()),
        read_log(text, "f", &named, Ok).map(|log| log.samples.len()),
        io::read(text, "f", None).map(|parsed| parsed.graph.vertex_count()),
    ];
    for error in results.iter().filter_map(|result| result.as_ref().err()) {
        assert!(!error.help().is_empty() && !error.to_string().is_empty());
        if let Some(place) = &error.place {
            let lines = text.split(|&b| b == b'\n').count();
            assert!((1..=lines).contains(&(place.line as usize)), "{error}");
            assert!(place.span.start <= place.span.end && place.span.end <= text.len(), "{error}");
        }
    }
    results.iter().filter(|result| result.is_ok()).count()
}

const TEXTS: [&str; 6] = [
    "# time tx ty tz qx qy qz qw\n1.5 1 2 3 0 0 0 1\n2.5 1 2 3 0 0 1 0\n3.5 1 2 3 .1 .2 .3 .9\n",
    "#timestamp [ns],w\n1403715273262142976,-0.002,0.017,0.077,9.08,0.13,-3.69\n1403715273267142912,0,0,0,9,nan,-3\n",
    "Time dt accelX accelY accelZ omegaX omegaY omegaZ\n1 1 1 1 9 0 0 0\n2 1 1 1 9 0 0 0\n",
    "Time,X,Y,Z\n1,2,3,4\n2,3,4,5\n",
    "# Time [s]    Subject #    range [m]    bearing [rad]\n1248444189.599 \t  14 \t  3.787 \t -0.257\n2e9 90 6.7 1\n",
    "  1 \t   5\n  2 \t  14\n",
];

#[test]
fn twenty_thousand_injured_logs_never_panic_and_errors_point_into_the_file() {
    const BYTES: &[u8] = b"0123456789.-+eE \n\r\t#,;NaIf\0\xff\x1f\x8b";
    let mut rng = ChaCha8Rng::seed_from_u64(2026);
    let mut read = 0;
    for round in 0..20_000 {
        let mut text = TEXTS[round % TEXTS.len()].as_bytes().to_vec();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..text.len().max(1)).min(text.len().saturating_sub(1));
            let end = (at + rng.random_range(1..30)).min(text.len());
            match rng.random_range(0..5) {
                0 => text[at] = BYTES[rng.random_range(0..BYTES.len())],
                1 => text.insert(at, BYTES[rng.random_range(0..BYTES.len())]),
                2 => drop(text.drain(at..end)),
                3 => text.extend_from_within(at..end),
                _ => text.truncate(at),
            }
            if text.is_empty() {
                text.push(b'1');
            }
        }
        read += read_with_all(&text);
    }
    assert!((2000..60_000).contains(&read), "{read} read: the injuries are too mild or too severe");
}

#[test]
fn bytes_of_any_kind_never_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for length in 0..600 {
        let bytes: Vec<u8> = (0..length).map(|_| rng.random()).collect();
        read_with_all(&bytes);
    }
}

#[test]
fn public_logs_are_read_whole() {
    let count = |path: &str, read: fn(&[u8], &str) -> usize| {
        public_data::bytes(path).map(|bytes| (path.to_owned(), read(&bytes, path)))
    };
    let tum = |bytes: &[u8], name: &str| read_tum(bytes, name).unwrap().samples.len();
    let all = [
        (count("inertial/euroc-V1_01_easy/groundtruth-original.tum.txt.gz", tum), 28712),
        (
            count("inertial/euroc-V1_01_easy/imu0.csv.gz", |b, n| {
                read_euroc_imu(b, n).unwrap().samples.len()
            }),
            29120,
        ),
        (
            count("inertial/euroc-V1_01_easy/groundtruth-recomputed.csv", |b, n| {
                read_euroc_states(b, n).unwrap().samples.len()
            }),
            2895,
        ),
        (
            count("inertial/kitti-imu-gps/KittiEquivBiasedImu.txt.gz", |b, n| {
                read_kitti_imu(b, n).unwrap().samples.len()
            }),
            46968,
        ),
        (
            count("inertial/kitti-imu-gps/KittiGps_converted.txt", |b, n| {
                read_positions(b, n).unwrap().samples.len()
            }),
            470,
        ),
        (
            count("landmark-slam/mrclam6/Landmark_Groundtruth.dat", |b, n| {
                read_mrclam_landmarks(b, n).unwrap().len()
            }),
            15,
        ),
        (count("landmark-slam/mrclam6/Barcodes.dat", |b, n| read_mrclam_barcodes(b, n).unwrap().len()), 20),
    ];
    for (found, expected) in all {
        if let Some((path, found)) = found {
            assert_eq!(found, expected, "{path}");
        }
    }
    let robots = (1..=5).filter_map(|robot| {
        let path = format!("landmark-slam/mrclam6/Robot{robot}_Measurement.dat.gz");
        Some(read_mrclam_measurements(&public_data::bytes(&path)?, &path).unwrap().samples.len())
    });
    let sightings: usize = robots.sum();
    assert!(sightings == 0 || sightings == 19377, "{sightings}");
}

#[test]
fn a_trajectory_that_was_written_is_read_and_written_as_it_was() {
    for k in 0..200 {
        let [a, b, c, d] = [1, 2, 3, 4].map(|i| f64::from(7 * k + 3 * i).sin()); // of any norm
        let text = format!("{k} 0.1 0.2 9 {a} {b} {c} {d}\n");
        let once = write_tum(&read_tum(text.as_bytes(), "").unwrap().samples);
        let twice = write_tum(&read_tum(once.as_bytes(), "").unwrap().samples);
        assert_eq!(once, twice, "dividing by a norm that is off in its last digit moves last digits");
    }
}
