//! The table of `bench rollouts`.

use std::fmt::Write;

use serde::Serialize;
use tunenet_core::tune::Verdict;

use crate::goals::met;

/// One problem, tuned by each method.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    pub problem: &'static str,
    pub parameters: usize,
    pub recordings: usize,
    pub verdict: Verdict,
    pub rollouts: usize,
    /// `None` where scipy is not there.
    pub scipy_rollouts: Option<usize>,
    /// `None` where `mujoco.sysid` is not there.
    pub mujoco_rollouts: Option<usize>,
    pub most_rollouts: usize,
    /// In half-widths of the 95 % intervals.
    pub largest_difference: Option<f64>,
}

/// The table. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(command: &str, rows: &[Comparison]) -> String {
    let mut out = format!("# Rollouts of a tuning\n\n    {command}\n\n");
    out.push_str(
        "A rollout simulates one recording once. *scipy* is its least squares (trust-region reflective), *mujoco.sysid* its `optimize`, both \
         from the same start, within the same bounds, without intervals and without checks. *Difference* is the largest of a \
         parameter to scipy's, in half-widths of its 95 % interval.\n\n\
         | problem | parameters | recordings | verdict | rollouts | scipy | mujoco.sysid | goal | difference |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let verdict = match row.verdict {
            Verdict::Tuned => "tuned",
            Verdict::Rejected => "rejected",
            Verdict::PoorFit => "poor fit",
            Verdict::NotIdentifiable => "not identifiable",
        };
        let missing = || "not there".to_owned();
        let theirs = |rollouts: Option<usize>| rollouts.map_or_else(missing, |count| count.to_string());
        let (scipy, mujoco) = (theirs(row.scipy_rollouts), theirs(row.mujoco_rollouts));
        let difference = row.largest_difference.map_or_else(missing, |d| format!("{d:.3}"));
        let (name, parameters, recordings, rollouts) = (row.problem, row.parameters, row.recordings, row.rollouts);
        let goal = format!("≤ {}, {}", row.most_rollouts, met(rollouts <= row.most_rollouts));
        let _ = writeln!(
            out,
            "| {name} | {parameters} | {recordings} | {verdict} | {rollouts} | {scipy} | {mujoco} | {goal} | {difference} |"
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_goal_and_a_missing_scipy_are_shown() {
        let row = Comparison {
            problem: "cart",
            parameters: 5,
            recordings: 6,
            verdict: Verdict::Tuned,
            rollouts: 210,
            scipy_rollouts: None,
            mujoco_rollouts: Some(324),
            most_rollouts: 200,
            largest_difference: None,
        };
        let text = markdown("tunenet bench rollouts", &[row]);
        assert!(
            text.ends_with("| cart | 5 | 6 | tuned | 210 | not there | 324 | ≤ 200, **missed** | not there |\n"),
            "{text}"
        );
    }
}
