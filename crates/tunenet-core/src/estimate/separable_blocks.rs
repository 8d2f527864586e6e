//! Recombination of starts by blocks of a partially separable misfit (Griewank and Toint 1982): of a robot with several joints, the
//! parameters of a joint act on what is measured of it and hardly on the rest, so that each block takes the start that suits it best.

use super::jacobian::Columns;
use super::problem::Point;

/// A parameter acts on every channel whose derivative has at least this share of its greatest one.
const ACTS: f64 = 0.5;

/// Blocks of channels that share no parameter.
pub(crate) struct Blocks {
    /// The block of each channel.
    of_channel: Vec<usize>,
    /// The block of each shared parameter; `None` where it acts on nothing.
    of_parameter: Vec<Option<usize>>,
}

/// A place, and what it leaves of each channel.
#[derive(Clone)]
pub(crate) struct Place {
    pub point: Point,
    /// The mean absolute residual of each channel in units of its noise.
    pub misfits: Vec<f64>,
}

impl Place {
    /// `residuals`: in units of the noise, shape `[recording][sample · channel]`, of `width` channels.
    pub fn new(point: Point, residuals: &[Vec<f64>], width: usize) -> Self {
        let mut misfits = vec![0.0; width];
        for (i, value) in residuals.iter().flat_map(|values| values.iter().enumerate()) {
            misfits[i % width] += value.abs();
        }
        let samples = residuals.iter().map(Vec::len).sum::<usize>() / width.max(1);
        for sum in &mut misfits {
            *sum /= samples.max(1) as f64;
        }
        Self { point, misfits }
    }
}

impl Blocks {
    /// From derivatives of each recording, of `width` channels, by the first `parameters` shared parameters.
    pub fn new(columns: &[Columns], width: usize, parameters: usize) -> Self {
        let mut powers = vec![vec![0.0; width]; parameters];
        for one in columns {
            for (&index, column) in one.indices.iter().zip(&one.shared) {
                let Some(power) = powers.get_mut(index) else { continue };
                column.iter().enumerate().for_each(|(i, value)| power[i % width] += value * value);
            }
        }
        let mut of_channel: Vec<usize> = (0..width).collect();
        let mut first_of = Vec::with_capacity(parameters);
        for power in &powers {
            let greatest = power.iter().copied().fold(0.0, f64::max);
            let acts = |channel: &usize| greatest > 0.0 && power[*channel] >= ACTS * ACTS * greatest;
            let channels: Vec<usize> = (0..width).filter(acts).collect();
            first_of.push(channels.first().copied());
            for pair in channels.windows(2) {
                let (kept, merged) = (of_channel[pair[0]], of_channel[pair[1]]);
                of_channel.iter_mut().filter(|block| **block == merged).for_each(|block| *block = kept);
            }
        }
        let of_parameter = first_of.into_iter().map(|channel| channel.map(|channel| of_channel[channel])).collect();
        Self { of_channel, of_parameter }
    }

    /// What is left of the channels of a block, of `misfits` of all channels.
    pub fn left(&self, misfits: &[f64], block: usize) -> f64 {
        let own = self.of_channel.iter().zip(misfits).filter(|(of, _)| **of == block);
        own.map(|(_, misfit)| misfit).sum()
    }

    /// The parameters of a block, by position.
    pub fn parameters(&self, block: usize) -> impl Iterator<Item = usize> {
        let each = self.of_parameter.iter().enumerate();
        each.filter(move |(_, of)| **of == Some(block)).map(|(position, _)| position)
    }

    /// The place to which every block contributes the values of that one of `places` which leaves least of its channels; `None` where this
    /// is one of them.
    pub fn recombined(&self, places: &[Place]) -> Option<Point> {
        let first = places.first()?;
        let left = |place: &Place, block: usize| self.left(&place.misfits, block);
        let best = |block: usize| {
            let by_left = |a: &usize, b: &usize| left(&places[*a], block).total_cmp(&left(&places[*b], block));
            (0..places.len()).min_by(by_left).unwrap_or(0)
        };
        let of_block: Vec<usize> = (0..self.of_channel.len()).map(best).collect();
        let mut used = self.of_channel.iter().map(|block| of_block[*block]);
        let one = used.next()?;
        if used.all(|place| place == one) {
            return None;
        }
        let mut point = first.point.clone();
        for (position, value) in point.parameters.iter_mut().enumerate() {
            if let Some(block) = self.of_parameter.get(position).copied().flatten() {
                *value = places[of_block[block]].point.parameters[position];
            }
        }
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(shared: &[[f64; 3]]) -> Columns {
        // Two samples of three channels.
        let of = |power: &[f64; 3]| [power.as_slice(), power.as_slice()].concat();
        Columns { indices: (0..shared.len()).collect(), shared: shared.iter().map(of).collect(), nuisances: Vec::new() }
    }

    fn place(parameters: &[f64], left: [f64; 3]) -> Place {
        let point = Point { parameters: parameters.to_vec(), nuisances: Vec::new() };
        Place::new(point, &[vec![left[0], -left[1], left[2]], left.to_vec()], 3)
    }

    #[test]
    fn every_block_takes_the_values_of_the_place_that_suits_it() {
        // The first parameter acts on the first channel, the second on both others, the third on nothing.
        let blocks = Blocks::new(&[columns(&[[1.0, 0.3, 0.0], [0.0, 2.0, 1.5], [0.0; 3]])], 3, 3);
        let places = [place(&[1.0, 10.0, 7.0], [0.1, 9.0, 3.0]), place(&[2.0, 20.0, 8.0], [5.0, 2.0, 2.0])];
        assert_eq!(places[1].misfits, [5.0, 2.0, 2.0]);
        assert_eq!(blocks.recombined(&places).unwrap().parameters, [1.0, 20.0, 7.0]);
        // One place suits all blocks.
        assert!(blocks.recombined(&[places[0].clone(), place(&[3.0; 3], [0.0; 3])]).is_none());
        assert!(blocks.recombined(&[]).is_none());
    }

    #[test]
    fn channels_that_share_a_parameter_are_one_block() {
        let blocks = Blocks::new(&[columns(&[[1.0, 0.0, 1.0], [0.0, 0.8, 1.0]])], 3, 2);
        let places = [place(&[1.0, 10.0], [0.0, 9.0, 3.0]), place(&[2.0, 20.0], [5.0, 2.0, 2.0])];
        assert!(blocks.recombined(&places).is_none());
    }
}
