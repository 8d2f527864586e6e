//! The list of MJCF elements and attributes: which are taken on, and what the others would change.
//!
//! Source: the schema of MuJoCo 4.0.0 (`mj_printSchema`). What stands in neither table is reported as unknown.

use crate::Changes;
use crate::Changes::{Contact, Dynamics, Nothing, Readings, Solver, Structure};

/// Orientation and place.
const POSE: [&str; 6] = ["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// The attributes of joints, shapes, … that the reader takes on.
pub(super) fn taken(element: &str) -> &'static [&'static str] {
    match element {
        "mujoco" => &["model"],
        "compiler" => &[
            "angle",
            "eulerseq",
            "autolimits",
            "inertiafromgeom",
            "inertiagrouprange",
            "balanceinertia",
            "boundmass",
            "boundinertia",
            "settotalmass",
            "coordinate",
        ],
        "option" => &["gravity"],
        "default" => &["class"],
        "body" | "frame" => &["name", "childclass"],
        "inertial" => &["mass", "diaginertia", "fullinertia"],
        "joint" => &[
            "name",
            "class",
            "type",
            "pos",
            "axis",
            "limited",
            "range",
            "stiffness",
            "springref",
            "ref",
            "armature",
            "damping",
            "frictionloss",
            "actuatorfrcrange",
            "actuatorfrclimited",
        ],
        "freejoint" => &["name"],
        "geom" => &["class", "type", "size", "mass", "density", "fromto", "group", "mesh", "shellinertia"],
        "fixed" => &["name", "class"],
        "equality" => &["active"],
        _ if ACTUATORS.contains(&element) => &[
            "name",
            "class",
            "joint",
            "tendon",
            "ctrllimited",
            "ctrlrange",
            "forcelimited",
            "forcerange",
            "gear",
            "kp",
            "kv",
            "dampratio",
            "timeconst",
            "inheritrange",
            "gainprm",
            "biasprm",
            "dynprm",
            "gaintype",
            "biastype",
            "dyntype",
            "delay",
            "area",
            "diameter",
            "bias",
        ],
        _ => &[],
    }
}

/// Actuators whose force the reader takes on.
pub(super) const ACTUATORS: [&str; 6] = ["general", "motor", "position", "velocity", "intvelocity", "cylinder"];
/// Those whose force it does not.
pub(super) const OTHER_ACTUATORS: [&str; 7] =
    ["damper", "muscle", "adhesion", "pid", "dcmotor", "orientation", "plugin"];

/// Whether the attribute says where the element lies, and the reader takes that on.
pub(super) fn places(element: &str, attribute: &str) -> bool {
    matches!(element, "body" | "frame" | "inertial" | "geom") && POSE.contains(&attribute)
}

/// Sections and elements that are left out with everything that they contain; `parent` is the element around them.
pub(super) fn left_out(parent: &str, element: &str) -> Option<(Changes, &'static str)> {
    Some(match (parent, element) {
        ("mujoco", "asset") => (Nothing, "shapes and looks; meshes are not opened"),
        ("mujoco", "visual" | "statistic" | "size" | "custom") => (Nothing, "looks, sizes and notes"),
        ("mujoco", "keyframe") => (Nothing, "positions to start from"),
        ("mujoco", "sensor") => (Readings, "sensors, with their noise and delay"),
        ("mujoco", "contact") => (Contact, "pairs of shapes that touch or do not"),
        ("mujoco", "deformable") => (Structure, "soft bodies"),
        ("mujoco", "extension") => (Dynamics, "plugins, whose forces are unknown"),
        ("compiler", "lengthrange") => (Solver, "how ranges of muscles are computed"),
        ("option", "flag") => (Dynamics, "switches parts of MuJoCo on or off; everything is on here"),
        ("default", "mesh" | "texture" | "material" | "site" | "camera" | "light") => (Nothing, "shapes and looks"),
        ("default", "pair") => (Contact, "how pairs of shapes touch"),
        ("default", _) if OTHER_ACTUATORS.contains(&element) => (Dynamics, "defaults of an actuator that is left out"),
        ("body" | "worldbody" | "frame", "site" | "camera" | "light") => (Nothing, "places and looks"),
        ("body" | "worldbody" | "frame", "composite" | "flexcomp") => (Structure, "would add bodies or soft bodies"),
        ("body" | "worldbody" | "frame", "replicate") => (Structure, "would add copies of what it contains"),
        ("body" | "worldbody" | "frame", "attach") => (Structure, "would add the bodies of another model"),
        (_, "plugin") => (Dynamics, "a plugin, whose forces are unknown"),
        ("equality", "connect" | "weld") => (Structure, "would close a loop between two bodies"),
        ("equality", "tendon") => (Structure, "would tie tendons"),
        ("equality", "flex" | "flexvert" | "flexstrain") => (Structure, "would tie soft bodies"),
        ("tendon", "spatial") => (Structure, "a cable through points of bodies"),
        _ => return None,
    })
}

/// What an attribute that is not taken on would change.
pub(super) fn effect(element: &str, attribute: &str) -> Option<(Changes, &'static str)> {
    let actuator = ACTUATORS.contains(&element) || OTHER_ACTUATORS.contains(&element);
    Some(match (element, attribute) {
        ("joint", "springdamper") => {
            (Dynamics, "would set stiffness and damping from a time constant and a damping ratio")
        }
        ("joint", "actuatorgravcomp") => (Dynamics, "would count gravity compensation as a force of the actuator"),
        ("joint" | "fixed" | "tendon", "springyield") => (Dynamics, "would let the spring yield"),
        ("joint", "margin" | "solreflimit" | "solimplimit") => (Contact, "how hard the stops of a joint are"),
        ("joint", "solreffriction" | "solimpfriction") => (Solver, "how exactly dry friction sticks"),
        ("freejoint", "align") => (Nothing, "which frame the free joint has"),
        ("body", "gravcomp") => (Dynamics, "would compensate gravity of the body"),
        ("body", "mocap") => (Structure, "would let a recording move the body; it is fixed here"),
        ("body", "sleep" | "simple" | "fuse") => (Solver, "how the body is stored and put to sleep"),
        ("geom", "fitscale") => (Nothing, "how a shape is fitted to a mesh"),
        (
            "geom",
            "contype" | "conaffinity" | "condim" | "friction" | "solref" | "solimp" | "solmix" | "margin" | "gap"
            | "priority" | "adhesion" | "surfacevel",
        ) => (Contact, "how a shape touches others"),
        ("option", "timestep") => (Solver, "the step of MuJoCo; the simulation file states its own"),
        ("option", "density" | "viscosity" | "wind") | ("geom", "fluidshape" | "fluidcoef") => {
            (Dynamics, "drag of a fluid")
        }
        ("option", "actuatorgroupdisable") => (Dynamics, "would switch actuators off"),
        ("option", "magnetic") => (Readings, "the magnetic field that sensors read"),
        ("option", "cone" | "impratio" | "o_margin" | "o_solref" | "o_solimp" | "o_friction") => {
            (Contact, "how shapes touch")
        }
        ("option", _) => (Solver, "how MuJoCo integrates and solves"),
        ("compiler", "fusestatic") => (Nothing, "would merge bodies that do not move"),
        ("compiler", _) => (Nothing, "where other files are, and how MuJoCo stores the model"),
        ("equality", "solref" | "solimp") => (Solver, "how hard a tie between joints is; it is rigid here"),
        ("equality", "name" | "class") => (Nothing, "a name"),
        ("fixed" | "tendon", "stiffness" | "springlength" | "damping" | "frictionloss" | "armature") => {
            (Dynamics, "spring, friction or inertia of a tendon")
        }
        ("fixed" | "tendon", "range" | "limited" | "actuatorfrcrange" | "actuatorfrclimited") => {
            (Dynamics, "limits of a tendon")
        }
        ("fixed" | "tendon", "margin" | "solreflimit" | "solimplimit" | "solreffriction" | "solimpfriction") => {
            (Solver, "how hard the limits of a tendon are")
        }
        ("geom" | "fixed" | "tendon", "name" | "rgba" | "width" | "material" | "castshadow" | "hfield") => {
            (Nothing, "looks")
        }
        (_, "damping" | "armature") if actuator => (Dynamics, "damping or inertia of the actuator itself"),
        (_, "actlimited" | "actrange") if actuator => (Dynamics, "limits of what the filter holds"),
        (_, "actearly" | "actdim") if actuator => (Solver, "when the filter acts"),
        (_, "jointinparent") if actuator => (Dynamics, "an axis that does not turn along"),
        (_, "site" | "refsite" | "slidersite" | "cranksite" | "cranklength" | "body") if actuator => {
            (Dynamics, "an actuator on something else than a joint or a tendon")
        }
        (_, "nsample" | "interp") if actuator => (Solver, "how delayed commands are stored and interpolated"),
        (_, "lengthrange") if actuator => (Nothing, "the range of a muscle"),
        (_, "input" | "ffrange" | "velrange") if actuator => (Dynamics, "further commands of the actuator"),
        (_, "user" | "group") => (Nothing, "notes and groups"),
        _ => return None,
    })
}
