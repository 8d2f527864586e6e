//! Single values: leaps, a tracker that stands still, and a path cut off at the border of the view.

use super::share;
use crate::findings;
use crate::segmentation::span;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Check;
use tunenet_core::observation::Observation;
use tunenet_core::observation::{noise_sd, step};

/// Fewest equal values in a row that noise does not explain.
const STANDS: usize = 5;

/// The check of single outliers.
pub(crate) fn outliers(places: &[usize], kept: bool, samples: usize) -> Check {
    const KIND: FindingKind = findings::SAMPLES_OUTLIERS;
    if places.is_empty() {
        return Check::passed(KIND, "no outliers");
    }
    let shown: Vec<String> = places.iter().take(4).map(|i| (i + 1).to_string()).collect();
    let more = if places.len() > 4 { format!(" and {} more", places.len() - 4) } else { String::new() };
    let shown = shown.join(", ");
    let share = share(places.len(), samples);
    let text = match (places.len(), kept) {
        (1, true) => format!("sample {shown} is an outlier and was excluded ({share})"),
        (1, false) => format!("sample {shown} is an outlier and was kept, because too few would remain"),
        (_, true) => format!("samples {shown}{more} are outliers and were excluded ({share})"),
        (_, false) => format!("samples {shown}{more} are outliers and were kept, because too few would remain"),
    };
    Check::noticed(KIND, text, "correct or remove it")
}

/// Where the values stand still while the ball must move on: within the record (`inside`), at its end, or at the border of
/// the view. The samples to leave out go with it.
pub(crate) fn frozen(seen: &Observation, inside: &[(usize, usize)]) -> (Check, Vec<usize>) {
    const KIND: FindingKind = findings::SAMPLES_FROZEN;
    let mut out: Vec<usize> = inside.iter().flat_map(|(a, b)| a + 1..b + 1).collect();
    let mut places: Vec<String> =
        inside.iter().map(|(a, b)| format!("from {:.3} to {:.3} s", seen.clock()[*a], seen.clock()[*b])).collect();
    if let Some(first) = lost_at_end(seen) {
        out.extend(first + 1..seen.len());
        places.push(format!("from {:.3} s to the end", seen.clock()[first]));
    }
    for (from, to) in clipped(seen) {
        out.extend(from..=to);
        places.push(format!("at the border of the view from {:.3} to {:.3} s", seen.clock()[from], seen.clock()[to]));
    }
    out.sort_unstable();
    out.dedup();
    if places.is_empty() {
        return (Check::passed(KIND, "the values are never frozen during motion"), out);
    }
    let shown = places.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
    let more = if places.len() > 3 { format!(" and {} more times", places.len() - 3) } else { String::new() };
    let text = format!(
        "exactly the same values {shown}{more}: the tracker lost the ball, and {} samples were left out ({})",
        out.len(),
        share(out.len(), seen.len())
    );
    (Check::noticed(KIND, text, "keep the whole path in view, or leave out samples without a ball"), out)
}

/// From which sample on a noisy record repeats itself to its end: a ball at rest would go on being noisy.
fn lost_at_end(seen: &Observation) -> Option<usize> {
    let last = seen.len() - 1;
    let first = (0..last).rev().take_while(|i| seen.row(*i) == seen.row(last)).last()?;
    if last - first + 1 < STANDS || first < STANDS + 3 {
        return None;
    }
    let noisy = (0..seen.channels().len()).any(|c| {
        let before: Vec<f64> = seen.column(c).take(first).collect();
        let noise = noise_sd(&before);
        noise > 1e-6 * span(&before) && noise > 2.0 * step(&before)
    });
    noisy.then_some(first)
}

/// Runs in which the height stands at the very top of all heights seen while the ball comes and goes.
fn clipped(seen: &Observation) -> Vec<(usize, usize)> {
    let heights: Vec<f64> = seen.column(2).collect();
    let top = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let coarse = 2.0 * step(&heights) + 1e-6 * span(&heights);
    let mut runs = Vec::new();
    let mut i = 0;
    while i < heights.len() {
        if heights[i] < top {
            i += 1;
            continue;
        }
        let first = i;
        while i < heights.len() && heights[i] >= top {
            i += 1;
        }
        let last = i - 1;
        let comes = first > 0 && top - heights[first - 1] > coarse;
        let goes = i >= heights.len() || top - heights[i] > coarse;
        // A ball held at the start stands at the top as well.
        if comes && goes && last - first + 1 >= STANDS - 1 {
            runs.push((first, last));
        }
    }
    runs
}
