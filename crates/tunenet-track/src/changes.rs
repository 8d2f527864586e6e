//! Frames that a camera or a converter wrote twice.

use tunenet_core::statistics::median;

use super::view::View;

/// Points of a frame that are compared, along its longer side.
const POINTS: usize = 128;
/// Two frames that differ by less than this share of the usual change are one frame shown twice.
const SAME_SHARE: f64 = 0.1;
/// Longer runs of equal frames are a still scene, not frames that were written again.
const LONGEST_RUN: usize = 4;

/// How much each frame differs from the one before.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    before: Vec<[u8; 3]>,
    now: Vec<[u8; 3]>,
    /// Mean difference in grey levels; infinite for the first frame.
    change: Vec<f64>,
}

impl Changes {
    /// Takes in the next frame.
    pub fn push(&mut self, view: &View<'_>) {
        let every = view.columns().max(view.rows()).div_ceil(POINTS);
        self.now.clear();
        for row in (every / 2..view.rows()).step_by(every) {
            self.now.extend((every / 2..view.columns()).step_by(every).map(|column| view.pixel(column, row)));
        }
        let known = self.before.len() == self.now.len();
        let sum: u64 = self
            .before
            .iter()
            .zip(&self.now)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>())
            .sum();
        self.change.push(if known { sum as f64 / (3 * self.now.len()).max(1) as f64 } else { f64::INFINITY });
        std::mem::swap(&mut self.before, &mut self.now);
    }

    /// The frames that repeat the one before, from 0.
    pub fn repeated(&self) -> Vec<usize> {
        let Some(usual) = median(self.change.iter().copied().filter(|c| c.is_finite())) else { return Vec::new() };
        let same: Vec<bool> = self.change.iter().map(|c| *c < SAME_SHARE * usual).collect();
        let mut repeated = Vec::new();
        let mut i = 0;
        while i < same.len() {
            let run = same[i..].iter().take_while(|s| **s).count();
            if run <= LONGEST_RUN {
                repeated.extend(i..i + run);
            }
            i += run + 1;
        }
        repeated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_repetitions_are_found_and_a_still_scene_is_none() {
        let change = |values: &[f64]| Changes { change: values.to_vec(), ..Changes::default() }.repeated();
        assert_eq!(change(&[f64::INFINITY, 0.0, 2.0, 2.1, 1.9, 0.1, 2.0]), [1, 5]);
        assert_eq!(change(&[f64::INFINITY, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]), [0; 0]);
        assert_eq!(change(&[]), [0; 0]);
    }
}
