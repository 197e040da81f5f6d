//! Times as text.

/// What the time of a row is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamp {
    /// A column of seconds, decimal, kept to the nanosecond.
    Seconds,
    /// A column of whole nanoseconds.
    Nanoseconds,
    /// No column: a row every so many seconds, from 0 on.
    Every(f64),
}

impl Stamp {
    pub(super) fn has_column(self) -> bool {
        !matches!(self, Self::Every(_))
    }

    /// The time of row number `row`, where there is no column.
    pub(super) fn of_row(self, row: i64) -> i64 {
        match self {
            Self::Every(period) => (period * row as f64 * 1e9).round() as i64,
            Self::Seconds | Self::Nanoseconds => 0,
        }
    }

    /// Nanoseconds; `None` for what is no time.
    pub(super) fn parse(self, cell: &[u8]) -> Option<i64> {
        let text = core::str::from_utf8(cell).ok()?;
        match self {
            Self::Nanoseconds => text.parse().ok(),
            Self::Seconds | Self::Every(_) => decimal(text).or_else(|| rounded(text)),
        }
    }
}

/// Digits before and after a point, to the nanosecond, the tenth decimal rounded.
fn decimal(text: &str) -> Option<i64> {
    let (negative, digits) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let all_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || !all_digits(whole) || !all_digits(part) {
        return None;
    }
    let digit = |i: usize| part.as_bytes().get(i).map_or(0, |b| i64::from(b - b'0'));
    let nanoseconds = (0..9).fold(0, |sum, i| 10 * sum + digit(i)) + i64::from(digit(9) >= 5);
    let stamp = whole.parse::<i64>().ok()?.checked_mul(1_000_000_000)?.checked_add(nanoseconds)?;
    Some(if negative { -stamp } else { stamp })
}

/// Any other way to write a number, such as with an exponent.
fn rounded(text: &str) -> Option<i64> {
    let stamp = text.parse::<f64>().ok()? * 1e9;
    (stamp.abs() < 9.2e18).then(|| stamp.round() as i64)
}

/// Seconds as text, all nine decimals.
pub(super) fn print(stamp_ns: i64) -> String {
    let sign = if stamp_ns < 0 { "-" } else { "" };
    let stamp = stamp_ns.unsigned_abs();
    format!("{sign}{}.{:09}", stamp / 1_000_000_000, stamp % 1_000_000_000)
}
