//! Whether a hypothesis stands: residual diagnostics, practical significance, validation, verdict.

pub(in crate::diagnose) mod adequacy;
pub(in crate::diagnose) mod cluster_robust;
pub(in crate::diagnose) mod held_out_proof;
pub(in crate::diagnose) mod heterogeneity;
pub(in crate::diagnose) mod judgement;
pub(in crate::diagnose) mod leave_segments_out;
pub(in crate::diagnose) mod negative_control;
pub(in crate::diagnose) mod practical_significance;
pub(in crate::diagnose) mod random_effect;
pub(in crate::diagnose) mod recording_scores;
pub(in crate::diagnose) mod verdict;
