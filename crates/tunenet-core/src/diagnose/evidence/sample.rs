//! A sample of many recordings (two-phase sampling, Neyman 1938): what they miss is searched in few of them, and fitted to all.

use super::Evidence;
use crate::statistics::evenly;

/// A sample is searched where at least so many recordings of one object are fitted.
const MANY: usize = 24;
/// How many of them, and of those held out, the sample has.
const FITTED: usize = 8;
const HELD_OUT: usize = 4;

/// A few recordings for many.
pub(in crate::diagnose) struct Sample {
    pub evidence: Evidence,
    /// The positions of those that are fitted among all that are.
    pub fitted: Vec<usize>,
}

impl Evidence {
    /// Recordings evenly distributed over all, so many times the least; `None` where there are few for that, or several objects.
    pub fn sample(&self, times: usize) -> Option<Sample> {
        let mut all = self.training.iter().chain(&self.validation);
        let first = self.training.first()?;
        if self.training.len() < times * MANY || !all.all(|recording| recording.object == first.object) {
            return None;
        }
        let fitted = evenly(self.training.len(), times * FITTED);
        let held_out = evenly(self.validation.len(), times * HELD_OUT);
        let evidence = Self {
            training: fitted.iter().map(|&i| self.training[i].clone()).collect(),
            validation: held_out.iter().map(|&i| self.validation[i].clone()).collect(),
            noise: self.noise,
        };
        Some(Sample { evidence, fitted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    #[test]
    fn only_many_recordings_are_sampled() {
        in_swings(&[], 30, 6, |context| {
            let sample = context.evidence.sample(1).unwrap();
            assert_eq!((sample.evidence.training.len(), sample.evidence.validation.len()), (FITTED, HELD_OUT));
            let indices: Vec<usize> = sample.evidence.training.iter().map(|one| one.index).collect();
            let wanted: Vec<usize> = sample.fitted.iter().map(|&i| context.evidence.training[i].index).collect();
            assert_eq!(indices, wanted);
            assert!(context.evidence.sample(2).is_none(), "24 recordings are few for 16 of them");
        });
        in_swings(&[], 30, 10, |context| assert!(context.evidence.sample(1).is_none()));
    }
}
