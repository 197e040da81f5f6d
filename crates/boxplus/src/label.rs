//! What people call a vertex.

use core::fmt;
use core::str::FromStr;

/// The bits below the letter.
const INDEX_BITS: u32 = 56;

/// An id as files write it: a number, or a letter and a number as in `A0` or `L17`, which is kept in one id with the letter
/// in the highest byte (GTSAM's symbols). Ids sort by letter, then by number.
///
/// ```
/// use boxplus::pose_graph::Label;
/// let label = Label::new(b'L', 17).unwrap();
/// assert_eq!(label.to_string(), "L17");
/// assert_eq!("L17".parse(), Ok(label));
/// assert_eq!(Label(17).to_string(), "17");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label(pub u64);

impl Label {
    /// A letter and a number; `None` unless it is an ASCII letter and a number below 2⁵⁶.
    pub fn new(letter: u8, number: u64) -> Option<Self> {
        let fits = letter.is_ascii_alphabetic() && number >> INDEX_BITS == 0;
        fits.then(|| Self(u64::from(letter) << INDEX_BITS | number))
    }

    /// The letter, or `None` where the id is a number.
    pub fn letter(self) -> Option<u8> {
        Some((self.0 >> INDEX_BITS) as u8).filter(u8::is_ascii_alphabetic)
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.letter() {
            Some(letter) => write!(f, "{}{}", char::from(letter), self.0 & ((1 << INDEX_BITS) - 1)),
            None => write!(f, "{}", self.0),
        }
    }
}

/// Text that names no vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not an id; expected a number as 17, or a letter and a number as L17")]
pub struct NoLabel;

impl FromStr for Label {
    type Err = NoLabel;

    fn from_str(text: &str) -> Result<Self, NoLabel> {
        let digits = |text: &str| {
            let all = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse::<u64>().ok().filter(|_| all)
        };
        let symbol = || Self::new(*text.as_bytes().first()?, digits(text.get(1..)?)?);
        digits(text).map(Self).or_else(symbol).ok_or(NoLabel)
    }
}
