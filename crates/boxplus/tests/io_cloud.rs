//! Files of point clouds: every format is read as written, every injury is told with its place, none of them panics.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used)] // a failing test may panic
#![allow(clippy::print_stdout)] // a skipped test says so

#[path = "public_data/mod.rs"]
mod public_data;

use boxplus::io::cloud::{self, CloudFormat};
use boxplus::io::{IoError, IoErrorKind};
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;

/// Three points whose coordinates are exact in 32 bits.
fn three() -> Vec<Vector3<f64>> {
    vec![vector![1.0, -2.5, 3.25], vector![0.0, 1e6, -0.125], vector![7.0, 8.0, 9.0]]
}

fn points(bytes: &[u8], name: &str) -> Vec<Vector3<f64>> {
    cloud::read(bytes, name, None).unwrap().points
}

fn refused(bytes: impl AsRef<[u8]>, name: &str) -> IoError {
    cloud::read(bytes.as_ref(), name, None).unwrap_err()
}

/// A PLY with a colour between the coordinates, a list, and an element before the vertices.
fn ply(encoding: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\ncomment made up\nelement camera 1\nproperty list uchar int tags\nelement vertex 3\nproperty float x\nproperty uchar red\nproperty double y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let big = encoding == "binary_big_endian";
    let put = |bytes: &mut Vec<u8>, mut little: Vec<u8>| {
        if big {
            little.reverse();
        }
        bytes.extend(little);
    };
    if encoding == "ascii" {
        bytes.extend(b"2 5 6\n1 255 -2.5 3.25\n0 0 1e6 -0.125\n7 1 8 9\n3 0 1 2\n");
        return bytes;
    }
    bytes.push(2);
    [5_i32, 6].iter().for_each(|x| put(&mut bytes, x.to_le_bytes().to_vec()));
    for p in three() {
        put(&mut bytes, (p.x as f32).to_le_bytes().to_vec());
        bytes.push(255);
        put(&mut bytes, p.y.to_le_bytes().to_vec());
        put(&mut bytes, (p.z as f32).to_le_bytes().to_vec());
    }
    bytes.push(3);
    [0_i32, 1, 2].iter().for_each(|x| put(&mut bytes, x.to_le_bytes().to_vec()));
    bytes
}

/// A PCD with a field of two counts before the coordinates.
fn pcd(data: &str) -> Vec<u8> {
    let mut bytes = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS normal x y z\nSIZE 2 4 8 4\nTYPE U F F F\nCOUNT 2 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {data}\n"
    )
    .into_bytes();
    let columns = |p: &Vector3<f64>| {
        let f = |x: f64| (x as f32).to_le_bytes().to_vec();
        [vec![1, 0, 2, 0], f(p.x), p.y.to_le_bytes().to_vec(), f(p.z)]
    };
    match data {
        "ascii" => {
            three().iter().for_each(|p| bytes.extend(format!("1 2 {} {} {}\n", p.x, p.y, p.z).bytes()));
        }
        "binary" => three().iter().for_each(|p| bytes.extend(columns(p).concat())),
        _ => {
            let rows: Vec<_> = three().iter().map(columns).collect();
            let body: Vec<u8> =
                (0..4).flat_map(|k| rows.iter().flat_map(move |row| row[k].clone())).collect();
            let packed: Vec<u8> =
                body.chunks(32).flat_map(|c| [&[c.len() as u8 - 1][..], c].concat()).collect();
            bytes.extend((packed.len() as u32).to_le_bytes());
            bytes.extend((body.len() as u32).to_le_bytes());
            bytes.extend(packed);
        }
    }
    bytes
}

fn kitti(stride: usize) -> Vec<u8> {
    let point = |p: &Vector3<f64>| [p.x, p.y, p.z, 0.5].into_iter().take(stride).collect::<Vec<_>>();
    three().iter().flat_map(point).flat_map(|x| (x as f32).to_le_bytes()).collect()
}

/// One file of each kind.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let text = |separator: &str| -> Vec<u8> {
        let line = |p: &Vector3<f64>| format!("{}{separator}{}{separator}{}\n", p.x, p.y, p.z).into_bytes();
        three().iter().flat_map(line).collect()
    };
    vec![
        ("a.ply", ply("ascii")),
        ("b.ply", ply("binary_little_endian")),
        ("c.ply", ply("binary_big_endian")),
        ("a.pcd", pcd("ascii")),
        ("b.pcd", pcd("binary")),
        ("c.pcd", pcd("binary_compressed")),
        ("a.xyz", text("  ")),
        ("a.csv", [b"x,y,z\n".to_vec(), text(" , ")].concat()),
        (
            "b.csv",
            b"\xef\xbb\xbf\"t\";\"z\";\"x\";\"y\"\r\n0;3.25;1;-2.5\r\n0;-0.125;0;1e6\r\n0;9;7;8\r\n".to_vec(),
        ),
        ("a.bin", kitti(4)),
        ("b.bin", kitti(3)),
        ("written.ply", cloud::write_ply(&three()).unwrap()),
    ]
}

#[test]
fn every_format_gives_the_same_points() {
    for (name, bytes) in samples() {
        assert_eq!(points(&bytes, name), three(), "{name}");
        let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::default());
        packed.write_all(&bytes).unwrap();
        assert_eq!(points(&packed.finish().unwrap(), &format!("{name}.gz")), three(), "{name}");
    }
}

#[test]
fn two_columns_are_a_cloud_of_the_plane() {
    for (name, text) in [
        ("a.csv", "1 , 2\n3,4\n"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nend_header\n1 2\n3 4\n",
        ),
        ("a.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n1 2\n3 4\n"),
    ] {
        let cloud = cloud::read(text.as_bytes(), name, None).unwrap();
        assert!(cloud.planar, "{name}");
        assert_eq!(cloud.points, [vector![1.0, 2.0, 0.0], vector![3.0, 4.0, 0.0]], "{name}");
    }
}

#[test]
fn an_empty_field_keeps_the_columns_apart() {
    // As pandas writes a frame: the index has no name.
    let indexed = b",x,y,z\n0,1,2,3\n1,4,5,6\n";
    assert_eq!(points(indexed, "frame.csv"), [vector![1.0, 2.0, 3.0], vector![4.0, 5.0, 6.0]]);
    assert_eq!(points(b"x,y,note,z\n1,2,,3\n4,5,,6,\n", "a.csv")[1], vector![4.0, 5.0, 6.0]);
    assert_eq!(points(b"1;2;3;;7\n", "a.csv"), [vector![1.0, 2.0, 3.0]]);
    for text in ["1,,3,4\n", "1 , , 3,4\n", "x,y,z,i\n1,,3,4\n"] {
        let error = refused(text, "a.csv").to_string();
        assert!(error.ends_with("`` is not a number; expected y"), "{error}");
    }
}

#[test]
fn points_that_are_none_are_left_out_and_counted() {
    let cloud = cloud::read(b"1 2 3\nnan nan nan\n4 inf 6\n7 8 1e999\n4 5 6\n", "scan.xyz", None).unwrap();
    assert_eq!((cloud.points.len(), cloud.dropped), (2, 3));
    let error = refused("nan nan nan\n", "scan.xyz");
    assert_eq!(
        error.to_string(),
        "scan.xyz: no points in this file (1 with coordinates that are not finite)"
    );
    assert!(cloud::write_ply(&[vector![f64::NAN, 0.0, 0.0]]).is_err());
}

#[test]
fn injuries_are_told_with_their_place() {
    let ascii = String::from_utf8(ply("ascii")).unwrap();
    let header = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\n";
    let cases: &[(&str, String, &str)] = &[
        ("a.xyz", "1 2 3\n4 5\n".into(), "a.xyz:2:4: the line ends too early; expected z"),
        (
            "a.xyz",
            "# only\n".into(),
            "a.xyz: no points in this file (0 with coordinates that are not finite)",
        ),
        ("a.xyz", String::new(), "a.xyz: no points in this file (0 with coordinates that are not finite)"),
        ("a.xyz", "Dear Sir\n".into(), "a.xyz:1:1: `Dear` is not a number; expected x"),
        ("a.xyz", "1 2 3\n\0\0".into(), "a.xyz:2:1: this is not a text file (byte 0x00)"),
        ("a.csv", "a,x,y\n1,2\n".into(), "a.csv:2:4: the line ends too early; expected y"),
        ("a.ply", ascii.replace("-2.5", "two"), "a.ply:15:7: `two` is not a number; expected y"),
        (
            "a.ply",
            ascii.replace("element vertex 3", "element vertex many"),
            "a.ply:6:16: `many` is not a number; expected the number of its records",
        ),
        (
            "a.ply",
            ascii.replace("float x", "quad x"),
            "a.ply:7:10: `quad` cannot stand here; expected a type: char, uchar, short, ushort, int, uint, float, double",
        ),
        (
            "a.ply",
            ascii.replace("format ascii", "format morse"),
            "a.ply:2:8: `morse` cannot stand here; expected ascii, binary_little_endian or binary_big_endian",
        ),
        (
            "a.ply",
            ascii.replace("format ascii 1.0\n", ""),
            "a.ply:12:1: `end_header` cannot stand here; expected format first",
        ),
        (
            "a.ply",
            ascii.replace("end_header", "comment"),
            "a.ply:14:1: `2` cannot stand here; expected format, element, property, comment, obj_info or end_header",
        ),
        (
            "a.ply",
            ascii.replace("vertex 3", "vertex 9"),
            "a.ply: the file ends after 4 of 9 lines that its header promises",
        ),
        ("a.ply", ascii.replace("float x", "float u"), "a.ply: the points have no x and y"),
        ("a.ply", "ply\nformat ascii 1.0\n".into(), "a.ply: the header has no `end_header`"),
        (
            "a.pcd",
            format!("{header}DATA ascii\n1 2 3\n"),
            "a.pcd: the file ends after 1 of 2 lines that its header promises",
        ),
        (
            "a.pcd",
            format!("{header}DATA morse\n"),
            "a.pcd:5:6: `morse` cannot stand here; expected ascii, binary or binary_compressed",
        ),
        (
            "a.pcd",
            format!("{header}DATA binary\nab"),
            "a.pcd: the file ends at byte 57, 22 bytes before what its header promises",
        ),
        ("a.pcd", header.replace("4 4 4", "4 4"), "a.pcd: the header has no `DATA`"),
        (
            "a.pcd",
            format!("{}DATA ascii\n", header.replace("4 4 4", "4 4")),
            "a.pcd: `SIZE` is missing in the header, or has not one entry per field",
        ),
        (
            "a.pcd",
            format!("{}DATA ascii\n", header.replace("4 4 4", "4 3 4")),
            "a.pcd: no number of the given type has 3 bytes",
        ),
        (
            "a.pcd",
            format!("{}DATA ascii\n", header.replace("WIDTH 2\n", "")),
            "a.pcd: `POINTS` is missing in the header, or has not one entry per field",
        ),
        (
            "a.pcd",
            format!("{header}DATA binary_compressed\n\u{1}\0\0\0\u{18}\0\0\0\u{7f}"),
            "a.pcd: the compressed points are corrupt",
        ),
        (
            "a.bin",
            "abcde".into(),
            "a.bin: 5 bytes are no whole number of points of three or four 32-bit floats",
        ),
        ("a.bin", String::new(), "a.bin: no points in this file (0 with coordinates that are not finite)"),
    ];
    for (name, text, message) in cases {
        let error = refused(text, name);
        assert_eq!(error.to_string(), *message);
        assert!(!error.help().is_empty());
    }
}

#[test]
fn a_header_that_promises_more_than_the_memory_of_the_world_is_refused_at_once() {
    let most = usize::MAX;
    for text in [
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {most}\nproperty float x\nproperty float y\nend_header\nabcdefgh"),
        format!("ply\nformat binary_little_endian 1.0\nelement blank {most}\nelement vertex 1\nproperty float x\nproperty float y\nend_header\nabc"),
        format!("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH {most}\nHEIGHT {most}\nDATA binary\nabcdefgh"),
        format!("FIELDS x y f\nSIZE 4 4 8\nTYPE F F F\nCOUNT 1 1 {most}\nPOINTS 2\nDATA binary\nabcdefgh"),
        "FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 2\nDATA binary_compressed\n\u{1}\0\0\0\u{7f}\u{7f}\u{7f}\u{7f}a".to_owned(),
    ] {
        let error = refused(&text, if text.starts_with("ply") { "a.ply" } else { "a.pcd" });
        let expected = matches!(error.kind, IoErrorKind::Truncated { .. } | IoErrorKind::LzfCorrupt);
        assert!(expected, "{error}");
    }
}

#[test]
fn every_cut_is_read_or_refused() {
    for (name, bytes) in samples() {
        for end in 0..bytes.len() {
            if let Ok(cloud) = cloud::read(&bytes[..end], name, None) {
                assert!(
                    cloud.points.len() <= 4 && cloud.points.iter().all(|p| p.iter().all(|x| x.is_finite()))
                );
            }
        }
    }
}

#[test]
fn many_thousand_random_injuries_never_panic() {
    let mut draw = ChaCha8Rng::seed_from_u64(1);
    for (name, bytes) in samples() {
        for _ in 0..5000 {
            let mut injured = bytes.clone();
            for _ in 0..draw.random_range(1..6) {
                let at = draw.random_range(0..injured.len());
                match draw.random_range(0..4) {
                    0 => injured[at] = draw.random(),
                    1 => injured[at] ^= 1 << draw.random_range(0..8),
                    2 => drop(injured.drain(at..(at + draw.random_range(1..9)).min(injured.len()))),
                    _ => injured.insert(at, *b"0123456789 -\n.e".get(draw.random_range(0..15)).unwrap()),
                }
                if injured.is_empty() {
                    break;
                }
            }
            for format in [None, Some(CloudFormat::ALL[draw.random_range(0..4)])] {
                let _ = cloud::read(&injured, name, format);
            }
        }
    }
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        for format in CloudFormat::ALL {
            let _ = cloud::read(&bytes, "any", Some(format));
        }
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit(
        xyz in proptest::collection::vec(proptest::array::uniform3(proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO), 1..50)
    ) {
        let written: Vec<_> = xyz.into_iter().map(Vector3::from).collect();
        prop_assert_eq!(points(&cloud::write_ply(&written).unwrap(), "a.ply"), written);
    }
}

#[test]
fn public_files_have_as_many_points_as_their_authors_say() {
    for (name, count, planar) in [
        ("small_gicp-source.ply", 69792, false),
        ("small_gicp-target.ply", 69088, false),
        ("bunny-bun_zipper_res3.ply", 1889, false),
        ("bunny-part1.xyz", 20702, false),
        ("car_cloud400.csv.gz", 24989, false),
        ("car_cloud401.csv.gz", 25193, false),
        ("2D_oneBox.csv", 0, true),
        ("kitti_07_dump/000000.points.bin", 21562, false),
        ("kitti_07_dump/000001.points.bin", 24703, false),
        ("kitti_07_dump/000002.points.bin", 24573, false),
        ("kitti_07_dump/000003.points.bin", 16911, false),
        ("kitti_07_dump/000004.points.bin", 19872, false),
    ] {
        let Some(bytes) = public_data::bytes(&format!("registration/{name}")) else { return };
        let cloud = cloud::read(&bytes, name, None).unwrap_or_else(|e| panic!("{e}"));
        println!("{name}: {} points", cloud.points.len());
        assert!(count == 0 || cloud.points.len() == count, "{name}: {}", cloud.points.len());
        assert_eq!((cloud.planar, cloud.dropped), (planar, 0), "{name}");
    }
}
