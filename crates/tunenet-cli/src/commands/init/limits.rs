//! The unit that the limits of a model leave for the numbers of a joint, where their smallest step shows none.

/// How far a joint may be beyond its limits, as a share of the way between them: stops give.
const BEYOND: f64 = 0.03;
/// A joint that moves by less than this share of the way between its limits shows no unit by them.
const LEAST_WAY: f64 = 0.05;
/// Normalised numbers go from -100 to 100.
const NORMALISED: f64 = 100.5;

/// What `--units` would say of numbers between `low` and `high` of a joint with these limits, rad or m: the only one of radians, degrees
/// and -100..100, or of metres, millimetres and -100..100, in which it stays within them and moves by more than little.
pub fn by_limits((low, high): (f64, f64), (lower, upper): (f64, f64), turns: bool) -> Option<String> {
    let way = upper - lower;
    if !(way > 0.0 && way.is_finite() && low < high) {
        return None;
    }
    let fits = |factor: f64, zero: f64| {
        let (from, to) = (zero + factor * low, zero + factor * high);
        from >= lower - BEYOND * way && to <= upper + BEYOND * way && to - from >= LEAST_WAY * way
    };
    let normalised = way / (2.0 * 100.0);
    let [whole, part, share] = if turns {
        ["rad".to_owned(), "deg".to_owned(), format!("{:.4}deg", normalised.to_degrees())]
    } else {
        ["m".to_owned(), "mm".to_owned(), format!("{:.4}mm", 1e3 * normalised)]
    };
    let ways = [
        (fits(1.0, 0.0), whole),
        (fits(if turns { 1f64.to_radians() } else { 1e-3 }, 0.0), part),
        (low >= -NORMALISED && high <= NORMALISED && fits(normalised, lower.midpoint(upper)), share),
    ];
    let mut fitting = ways.into_iter().filter(|(fits, _)| *fits).map(|(_, unit)| unit);
    let first = fitting.next()?;
    fitting.next().is_none().then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_only_unit_that_fits_the_limits_is_proposed() {
        let limits = (-1.6, 1.6);
        let of = |low: f64, high: f64| by_limits((low, high), limits, true);
        assert_eq!(of(-0.567, -0.331).as_deref(), Some("rad"));
        assert_eq!(of(-1.2, 1.5).as_deref(), Some("rad"));
        assert_eq!(by_limits((0.02, 0.3), (0.0, 0.4), false).as_deref(), Some("m"));
        assert_eq!(by_limits((120.0, 300.0), (0.0, 0.4), false).as_deref(), Some("mm"));
        assert_eq!(of(-100.0, 40.0).as_deref(), Some("0.9167deg"), "100° are beyond 1.6 rad");
        assert_eq!(by_limits((10.0, 150.0), (-3.0, 3.0), true).as_deref(), Some("deg"), "150 is beyond -100..100");
    }

    #[test]
    fn where_several_fit_or_none_nothing_is_proposed() {
        assert_eq!(by_limits((-60.0, 40.0), (-1.6, 1.6), true), None, "degrees or -100..100");
        assert_eq!(by_limits((-0.01, 0.01), (-1.6, 1.6), true), None, "it hardly moves");
        assert_eq!(by_limits((1000.0, 3000.0), (-1.6, 1.6), true), None, "counts");
        assert_eq!(by_limits((0.0, 1.0), (f64::NEG_INFINITY, f64::INFINITY), true), None);
    }
}
