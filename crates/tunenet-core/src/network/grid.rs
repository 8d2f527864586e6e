//! One-pass selection of the numbers nearest to an even grid over `[0, 1]`, in memory that does not grow with their count.

/// A number with its place in the order that it was shown in.
type Numbered = (f64, usize);

/// Looks at numbers one after the other.
pub(super) struct Grid {
    points: Vec<f64>,
    /// Between two points of the grid, and outside: the least and the greatest number seen, of equal ones the first and
    /// the last.
    between: Vec<Option<(Numbered, Numbered)>>,
}

impl Grid {
    /// A grid of `count` points from 0 to 1.
    pub(super) fn new(count: usize) -> Self {
        let points = (0..count).map(|i| i as f64 / (count - 1).max(1) as f64).collect();
        Self { points, between: vec![None; count + 1] }
    }

    /// Shows one number.
    pub(super) fn look(&mut self, value: f64, number: usize) {
        let place = self.points.partition_point(|point| value >= *point);
        let seen = (value, number);
        self.between[place] = Some(match self.between[place] {
            None => (seen, seen),
            Some((least, greatest)) => (
                if value.total_cmp(&least.0).is_lt() { seen } else { least },
                if value.total_cmp(&greatest.0).is_lt() { greatest } else { seen },
            ),
        });
    }

    /// For each point the nearest number that was shown, of two equally near the greater; each once, in rising order.
    pub(super) fn nearest(&self) -> Vec<usize> {
        let mut chosen = Vec::with_capacity(self.points.len());
        for (place, point) in self.points.iter().enumerate() {
            let below = self.between[..=place].iter().rev().flatten().next().map(|b| b.1);
            let above = self.between[place + 1..].iter().flatten().next().map(|b| b.0);
            let nearest = match (below, above) {
                (Some(below), Some(above)) => {
                    if point - below.0 < above.0 - point {
                        below
                    } else {
                        above
                    }
                }
                (Some(only), None) | (None, Some(only)) => only,
                (None, None) => continue,
            };
            chosen.push(nearest.1);
        }
        chosen.dedup();
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};

    /// All kept and sorted: the same choice, without the economy.
    fn sorted(values: &[f64], count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let place = |i: usize| values[order[i]];
        let mut chosen: Vec<usize> = (0..count)
            .map(|i| {
                let grid = i as f64 / (count - 1).max(1) as f64;
                let after = order.partition_point(|p| values[*p] < grid).min(order.len() - 1);
                let before = after.saturating_sub(1);
                if grid - place(before) < place(after) - grid { before } else { after }
            })
            .collect();
        chosen.dedup();
        chosen.into_iter().map(|i| order[i]).collect()
    }

    #[test]
    fn one_look_chooses_as_sorting_does() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for case in 0..400 {
            let count = random.random_range(1..40);
            // Equal numbers, numbers on the grid and numbers outside it among them.
            let mut draw = || -> f64 {
                match random.random_range(0..4) {
                    0 => f64::from(random.random_range(0..8_u8)) / 7.0,
                    1 => random.random_range(-0.2..1.3),
                    _ => random.random(),
                }
            };
            let values: Vec<f64> = (0..=case % 60).map(|_| draw()).collect();
            let mut grid = Grid::new(count);
            values.iter().enumerate().for_each(|(i, v)| grid.look(*v, i));
            assert_eq!(grid.nearest(), sorted(&values, count), "{values:?} {count}");
        }
    }

    #[test]
    fn nothing_seen_is_nothing_chosen() {
        assert!(Grid::new(5).nearest().is_empty());
    }
}
