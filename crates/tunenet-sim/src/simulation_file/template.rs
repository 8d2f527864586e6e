//! A simulation file to start from, written from the schema, so that it names every key there is.

use std::fmt::Write as _;

use super::domain::Domain;
use super::schema::{Definition, Key, PARAMETER_KEYS, Shape};
use super::{equations_schema, process_schema, robot_schema};

/// What stands above everything else.
const BALL_HEAD: &str = "\
# A ball that falls and bounces. Set your ball's radius and tune:
#
#   tunenet tune --sim ball.toml drop.csv --out tuned.toml
#
# A line `# key = value` is optional: remove the `#` to use it, and the one before its [table] if there is one. Above each
# key are its meaning, unit and range. z points up, axes are right-handed; a ball's position is that of its centre, and a
# height of fall is measured from its lowest point. If [release] or the surface height are not set, they are estimated
# from each recording.
";

const ARM_HEAD: &str = "\
# An arm that moves a payload. Set your arm's URDF and the link that holds the payload, and tune:
#
#   tunenet tune --sim arm.toml torques.csv --out tuned.toml
#
# A line `# key = value` is optional: remove the `#` to use it. Above each key are its meaning, unit and range. World axes
# have z up and the arm's base at the origin. The end effector's z axis points down while it moves along the circle, at
# centre + radius (0, cos, sin) of rate times time.
";

const PROCESS_HEAD: &str = "\
# A simulation by an external program, in any language, that speaks lines of JSON. The program in this folder is an
# example; it runs only with --allow-process, because it has your user's permissions:
#
#   tunenet simulate --sim process.toml --allow-process --set parameters.length.value=0.62 --out swing.csv
#   tunenet tune --sim process.toml --allow-process swing.csv --out tuned.toml
#
# It reads a line and answers with a line, until its input ends:
#
#   {\"tunenet\": 2, \"channels\": [\"angle_rad\"], \"parameters\": [...], \"effects\": [...], \"inputs\": [...], ...}
#   {\"tunenet\": 2}
#   {\"id\": 1, \"recording\": 1, \"start_s\": 0.0, \"inputs\": {\"torque_nm\": {...}}, \"settings\": {...}}
#   {\"id\": 1}
#   {\"id\": 2, \"recording\": 1, \"parameters\": {\"length\": 1.0, ...}, \"start\": {...}, \"times_s\": [0.0, 0.01], ...}
#   {\"id\": 2, \"values\": [[0.5], [0.4998]]}
#
# A line `# key = value` is optional: remove the `#` to use it, and the one before its [table] if there is one. Above
# each key are its meaning, unit and range.
";

const EQUATIONS_HEAD: &str = "\
# A simulation whose equations stand in this file: here a damped pendulum that a motor drives. Nothing else is run:
#
#   tunenet simulate --sim equations.toml --set parameters.length.value=0.62 --out swing.csv
#   tunenet tune --sim equations.toml swing.csv --out tuned.toml
#
# Formulas know + - * / ^, abs, sign, min, max, sqrt, cbrt, exp, ln, sin, cos, tan, atan2, tanh, clamp(x, low, high),
# delay(input, seconds), all names of this file, and t_s, the time in s. Units are checked where they are known.
#
# A line `# key = value` is optional: remove the `#` to use it, and the one before its [table] if there is one. Above
# each key are its meaning, unit and range.
";

const ROBOT_HEAD: &str = "\
# Robot joints that follow commands: a motor with its firmware, a gear with friction, links and loads of a
# model file (URDF or MJCF).
#
#   tunenet simulate --sim robot.toml --inputs commands.csv --out swing.csv
#   tunenet tune --sim robot.toml swing.csv --out tuned.toml
#   tunenet diagnose --sim robot.toml --manifest runs.toml
#
# Parameters are named JOINT__NAME (two underscores): stall_torque, back_emf, viscous, coulomb, armature, zero.
#
# A line `# key = value` is optional: remove the `#` to use it, and the one before its [table] if there is one. Above
# each key are its meaning, unit and range.
";

/// The tables of a robot with one joint that a file names itself.
const ROBOT: &str = "
[inputs.hinge_goal_rad]
# The commands of a joint: a column of every recording, by this name or by `column`. `hold` says what they are between
# samples: \"previous\" or \"linear\".
default = 0.0

[inputs.torque_on]
# Whether motors are on: 0 releases them.
default = 1.0

[joints.hinge]
# A joint of the model, by its name there. Joints without a table are held at 0.
drive = \"position\"
command = \"hinge_goal_rad\"
enable = \"torque_on\"
observe = [\"hinge_rad\"]
kp = 16.0
gain_1_rad = 0.166

[loads.tip]
# A mass on a link. A manifest may say other masses and places for a recording, and other gains.
link = \"pendulum\"
mass_kg = 0.5
position_m = [0.0, 0.0, -0.1]
";

/// The tables that a file of equations names itself.
const EQUATIONS: &str = "
[states.angle_rad]
# What changes with time. A name ends in its unit, or the table says it: `unit` with a text.

[states.rate_rad_s]

[derivatives]
# How fast each state changes.
angle_rad = \"rate_rad_s\"
rate_rad_s = \"-gravity/length*sin(angle_rad) - damping*rate_rad_s + gain*u_v\"

[outputs]
# What is recorded, by the names of the columns. Without this table: every state.
angle_rad = \"angle_rad\"

[constants]
# Numbers that formulas use and that are not tuned. A manifest may say others for a recording.
gravity = 9.81
gain = 1.0

[inputs.u_v]
# What drives it: a column of every recording, by its name with unit. Without `default` every recording has to have it.
default = 0.0

[start.angle_rad]
# A state at the first stamp of a recording: a number or \"first\", the first sample of the channel of that name. With a
# standard deviation or bounds it is estimated.
value = 0.5
sd = 0.05

[start.rate_rad_s]
value = 0.0

[candidates.dry_friction]
# An effect that `diagnose` may find missing: what it adds to derivatives, and each of its numbers.
sentence = \"the hinge rubs with a constant torque\"
acts = \"joint\"
adds.rate_rad_s = \"-c*sign(rate_rad_s)\"

[candidates.dry_friction.coefficients.c]
unit = \"rad/s²\"
min = 0.0
max = 5.0
typical = 0.05
";

/// Keys that are written without a mark, and the values to start from. Others begin at 0, or at their least value.
const VALUES: &[(Domain, &str, bool, &str)] = &[
    (Domain::Ball, "world.gravity_m_s2", true, "9.81"),
    (Domain::Ball, "ball.radius_m", true, "0.02"),
    (Domain::Ball, "ball.mass_kg", false, "0.0027"),
    (Domain::Ball, "release.height_m", false, "1.0"),
    (Domain::Ball, "release.position_m", false, "[0.0, 0.0, 1.02]"),
    (Domain::Ball, "record.rate_hz", true, "120.0"),
    (Domain::Ball, "record.frames", true, "360"),
    (Domain::Arm, "world.gravity_m_s2", true, "9.81"),
    (Domain::Arm, "arm.urdf", true, "\"arm.urdf\""),
    (Domain::Arm, "arm.payload_link", true, "\"tool0\""),
    (Domain::Arm, "arm.payload_size_m", false, "0.05"),
    (Domain::Arm, "arm.current_gain_nm_a", false, "[10.0, 10.0, 10.0, 10.0, 10.0, 10.0]"),
    (Domain::Arm, "motion.centre_m", false, "[-0.4, 0.0, 0.0]"),
    (Domain::Arm, "motion.radius_m", false, "0.2"),
    (Domain::Arm, "motion.rate_rad_s", false, "1.2"),
    (Domain::Arm, "motion.duration_s", false, "5.0"),
    (Domain::Arm, "motion.cutoff_hz", false, "10.0"),
    (Domain::Arm, "record.rate_hz", true, "240.0"),
    (Domain::Process, "process.command", true, "[\"python3\", \"pendulum.py\"]"),
    (Domain::Process, "process.channels", true, "[\"angle_rad\"]"),
    (Domain::Process, "process.folder", false, "\"programs\""),
    (Domain::Process, "process.timeout_s", true, "10.0"),
    (Domain::Process, "process.start_timeout_s", false, "60.0"),
    (Domain::Process, "process.workers", false, "2"),
    (Domain::Equations, "record.rate_hz", true, "72.0"),
    (Domain::Equations, "record.frames", true, "216"),
    (Domain::Process, "record.rate_hz", true, "72.0"),
    (Domain::Process, "record.frames", true, "216"),
    (Domain::Robot, "robot.model", true, "\"arm.urdf\""),
    (Domain::Robot, "world.gravity_m_s2", true, "9.81"),
    (Domain::Robot, "integrate.step_s", true, "0.001"),
    (Domain::Robot, "record.rate_hz", true, "100.0"),
    (Domain::Robot, "record.frames", true, "600"),
];

/// A commented simulation file with every key that there is: required ones with a value, optional ones behind a mark. It is
/// valid as it stands.
#[must_use]
pub fn template(domain: Domain) -> String {
    let own = if domain == Domain::Robot { ROBOT } else { EQUATIONS };
    let mut text = keys(domain, own);
    for known in samples(domain) {
        parameter(&mut text, (known.name, known.default, known.tune), known);
    }
    text
}

/// A template without its parameters; `own` are the tables that a file of this kind names itself.
pub(super) fn keys(domain: Domain, own: &str) -> String {
    let head = match domain {
        Domain::Ball => BALL_HEAD,
        Domain::Arm => ARM_HEAD,
        Domain::Process => PROCESS_HEAD,
        Domain::Equations => EQUATIONS_HEAD,
        Domain::Robot => ROBOT_HEAD,
    };
    let mut text = String::from(head);
    let mut table = "";
    for key in domain.keys() {
        let (head, name) = key.path.rsplit_once('.').unwrap_or(("", &key.path));
        let (active, value) = value(domain, key);
        if head != table {
            // An effect is there as soon as its table is; the other tables may be empty.
            let mark = if head.starts_with("effects.") { "# " } else { "" };
            text.push_str(&line(&format!("\n{mark}[{head}]")));
            table = head;
        } else if head.is_empty() {
            text.push('\n');
        }
        text.push_str(&comment(key));
        let mark = if active { "" } else { "# " };
        text.push_str(&line(&format!("{mark}{name} = {value}")));
        if matches!(domain, Domain::Equations | Domain::Robot) && key.path == "kind" {
            text.push_str(own);
        }
    }
    if domain == Domain::Process {
        text.push_str(SETTINGS);
    }
    text
}

/// What is shown of the settings of a program, which have no keys of ours.
const SETTINGS: &str = "
[settings]
# Other values for the program. They are passed to it unchanged, with every recording.
mass_kg = 0.5

[inputs.torque_nm]
# What drives it: a column of every recording, by its name with unit. Without `default` every recording has to have it.
default = 0.0

[start.angle_rad]
# A state at the first stamp of a recording: a number or \"first\", the first sample of the channel of that name. With a
# standard deviation or bounds it is estimated.
value = 0.5
sd = 0.05

[candidates.dry_friction]
# An effect that `diagnose` may find missing, and each of its numbers.
sentence = \"the hinge rubs with a constant torque\"
acts = \"joint\"

[candidates.dry_friction.coefficients.rad_s2]
unit = \"rad/s²\"
min = 0.0
max = 5.0
typical = 0.05
";

/// The parameters that are written: all that there are, or, where a file names its own, some to start from.
fn samples(domain: Domain) -> &'static [Definition] {
    match domain {
        Domain::Process => process_schema::SAMPLES,
        Domain::Equations => equations_schema::SAMPLES,
        Domain::Robot => robot_schema::SAMPLES,
        Domain::Ball | Domain::Arm => domain.parameters(),
    }
}

/// The table of a parameter; `tune` says whether it is tuned.
pub(super) fn parameter(
    text: &mut String,
    (name, [value, min, max], tune): (&str, [f64; 3], bool),
    known: &Definition,
) {
    text.push_str(&line(&format!("\n[parameters.{name}]")));
    text.push_str(&line(&format!("# {}.", known.meaning)));
    for key in PARAMETER_KEYS {
        let value = match &*key.path {
            "value" => format!("{value:?}"),
            "min" => format!("{min:?}"),
            "max" => format!("{max:?}"),
            "unit" => format!("\"{}\"", known.unit),
            "tune" => tune.to_string(),
            other => value_of(key.shape, other),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<15} # {}", format!("{} = {value}", key.path), key.meaning);
    }
}

pub(super) fn line(text: &str) -> String {
    format!("{text}\n")
}

/// Whether the key stands without a mark, and the value to start from.
fn value(domain: Domain, key: &Key) -> (bool, String) {
    match VALUES.iter().find(|(of, path, ..)| *of == domain && *path == key.path) {
        Some((_, _, active, value)) => (*active || key.required, (*value).into()),
        None => (key.required, value_of(key.shape, &key.path)),
    }
}

fn value_of(shape: Shape, path: &str) -> String {
    // A factor is absent at 1, everything else at 0.
    let absent = if path.ends_with(".factor") || path.ends_with(".fraction") { 1.0_f64 } else { 0.0 };
    let nearest = |min: f64, max: f64| format!("{:?}", absent.clamp(min, max));
    match shape {
        Shape::Number(min, max) | Shape::NumberOrList(min, max) => nearest(min, max),
        Shape::Whole(min, max) => 0.clamp(min, max).to_string(),
        Shape::Numbers(count, min, max) => format!("[{}]", vec![nearest(min, max); count].join(", ")),
        Shape::List(min, max) => format!("[{}]", nearest(min, max)),
        Shape::Word(words) => format!("\"{}\"", words.first().unwrap_or(&path)),
        Shape::NumberOrWord(_, _, word) => format!("\"{word}\""),
        Shape::Flag => "false".into(),
        Shape::Texts => format!("[\"{path}\"]"),
        Shape::Names => "[]".into(),
        Shape::Anything => "0".into(),
    }
}

/// `# Gravity, downwards (default: 9.81). A number from 0.000001 to 1000, in m/s².`
fn comment(key: &Key) -> String {
    let unit = unit(&key.path).map_or_else(String::new, |unit| format!(", in {unit}"));
    line(&format!("# {}. {}{unit}.", capital(&key.meaning), capital(&key.shape.expected())))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The unit that ends a key. Longer endings come first.
fn unit(path: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 24] = [
        ("_nms2_rad2", "N·m·s²/rad²"),
        ("_nms_rad", "N·m·s/rad"),
        ("_s_rad", "s/rad"),
        ("_1_rad", "1/rad"),
        ("_nm_rad", "N·m/rad"),
        ("_rad_nm", "rad/(N·m)"),
        ("_kg_m2", "kg·m²"),
        ("_nm_a", "N·m/A"),
        ("_rad_s", "rad/s"),
        ("_m_s2", "m/s²"),
        ("_s_m", "s/m"),
        ("_m_s", "m/s"),
        ("_1_m", "1/m"),
        ("_1_s", "1/s"),
        ("_n_m", "N/m"),
        ("_pa_s", "Pa·s"),
        ("_rad", "radians"),
        ("_px", "pixels"),
        ("_hz", "1/s (Hz)"),
        ("_kg", "kilograms"),
        ("_nm", "N·m"),
        ("_pa", "pascals"),
        ("_m", "metres"),
        ("_s", "seconds"),
    ];
    // A key may be nothing but its unit: `effects.coulomb_friction.nm`.
    let name = format!("_{}", path.rsplit('.').next().unwrap_or(path));
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::SimulationFile;
    use super::*;

    fn parsed(text: &str) -> SimulationFile {
        SimulationFile::parse(Path::new("ball.toml"), text).unwrap_or_else(|e| panic!("{e}\n{text}"))
    }

    #[test]
    fn it_is_valid_and_names_every_key() {
        for domain in Domain::ALL {
            let text = template(domain);
            let parameters = parsed(&text).parameters().unwrap();
            let tuned: Vec<bool> = parameters.iter().map(|p| p.tune).collect();
            assert_eq!(tuned, samples(domain).iter().map(|p| p.tune).collect::<Vec<_>>());
            assert!(tuned[0]);
            for key in domain.keys() {
                let name = key.path.rsplit_once('.').map_or(&*key.path, |(_, name)| name);
                let count =
                    text.lines().filter(|l| l.trim_start_matches("# ").starts_with(&format!("{name} = "))).count();
                assert!(count > 0, "{}", key.path);
            }
            assert!(text.lines().all(|l| l.chars().count() <= 120 || l.starts_with('#')));
        }
    }

    /// What the file asks the user to do: take the mark away from any one line.
    #[test]
    fn every_optional_line_can_be_used() {
        for domain in Domain::ALL {
            let text = template(domain);
            let lines: Vec<&str> = text.lines().collect();
            let mut used = 0;
            for (i, optional) in lines.iter().enumerate() {
                let Some(bare) =
                    optional.strip_prefix("# ").filter(|l| l.split_once(" = ").is_some_and(|(k, _)| is_key(k)))
                else {
                    continue;
                };
                let mut changed: Vec<&str> = lines.clone();
                changed[i] = bare;
                if let Some(head) = (0..i).rev().find(|j| lines[*j].trim_start_matches("# ").starts_with('[')) {
                    changed[head] = lines[head].trim_start_matches("# ");
                }
                parsed(&changed.join("\n"));
                used += 1;
            }
            let optional = domain.keys().filter(|key| !value(domain, key).0).count();
            assert_eq!(used, optional, "{}", domain.name());
        }
    }

    fn is_key(text: &str) -> bool {
        text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    }

    #[test]
    fn a_physical_key_has_its_unit_in_words() {
        assert_eq!(unit("arm.current_gain_nm_a"), Some("N·m/A"));
        assert_eq!(unit("world.gravity_m_s2"), Some("m/s²"));
        assert_eq!(unit("effects.magnus.sx_1_s"), Some("1/s"));
        assert_eq!(unit("release.spin_rad_s"), Some("rad/s"));
        assert_eq!(unit("record.frames"), None);
        // Each key of an effect of an arm has the unit that its catalogue gives it.
        let keys =
            Domain::Arm.keys().filter_map(|key| Some((unit(&key.path), key.path.strip_prefix("effects.")?.to_owned())));
        for (found, path) in keys {
            let (effect, key) = path.split_once('.').unwrap();
            if key == "tune" {
                continue;
            }
            let effect = crate::arm::effects::ArmEffect::find(effect).unwrap();
            let coefficient = effect.coefficients.iter().find(|c| c.key == key).unwrap();
            let words = match coefficient.unit.as_ref() {
                "rad" => "radians",
                "m" => "metres",
                "s" => "seconds",
                "kg" => "kilograms",
                other => other,
            };
            assert_eq!(found.unwrap_or("1"), words, "{path}");
        }
    }
}
