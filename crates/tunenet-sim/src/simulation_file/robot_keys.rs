//! The keys of a simulation file of robot joints.

use std::borrow::Cow;
use std::sync::LazyLock;

use tunenet_core::simulator::Coefficient;

use super::schema::{GREATEST, Key, LEAST, Shape, key};
use crate::robot::{Drive, effects};

const TEXT: Shape = Shape::Word(&[]);

/// The keys of a file of robot joints besides the tables that it names itself, its effects, its parameters and its provenance.
pub const ROBOT_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["robot"]), true, "what is simulated: robot joints that follow commands"),
    key("robot.model", TEXT, true, "the robot's model, a URDF or an MJCF, from the folder of this file"),
    key(
        "robot.base_tilt_rad",
        Shape::Numbers(2, -3.2, 3.2),
        false,
        "turn of the base about x, then about y of the world",
    ),
    key("world.gravity_m_s2", Shape::Number(0.0, 1e3), false, "gravity, downwards (default: 9.81)"),
    key("integrate.step_s", Shape::Number(1e-6, 0.1), false, "step of the integration (default: 0.001)"),
    key("record.rate_hz", Shape::Number(1e-3, 1e6), false, "samples per second that `simulate` and `gen` write"),
    key("record.frames", Shape::Whole(3, 10_000_000), false, "how many samples they write"),
];

/// The keys of `[joints.NAME]`.
pub const JOINT_KEYS: &[Key] = &[
    key("drive", Shape::Word(Drive::WORDS), true, "what a command means"),
    key("command", TEXT, true, "the input that holds its commands"),
    key(
        "command_scale",
        Shape::Number(-GREATEST, GREATEST),
        false,
        "what a recorded command is multiplied by to be the goal of the joint, its torque or its voltage; not 0 (default: 1)",
    ),
    key(
        "command_range",
        Shape::Numbers(2, -GREATEST, GREATEST),
        false,
        "to which the robot clips its commands, after `command_scale`, the smaller number first (default: no range)",
    ),
    key("enable", TEXT, false, "the input that switches its motor: 0 releases it (default: always on)"),
    key(
        "observe",
        Shape::Texts,
        true,
        "what is recorded of it: names that end in rad, rad_s, nm or a; of a prismatic joint in m, m_s, n or a",
    ),
    key("kp", Shape::Number(0.0, GREATEST), false, "gain of the firmware (default: 1)"),
    key("kd", Shape::Number(0.0, GREATEST), false, "damping of the firmware: duty for each rad/s (default: 0)"),
    key(
        "gain_1_rad",
        Shape::Number(0.0, GREATEST),
        false,
        "duty for each unit of kp and rad of error (of a velocity drive, rad/s); position and velocity drives need it",
    ),
    key(
        "n_v",
        Shape::Number(-GREATEST, GREATEST),
        false,
        "force for each volt of a prismatic joint with a voltage drive",
    ),
    key(
        "nm_v",
        Shape::Number(-GREATEST, GREATEST),
        false,
        "torque for each volt of another joint with a voltage drive",
    ),
    key("nm_a", Shape::Number(-GREATEST, GREATEST), false, "torque for each ampere, where a current is observed"),
    key("duty_max", Shape::Number(LEAST, 1.0), false, "greatest duty (default: 1)"),
    key("supply_v", Shape::Number(LEAST, 1e4), false, "supply voltage; only `voltage_sag` uses it (default: 12)"),
];

/// The keys of `[loads.NAME]`.
pub const LOAD_KEYS: &[Key] = &[
    key("link", TEXT, true, "the link of the model that carries it"),
    key("mass_kg", Shape::Number(0.0, 1e6), true, "its mass, a point"),
    key(
        "position_m",
        Shape::Numbers(3, -1e3, 1e3),
        false,
        "where it is, in the axes of its link (default: its origin)",
    ),
];

/// All keys whose tables a file names itself and that no other kind of file has, by their paths.
pub static ROBOT_TABLES: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let all = JOINT_KEYS.iter().map(|key| ("joints", key)).chain(LOAD_KEYS.iter().map(|key| ("loads", key)));
    all.map(|(head, key)| Key { path: Cow::Owned(format!("{head}.NAME.{}", key.path)), ..key.clone() }).collect()
});

/// The keys below `[effects]` of a robot: one for each coefficient of the catalogue, and whether `tune` may change it.
pub static ROBOT_EFFECT_KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let keys = effects::all().into_iter().flat_map(|effect| {
        let one = |c: &Coefficient| {
            let (min, max) = effect.bounds_in_files(c);
            Key {
                path: Cow::Owned(format!("effects.{}.{}", effect.name, c.key)),
                shape: Shape::NumberOrList(min, max),
                required: false,
                meaning: Cow::Borrowed(effect.sentence),
            }
        };
        let tune = Key {
            path: Cow::Owned(format!("effects.{}.tune", effect.name)),
            shape: Shape::Flag,
            required: false,
            meaning: Cow::Borrowed("whether `tune` may change these numbers (default: false)"),
        };
        effect.coefficients.iter().map(one).chain([tune]).collect::<Vec<_>>()
    });
    keys.collect()
});
