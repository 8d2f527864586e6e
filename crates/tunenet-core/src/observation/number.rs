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
