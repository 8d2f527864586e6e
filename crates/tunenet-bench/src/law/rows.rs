//! What is asked: the sets of each row.

use super::arena::Arena;
use super::laws::{DISCOVER, HIDDEN_STATE, INSIDE, OUTSIDE};
use super::set::{Hidden, Recipe};

/// What is hidden in the recordings of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LawRow {
    /// No law.
    Clean,
    /// No law; autocorrelated noise.
    Autocorrelated,
    /// No law; 1 % outliers.
    Outliers,
    /// A law, 3, 10 and 30 times the noise.
    Ratio3,
    Ratio10,
    Ratio30,
    /// A force that depends on a hidden state.
    HiddenState,
    /// A law outside the grammar.
    Outside,
    /// The single-body laws of `DiscoverPhysics`.
    Discover,
}

/// One set to draw.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    pub row: LawRow,
    pub recipe: Recipe,
    pub number: u64,
}

const ARENAS: [Arena; 4] = [Arena::Flight, Arena::Plane, Arena::Centre, Arena::Pendulum];
/// Sets without a law, with white noise and with other noise, for each of a law: 300 and 60 where a law has 20.
const CLEAN: (u64, u64) = (15, 4);
const NOISY: (u64, u64) = (3, 4);
/// Sets at the greatest ratio for each at the others.
const GREATEST: (u64, u64) = (1, 4);
/// How much of autocorrelated noise the next sample keeps, and the share of outliers.
const COLOUR: f64 = 0.5;
const OUTLIERS: f64 = 0.01;
/// The ratio of what is outside the grammar and of hidden states.
const OTHER_RATIO: f64 = 10.0;

impl LawRow {
    pub const ALL: [Self; 9] = [
        Self::Clean,
        Self::Autocorrelated,
        Self::Outliers,
        Self::Ratio3,
        Self::Ratio10,
        Self::Ratio30,
        Self::HiddenState,
        Self::Outside,
        Self::Discover,
    ];

    /// As on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Autocorrelated => "coloured",
            Self::Outliers => "outliers",
            Self::Ratio3 => "ratio-3",
            Self::Ratio10 => "ratio-10",
            Self::Ratio30 => "ratio-30",
            Self::HiddenState => "hidden-state",
            Self::Outside => "outside",
            Self::Discover => "discover",
        }
    }

    /// The sets of this row, those of one law after the other, where a law has `sets` of them.
    fn sets(self, sets: u64) -> Vec<Asked> {
        let (colour, outliers) = match self {
            Self::Autocorrelated => (COLOUR, 0.0),
            Self::Outliers => (0.0, OUTLIERS),
            _ => (0.0, 0.0),
        };
        let mut all = Vec::new();
        let mut ask = |hidden, ratio, count| {
            let recipe = Recipe { hidden, ratio, colour, outliers };
            all.extend((0..count).map(|number| Asked { row: self, recipe, number }));
        };
        let share = |(of, by): (u64, u64)| (sets * of).div_ceil(by);
        match self {
            // In four arenas.
            Self::Clean => {
                for arena in ARENAS {
                    ask(Hidden::Nothing(arena), 0.0, share(CLEAN));
                }
            }
            Self::Autocorrelated | Self::Outliers => {
                for arena in ARENAS {
                    ask(Hidden::Nothing(arena), 0.0, share(NOISY));
                }
            }
            Self::Ratio3 | Self::Ratio10 | Self::Ratio30 => {
                let (ratio, count) = match self {
                    Self::Ratio3 => (3.0, sets),
                    Self::Ratio10 => (10.0, sets),
                    _ => (30.0, share(GREATEST)),
                };
                for (name, arena) in INSIDE {
                    ask(Hidden::Inside(name, arena), ratio, count);
                }
            }
            Self::HiddenState | Self::Outside => {
                let those = if self == Self::Outside { OUTSIDE } else { HIDDEN_STATE };
                for (name, arena, kind) in those {
                    ask(Hidden::Strange(name, arena, kind), OTHER_RATIO, sets);
                }
            }
            Self::Discover => {
                for name in DISCOVER {
                    ask(Hidden::Discover(name), 0.0, sets);
                }
            }
        }
        all
    }
}

impl Asked {
    /// Whether nothing is hidden.
    pub fn nothing(&self) -> bool {
        matches!(self.recipe.hidden, Hidden::Nothing(_))
    }
}

/// The sets of a run; `only` holds names of rows or of laws, and none means all.
pub fn sets(only: &[String], sets: u64) -> Vec<Asked> {
    let mut all: Vec<Asked> = LawRow::ALL.into_iter().flat_map(|row| row.sets(sets)).collect();
    let (rows, laws): (Vec<&String>, Vec<&String>) =
        only.iter().partition(|name| LawRow::ALL.iter().any(|row| row.name() == name.as_str()));
    all.retain(|asked| {
        let of_row = rows.is_empty() || rows.iter().any(|name| asked.row.name() == name.as_str());
        of_row && (laws.is_empty() || laws.iter().any(|name| asked.recipe.hidden.name() == name.as_str()))
    });
    all
}

/// What `--only` takes.
pub fn names() -> Vec<&'static str> {
    let inside = INSIDE.into_iter().map(|(name, _)| name);
    let strange = OUTSIDE.into_iter().chain(HIDDEN_STATE).map(|(name, ..)| name);
    LawRow::ALL.into_iter().map(LawRow::name).chain(inside).chain(strange).chain(DISCOVER).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_whole_run_holds_enough_sets() {
        let all = sets(&[], 20);
        let of = |row: LawRow| all.iter().filter(|asked| asked.row == row).count();
        assert_eq!(LawRow::ALL.map(of), [300, 60, 60, 520, 520, 130, 160, 160, 120]);
        let names: HashSet<String> = all
            .iter()
            .map(|asked| format!("{} {} {}", asked.row.name(), asked.recipe.hidden.name(), asked.number))
            .collect();
        assert_eq!(names.len(), all.len());
    }

    #[test]
    fn rows_and_laws_are_selected() {
        let count = |only: &[&str]| sets(&only.iter().map(ToString::to_string).collect::<Vec<_>>(), 20).len();
        assert_eq!(count(&["drag-2"]), 45);
        assert_eq!(count(&["drag-2", "ratio-10"]), 20);
        assert_eq!(count(&["hidden-state"]), 160);
        let all = names();
        assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
    }
}
