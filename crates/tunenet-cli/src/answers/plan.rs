//! The answer of `tunenet plan`: the scene, what is uncertain in it, and the best release.

use tunenet_core::observation::Note;
use tunenet_sim::shot::{self, ArmReach, Belief, Settings, ShotScene};

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
