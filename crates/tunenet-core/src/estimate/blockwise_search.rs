//! Evolution strategy of one parent and one child with the rule of one success in five (Rechenberg 1973), for all blocks of a partially
//! separable misfit at once: one rollout shows what a step of each block does to that block.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::separable_blocks::Blocks;

/// The standard deviation of a first step, and of the least and the greatest one, as shares of the bounds.
const FIRST: f64 = 0.2;
const LEAST: f64 = 2e-3;
const GREATEST: f64 = 0.4;
/// A success makes steps longer by this factor, and four failures shorter by it.
const FACTOR: f64 = 1.5;
/// Tries for each parameter of the largest block.
const TRIES: usize = 40;
/// After so many tries what all blocks leave together is measured again: each moves the others a little.
const MEASURED: usize = 10;

/// What the search knows of a block.
struct State {
    left: f64,
    step: f64,
}

/// Shares of the bounds, from 0 to 1, at which every block leaves less than at `shares`; `misfits` are what given shares leave of each
/// channel, `None` where they cannot be simulated.
pub(crate) fn blockwise_search(
    blocks: &Blocks,
    mut shares: Vec<f64>,
    misfits: impl Fn(&[f64]) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let Some(first) = misfits(&shares) else { return shares };
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let count = first.len();
    let largest = (0..count).map(|block| blocks.parameters(block).count()).max().unwrap_or(0);
    let mut states: Vec<State> =
        (0..count).map(|block| State { left: blocks.left(&first, block), step: FIRST }).collect();
    for number in 1..=TRIES * largest {
        if number % MEASURED == 0
            && let Some(now) = misfits(&shares)
        {
            states.iter_mut().enumerate().for_each(|(block, state)| state.left = blocks.left(&now, block));
        }
        let mut tried = shares.clone();
        for (block, state) in states.iter().enumerate() {
            for parameter in blocks.parameters(block) {
                let normal: f64 = random.sample(StandardNormal);
                tried[parameter] = (tried[parameter] + state.step * normal).clamp(0.0, 1.0);
            }
        }
        let found = misfits(&tried);
        for (block, state) in states.iter_mut().enumerate() {
            let left = found.as_ref().map_or(f64::INFINITY, |found| blocks.left(found, block));
            if left < state.left {
                state.left = left;
                state.step = (state.step * FACTOR).min(GREATEST);
                blocks.parameters(block).for_each(|parameter| shares[parameter] = tried[parameter]);
            } else {
                state.step = (state.step * FACTOR.powf(-0.25)).max(LEAST);
            }
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::jacobian::Columns;

    /// Two channels with two parameters each, which disturb the other one a little.
    #[test]
    fn every_block_finds_its_own_minimum() {
        let columns = vec![vec![1.0, 0.0], vec![1.0, 0.0], vec![0.0, 1.0], vec![0.0, 1.0]];
        let columns = Columns { indices: (0..4).collect(), shared: columns, nuisances: Vec::new() };
        let blocks = Blocks::new(&[columns], 2, 4);
        let misfits = |u: &[f64]| {
            let one = |a: f64, b: f64| (a - 0.7).abs() + (b - 0.4).abs();
            (u[0] <= 0.99).then(|| vec![one(u[0], u[1]) + 0.01 * u[2], one(1.0 - u[2], u[3]) + 0.01 * u[0]])
        };
        let found = blockwise_search(&blocks, vec![0.1, 0.9, 0.9, 0.9], misfits);
        for (found, expected) in found.iter().zip([0.7, 0.4, 0.3, 0.4]) {
            assert!((found - expected).abs() < 0.05, "{found} {expected}");
        }
        let refused = blockwise_search(&blocks, vec![1.0, 0.5, 0.5, 0.5], misfits);
        assert_eq!(refused, [1.0, 0.5, 0.5, 0.5], "a start that cannot be simulated stays");
    }
}
