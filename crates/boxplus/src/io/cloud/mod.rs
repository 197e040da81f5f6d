//! Files of point clouds: bytes in, points out.
//!
//! | format | what | known by |
//! |---|---|---|
//! | [PLY](CloudFormat::Ply) | ascii, binary little and big endian; x, y, z of the element `vertex`, all else passed over | first line `ply` |
//! | [PCD](CloudFormat::Pcd) | ascii, binary, binary_compressed | a header with `FIELDS` and `DATA` |
//! | [text](CloudFormat::Text) | XYZ and CSV: two or three numbers first in a line, apart by blanks, or by commas or semicolons, between which a field may be empty; a header may name the columns x, y, z | anything else that is text |
//! | [KITTI](CloudFormat::Kitti) | `.bin`: 32-bit floats x, y, z, intensity; also x, y, z alone | a name in `.bin` |
//!
//! All may be packed by gzip. Points with a coordinate that is NaN or infinite, as sensors write where nothing came back, are
//! left out and counted.
//!
//! ```
//! use boxplus::io::cloud;
//! let cloud = cloud::read(b"x,y,z\n1,2,3\nnan,0,0\n4,5,6\n", "scan.csv", None)?;
//! assert_eq!((cloud.points.len(), cloud.dropped, cloud.planar), (2, 1, false));
//! let ply = cloud::write_ply(&cloud.points)?;
//! assert_eq!(cloud::read(&ply, "scan.ply", None)?.points, cloud.points);
//!
//! let error = cloud::read(b"1 2 3\n4 five 6\n", "scan.xyz", None).unwrap_err();
//! assert_eq!(error.to_string(), "scan.xyz:2:3: `five` is not a number; expected y");
//! # Ok::<(), boxplus::io::IoError>(())
//! ```

mod fields;
mod header;
mod lzf;
mod pcd;
mod ply;
mod text;

use super::decompress;
use super::error::{IoError, IoErrorKind};
use core::{fmt, str::FromStr};
use fields::{Binary, Number};
pub(super) use fields::{Line, Lines};
use nalgebra::Vector3;

/// A file format of point clouds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CloudFormat {
    /// The polygon file format of Stanford; its faces are ignored.
    Ply,
    /// That of the Point Cloud Library, version 0.7.
    Pcd,
    /// Numbers in lines: `.xyz`, `.csv`, `.txt`.
    Text,
    /// Little-endian 32-bit floats without header. Four to a point (x, y, z, intensity) as in KITTI; three where their number is no
    /// multiple of four, or, if it is one of three, where a fourth number is no intensity from 0 to 255.
    Kitti,
}

impl CloudFormat {
    /// Every format.
    pub const ALL: [Self; 4] = [Self::Ply, Self::Pcd, Self::Text, Self::Kitti];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Pcd => "pcd",
            Self::Text => "text",
            Self::Kitti => "kitti",
        }
    }
}

impl fmt::Display for CloudFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`CloudFormat::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a format of point clouds; choose ply, pcd, text or kitti")]
pub struct UnknownCloudFormat;

impl FromStr for CloudFormat {
    type Err = UnknownCloudFormat;

    fn from_str(name: &str) -> Result<Self, UnknownCloudFormat> {
        Self::ALL.into_iter().find(|format| format.name() == name).ok_or(UnknownCloudFormat)
    }
}

/// A point cloud that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Its points, all finite, in the units of the file; z is 0 where it has none.
    pub points: Vec<Vector3<f64>>,
    /// Whether it has two coordinates only.
    pub planar: bool,
    /// How many points had a coordinate that is NaN or infinite, and are left out.
    pub dropped: usize,
    /// The format it was read in.
    pub format: CloudFormat,
}

/// Reads a point cloud from the bytes of a file, plain or gzip. `name` appears in errors; without a `format` it and the content
/// decide.
///
/// Time and memory are linear in the size of the file, whatever its header promises.
///
/// # Errors
/// [`IoError`]: what is malformed or ends early, with the line, or the byte after decompression.
pub fn read(bytes: &[u8], name: &str, format: Option<CloudFormat>) -> Result<Cloud, IoError> {
    let text = decompress(bytes, name)?;
    let format = format.unwrap_or_else(|| sniff(&text, name));
    let file = File { name, bytes: &text };
    let mut points = Points::default();
    match format {
        CloudFormat::Ply => ply::read(file, &mut points)?,
        CloudFormat::Pcd => pcd::read(file, &mut points)?,
        CloudFormat::Text => text::read(file, &mut points)?,
        CloudFormat::Kitti => kitti(file, &mut points)?,
    }
    if points.kept.is_empty() {
        return Err(file.fail(IoErrorKind::NoPoints { dropped: points.dropped }));
    }
    Ok(Cloud { points: points.kept, planar: points.planar, dropped: points.dropped, format })
}

/// Points as a binary little-endian PLY with 64-bit coordinates, so that reading gives the same bits.
///
/// # Errors
/// [`IoErrorKind::NotFinite`] where a coordinate is NaN or infinite.
pub fn write_ply(points: &[Vector3<f64>]) -> Result<Vec<u8>, IoError> {
    if let Some(x) = points.iter().flat_map(|p| p.iter()).find(|x| !x.is_finite()) {
        let kind = IoErrorKind::NotFinite { found: x.to_string().into() };
        return Err(IoError { name: "PLY".into(), place: None, kind });
    }
    let properties = "property double x\nproperty double y\nproperty double z";
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment written by boxplus\nelement vertex {}\n{properties}\nend_header\n",
        points.len()
    );
    let mut bytes = header.into_bytes();
    points.iter().flat_map(|p| p.iter()).for_each(|x| bytes.extend(x.to_le_bytes()));
    Ok(bytes)
}

/// The bytes of a file, after decompression.
#[derive(Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) name: &'a str,
    pub(super) bytes: &'a [u8],
}

impl File<'_> {
    /// An error about the file as a whole.
    pub(super) fn fail(self, kind: IoErrorKind) -> IoError {
        IoError { name: self.name.into(), place: None, kind }
    }
}

/// Points as they come, those that are none left out.
#[derive(Default)]
struct Points {
    kept: Vec<Vector3<f64>>,
    dropped: usize,
    planar: bool,
}

impl Points {
    fn push(&mut self, point: [f64; 3]) {
        if point.iter().all(|x| x.is_finite()) {
            self.kept.push(point.into());
        } else {
            self.dropped += 1;
        }
    }
}

fn sniff(bytes: &[u8], name: &str) -> CloudFormat {
    let plain = name.strip_suffix(".gz").unwrap_or(name);
    let ends = |ending: &str| plain.len() > ending.len() && plain.to_ascii_lowercase().ends_with(ending);
    let starts = |word: &[u8]| bytes.starts_with(word);
    if starts(b"ply\n") || starts(b"ply\r") || starts(b"ply ") {
        CloudFormat::Ply
    } else if starts(b"# .PCD") || starts(b"VERSION") || starts(b"FIELDS") || ends(".pcd") {
        CloudFormat::Pcd
    } else if ends(".bin") {
        CloudFormat::Kitti
    } else if ends(".ply") {
        CloudFormat::Ply
    } else {
        CloudFormat::Text
    }
}

fn kitti(file: File<'_>, points: &mut Points) -> Result<(), IoError> {
    let mut binary = Binary::new(file, 0, false);
    let count = file.bytes.len() / 4;
    let (three, four) = (count.is_multiple_of(3), count.is_multiple_of(4));
    if !file.bytes.len().is_multiple_of(4) || !(three || four) {
        return Err(file.fail(IoErrorKind::NotPoints { bytes: file.bytes.len() }));
    }
    let mut numbers = Vec::with_capacity(count);
    for _ in 0..count {
        numbers.push(binary.number(Number::F32)?);
    }
    let is_intensity = |x: &f64| (0.0..=255.0).contains(x);
    let with_intensity = four && numbers.iter().skip(3).step_by(4).all(is_intensity);
    let stride = if with_intensity || !three { 4 } else { 3 };
    numbers.chunks_exact(stride).for_each(|p| points.push([p[0], p[1], p[2]]));
    Ok(())
}
