//! Connected components of a mask.

/// One connected patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// Its centroid, px from the centre of the first pixel.
    pub u: f64,
    /// Its centroid, px downwards.
    pub v: f64,
    /// How many pixels it has.
    pub area: f64,
    /// Left, top, width and height of its box, px.
    pub bounds: [usize; 4],
}

impl Blob {
    /// Its area over that of the ellipse in its box: 1 for a disc or a disc that is blurred along an axis.
    #[must_use]
    pub fn fill(&self) -> f64 {
        let [_, _, width, height] = self.bounds.map(|n| n as f64);
        self.area / (std::f64::consts::FRAC_PI_4 * width * height)
    }
}

/// Pixels of one row, side by side: from `start` to before `end`.
#[derive(Debug, Clone, Copy)]
struct Run {
    row: usize,
    start: usize,
    end: usize,
    /// The patch it belongs to, as the number of an earlier run or its own.
    patch: usize,
}

/// The patches of `mask` (rows of `columns` pixels), joined also across corners, the largest first.
///
/// Masks of a followed ball are so small that setting up a general library's call takes longer than this.
pub(crate) fn blobs(mask: &[bool], columns: usize) -> Vec<Blob> {
    let runs = patches(mask, columns);
    // Sums of each patch, under the number of its first run.
    let mut sums: Vec<Option<Sums>> = vec![None; runs.len()];
    for run in &runs {
        let sum = sums[run.patch].get_or_insert(Sums::none());
        sum.add(run);
    }
    let mut found: Vec<Blob> = sums.into_iter().flatten().map(|s| s.blob()).collect();
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

/// Runs of the mask, each with the first run of its patch.
fn patches(mask: &[bool], columns: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut above = 0..0;
    for (row, pixels) in mask.chunks_exact(columns.max(1)).enumerate() {
        let first = runs.len();
        let mut at = 0;
        let mut near = above.start;
        while let Some(skipped) = pixels[at..].iter().position(|p| *p) {
            let start = at + skipped;
            let end = pixels[start..].iter().position(|p| !*p).map_or(columns, |n| start + n);
            let own = runs.len();
            runs.push(Run { row, start, end, patch: own });
            // Runs of the row above end before the next begins, so none is looked at twice but the last.
            while near < above.end && runs[near].end < start {
                near += 1;
            }
            let mut other = near;
            while other < above.end && runs[other].start <= end {
                let (a, b) = (root(&runs, own), root(&runs, other));
                runs[a.max(b)].patch = a.min(b);
                other += 1;
            }
            at = end;
        }
        above = first..runs.len();
    }
    for i in 0..runs.len() {
        // Earlier runs point at their first one already.
        runs[i].patch = runs[runs[i].patch].patch;
    }
    runs
}

fn root(runs: &[Run], mut at: usize) -> usize {
    while runs[at].patch != at {
        at = runs[at].patch;
    }
    at
}

#[derive(Debug, Clone, Copy)]
struct Sums {
    area: usize,
    u: f64,
    v: f64,
    low: [usize; 2],
    high: [usize; 2],
}

impl Sums {
    fn none() -> Self {
        Self { area: 0, u: 0.0, v: 0.0, low: [usize::MAX; 2], high: [0; 2] }
    }

    fn add(&mut self, run: &Run) {
        let count = run.end - run.start;
        self.area += count;
        self.u += count as f64 * 0.5 * (run.start + run.end - 1) as f64;
        self.v += (count * run.row) as f64;
        self.low = [self.low[0].min(run.start), self.low[1].min(run.row)];
        self.high = [self.high[0].max(run.end), self.high[1].max(run.row + 1)];
    }

    fn blob(&self) -> Blob {
        let [left, top] = self.low;
        let area = self.area as f64;
        let bounds = [left, top, self.high[0] - left, self.high[1] - top];
        Blob { u: self.u / area, v: self.v / area, area, bounds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use opencv::core::{CV_32S, Mat, MatTraitConst};
    use opencv::imgproc::connected_components_with_stats;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn validate_patches_are_those_of_opencv(columns in 1usize..24, bits in prop::collection::vec(any::<bool>(), 1..600)) {
            let rows = bits.len() / columns;
            prop_assume!(rows > 0);
            let mask = &bits[..rows * columns];
            let found = blobs(mask, columns);
            let bytes: Vec<u8> = mask.iter().map(|m| u8::from(*m)).collect();
            let picture = Mat::new_rows_cols_with_data(i32::try_from(rows).unwrap(), i32::try_from(columns).unwrap(), &bytes).unwrap();
            let (mut labels, mut stats, mut centroids) = (Mat::default(), Mat::default(), Mat::default());
            let count = connected_components_with_stats(&picture, &mut labels, &mut stats, &mut centroids, 8, CV_32S).unwrap();
            let number = |i: i32, c: i32| usize::try_from(*stats.at_2d::<i32>(i, c).unwrap()).unwrap();
            let mut theirs: Vec<(usize, [usize; 4])> =
                (1..count).map(|i| (number(i, 4), [number(i, 0), number(i, 1), number(i, 2), number(i, 3)])).collect();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts")]
            let mut ours: Vec<(usize, [usize; 4])> = found.iter().map(|b| (b.area as usize, b.bounds)).collect();
            theirs.sort_unstable();
            ours.sort_unstable();
            prop_assert_eq!(ours, theirs);
        }
    }

    #[test]
    fn a_ring_has_its_centre_in_its_middle() {
        let mask: Vec<bool> = (0..25).map(|i| i != 12).collect();
        let found = blobs(&mask, 5);
        assert_eq!(found, [Blob { u: 2.0, v: 2.0, area: 24.0, bounds: [0, 0, 5, 5] }]);
        assert!((found[0].fill() - 24.0 / (25.0 * std::f64::consts::FRAC_PI_4)).abs() < 1e-12);
        assert!(blobs(&[false; 9], 3).is_empty());
    }
}
