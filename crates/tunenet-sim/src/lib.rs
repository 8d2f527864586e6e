//! The worlds that tunenet simulates, on Rapier.
//!
//! | module | what |
//! |---|---|
//! | [`simulation_file`] | the one file that describes a simulation |
//! | [`scene`] | what such a file says, as values |
//! | [`arm`] | arms read from a URDF or an MJCF: kinematics, inverse dynamics, motions |
//! | [`ball`] | a ball that falls, bounces and rolls, contacts at their time of impact |
//! | [`observed_ball`] | that ball as a simulator that core can tune |
//! | [`observed_arm`] | an arm that follows a motion, as a simulator that core can tune |
//! | [`observed_equations`] | the equations of a file as a simulator that core can tune |
//! | [`observed_robot`] | the robot joints of a file as a simulator that core can tune |
//! | [`observed`] | from a file to such a simulator, its effects included |
//! | [`robot`] | robot joints from commands: drives, friction, rollouts |
//! | [`robot_changes`] | the numbers of robot joints as changes of their model file |
//! | [`replayed_arm`] | an arm whose measured motion is replayed: torques from logs |
//! | [`open_drag`] | the drag that recordings leave open |
//! | [`formula_effect`] | effects that a user writes as formulas |
//! | [`law`] | balls and equations as hosts of a search for a law |
//! | [`phase`] | where effects act, in words |
//! | [`declared`] | channels, inputs, initial states and candidates that a file declares itself |
//! | [`equations`] | a simulator of formulas that stand in the file itself |
//! | [`process`] | a simulator of any language: a program that speaks lines of JSON |
//! | [`network`] | which network a fit starts with |
//! | [`built_in`] | the network that comes with the tool |
//! | [`video_drops`] | drops in front of an uncalibrated camera |
//! | [`video_ball`] | a drop from a known height, tuned to pixels |
//! | [`shot`] | a ball that bounces off a plane through a hoop, and from where to let it go |
//! | [`drawn`] | recordings of it, drawn at random: what its networks learn from |

pub mod arm;
pub mod ball;
pub mod built_in;
pub mod declared;
pub mod drawn;
pub mod equations;
pub mod findings;
pub mod formula_effect;
pub mod law;
pub mod network;
pub mod observed;
pub mod observed_arm;
pub mod observed_ball;
pub mod observed_equations;
pub mod observed_robot;
pub mod open_drag;
pub mod phase;
pub mod process;
pub mod replayed_arm;
pub mod robot;
pub mod robot_changes;
pub mod scene;
pub mod shot;
pub mod simulation_file;
mod valid_range;
pub mod video_ball;
pub mod video_drops;

pub use drawn::Drawn;
pub use network::{ChosenNetwork, NetworkSource, NetworkStore, choose_network};
pub use observed::simulator;
pub use observed_arm::ObservedArm;
pub use observed_ball::ObservedBall;
pub use observed_equations::EquationsSimulator;
pub use observed_robot::RobotSimulator;
pub use process::{ProcessSimulator, Session};
pub use replayed_arm::ReplayedArm;
pub use simulation_file::SimulationFile;
pub use video_ball::VideoBall;

/// The code of the book's page on embedding, compiled and run with the doctests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/embedding.md")]
pub struct EmbeddingPage;
