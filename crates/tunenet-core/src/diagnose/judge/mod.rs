//! Judgement of a hypothesis: residual diagnostics, practical significance, hold-out validation, doubts.

pub(in crate::diagnose) mod adequacy;
pub(in crate::diagnose) mod cluster_robust;
pub(in crate::diagnose) mod held_out_proof;
pub(in crate::diagnose) mod heterogeneity;
pub(in crate::diagnose) mod leave_segments_out;
pub(in crate::diagnose) mod negative_control;
pub(in crate::diagnose) mod practical_significance;
pub(in crate::diagnose) mod random_effect;
pub(in crate::diagnose) mod random_effect_diagnostics;
pub(in crate::diagnose) mod recording_scores;
pub(in crate::diagnose) mod validation_doubt;

use serde::Serialize;

/// One test of what the final model leaves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Test {
    /// What was tested.
    pub name: &'static str,
    /// The statistic.
    pub value: f64,
    /// The greatest that passes.
    pub threshold: f64,
    /// Whether it passed.
    pub passed: bool,
}
