//! The answer of `tunenet plan`: the scene, what is uncertain in it, and the best release.

use tunenet_core::observation::Note;
use tunenet_sim::shot::{self, ArmReach, Belief, Settings, ShotScene, Task};

use crate::findings;

/// Everything that was asked and answered.
pub struct Answer {
    pub scene: ShotScene,
    pub belief: Belief,
    pub arm: Option<ArmReach>,
    pub plan: shot::Plan,
    pub settings: Settings,
    pub notes: Vec<Note>,
    pub seconds: f64,
}

/// What a person should know of the plan.
pub fn notice(plan: &shot::Plan, task: &Task) -> Vec<Note> {
    let mut notes = Vec::new();
    let out_of_reach = plan.candidates.iter().filter(|c| c.joints_rad.is_none()).count();
    if out_of_reach > 0 {
        notes.push(Note::new(
            findings::PLAN_ARM_REACH,
            format!("the arm reaches {} of {} heights", plan.candidates.len() - out_of_reach, plan.candidates.len()),
            "move its base in the task file, or narrow `release.heights_m`",
        ));
    }
    let at_end = plan.best == 0 || plan.best + 1 == plan.candidates.len();
    if plan.reachable && at_end {
        let (low, high) = task.release.heights_m;
        notes.push(Note::new(
            findings::PLAN_AT_END,
            format!(
                "the best height is the {} that the task allows",
                if plan.best == 0 { "lowest" } else { "highest" }
            ),
            format!("widen `release.heights_m` beyond {low} to {high} m where there is room"),
        ));
    }
    notes
}
