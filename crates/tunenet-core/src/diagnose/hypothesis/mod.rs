//! What could be missing: hypotheses, their scores, and the search among them.

pub(in crate::diagnose) mod candidate_scores;
pub(in crate::diagnose) mod catalogue;
pub(in crate::diagnose) mod confusable_set;
pub(in crate::diagnose) mod context;
pub(in crate::diagnose) mod forward_selection;
pub(in crate::diagnose) mod joint;
pub(in crate::diagnose) mod multistart;
pub(in crate::diagnose) mod plausibility;
pub(in crate::diagnose) mod pruning;
pub(in crate::diagnose) mod structure;
pub(in crate::diagnose) mod wording;
