//! What the model states of the motors of a file's joints: where it clips their commands, and whether it limits their torques.

use tunenet_core::simulator::{Effect, Parameter};
use tunenet_formats::Result;
use tunenet_models::Robot;

use crate::SimulationFile;
use crate::arm::{Model, model_file};
use crate::robot::layout::Role;
use crate::robot::numbers::Number;
use crate::robot::{Drive, StatedMotor, stated_motors};
use crate::scene::JointScene;

/// The effect that lowers the torque limit.
const LIMIT: &str = "duty_limit";
/// The least share of a torque limit that a model states.
const LEAST_OF_A_STATED_LIMIT: f64 = 0.02;
/// A torque limit that clips commands as their range does may differ from it by this share.
const SAME: f64 = 1e-9;

/// The motor of each joint of the file, in this order; `None` without one, and where the file gives the joint another drive.
pub(super) fn of_joints(
    file: &SimulationFile,
    whole: &Model,
    described: Option<&Robot>,
    order: &[(&str, &JointScene)],
) -> Result<Vec<Option<StatedMotor>>> {
    let motors = described.map(stated_motors).unwrap_or_default();
    let one = |(key, joint): &(&str, &JointScene)| {
        let name = model_file::named(file, whole, key)?;
        Ok(motors.iter().find(|motor| motor.joint == name && motor.drive == joint.drive).cloned())
    };
    order.iter().map(one).collect()
}

/// To which goals or torques a copy of the model clips the commands of each joint, where its simulation does not: the torque limit of a
/// torque drive clips them too.
pub(super) fn command_ranges(
    motors: &[Option<StatedMotor>],
    order: &[(&str, &JointScene)],
    roles: &[Role],
    parameters: &[Parameter],
) -> Vec<Option<[f64; 2]>> {
    let one = |(place, motor): (usize, &Option<StatedMotor>)| {
        let range = motor.as_ref()?.command_range?;
        let joint = order[place].1;
        let is = |role: &Role| role.joint == place && role.number == Number::StallTorque;
        let limit = roles.iter().zip(parameters).find(|(role, _)| is(role)).map(|(_, parameter)| parameter.value);
        let most =
            limit.filter(|limit| *limit > 0.0 && joint.drive == Drive::Torque).map(|limit| limit * joint.duty_max);
        let clips = most.is_some_and(|most| -most >= range[0] * (1.0 + SAME) && most <= range[1] * (1.0 + SAME));
        Some(range).filter(|_| !clips)
    };
    motors.iter().enumerate().map(one).collect()
}

/// The effect on the torque limit goes far down only in joints whose model states no limit: theirs is the torque of an error that no
/// joint has, of which any share may be the true one.
pub(super) fn with_limits_reached(mut entry: Effect, motors: &[Option<StatedMotor>]) -> Effect {
    if entry.name != LIMIT {
        return entry;
    }
    for (coefficient, plausible) in entry.coefficients.iter_mut().zip(&mut entry.plausible) {
        let joint = coefficient.number.and_then(|number| number.checked_sub(1));
        let motor = joint.and_then(|joint| motors.get(joint)?.as_ref());
        if motor.is_some_and(|motor| !motor.limited) {
            plausible.0 = coefficient.min;
        } else {
            coefficient.min = coefficient.min.max(LEAST_OF_A_STATED_LIMIT);
        }
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::effects::RobotEffect;

    const MODEL: &str = "<mujoco><compiler angle='radian'/><worldbody><body><joint name='a'/><geom size='0.1'/>\
        <body><joint name='b'/><geom size='0.1'/><body><joint name='c'/><geom size='0.1'/></body></body></body></worldbody>\
        <actuator><position joint='a' kp='30' gear='2' ctrlrange='-0.4 0.6'/><motor joint='b' gear='3' ctrlrange='-1 1'/>\
        <position joint='c' kp='30' forcerange='-3 3'/></actuator></mujoco>";
    const FILE: &str = "kind = \"robot\"\n[robot]\nmodel = \"m.xml\"\n[inputs.a_goal_rad]\n[inputs.b_torque_nm]\n[inputs.c_goal_rad]\n\
        [joints.a]\ndrive = \"position\"\ncommand = \"a_goal_rad\"\nobserve = [\"a_rad\"]\ngain_1_rad = 0.1\ncommand_scale = 0.5\n\
        [joints.b]\ndrive = \"torque\"\ncommand = \"b_torque_nm\"\nobserve = [\"b_rad\"]\ncommand_scale = 3.0\n\
        [joints.c]\ndrive = \"position\"\ncommand = \"c_goal_rad\"\nobserve = [\"c_rad\"]\ngain_1_rad = 10.0\n\
        [parameters.a__stall_torque]\nvalue = 1200.0\nmin = 1.0\nmax = 2000.0\n[parameters.c__stall_torque]\nvalue = 3.0\nmin = 0.1\nmax = 9.0\n";
    const LIMITED: &str = "[parameters.b__stall_torque]\nvalue = 3.0\nmin = 0.1\nmax = 9.0\n";

    fn with_motors<T>(text: &str, ask: impl FnOnce(&[Option<StatedMotor>], Vec<Option<[f64; 2]>>) -> T) -> T {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.xml"), MODEL).unwrap();
        let file = SimulationFile::parse(&folder.path().join("robot.toml"), text).unwrap();
        let (whole, described) = model_file::read_driven(&folder.path().join("m.xml")).unwrap();
        let chain = super::super::chain(&file, &whole).unwrap();
        let order = super::super::order(&file, &chain).unwrap();
        let motors = of_joints(&file, &whole, described.as_ref(), &order).unwrap();
        let parameters = file.parameters().unwrap();
        let ranges = command_ranges(&motors, &order, &super::super::roles(&parameters, &order), &parameters);
        ask(&motors, ranges)
    }

    #[test]
    fn commands_have_a_range_where_no_torque_limit_clips_them_as_well() {
        with_motors(FILE, |_, ranges| assert_eq!(ranges, [Some([-0.2, 0.3]), Some([-3.0, 3.0]), None]));
        with_motors(&format!("{FILE}{LIMITED}"), |_, ranges| assert_eq!(ranges, [Some([-0.2, 0.3]), None, None]));
    }

    #[test]
    fn a_limit_that_no_model_states_may_be_any_share_of_the_assumed_one() {
        with_motors(FILE, |motors, _| {
            let entry = RobotEffect::find(LIMIT).unwrap().entry(&["a", "b", "c"], |_| true);
            let least = entry.coefficients[0].min;
            assert!(least < LEAST_OF_A_STATED_LIMIT);
            let found = with_limits_reached(entry, motors);
            let of = |place: usize| (found.coefficients[place].min, found.plausible[place].0);
            assert_eq!((of(0), of(2)), ((least, least), (LEAST_OF_A_STATED_LIMIT, 0.1)));
        });
    }
}
