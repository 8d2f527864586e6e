//! How far a fit is, on the line of progress: `tuning, 40 rollouts, first fit, gap 0.0123, 3s`.

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use indicatif::ProgressBar;
use tunenet_core::observation::three_digits;
use tunenet_core::tune::{Phase, Watch};

/// Writes phase and gap into the prefix of a bar, whose style shows it between rollouts and time.
pub struct FitProgress {
    bar: ProgressBar,
    state: Mutex<State>,
}

struct State {
    phase: Phase,
    gap: Option<f64>,
}

impl FitProgress {
    /// Shows a fit on `bar`.
    pub fn on(bar: &ProgressBar) -> Self {
        Self { bar: bar.clone(), state: Mutex::new(State { phase: Phase::Fit, gap: None }) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn show(&self, state: &State) {
        self.bar.set_prefix(line(state));
    }
}

fn line(state: &State) -> String {
    let phase = match state.phase {
        Phase::Fit => "first fit",
        Phase::Search => "further starts",
        Phase::Intervals => "intervals",
    };
    let gap = state.gap.map_or_else(String::new, |gap| format!(", gap {}", three_digits(gap)));
    format!("{phase}{gap}, ")
}

impl Watch for FitProgress {
    fn phase(&self, phase: Phase) {
        let mut state = self.state();
        state.phase = phase;
        self.show(&state);
    }

    fn gap(&self, gap: f64) {
        let mut state = self.state();
        // Fits along a profile leave more than the best point.
        if state.gap.is_none_or(|least| gap < least) {
            state.gap = Some(gap);
            self.show(&state);
        }
    }

    fn rollouts(&self, _: usize) {}
}

impl fmt::Debug for FitProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FitProgress").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_prefix_holds_the_phase_and_the_least_gap() {
        let bar = ProgressBar::hidden();
        let fit = FitProgress::on(&bar);
        fit.phase(Phase::Fit);
        assert_eq!(bar.prefix(), "first fit, ");
        fit.gap(0.5);
        fit.gap(0.012_345);
        fit.phase(Phase::Intervals);
        fit.gap(0.02);
        assert_eq!(bar.prefix(), "intervals, gap 0.0123, ");
    }
}
