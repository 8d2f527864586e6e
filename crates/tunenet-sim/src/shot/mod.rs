//! The bounce shot: a ball released above an inclined plane, so that it bounces once and falls through a hoop.
//!
//! ```text
//! task file → scene → flight → pass → plan
//!                 belief ↗      ↖ reach
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`task`] | the file that says where plane, hoop and robot stand |
//! | [`scene`] | both for one ball, in Rapier |
//! | [`flight`] | one shot: the fall, the bounce, the way to the hoop |
//! | [`pass`] | how the ball passes the hoop: through it, at the rim, next to it |
//! | [`belief`] | what a tuned file leaves uncertain, drawn |
//! | [`reach`], [`arm`] | from which heights a hand, or an arm, can let go |
//! | [`mod@plan`] | the best of many heights |
//!
//! The origin is the ball's centre when it touches the plane; z points up.

pub mod arm;
pub mod belief;
pub mod flight;
pub mod pass;
pub mod plan;
mod provenance;
pub mod reach;
pub mod scene;
pub mod task;

pub use crate::scene::Task;
pub use arm::ArmReach;
pub use belief::Belief;
pub use flight::Flight;
pub use pass::Pass;
pub use plan::{Candidate, NoPlan, Plan, Rule, Settings, plan};
pub use reach::Reach;
pub use scene::ShotScene;
