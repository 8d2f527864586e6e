//! A set as a user has it: a model, a simulation file that lacks the effect, a manifest, and a CSV file for each run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::json;

use super::servo::{GAIN_1_RAD, GRAVITY_M_S2, Motor, SUPPLY_V};
use super::set::{FITTED, JointSet};
use crate::output::file_of;

/// A hinge about −y whose own link weighs nothing to speak of: a positive angle swings a load below it towards +x.
const MODEL: &str = r#"<robot name="pendulum"><link name="base"/><link name="arm"><inertial><mass value="0.000001"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/></joint></robot>
"#;

/// The files of a set.
pub struct Files {
    pub folder: PathBuf,
    pub simulation: PathBuf,
    pub manifest: PathBuf,
}

impl Files {
    /// Writes a set to `folder`; `truth.json` in it is for people, no part of what the tool gets.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(folder: &Path, set: &JointSet) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("creating {}", folder.display()))?;
        let keep = |name: &str, text: String| -> Result<PathBuf> {
            let path = folder.join(name);
            std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
            Ok(path)
        };
        keep("pendulum.urdf", MODEL.into())?;
        for number in 0..set.runs.len() {
            keep(&format!("run_{}.csv", number + 1), table(set, number))?;
        }
        keep("truth.json", file_of(&json!({ "motor": set.motor, "secrets": set.secrets })))?;
        let (simulation, manifest) = (keep("joint.toml", simulation())?, keep("runs.toml", manifest(set))?);
        Ok(Self { folder: folder.into(), simulation, manifest })
    }
}

fn table(set: &JointSet, number: usize) -> String {
    let run = &set.runs[number];
    let mut out = String::from("t_s,goal_rad,torque_on,position_rad\n");
    for (i, (t, goal)) in run.clock.iter().zip(&run.goal).enumerate() {
        let on = u8::from(run.off_from.is_none_or(|off| i < off));
        let _ = writeln!(out, "{t:.6},{goal:.6},{on},{:.6}", set.measured[number][i]);
    }
    out
}

/// What a user knows: the base model without the values of its parameters.
fn simulation() -> String {
    let mut out = format!(
        "kind = \"robot\"\n[robot]\nmodel = \"pendulum.urdf\"\n[world]\ngravity_m_s2 = {GRAVITY_M_S2}\n\
         [inputs.hinge_goal_rad]\ncolumn = \"goal_rad\"\nhold = \"linear\"\n[inputs.torque_on]\ndefault = 1.0\n\
         [joints.hinge]\ndrive = \"position\"\ncommand = \"hinge_goal_rad\"\nenable = \"torque_on\"\n\
         observe = [\"position_rad\"]\ngain_1_rad = {GAIN_1_RAD}\nsupply_v = {SUPPLY_V:?}\n\
         [loads.tip]\nlink = \"arm\"\nmass_kg = 0.5\nposition_m = [0.0, 0.0, -0.1]\n"
    );
    for ((name, min, max, unit), value) in Motor::NAMES.iter().zip(Motor::CENTRE.numbers()) {
        let _ = write!(
            out,
            "[parameters.hinge__{name}]\nvalue = {value:?}\nmin = {min:?}\nmax = {max:?}\nunit = \"{unit}\"\n"
        );
    }
    out
}

fn manifest(set: &JointSet) -> String {
    let mut out = String::new();
    for (i, run) in set.runs.iter().enumerate() {
        let _ = write!(
            out,
            "[[observation]]\nfile = \"run_{}.csv\"\nobject = \"servo\"\njoints.hinge.kp = {:?}\n\
             loads.tip.mass_kg = {:?}\nloads.tip.position_m = [0.0, 0.0, {:?}]\nheld_out = {}\n\n",
            i + 1,
            run.kp,
            run.mass_kg,
            -run.length_m,
            i >= FITTED
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use tunenet_sim::SimulationFile;

    use super::super::set::stream;
    use super::*;

    #[test]
    fn the_tool_reads_the_simulation_file() {
        let set = JointSet::draw(None, &mut stream("test", 1, "files", 0)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let files = Files::write(folder.path(), &set).unwrap();
        let file = SimulationFile::read(&files.simulation).unwrap();
        let simulator = tunenet_sim::observed_robot::robot(&[&file]).unwrap();
        let parameters = tunenet_core::simulator::Simulator::parameters(&simulator);
        assert_eq!(parameters.iter().map(|p| p.value).collect::<Vec<_>>(), Motor::CENTRE.numbers());
    }

    #[test]
    fn a_table_has_a_row_for_each_stamp_and_the_switch() {
        let set = JointSet::draw(None, &mut stream("test", 1, "files", 0)).unwrap();
        let (plain, dropped) = (table(&set, 0), table(&set, 2));
        assert!(plain.starts_with("t_s,goal_rad,torque_on,position_rad\n0.000000,") && plain.lines().count() == 601);
        let off = |text: &str| text.lines().filter(|line| line.split(',').nth(2) == Some("0")).count();
        assert_eq!((off(&plain), off(&dropped)), (0, 400));
        assert_eq!(manifest(&set).matches("held_out = true").count(), 3);
    }
}
