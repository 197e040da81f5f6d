//! Files of bundle adjustment: those of Bundle Adjustment in the Large, and reconstructions for other programs.
//!
//! ```text
//! cameras points observations
//! camera point u v                      an observation a line, numbers from 0, pixels from the middle, v upwards
//! …
//! r₁ r₂ r₃ t₁ t₂ t₃ f k₁ k₂              nine numbers a camera, one a line: P = R·X + t, R = Exp(r), seen along −z
//! …
//! x y z                                 three numbers a point
//! ```
//!
//! Numbers may stand in lines as they like; packed files (gzip, bzip2) are read as they are.
//!
//! ```
//! use boxplus::io::bal;
//! let text = b"1 1 1\n0 0 -10.5 20\n0 0 0\n0 0 -2\n500 0 0\n0.1 0.2 -3\n";
//! let bundle = bal::read(text, "tiny.bal")?;
//! assert_eq!(bundle.views[0].camera.focal, 500.0);
//! assert!((bundle.residual(&bundle.observations[0]).unwrap() - nalgebra::vector![20.5, 0.0]).norm() < 1e-12);
//!
//! let error = bal::read(b"1 1 1\n0 7 1.0 2.0\n", "typo.bal").unwrap_err();
//! assert_eq!(error.to_string(), "typo.bal:2:3: there is no point 7: the header promises 1, counted from 0");
//! # Ok::<(), boxplus::io::IoError>(())
//! ```

mod export;

pub use export::{Colmap, colmap, write_ply};

use super::cloud::{File, Line, Lines};
use super::decompress;
use super::error::{IoError, IoErrorKind, WriteError};
use crate::bundle_adjustment::{self, BalView, Bundle, Observation};
use crate::camera::{Snavely, View};
use crate::lie::{LieGroup, SE3, SO3};
use core::fmt::Write;
use nalgebra::{Vector3, vector};

/// Whether a text starts like such a file: three whole numbers, then, in a line of its own, two whole numbers and two more. It may be packed.
pub fn looks_like(bytes: &[u8]) -> bool {
    let Ok(text) = decompress(bytes, "") else { return false };
    let start = &text[..text.len().min(4096)];
    let mut lines = start.split(|&b| b == b'\n').filter(|line| !line.trim_ascii().is_empty());
    let fields = |line: Option<&[u8]>| -> Option<Vec<String>> {
        let text = core::str::from_utf8(line?).ok()?;
        Some(text.split_ascii_whitespace().map(str::to_owned).collect())
    };
    let whole = |fields: &[String]| fields.iter().all(|field| field.parse::<u32>().is_ok());
    let number = |field: &String| field.parse::<f64>().is_ok();
    match (fields(lines.next()), fields(lines.next())) {
        (Some(head), Some(first)) => {
            head.len() == 3
                && whole(&head)
                && first.len() == 4
                && whole(&first[..2])
                && first.iter().all(number)
        }
        _ => false,
    }
}

/// Reads a bundle from the bytes of a file, plain or packed. `name` appears in errors.
///
/// Time and memory are linear in the size of the file, whatever its header promises.
///
/// # Errors
/// [`IoError`], with the place: what is no finite number, an observation of what does not exist, and a file that ends before or goes on
/// after what its header promises. What is well-formed but makes no sense is found by [`Bundle::faults`].
pub fn read(bytes: &[u8], name: &str) -> Result<Bundle, IoError> {
    let text = decompress(bytes, name)?;
    if let Some(at) = text.iter().position(|&b| b == 0) {
        return Err(super::not_text(super::scan::Source { name, text: &text, layouts: &[] }, at));
    }
    let file = File { name, bytes: &text };
    let mut numbers = Numbers { file, lines: Lines::new(file), line: None };
    let counts = ["the number of cameras", "the number of points", "the number of observations"];
    let mut head = [0; 3];
    for (count, expected) in head.iter_mut().zip(counts) {
        *count = numbers.next(expected, |line| line.whole(expected))?;
    }
    let [views, points, observations] = head;
    // An observation has eight characters at least, a point six: no header can ask for more memory than the file is worth.
    let mut bundle = Bundle {
        observations: Vec::with_capacity(observations.min(text.len() / 8)),
        points: Vec::with_capacity(points.min(text.len() / 6)),
        views: vec![],
    };
    for _ in 0..observations {
        bundle.observations.push(numbers.observation(views, points)?);
    }
    for _ in 0..views {
        bundle.views.push(view(&numbers.finite(&CAMERA)?));
    }
    for _ in 0..points {
        bundle.points.push(numbers.finite(&["x", "y", "z"])?.into());
    }
    numbers.finish()?;
    Ok(bundle)
}

/// What the numbers of a camera are called.
const CAMERA: [&str; 9] = ["r1", "r2", "r3", "t1", "t2", "t3", "f", "k1", "k2"];

fn view(&[r1, r2, r3, t1, t2, t3, focal, k1, k2]: &[f64; 9]) -> BalView {
    let camera_from_world = SE3::new(SO3::exp(&vector![r1, r2, r3]), vector![t1, t2, t3]);
    View { world_from_camera: camera_from_world.inverse(), camera: Snavely { focal, distortion: [k1, k2] } }
}

/// Writes a bundle. Numbers are the shortest decimals that read back as the same float; poses, whose rotations are vectors in the file,
/// come back to rounding.
///
/// # Errors
/// [`WriteError::NotFinite`].
pub fn write(bundle: &Bundle) -> Result<String, WriteError> {
    check(bundle)?;
    let mut text = format!("{} {} {}\n", bundle.views.len(), bundle.points.len(), bundle.observations.len());
    // Writing to a string cannot fail.
    for Observation { view, point, pixel, .. } in &bundle.observations {
        let _ = writeln!(text, "{view} {point} {} {}", pixel.x, pixel.y);
    }
    for view in &bundle.views {
        let camera_from_world = view.world_from_camera.inverse();
        let (r, t) = (camera_from_world.rotation().log(), camera_from_world.translation());
        let [k1, k2] = view.camera.distortion;
        for x in r.iter().chain(t.iter()).chain([&view.camera.focal, &k1, &k2]) {
            let _ = writeln!(text, "{x:e}");
        }
    }
    for x in bundle.points.iter().flat_map(Vector3::iter) {
        let _ = writeln!(text, "{x:e}");
    }
    Ok(text)
}

/// Refuses what no reader would take.
fn check(bundle: &Bundle) -> Result<(), WriteError> {
    use bundle_adjustment::Fault::{PixelNotFinite, PointNotFinite, ViewNotFinite};
    let not_finite = bundle.faults().into_iter().find_map(|fault| match fault {
        PixelNotFinite { view, .. } => Some(("observation by camera", u64::from(view))),
        ViewNotFinite { view, .. } => Some(("camera", view as u64)),
        PointNotFinite { point, .. } => Some(("point", point as u64)),
        _ => None,
    });
    not_finite.map_or(Ok(()), |(tag, id)| Err(WriteError::NotFinite { tag, id }))
}

/// Numbers one after another, whatever the lines.
struct Numbers<'a> {
    file: File<'a>,
    lines: Lines<'a>,
    line: Option<Line<'a>>,
}

impl<'a> Numbers<'a> {
    /// The line with a further field.
    fn advance(&mut self) -> Option<&mut Line<'a>> {
        while self.line.as_ref().is_none_or(Line::is_done) {
            self.line = Some(self.lines.next()?);
        }
        self.line.as_mut()
    }

    fn next<T>(
        &mut self,
        expected: &'static str,
        read: impl FnOnce(&mut Line<'a>) -> Result<T, IoError>,
    ) -> Result<T, IoError> {
        let file = self.file;
        let ended = || file.fail(IoErrorKind::EndsEarly { expected });
        self.advance().ok_or_else(ended).and_then(read)
    }

    fn finite<const N: usize>(&mut self, names: &[&'static str; N]) -> Result<[f64; N], IoError> {
        let mut numbers = [0.0; N];
        for (number, name) in numbers.iter_mut().zip(names) {
            *number = self.next(name, |line| match line.float(name)? {
                x if x.is_finite() => Ok(x),
                _ => Err(line.fail(IoErrorKind::NotFinite { found: line.found() }, name)),
            })?;
        }
        Ok(numbers)
    }

    /// The number of a thing of which there are `count`; `missing` says what is wrong with any other.
    fn index(
        &mut self,
        what: &'static str,
        count: usize,
        missing: fn(u32, u32) -> IoErrorKind,
    ) -> Result<u32, IoError> {
        self.next(what, |line| match line.whole(what)? {
            number if number < count => Ok(number as u32),
            number => {
                let [number, count] = [number, count].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
                Err(line.fail(missing(number, count), ""))
            }
        })
    }

    fn observation(&mut self, views: usize, points: usize) -> Result<Observation, IoError> {
        let view =
            self.index("camera", views, |number, count| IoErrorKind::NoSuchCamera { number, count })?;
        let line = self.line.as_ref().map_or(0, Line::number);
        let point =
            self.index("point", points, |number, count| IoErrorKind::NoSuchPoint { number, count })?;
        let pixel = self.finite(&["u", "v"])?.into();
        Ok(Observation { view, point, pixel, line: bundle_adjustment::Line(line) })
    }

    /// Nothing may follow.
    fn finish(&mut self) -> Result<(), IoError> {
        match self.advance() {
            None => Ok(()),
            Some(line) => {
                let _ = line.field();
                Err(line.fail(IoErrorKind::TooManyFields { found: line.found() }, ""))
            }
        }
    }
}
