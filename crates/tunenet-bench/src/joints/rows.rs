//! What is asked: so many sets of each effect at each ratio, and clean ones.

use super::servo::{SECRETS, Secret};

/// Root mean squares of what is hidden, before tuning, over the noise.
pub const RATIOS: [f64; 3] = [3.0, 10.0, 30.0];
/// Clean sets for each of one effect at one ratio, and the most of them, which bound a rate of 1 %.
const CLEAN: u64 = 50;
const MOST_CLEAN: u64 = 300;
/// Sets at the greatest ratio for each at the others.
const GREATEST: (u64, u64) = (1, 2);

/// One set to draw.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// `None`: nothing.
    pub hidden: Option<&'static Secret>,
    pub ratio: f64,
    pub number: u64,
}

impl Asked {
    /// The name of its kind.
    pub fn cell(&self) -> String {
        self.hidden.map_or_else(|| CLEAN_ROW.into(), |secret| format!("{}-{}", secret.name, self.ratio))
    }
}

/// As on the command line.
pub const CLEAN_ROW: &str = "clean";
const ROWS: [&str; 3] = ["ratio-3", "ratio-10", "ratio-30"];

fn row(ratio: f64) -> &'static str {
    RATIOS.iter().position(|one| *one == ratio).map_or(CLEAN_ROW, |at| ROWS[at])
}

/// The sets of a run; `only` holds names of rows and of effects, and none means all.
pub fn sets(only: &[String], sets: u64) -> Vec<Asked> {
    let mut all: Vec<Asked> =
        (0..(CLEAN * sets).min(MOST_CLEAN)).map(|number| Asked { hidden: None, ratio: 0.0, number }).collect();
    for ratio in RATIOS {
        let count = if ratio == RATIOS[2] { (sets * GREATEST.0).div_ceil(GREATEST.1) } else { sets };
        for secret in &SECRETS {
            all.extend((0..count).map(|number| Asked { hidden: Some(secret), ratio, number }));
        }
    }
    let is_row = |name: &&String| name.as_str() == CLEAN_ROW || ROWS.contains(&name.as_str());
    let (rows, effects): (Vec<&String>, Vec<&String>) = only.iter().partition(is_row);
    all.retain(|asked| {
        let own = row(asked.ratio);
        let of_row = rows.is_empty() || rows.iter().any(|name| name.as_str() == own);
        let of_effect = effects.is_empty() || asked.hidden.is_some_and(|s| effects.iter().any(|name| *name == s.name));
        of_row && of_effect
    });
    all
}

/// What `--only` takes.
pub fn names() -> Vec<&'static str> {
    std::iter::once(CLEAN_ROW).chain(ROWS).chain(SECRETS.iter().map(|secret| secret.name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_run_holds_three_hundred_clean_sets() {
        let all = sets(&[], 20);
        let count = |ratio: f64| all.iter().filter(|asked| asked.ratio == ratio).count();
        assert_eq!([0.0, 3.0, 10.0, 30.0].map(count), [300, 460, 460, 230]);
    }

    #[test]
    fn rows_and_effects_are_selected() {
        let count = |only: &[&str]| sets(&only.iter().map(ToString::to_string).collect::<Vec<_>>(), 4).len();
        assert_eq!(count(&["clean"]), 200);
        assert_eq!(count(&["backlash"]), 10);
        assert_eq!(count(&["ratio-10", "backlash", "dead_band"]), 8);
        assert_eq!(names().len(), 27);
    }
}
