//! What each row measures: which sets are drawn, and how many.

use super::blind::{EffectKind, Noise, Recipe, Trouble};
use crate::args::DiagnoseRow;

/// Recordings of each set that are held out.
const HELD_OUT: usize = 2;
/// Sets that are kept in one piece.
const SETS_PER_PIECE: u64 = 10;

/// Sets of one kind.
#[derive(Debug, Clone)]
pub struct DiagnoseCell {
    pub row: DiagnoseRow,
    /// Unique among all cells; its draws follow from this name.
    pub name: String,
    pub recipe: Recipe,
    /// The first of its sets, and how many.
    pub first: u64,
    pub count: u64,
}

/// How many sets of each kind are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Counts {
    /// Of each row of clean recordings.
    clean: u64,
    /// Of each effect, ratio and number of drops.
    effect: u64,
    /// Of pairs.
    pairs: u64,
    /// Of each effect that is in no catalogue, ratio and number of drops.
    outside: u64,
    /// Of three effects.
    threes: u64,
    /// Of each kind of trouble.
    troubled: u64,
    /// Of each effect, for the experiment that is to separate what one drop cannot.
    experiments: u64,
    /// Of each effect, in many drops.
    many: u64,
    /// Sets that are timed.
    timed: u64,
}

impl Counts {
    pub const WHOLE: Self = Self {
        clean: 300,
        effect: 10,
        pairs: 60,
        outside: 4,
        threes: 40,
        troubled: 40,
        experiments: 5,
        many: 2,
        timed: 10,
    };
    pub const QUICK: Self = Self {
        clean: 40,
        effect: 2,
        pairs: 12,
        outside: 1,
        threes: 6,
        troubled: 10,
        experiments: 1,
        many: 1,
        timed: 4,
    };
}

impl DiagnoseRow {
    /// Every row, in the order of the tables.
    pub const ALL: [Self; 19] = [
        Self::Clean,
        Self::Autocorrelated,
        Self::Outliers,
        Self::Dropped,
        Self::Ratio1,
        Self::Ratio3,
        Self::Ratio10,
        Self::Ratio30,
        Self::Two,
        Self::Three,
        Self::Outside,
        Self::Formulas,
        Self::WrongMass,
        Self::OddBall,
        Self::Scatter,
        Self::Plane,
        Self::Experiment,
        Self::Many,
        Self::Cost,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Autocorrelated => "coloured",
            Self::Outliers => "outliers",
            Self::Dropped => "dropped",
            Self::Ratio1 => "ratio-1",
            Self::Ratio3 => "ratio-3",
            Self::Ratio10 => "ratio-10",
            Self::Ratio30 => "ratio-30",
            Self::Two => "two",
            Self::Three => "three",
            Self::Outside => "outside",
            Self::Formulas => "formulas",
            Self::WrongMass => "wrong-mass",
            Self::OddBall => "odd-ball",
            Self::Scatter => "scatter",
            Self::Plane => "plane",
            Self::Experiment => "experiment",
            Self::Many => "many",
            Self::Cost => "cost",
        }
    }

    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Self::Clean => "nothing hidden, white noise",
            Self::Autocorrelated => "nothing hidden, AR(1) noise with ρ 0.3 and 0.5",
            Self::Outliers => "nothing hidden, 1 % of the samples 5 to 30 σ off",
            Self::Dropped => "nothing hidden, 15 % of the frames missing",
            Self::Ratio1 => "one effect of the catalogue, as large as the noise",
            Self::Ratio3 => "one effect of the catalogue, 3 times the noise",
            Self::Ratio10 => "one effect of the catalogue, 10 times the noise",
            Self::Ratio30 => "one effect of the catalogue, 30 times the noise",
            Self::Two => "two effects of the catalogue, each 10 times the noise",
            Self::Three => "three effects of the catalogue, each 10 times the noise",
            Self::Outside => "an effect that the catalogue does not hold, 3, 10 and 30 times the noise",
            Self::Formulas => {
                "one of six formulas that the file declares, 3, 10 and 30 times the noise, or nothing hidden"
            }
            Self::WrongMass => "drag, 10 times the noise; the file states a fifth or five times the ball's mass",
            Self::OddBall => "nothing hidden; one of five recordings shows a ball of another restitution",
            Self::Scatter => "nothing hidden; the restitution differs from recording to recording",
            Self::Plane => {
                "one effect of the catalogue, 10 times the noise, or nothing hidden; only x and z are recorded"
            }
            Self::Experiment => "one drop of one effect, 10 times the noise, then the experiment that was asked for",
            Self::Many => "100 drops: nothing hidden, or an effect in or outside the catalogue, 10 times the noise",
            Self::Cost => "three drops of 216 samples on two threads",
        }
    }

    /// The ratio of a row with one effect.
    pub fn ratio(self) -> Option<f64> {
        match self {
            Self::Ratio1 => Some(1.0),
            Self::Ratio3 => Some(3.0),
            Self::Ratio10 => Some(10.0),
            Self::Ratio30 => Some(30.0),
            _ => None,
        }
    }

    /// Whether nothing is hidden in its sets.
    pub fn is_clean(self) -> bool {
        matches!(self, Self::Clean | Self::Autocorrelated | Self::Outliers | Self::Dropped)
    }

    /// The cells of this row.
    pub fn cells(self, counts: Counts) -> Vec<DiagnoseCell> {
        let mut cells = Cells { row: self, cells: vec![] };
        let white = Noise::WHITE;
        match self {
            Self::Clean => {
                for drops in [1, 3, 6] {
                    cells.add(&format!("{drops}"), vec![], 0.0, drops, white, counts.clean / 3);
                }
            }
            Self::Autocorrelated => {
                for colour in [0.3, 0.5] {
                    let noise = Noise { colour, ..white };
                    cells.add(&format!("{colour}"), vec![], 0.0, 3, noise, counts.clean / 2);
                }
            }
            Self::Outliers => cells.add("3", vec![], 0.0, 3, Noise { outliers: 0.01, ..white }, counts.clean),
            Self::Dropped => cells.add("3", vec![], 0.0, 3, Noise { dropped: 0.15, ..white }, counts.clean),
            Self::Ratio1 | Self::Ratio3 | Self::Ratio10 | Self::Ratio30 => {
                for drops in [1, 3, 10] {
                    for kind in EffectKind::CATALOGUE {
                        let name = format!("{drops}-{}", kind.name());
                        let ratio = self.ratio().unwrap_or_default();
                        cells.add(&name, vec![kind], ratio, drops, white, counts.effect);
                    }
                }
            }
            Self::Two => {
                let pairs = pairs();
                for number in 0..counts.pairs {
                    // A stride that has no factor in common with their number visits all pairs evenly.
                    let (a, b) = pairs[usize::try_from(number * 37 + 11).unwrap_or(0) % pairs.len()];
                    let name = format!("{number}-{}-{}", a.name(), b.name());
                    cells.add(&name, vec![a, b], 10.0, 6, white, 1);
                }
            }
            Self::Three => {
                let threes = threes();
                for number in 0..counts.threes {
                    let hidden = threes[usize::try_from(number * 101 + 17).unwrap_or(0) % threes.len()];
                    let name = format!("{number}-{}", hidden.map(EffectKind::name).join("-"));
                    cells.add(&name, hidden.to_vec(), 10.0, 6, white, 1);
                }
            }
            Self::Outside => {
                for kind in EffectKind::OUTSIDE {
                    cells.add(&format!("1-{}", kind.name()), vec![kind], 10.0, 1, white, counts.outside);
                    for (ratio, drops) in [(3.0, 3), (10.0, 3), (30.0, 3), (10.0, 10)] {
                        let name = format!("{drops}-{}-at-{ratio}", kind.name());
                        cells.add(&name, vec![kind], ratio, drops, white, counts.outside);
                    }
                }
            }
            Self::Formulas => {
                cells.add("3", vec![], 0.0, 3, white, 2 * counts.troubled);
                for kind in EffectKind::DECLARED {
                    for ratio in [3.0, 10.0, 30.0] {
                        let name = format!("3-{}-at-{ratio}", kind.name());
                        cells.add(&name, vec![kind], ratio, 3, white, counts.effect);
                    }
                }
            }
            Self::WrongMass => {
                for times in [0.2, 5.0] {
                    let drag = vec![EffectKind::QuadraticDrag];
                    let trouble = Trouble::WrongMass(times);
                    cells.troubled(&format!("{times}"), drag, (10.0, 4), trouble, counts.troubled / 2);
                }
            }
            Self::OddBall => {
                for by in [-0.15, 0.08] {
                    cells.troubled(&format!("{by}"), vec![], (0.0, 5), Trouble::OddBall(by), counts.troubled / 2);
                }
            }
            Self::Scatter => {
                for sd in [0.005, 0.02] {
                    let trouble = Trouble::RestitutionScatters(sd);
                    cells.troubled(&format!("{sd}"), vec![], (0.0, 6), trouble, counts.troubled / 2);
                }
            }
            Self::Plane => {
                cells.troubled("clean", vec![], (0.0, 4), Trouble::PlaneOnly, counts.troubled);
                for kind in EffectKind::CATALOGUE {
                    cells.troubled(kind.name(), vec![kind], (10.0, 4), Trouble::PlaneOnly, counts.troubled / 10);
                }
            }
            Self::Experiment => {
                for kind in EffectKind::CATALOGUE {
                    cells.add(kind.name(), vec![kind], 10.0, 1, white, counts.experiments);
                }
            }
            Self::Many => {
                cells.add("100", vec![], 0.0, 100, white, 4 * counts.many);
                for kind in EffectKind::CATALOGUE.into_iter().chain(EffectKind::OUTSIDE) {
                    cells.add(&format!("100-{}", kind.name()), vec![kind], 10.0, 100, white, counts.many);
                }
            }
            Self::Cost => cells.add("3", vec![EffectKind::QuadraticDrag], 10.0, 3, white, counts.timed),
        }
        cells.cells
    }
}

/// Effects that can be named side by side: neither has a twin, and both can be made large enough.
fn pairs() -> Vec<(EffectKind, EffectKind)> {
    let single = |kind: &&EffectKind| kind.twins().is_empty() && **kind != EffectKind::ObservationBlur;
    let kinds: Vec<EffectKind> = EffectKind::CATALOGUE.iter().filter(single).copied().collect();
    let with = |(i, a): (usize, &EffectKind)| kinds[i + 1..].iter().map(|b| (*a, *b)).collect::<Vec<_>>();
    kinds.iter().enumerate().flat_map(with).collect()
}

/// Triples of such effects.
fn threes() -> Vec<[EffectKind; 3]> {
    let pairs = pairs();
    let with = |(a, b): &(EffectKind, EffectKind)| {
        let after: Vec<[EffectKind; 3]> = pairs.iter().filter(|(c, _)| c == b).map(|(_, d)| [*a, *b, *d]).collect();
        after
    };
    pairs.iter().flat_map(with).collect()
}

struct Cells {
    row: DiagnoseRow,
    cells: Vec<DiagnoseCell>,
}

impl Cells {
    fn add(&mut self, name: &str, hidden: Vec<EffectKind>, ratio: f64, drops: usize, noise: Noise, count: u64) {
        let recipe = Recipe { hidden, ratio, drops, held_out: HELD_OUT, noise, trouble: Trouble::None };
        self.of(name, &recipe, count);
    }

    fn troubled(
        &mut self,
        name: &str,
        hidden: Vec<EffectKind>,
        (ratio, drops): (f64, usize),
        trouble: Trouble,
        count: u64,
    ) {
        let recipe = Recipe { hidden, ratio, drops, held_out: HELD_OUT, noise: Noise::WHITE, trouble };
        self.of(name, &recipe, count);
    }

    fn of(&mut self, name: &str, recipe: &Recipe, count: u64) {
        let mut first = 0;
        while first < count {
            let piece = SETS_PER_PIECE.min(count - first);
            let name = format!("{}-{name}", self.row.name());
            self.cells.push(DiagnoseCell { row: self.row, name, recipe: recipe.clone(), first, count: piece });
            first += piece;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_two_cells_share_their_draws() {
        let all: Vec<DiagnoseCell> = DiagnoseRow::ALL.into_iter().flat_map(|row| row.cells(Counts::WHOLE)).collect();
        let names: HashSet<(String, u64)> = all.iter().map(|c| (c.name.clone(), c.first)).collect();
        assert_eq!(names.len(), all.len());
        let clean = |row: DiagnoseRow| row.cells(Counts::WHOLE).iter().map(|c| c.count).sum::<u64>();
        assert!(
            [DiagnoseRow::Clean, DiagnoseRow::Autocorrelated, DiagnoseRow::Outliers, DiagnoseRow::Dropped]
                .into_iter()
                .all(|row| clean(row) >= 300)
        );
        assert_eq!(clean(DiagnoseRow::Outside), 420);
        assert!(!pairs().is_empty() && !pairs().len().is_multiple_of(37));
    }
}
