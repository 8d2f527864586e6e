//! Robot joints that follow commands.

mod bad_input;
mod formulas;
mod from_logs;
mod interfaces;
mod models;
mod servo;
mod swing;
mod traps;
mod truth;

use crate::common::Folder;

/// A hinge about −y with almost no weight of its own.
const MODEL: &str = r#"<robot name="p"><link name="base"/><link name="pendulum"><inertial><mass value="0.000001"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="pendulum"/><axis xyz="0 -1 0"/></joint></robot>"#;

/// A folder with the model and the file that `init robot` writes for it.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("arm.urdf", MODEL);
    folder.run("init robot --out robot.toml").ends(0);
    folder
}

/// Commands at 100 Hz for 4 s.
fn commands(of: impl Fn(f64) -> f64) -> String {
    let rows = (0..400).map(|i| f64::from(i) / 100.0).map(|t| format!("{t},{}\n", of(t)));
    std::iter::once("t_s,hinge_goal_rad\n".to_owned()).chain(rows).collect()
}
