//! Numbers for users.

/// From here on scientific notation is easier to read.
const LARGE: f64 = 1e10;

/// A number with so many decimals; a large one with three digits and a power of ten: `12.3`, `1.23e99`.
///
/// ```
/// use tunenet_core::observation::with_decimals;
/// assert_eq!([with_decimals(-12.34, 1), with_decimals(1.234e99, 1)], ["-12.3", "1.23e99"]);
/// ```
#[must_use]
pub fn with_decimals(value: f64, decimals: usize) -> String {
    if value.abs() >= LARGE { format!("{value:.2e}") } else { format!("{value:.decimals$}") }
}

/// A unit as it follows a number: after a space, and nothing of the unit 1.
///
/// ```
/// use tunenet_core::observation::after_number;
/// assert_eq!([after_number("m/s"), after_number("1")], [" m/s", ""]);
/// ```
#[must_use]
pub fn after_number(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A number with three significant digits; of a very small or large one with a power of ten: `1.36`, `0.0214`, `2.0e-6`.
///
/// ```
/// use tunenet_core::observation::three_digits;
/// assert_eq!([three_digits(1.3649), three_digits(0.021_44), three_digits(2e-6)], ["1.36", "0.0214", "2.0e-6"]);
/// ```
#[must_use]
pub fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    #[expect(clippy::cast_possible_truncation, reason = "an exponent")]
    let exponent = value.abs().log10().floor() as i32;
    if exponent < -4 {
        return format!("{value:.1e}");
    }
    // Nobody counts a row of digits.
    if exponent > 9 {
        return format!("{value:.2e}");
    }
    let decimals = usize::try_from(2 - exponent).unwrap_or(0);
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_a_row_of_digits() {
        assert_eq!([0.0, 1.26, 9_999_999.04].map(|v| with_decimals(v, 1)), ["0.0", "1.3", "9999999.0"]);
        assert_eq!([1e10, -5e99, f64::MAX].map(|v| with_decimals(v, 3)), ["1.00e10", "-5.00e99", "1.80e308"]);
        assert_eq!([f64::INFINITY, f64::NAN].map(|v| with_decimals(v, 1)), ["inf", "NaN"]);
    }
}
