//! What else rollouts can be spent on: searches for one number, each gets what was seen and a way to roll out, nothing else.
//!
//! | file | search |
//! |---|---|
//! | `brent` | Brent's bounded minimum of the squared error, by the crate `argmin` |
//! | `entropy_search` | greedy entropy search, the paper's rival |
//! | `evolution` | CMA-ES by the crate `cmaes`, the paper's other rival |
//! | `gauss_newton` | Gauss and Newton's step, its slope from finite differences |
//! | `nearest` | the nearest of stored rollouts, then Gauss–Newton with the slope between rollouts known |

pub mod brent;
pub mod entropy_search;
pub mod evolution;
pub mod gauss_newton;
pub mod nearest;

use anyhow::Result;

/// Estimates before the first rollout and after every one.
pub type Course = Vec<f64>;

/// A rollout of the simulator with one value of the number: what would be seen.
pub type Roll<'a> = Box<dyn Fn(f64) -> Result<Vec<f64>> + Sync + 'a>;

/// One number that is looked for.
pub struct Search<'a> {
    pub roll: Roll<'a>,
    /// What was seen; a rollout has as many values.
    pub seen: &'a [f64],
    /// What the iterations start from.
    pub proposed: f64,
    /// Least and greatest value that the target was drawn from: searches that need bounds get them.
    pub range: (f64, f64),
    /// Least and greatest value that can be simulated.
    pub bounds: (f64, f64),
    /// Random seed.
    pub seed: u64,
}

impl Search<'_> {
    /// Sum of the squared differences to what was seen.
    pub fn squares(&self, rolled: &[f64]) -> f64 {
        rolled.iter().zip(self.seen).map(|(a, b)| (a - b).powi(2)).sum()
    }

    /// The step to the number that Gauss and Newton's method takes from `here`, by the slope to another rollout; `None` where
    /// nothing depends on the number.
    fn step(&self, here: (f64, &[f64]), other: (f64, &[f64])) -> Option<f64> {
        let (mut square, mut product) = (0.0, 0.0);
        for ((new, old), seen) in here.1.iter().zip(other.1).zip(self.seen) {
            let slope = (new - old) / (here.0 - other.0);
            square += slope * slope;
            product += slope * (seen - new);
        }
        (square > 0.0).then(|| product / square)
    }
}
