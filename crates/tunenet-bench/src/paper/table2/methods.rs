//! Who tunes, and what the paper reports of it.

use anyhow::Result;
use tunenet_core::network::Model;

use super::super::super::search::{Course, brent, entropy_search, evolution, gauss_newton, nearest};
use super::super::super::tuning::ours;
use super::super::super::tuning::rivals::{self, Stored};
use super::super::super::tuning::targets::{DropTarget, Simulation};
use super::BUDGETS;
use super::direct::Direct;
use crate::lazy::Lazy;

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    Default,
    Paper,
    PaperAdam,
    Mean,
    Direct,
    DirectAdam,
    EntropySearch,
    Evolution,
    EvolutionInTwo,
    Brent,
    GaussNewton,
    Apex,
    Nearest,
}

impl Method {
    pub const ALL: [Self; 13] = [
        Self::Default,
        Self::Paper,
        Self::PaperAdam,
        Self::Mean,
        Self::Direct,
        Self::DirectAdam,
        Self::EntropySearch,
        Self::Evolution,
        Self::EvolutionInTwo,
        Self::Brent,
        Self::GaussNewton,
        Self::Apex,
        Self::Nearest,
    ];

    /// Its key in JSON.
    pub fn key(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Paper => "paper",
            Self::PaperAdam => "paper_adam",
            Self::Mean => "mean",
            Self::Direct => "direct",
            Self::DirectAdam => "direct_adam",
            Self::EntropySearch => "entropy_search",
            Self::Evolution => "cma_es",
            Self::EvolutionInTwo => "cma_es_2d",
            Self::Brent => "brent",
            Self::GaussNewton => "gauss_newton",
            Self::Apex => "apex",
            Self::Nearest => "nearest",
        }
    }

    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Self::Default => "TuneNet, preset `default`",
            Self::Paper => "TuneNet, preset `paper`",
            Self::PaperAdam => "preset `paper`, trained by AdamW",
            Self::Mean => "the mean of the training range",
            Self::Direct => "direct prediction, the paper's network",
            Self::DirectAdam => "the same, trained by AdamW",
            Self::EntropySearch => "greedy entropy search",
            Self::Evolution => "CMA-ES in one dimension",
            Self::EvolutionInTwo => "CMA-ES in two, the second idle",
            Self::Brent => "bounded Brent on the squared error",
            Self::GaussNewton => "Gauss–Newton by finite differences",
            Self::Apex => "apex-height loop",
            Self::Nearest => "nearest of 201 stored rollouts, then secant Gauss–Newton",
        }
    }

    /// Whether it spends rollouts on a target at all.
    pub fn rolls_out(self) -> bool {
        !matches!(self, Self::Mean | Self::Direct | Self::DirectAdam)
    }

    /// What the paper reports of it on a set, after so many rollouts (Section 4.2; arXiv 1907.11200).
    pub fn published(self, set: &str, rollouts: usize) -> Option<f64> {
        let known: &[(&str, usize, f64)] = match self {
            Self::Paper => &[
                ("easy", 1, 0.0145),
                ("easy", 5, 0.0050),
                ("easy", 10, 0.0053),
                ("hard", 1, 0.1103),
                ("hard", 5, 0.0212),
                ("hard", 10, 0.0145),
            ],
            Self::Direct => &[("easy", BUDGETS[0], 0.0120), ("hard", BUDGETS[0], 0.0493)],
            _ => &[],
        };
        known.iter().find(|(s, k, _)| *s == set && *k == rollouts).map(|(.., error)| *error)
    }
}

/// Everything that any of them needs.
pub struct Table2Tuners<'a> {
    pub simulation: &'a Simulation,
    pub stored: &'a Stored,
    pub default: &'a Model,
    pub paper: &'a Model,
    pub paper_adam: &'a Model,
    pub direct: &'a Lazy<'a, Direct>,
    pub direct_adam: &'a Lazy<'a, Direct>,
}

impl Table2Tuners<'_> {
    /// Trains what `method` estimates with, before threads share it.
    pub fn prepare(&self, method: Method) -> Result<()> {
        match method {
            Method::Direct => self.direct.get().map(|_| ()),
            Method::DirectAdam => self.direct_adam.get().map(|_| ()),
            _ => Ok(()),
        }
    }

    /// The estimate after 0, 1, … rollouts, up to the greatest of [`BUDGETS`].
    pub fn course(&self, method: Method, target: &DropTarget, seed: u64) -> Result<Course> {
        let (simulation, most) = (self.simulation, BUDGETS[BUDGETS.len() - 1]);
        let search = simulation.search(target, seed);
        match method {
            Method::Default => ours::course(simulation, self.default, target, most),
            Method::Paper => ours::course(simulation, self.paper, target, most),
            Method::PaperAdam => ours::course(simulation, self.paper_adam, target, most),
            Method::Mean => Ok(vec![0.5; most + 1]),
            Method::Direct => Ok(vec![self.direct.get()?.estimate(target)?; most + 1]),
            Method::DirectAdam => Ok(vec![self.direct_adam.get()?.estimate(target)?; most + 1]),
            Method::EntropySearch => entropy_search::search(&search, most),
            Method::Evolution => evolution::search(&search, most, 1),
            Method::EvolutionInTwo => evolution::search(&search, most, 2),
            Method::Brent => brent::search(&search, most),
            Method::GaussNewton => gauss_newton::search(&search, most),
            Method::Apex => rivals::apex_loop(simulation, target, most),
            Method::Nearest => nearest::search(&search, self.stored.from(target.fall_m, &simulation.clock), most),
        }
    }
}
