//! How far a list of impact times can be trusted.

/// Longest plausible interval, as a multiple of the one before. A bounce never gains energy, so the ratio stays below 1;
/// the margin covers the scatter of late bounces.
const LONGEST_RATIO: f64 = 1.25;

/// Shortest plausible interval, as a multiple of the one before: a click between two impacts halves it.
const SHORTEST_RATIO: f64 = 0.5;

/// Why a list ends before its last time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Doubt {
    /// Index of the first time that cannot be numbered any more.
    pub from: usize,
    /// The interval that ends there, in s.
    pub interval_s: f64,
    /// The interval before it, in s.
    pub before_s: f64,
}

/// The first place where a missed or a false click is likely, since the impacts cannot be counted beyond it.
pub(crate) fn doubt(time_s: &[f64]) -> Option<Doubt> {
    time_s.windows(3).enumerate().find_map(|(i, times)| {
        let (before_s, interval_s) = (times[1] - times[0], times[2] - times[1]);
        let ratio = interval_s / before_s;
        (!(SHORTEST_RATIO..=LONGEST_RATIO).contains(&ratio)).then_some(Doubt { from: i + 2, interval_s, before_s })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_click_doubles_an_interval() {
        let found = doubt(&[0.0, 1.0, 1.9, 3.5, 4.2]).unwrap();
        assert_eq!(found.from, 3);
        assert!((found.interval_s - 1.6).abs() < 1e-12 && (found.before_s - 0.9).abs() < 1e-12);
    }

    #[test]
    fn a_false_click_halves_one() {
        assert_eq!(doubt(&[0.0, 1.0, 1.4, 1.9]).map(|d| d.from), Some(2));
    }

    #[test]
    fn a_bouncing_ball_is_not_doubted() {
        assert_eq!(doubt(&[0.0, 1.0, 1.9, 2.71, 3.439]), None);
        assert_eq!(doubt(&[0.0, 1.0]), None);
    }
}
