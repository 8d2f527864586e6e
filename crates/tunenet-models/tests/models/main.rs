//! The crate as its users see it, and what MuJoCo and Pinocchio make of the same models.

mod edit;
mod hostile;
mod isaac_lab;
mod left_out;
mod mujoco;
mod pinocchio;
mod support;
