//! Test of a change point: whether a sudden change of velocity persists in wider windows.
//!
//! A few samples off the path, as of a tracker that loses its ball for a moment, change the slopes of a narrow window as an
//! impact does. After an impact the velocity is different in any window; after a tracking error it is the old one again.

use std::ops::Range;

use super::polynomial::Polynomial;

/// The wide window has so many times the samples of the narrow one ...
const WIDER: usize = 3;
/// ... and where another change leaves less room than this many times, the two cannot be distinguished.
const LEAST_WIDER: usize = 2;
/// What lasts keeps this share of its change of velocity. Of noise a window three times as wide leaves a fifth.
const KEPT: f64 = 0.5;

/// Those of `kinks` (the last sample before each) that windows wider than `half` samples see as well. `axes` are positions
/// in which free flight is straight.
pub(crate) fn lasting(clock: &[f64], axes: [&[f64]; 3], kinks: &[usize], half: usize) -> Vec<usize> {
    let jump = |before: Range<usize>, after: Range<usize>| -> Option<[f64; 3]> {
        let mut jump = [0.0; 3];
        for (jump, values) in jump.iter_mut().zip(axes) {
            let slope = |range: Range<usize>| {
                let line =
                    Polynomial::fit(&clock[range.clone()], &values[range.clone()], clock[range.start], Some(0.0))?;
                Some(line.slope(clock[range.start]))
            };
            *jump = slope(after.clone())? - slope(before.clone())?;
        }
        Some(jump)
    };
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let around = |k: usize, before: usize, after: usize| jump(k + 1 - before..k + 1, k + 1..k + 1 + after);
    let mut strongest: Vec<(f64, usize, [f64; 3])> =
        kinks.iter().filter_map(|&k| around(k, half, half).map(|j| (dot(&j, &j), k, j))).collect();
    strongest.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut kept: Vec<usize> = Vec::new();
    // A weaker change may be caused by a stronger one next to it, so that one bounds its windows, and not the other way.
    for (square, k, narrow) in strongest {
        let begin = kept.iter().filter(|&&other| other < k).max().map_or(0, |other| other + 1);
        let end = kept.iter().filter(|&&other| other > k).min().map_or(clock.len(), |other| other + 1);
        let (before, after) = ((k + 1 - begin).min(WIDER * half), (end - k - 1).min(WIDER * half));
        let enough = before.min(after) >= LEAST_WIDER * half;
        let wide = if enough { around(k, before, after) } else { None };
        if wide.is_none_or(|wide| dot(&wide, &narrow) >= KEPT * square) {
            kept.push(k);
        }
    }
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::lasting;

    /// A body at 2 m/s, 200 Hz, that changes to `after` m/s at sample 60; samples 20 to 22 are 20 mm off.
    #[test]
    fn a_stumble_goes_and_a_blow_stays() {
        let clock: Vec<f64> = (0..120).map(|i| f64::from(i) * 0.005).collect();
        let path = |after: f64| -> Vec<f64> {
            let at = |(i, t): (usize, &f64)| {
                let straight = if *t < 0.3 { 2.0 * t } else { 0.6 + after * (t - 0.3) };
                straight + if (20..23).contains(&i) { 0.02 } else { 0.0 }
            };
            clock.iter().enumerate().map(at).collect()
        };
        let still = vec![0.0; 120];
        let found = |after: f64, kinks: &[usize]| lasting(&clock, [&path(after), &still, &still], kinks, 4);
        assert_eq!(found(-1.0, &[19, 59]), [59]);
        assert_eq!(found(2.0, &[19, 22]), Vec::<usize>::new(), "the stumble's two ends");
        // Two changes within one window: no wider window separates them.
        assert_eq!(found(-1.0, &[55, 59]), [55, 59]);
    }
}
