//! XYZ and CSV.

use super::fields::{Line, Lines};
use super::{File, Points};
use crate::io::error::{IoError, IoErrorKind};

const NAMES: [&str; 3] = ["x", "y", "z"];

/// Which fields of a line are coordinates.
struct Columns {
    /// Their places, from 0.
    places: Vec<usize>,
}

impl Columns {
    /// From a line with names, if it is one: not a number first.
    fn named(mut line: Line<'_>) -> Option<Self> {
        let mut names = vec![];
        while let Some(word) = line.word() {
            names.push(word.trim_matches('"').to_ascii_lowercase());
        }
        if names.first()?.parse::<f64>().is_ok() {
            return None;
        }
        let places = NAMES.iter().map_while(|name| names.iter().position(|n| n == name));
        Some(Self { places: places.collect() }).filter(|columns| columns.places.len() >= 2)
    }

    /// The first two or three of a line.
    fn first(mut line: Line<'_>) -> Self {
        let count = core::iter::from_fn(|| line.field()).count();
        Self { places: (0..count.clamp(2, 3)).collect() }
    }

    /// The coordinates in a line.
    fn read(&self, line: &mut Line<'_>) -> Result<[f64; 3], IoError> {
        let mut point = [0.0; 3];
        let last = self.places.iter().max().copied().unwrap_or(0);
        for field in 0..=last {
            match self.places.iter().position(|place| *place == field) {
                Some(k) => point[k] = line.float(NAMES[k])?,
                None if line.field().is_none() => return Err(line.missing("a number")),
                None => {}
            }
        }
        Ok(point)
    }
}

pub(super) fn read(file: File<'_>, points: &mut Points) -> Result<(), IoError> {
    let mut columns: Option<Columns> = None;
    for mut line in Lines::new(file) {
        line.check_text()?;
        if line.is_comment_or_blank() {
            continue;
        }
        if columns.is_none() {
            columns = Columns::named(line.clone());
            if columns.is_some() {
                continue;
            }
        }
        let layout = columns.get_or_insert_with(|| Columns::first(line.clone()));
        points.push(layout.read(&mut line)?);
        points.planar = layout.places.len() == 2;
    }
    if columns.is_none() {
        return Err(file.fail(IoErrorKind::NoPoints { dropped: 0 }));
    }
    Ok(())
}
