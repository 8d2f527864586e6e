//! Nearest-neighbour start and secant slope from a few of the training's rollouts, which are stored with the weights.

use candle_core::{DType, Device, Tensor};

use super::grid::Grid;
use super::input::Encoded;
use super::rows::Rollout;
use super::training_set::TrainingSet;
use super::weights::Weights;
use crate::Result;

/// A rollout is kept where it covers at least this share of what the longest covers.
const WHOLE: f64 = 0.95;
/// A slope is taken between rollouts about this far on either side, as a share of the span: nearer, they differ by how
/// their samples fall into the intervals; farther, the chord is no slope.
const SLOPE_REACH: f64 = 0.01;

/// Stored rollouts as a branch sees them, with what they cover and the parameters that made them.
#[derive(Debug, Clone)]
pub(super) struct Library {
    rows: Vec<Encoded>,
    /// Parameters less their least value, over their span, shape `[rollout][parameter]`.
    normalised: Vec<Vec<f64>>,
}

impl Library {
    /// At most `most` proposed rollouts of a training set: for one parameter those nearest to an even grid, in its order.
    pub(super) fn choose(set: &TrainingSet<'_>, most: usize) -> Result<Option<Self>> {
        if most == 0 {
            return Ok(None);
        }
        let whole = |rollout: &Rollout| rollout.covered.len() as f64 >= WHOLE * set.longest as f64;
        let (mut grid, mut first) = (Grid::new(most), Vec::new());
        set.rollouts.scan(|number, rollout| {
            if number % 2 == 1 || !whole(rollout) {
                return;
            }
            grid.look(rollout.normalised[0], number);
            if first.len() < most {
                first.push(number);
            }
        })?;
        let chosen = if set.parameters.len() == 1 { grid.nearest() } else { first };
        let (mut library, mut rollout) = (Self { rows: Vec::new(), normalised: Vec::new() }, Rollout::default());
        for number in chosen {
            set.rollouts.read(number, &mut rollout)?;
            let values = rollout.row.iter().map(|v| f64::from(*v)).collect();
            library.rows.push(Encoded { values, covered: rollout.covered.clone() });
            library.normalised.push(rollout.normalised.clone());
        }
        Ok((!library.rows.is_empty()).then_some(library))
    }

    /// The stored rollout nearest to `seen`, over what both cover, with its parameters; `None` where none overlaps it.
    pub(super) fn nearest(&self, seen: &Encoded) -> Option<(Encoded, &[f64])> {
        let distance = |row: &Encoded| {
            let both = row.covered.start.max(seen.covered.start)..row.covered.end.min(seen.covered.end);
            let squares = both.clone().map(|i| (row.values[i] - seen.values[i]).powi(2)).sum::<f64>();
            if both.is_empty() { f64::INFINITY } else { squares / both.len() as f64 }
        };
        let each = self.rows.iter().zip(&self.normalised).map(|(row, normalised)| (distance(row), row, normalised));
        let (distance, row, normalised) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
        distance.is_finite().then(|| (row.clone(), normalised.as_slice()))
    }

    /// How far a rollout of one parameter at `normalised`, read between two stored ones, would lie from `seen`: mean square over
    /// what they cover; `None` for several parameters.
    pub(super) fn distance(&self, normalised: f64, seen: &Encoded) -> Option<f64> {
        if self.normalised.first().is_none_or(|p| p.len() != 1) || self.rows.len() < 2 {
            return None;
        }
        let after = self.normalised.partition_point(|p| p[0] < normalised).clamp(1, self.rows.len() - 1);
        let (a, b) = (&self.rows[after - 1], &self.rows[after]);
        let share =
            (normalised - self.normalised[after - 1][0]) / (self.normalised[after][0] - self.normalised[after - 1][0]);
        let start = a.covered.start.max(b.covered.start).max(seen.covered.start);
        let both = start..a.covered.end.min(b.covered.end).min(seen.covered.end);
        let between = |i: usize| a.values[i] + share * (b.values[i] - a.values[i]) - seen.values[i];
        (!both.is_empty()).then(|| both.clone().map(|i| between(i).powi(2)).sum::<f64>() / both.len() as f64)
    }

    /// How a rollout of one parameter changes with it at `normalised`, both in units of the span; 0 outside what is covered.
    pub(super) fn slope(&self, normalised: f64) -> Option<Encoded> {
        if self.normalised.first().is_none_or(|p| p.len() != 1) {
            return None;
        }
        let last = self.rows.len() - 1;
        let after = |at: f64| self.normalised.partition_point(|p| p[0] < at).min(last);
        let (low, high) = (after(normalised - SLOPE_REACH).saturating_sub(1), after(normalised + SLOPE_REACH));
        let (a, b) = (&self.rows[low], &self.rows[high]);
        let width = self.normalised[high][0] - self.normalised[low][0];
        let covered = a.covered.start.max(b.covered.start)..a.covered.end.min(b.covered.end);
        let mut values = vec![0.0; a.values.len()];
        for i in covered.clone() {
            values[i] = (b.values[i] - a.values[i]) / width;
        }
        (width > 0.0 && width < 4.0 * SLOPE_REACH && !covered.is_empty()).then_some(Encoded { values, covered })
    }

    /// As named tensors.
    pub(super) fn tensors(&self) -> Result<[(String, Tensor); 3]> {
        let (count, width) = (self.rows.len(), self.rows[0].values.len());
        let values: Vec<f32> = self.rows.iter().flat_map(|r| &r.values).map(|v| super::numbers::single(*v)).collect();
        let covered: Vec<f64> = self.rows.iter().flat_map(|r| [r.covered.start as f64, r.covered.end as f64]).collect();
        let tensor = |numbers: Vec<f64>, wide: usize| Tensor::from_vec(numbers, (count, wide), &Device::Cpu);
        Ok([
            ("library.rollouts".into(), Tensor::from_vec(values, (count, width), &Device::Cpu)?),
            ("library.covered".into(), tensor(covered, 2)?),
            ("library.places".into(), tensor(self.normalised.concat(), self.normalised[0].len())?),
        ])
    }

    /// Out of stored weights, for branches of `width` numbers; `None` where they hold none.
    pub(super) fn take(weights: &mut Weights, width: usize, parameters: usize) -> Result<Option<Self>> {
        let Some(count) = weights.shape("library.rollouts").and_then(|shape| shape.first().copied()) else {
            return Ok(None);
        };
        let rows = weights.take("library.rollouts", DType::F32, &[count, width])?.to_vec2::<f32>()?;
        let covered = weights.take("library.covered", DType::F64, &[count, 2])?.to_vec2::<f64>()?;
        let normalised = weights.take("library.places", DType::F64, &[count, parameters])?.to_vec2::<f64>()?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a saturating cast, then clamped")]
        let bound = |v: f64| (v as usize).min(width);
        let row = |(values, covered): (Vec<f32>, Vec<f64>)| Encoded {
            values: values.into_iter().map(f64::from).collect(),
            covered: bound(covered[0])..bound(covered[1]),
        };
        let rows: Vec<Encoded> = rows.into_iter().zip(covered).map(row).collect();
        Ok((!rows.is_empty()).then_some(Self { rows, normalised }))
    }
}
