//! What PLY and PCD have in common: a header that says where x, y and z are.

use super::fields::{Binary, Line, Lines, Number};
use super::{File, Points};
use crate::io::error::{IoError, IoErrorKind};

/// What a place in a record is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// x, y or z.
    Coordinate(usize),
    /// Passed over.
    Other,
}

impl Role {
    pub(super) fn of(name: &str) -> Self {
        match name {
            "x" | "X" => Self::Coordinate(0),
            "y" | "Y" => Self::Coordinate(1),
            "z" | "Z" => Self::Coordinate(2),
            _ => Self::Other,
        }
    }
}

/// One property of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Property {
    pub(super) role: Role,
    pub(super) number: Number,
    /// How many numbers: so many, or as many as a number before them says.
    pub(super) count: Count,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Count {
    Fixed(usize),
    Listed(Number),
}

impl Property {
    /// Bytes at least.
    pub(super) fn size(&self) -> usize {
        match self.count {
            Count::Fixed(count) => count.saturating_mul(self.number.size()),
            Count::Listed(number) => number.size(),
        }
    }
}

/// The record of one point, or of something else.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    pub(super) properties: Vec<Property>,
}

impl Record {
    /// Whether x and y, and whether z, are there.
    pub(super) fn coordinates(&self) -> (bool, bool) {
        let has = |axis| self.properties.iter().any(|p| p.role == Role::Coordinate(axis));
        (has(0) && has(1), has(2))
    }

    /// Bytes at least.
    pub(super) fn size(&self) -> usize {
        self.properties.iter().fold(0, |sum, p| sum.saturating_add(p.size()))
    }

    /// Reads a record from bytes.
    pub(super) fn binary(&self, bytes: &mut Binary<'_>) -> Result<[f64; 3], IoError> {
        let mut point = [0.0; 3];
        for property in &self.properties {
            match (property.count, property.role) {
                (Count::Fixed(1), Role::Coordinate(axis)) => point[axis] = bytes.number(property.number)?,
                (Count::Fixed(count), _) => {
                    bytes.take(count.saturating_mul(property.number.size()))?;
                }
                (Count::Listed(number), _) => {
                    let count = length(bytes.number(number)?);
                    bytes.take(count.saturating_mul(property.number.size()))?;
                }
            }
        }
        Ok(point)
    }

    /// Reads a record from a line.
    pub(super) fn ascii(&self, line: &mut Line<'_>) -> Result<[f64; 3], IoError> {
        let mut point = [0.0; 3];
        for property in &self.properties {
            match (property.count, property.role) {
                (Count::Fixed(1), Role::Coordinate(axis)) => {
                    point[axis] = line.float(["x", "y", "z"][axis])?;
                }
                (Count::Fixed(count), _) => skip(line, count)?,
                (Count::Listed(_), _) => {
                    let count = length(line.float("the length of a list")?);
                    skip(line, count)?;
                }
            }
        }
        Ok(point)
    }

    /// Reads records from lines; comments and blank lines are none.
    pub(super) fn ascii_records(
        &self,
        file: File<'_>,
        lines: &mut Lines<'_>,
        count: usize,
        mut take: impl FnMut([f64; 3]),
    ) -> Result<(), IoError> {
        let mut body = lines.filter(|line| !line.is_comment_or_blank());
        for given in 0..count {
            let Some(mut line) = body.next() else {
                return Err(file.fail(IoErrorKind::TooFewLines { given, promised: count }));
            };
            take(self.ascii(&mut line)?);
        }
        Ok(())
    }

    /// Reads points in bytes.
    pub(super) fn binary_points(
        &self,
        bytes: &mut Binary<'_>,
        count: usize,
        points: &mut Points,
    ) -> Result<(), IoError> {
        bytes.check_room(count, self.size().max(1))?;
        for _ in 0..count {
            points.push(self.binary(bytes)?);
        }
        Ok(())
    }
}

/// A length that was stored as any number; what is no length is too long.
#[allow(clippy::cast_sign_loss, reason = "checked; negative lengths are too long")]
pub(super) fn length(x: f64) -> usize {
    if x >= 0.0 { x as usize } else { usize::MAX }
}

fn skip(line: &mut Line<'_>, count: usize) -> Result<(), IoError> {
    for _ in 0..count {
        if line.field().is_none() {
            return Err(line.missing("a number"));
        }
    }
    Ok(())
}
