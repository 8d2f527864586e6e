//! The keys of an arm's simulation file, with unit and range.

use super::schema::{Definition, GREATEST, Key, LEAST, Shape, key};

/// The keys of an arm's file besides its parameters and its provenance.
pub const ARM_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["arm"]), true, "what is simulated"),
    key("world.gravity_m_s2", Shape::Number(LEAST, 1e3), false, "gravity, downwards (default: 9.81)"),
    key("arm.urdf", Shape::Word(&[]), true, "the arm's URDF, from the folder of this file"),
    key("arm.payload_link", Shape::Word(&[]), true, "the link of the URDF that holds the payload"),
    key(
        "arm.payload_size_m",
        Shape::Number(0.0, 10.0),
        false,
        "edge of the payload, a homogeneous cube (default: a point)",
    ),
    key(
        "arm.current_gain_nm_a",
        Shape::List(-1e4, 1e4),
        false,
        "torque for each ampere, joint by joint, where currents were recorded",
    ),
    key(
        "motion.kind",
        Shape::Word(&["circle", "replay"]),
        true,
        "whether the end effector moves along a circle or recorded joints are replayed",
    ),
    key("motion.centre_m", Shape::Numbers(3, -1e3, 1e3), false, "centre of the circle (default: [-0.4, 0, 0])"),
    key("motion.radius_m", Shape::Number(0.0, 1e3), false, "its radius (default: 0.2)"),
    key("motion.rate_rad_s", Shape::Number(-1e3, 1e3), false, "angular rate along the circle (default: 1.2)"),
    key("motion.duration_s", Shape::Number(1e-3, 1e4), false, "for how long (default: 5)"),
    key(
        "motion.cutoff_hz",
        Shape::Number(0.1, 1e3),
        false,
        "cut-off frequency of the filter for a replayed motion (default: 10)",
    ),
    key("record.rate_hz", Shape::Number(1e-3, 1e4), false, "samples per second that `simulate` and `gen` write"),
];

const PLACE: Definition = Definition {
    name: "payload_com_x",
    unit: "m",
    default: [0.0, -0.3, 0.3],
    tune: false,
    bounds: (-GREATEST, GREATEST),
    within: "any size",
    meaning: "Centre of mass of the payload along x of its link",
};

/// The parameters of an arm.
pub(super) const ARM_PARAMETERS: &[Definition] = &[
    Definition {
        name: "payload_mass",
        unit: "kg",
        default: [0.0, 0.0, 5.0],
        tune: true,
        bounds: (0.0, f64::INFINITY),
        within: "0 or more",
        meaning: "What the arm holds, beyond what its URDF says",
    },
    PLACE,
    Definition { name: "payload_com_y", meaning: "The same along y", ..PLACE },
    Definition { name: "payload_com_z", meaning: "The same along z", ..PLACE },
    Definition {
        name: "torque_gain",
        unit: "1",
        default: [1.0, 0.1, 10.0],
        tune: false,
        bounds: (1e-3, 1e3),
        within: "above 0",
        meaning: "Of a replayed motion: what the sensors of all joints show, over the true torque",
    },
];
