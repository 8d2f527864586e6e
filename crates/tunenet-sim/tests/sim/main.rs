//! Balls, arms and shots against formulas, other programs and integrators of their own.

mod arm_mjcf;
mod arm_motion;
mod arm_multibody;
mod arm_pinocchio;
mod arm_urdf;
mod assets;
mod ball_laws;
mod ball_limits;
mod built_in;
mod closed_form;
mod effects;
mod examples;
mod independent;
mod late_contacts;
mod robot_mujoco;
mod shot;
