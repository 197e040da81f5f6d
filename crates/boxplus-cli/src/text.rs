//! Numbers in print.

/// `4949` as `4 949`, with thin spaces that do not break.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len());
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// `x` to `digits` significant digits: plain between 10⁻³ and 10⁶, else as 1.27×10⁹.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { x.to_string() };
    }
    let scientific = format!("{:.*e}", digits.saturating_sub(1), x);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = digits.saturating_add_signed(-1 - exponent as isize);
        trimmed(&format!("{x:.decimals$}"))
    } else {
        format!("{}×10{}", trimmed(mantissa), superscript(exponent))
    }
}

/// Without superfluous zeros after the point.
fn trimmed(number: &str) -> String {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        number.to_owned()
    }
}

/// `-12` as `⁻¹²`.
pub fn superscript(n: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(u32::from(digit) - u32::from('0') + u32::from('⁰')).unwrap_or(digit),
    };
    n.to_string().chars().map(raised).collect()
}

/// A duration for people: `0.42 ms`, `38 ms`, `1.24 s`, `2 min 5 s`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 0.01 => format!("{:.2} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.2} s"),
        s => format!("{:.0} min {:.0} s", (s / 60.0).floor(), s % 60.0),
    }
}

/// `1 edge`, `2 edges`.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped_from_five_digits_on() {
        assert_eq!(
            [0, 999, 4949, 12345, 1234567].map(grouped),
            ["0", "999", "4949", "12\u{202f}345", "1\u{202f}234\u{202f}567"]
        );
    }

    #[test]
    fn numbers_keep_their_significant_digits() {
        let shown = [0.0, 675.7009629, 1274.0, 1.2739e9, 0.000012, -727.1496672, 9.99999999]
            .map(|x| significant(x, 6));
        assert_eq!(shown, ["0", "675.701", "1274", "1.2739×10⁹", "1.2×10⁻⁵", "-727.15", "10"]);
        assert_eq!([f64::INFINITY, f64::NAN].map(|x| significant(x, 3)), ["inf", "NaN"]);
    }

    #[test]
    fn superscripts_cover_all_digits() {
        assert_eq!((superscript(1234567890), superscript(-5)), ("¹²³⁴⁵⁶⁷⁸⁹⁰".to_owned(), "⁻⁵".to_owned()));
    }

    #[test]
    fn durations_change_their_unit() {
        assert_eq!([0.00042, 0.038, 1.239, 125.0].map(duration), ["0.42 ms", "38 ms", "1.24 s", "2 min 5 s"]);
    }
}
