//! What each row measures, and what is aimed at.

use crate::args::TuningRow;
use crate::scene::{EASY, HARD};

/// Rollouts after which the estimates are compared.
pub const BUDGETS: [usize; 5] = [1, 2, 3, 5, 10];
/// The greatest of them.
pub const MOST: usize = 10;

/// How the targets of a row are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// Least and greatest restitution.
    pub restitution: (f64, f64),
    /// Standard deviation of white noise on the height, m.
    pub noise_m: f64,
}

/// What is compared with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistic {
    Mean,
    Median,
}

/// What a limit is measured in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Restitution.
    Absolute(f64),
    /// Multiples of the Cramér–Rao bound's mean.
    Bounds(f64),
    /// Multiples of the same statistic of the maximum-likelihood fit.
    Likelihoods(f64),
}

/// What preset `default` is to reach.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    pub rollouts: usize,
    pub statistic: Statistic,
    pub limit: Limit,
}

impl TuningRow {
    /// Every row, in the order of the table.
    pub const ALL: [Self; 8] = [
        Self::Easy0,
        Self::Hard0,
        Self::Easy5mm,
        Self::Easy2cm,
        Self::Hard5mm,
        Self::Hard2cm,
        Self::General,
        Self::Cross,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Easy0 => "easy-0",
            Self::Hard0 => "hard-0",
            Self::Easy5mm => "easy-5mm",
            Self::Easy2cm => "easy-2cm",
            Self::Hard5mm => "hard-5mm",
            Self::Hard2cm => "hard-2cm",
            Self::General => "general",
            Self::Cross => "cross",
        }
    }

    /// How the targets are drawn; `None` where they come from files, or differ in more than this.
    pub fn conditions(self) -> Option<Conditions> {
        let (restitution, noise_m) = match self {
            Self::Easy0 => (EASY, 0.0),
            Self::Hard0 => (HARD, 0.0),
            Self::Easy5mm => (EASY, 0.005),
            Self::Easy2cm => (EASY, 0.02),
            Self::Hard5mm => (HARD, 0.005),
            Self::Hard2cm => (HARD, 0.02),
            Self::General | Self::Cross => return None,
        };
        Some(Conditions { restitution, noise_m })
    }

    pub fn goals(self) -> Vec<Goal> {
        let mean = |rollouts, limit| Goal { rollouts, statistic: Statistic::Mean, limit };
        match self {
            Self::Easy0 => vec![mean(1, Limit::Absolute(3e-4)), mean(5, Limit::Absolute(1e-6))],
            Self::Hard0 => vec![mean(1, Limit::Absolute(3e-3)), mean(5, Limit::Absolute(3e-4))],
            Self::Easy5mm => {
                vec![mean(1, Limit::Bounds(2.5)), mean(2, Limit::Bounds(1.5)), mean(5, Limit::Bounds(1.1))]
            }
            Self::Easy2cm => vec![mean(1, Limit::Bounds(1.5)), mean(5, Limit::Bounds(1.1))],
            Self::Hard2cm => vec![
                mean(5, Limit::Likelihoods(1.3)),
                Goal { rollouts: 5, statistic: Statistic::Median, limit: Limit::Likelihoods(1.1) },
            ],
            Self::Hard5mm | Self::General | Self::Cross => vec![],
        }
    }
}
