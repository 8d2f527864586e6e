//! Time in logs: whole nanoseconds.

/// A time in s as whole ns; `None` outside ±292 years.
pub(crate) fn to_ns(time_s: f64) -> Option<i64> {
    let whole = time_s.floor();
    // The fraction is exact in floating point, so large clocks (s since 1970) lose nothing here.
    let fraction = ((time_s - whole) * 1e9).round();
    if !whole.is_finite() || whole.abs() > 9e9 {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers of at most 9e9 and 1e9")]
    let (whole, fraction) = (whole as i64, fraction as i64);
    whole.checked_mul(1_000_000_000)?.checked_add(fraction)
}

/// Whole ns as s: the nearest double. Below 97 days (2^23 s) doubles are less than 1 ns apart and [`to_ns`] finds the same
/// ns again; beyond, they are more than 1 ns apart, and the double survives the way there and back.
pub(crate) fn to_s(time_ns: i64) -> f64 {
    // Up to 2^53 ns (104 days) one division rounds once. Beyond, doubles are 2 ns apart or more, and the sum's error of
    // less than 1e-15 s cannot matter.
    if time_ns.unsigned_abs() <= 1 << 53 {
        time_ns as f64 / 1e9
    } else {
        time_ns.div_euclid(1_000_000_000) as f64 + time_ns.rem_euclid(1_000_000_000) as f64 / 1e9
    }
}

/// Seconds and nanoseconds as whole ns; `None` outside ±292 years.
pub(crate) fn joined(sec: i64, nanosec: i64) -> Option<i64> {
    sec.checked_mul(1_000_000_000)?.checked_add(nanosec)
}

/// Whole seconds, rounded down, and the rest in ns.
pub(crate) fn split(time_ns: i64) -> (i64, u32) {
    let rest = time_ns.rem_euclid(1_000_000_000);
    (time_ns.div_euclid(1_000_000_000), u32::try_from(rest).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whole_nanoseconds_come_back(ns in -8_000_000_000_000_000i64..8_000_000_000_000_000) {
            prop_assert_eq!(to_ns(to_s(ns)), Some(ns));
        }

        #[test]
        fn clocks_since_1970_come_back(time_s in 1.0e9f64..4.0e9) {
            prop_assert_eq!(to_s(to_ns(time_s).unwrap()).to_bits(), time_s.to_bits());
        }

        #[test]
        fn splitting_and_joining_are_inverse(ns in any::<i64>()) {
            let (sec, nanosec) = split(ns);
            prop_assert!(nanosec < 1_000_000_000);
            if let Some(back) = joined(sec, i64::from(nanosec)) {
                prop_assert_eq!(back, ns);
            }
        }
    }

    #[test]
    fn no_time_is_too_large_to_refuse() {
        for time in [f64::NAN, f64::INFINITY, 1e300, -1e12] {
            assert_eq!(to_ns(time), None);
        }
        assert_eq!(to_ns(0.1), Some(100_000_000));
        assert_eq!(to_s(100_000_000).to_bits(), 0.1f64.to_bits());
    }
}
