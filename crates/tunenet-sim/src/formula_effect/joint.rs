//! A torque at one joint or several: a formula of its position, its speed, the time and its command. Where it jumps with the direction of the motion, a
//! rollout takes both sides of the jump, between which a joint sticks (Filippov 1988).

use std::sync::Arc;

use tunenet_formula::{Divisor, Formula, FormulaError, Node, Program, Tree};

use super::layout::Layout;
use super::{MOST_COEFFICIENTS, Misfit, formula, require_unit};
use crate::scene::Candidate;

/// What a formula of a joint that turns may use, with its unit, and of one that slides.
const VARIABLES: [(&str, &str); 3] = [("q_rad", "rad"), ("dq_rad_s", "rad/s"), ("t_s", "s")];
const OF_SLIDES: [(&str, &str); 3] = [("q_m", "m"), ("dq_m_s", "m/s"), ("t_s", "s")];
const SPEED: usize = 1;
const TIME: usize = 2;
/// What a formula of a joint that follows commands may use as well.
const COMMAND: &str = "command";
const MOST_VARIABLES: usize = VARIABLES.len() + 1;
/// Most places where a formula may jump.
const MOST_SURFACES: usize = 8;
/// Speed at which the direction of a motion has found its sign, rad/s.
const SLIDING_RAD_S: f64 = 0.01;

/// A joint that formulas may act at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct JointOf<'a> {
    pub name: &'a str,
    /// Whether it slides instead of turning.
    pub slides: bool,
    /// The unit of its command; `None` where it follows none.
    pub command_unit: Option<&'static str>,
}

/// What a joint does at an instant (s), in rad and rad/s or m and m/s, and its command, 0 where it follows none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointInstant {
    pub t: f64,
    pub q: f64,
    pub dq: f64,
    pub command: f64,
}

/// Where the formula jumps.
#[derive(Debug, Clone, PartialEq)]
enum Surface {
    /// Where the motion turns.
    Turn,
    /// Where this crosses zero.
    Zero(Program),
}

/// The torque.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointTorque {
    name: String,
    formula: Formula,
    layout: Layout,
    divisors: Vec<Divisor>,
    /// The formula with a side for each of its surfaces.
    sided: Program,
    surfaces: Vec<Surface>,
    /// Where each joint of the arm stands among those that it acts at.
    joints: Vec<Option<usize>>,
    /// Whether it points along the motion.
    along_motion: bool,
    depends_on_time: bool,
    /// How many variables it may use, which precede its coefficients.
    variables: usize,
}

impl JointTorque {
    /// What acts at the joints of an arm whose motion is known; without them it is only checked.
    pub fn of_arm(name: &str, candidate: &Candidate, joints: Option<&[String]>) -> Result<Self, Misfit> {
        if let Some(other) = candidate.gives.as_deref().filter(|gives| *gives != "nm") {
            let found = format!("\"{}\"", other.escape_debug());
            return Err(Misfit::new("gives", "\"nm\", the torque that an arm's motion needs more", found));
        }
        let turning = joints
            .map(|all| all.iter().map(|name| JointOf { name, slides: false, command_unit: None }).collect::<Vec<_>>());
        Self::made((name, candidate), turning.as_deref(), (false, false), "joints of the arm")
    }

    /// What acts at the joints of a robot that follows commands: those that turn, or those that slide where it gives a force.
    pub fn of_robot(name: &str, candidate: &Candidate, joints: Option<&[JointOf]>) -> Result<Self, Misfit> {
        let slides = match candidate.gives.as_deref() {
            None | Some("nm") => false,
            Some("n") => true,
            Some(other) => {
                let expected =
                    "\"nm\", the torque that a turning joint needs more, or \"n\", the force that a sliding one does";
                return Err(Misfit::new("gives", expected, format!("\"{}\"", other.escape_debug())));
            }
        };
        Self::made(
            (name, candidate),
            joints,
            (slides, true),
            if slides { "joints that slide" } else { "joints that turn" },
        )
    }

    fn made(
        (name, candidate): (&str, &Candidate),
        joints: Option<&[JointOf]>,
        (slides, commanded): (bool, bool),
        expected: &str,
    ) -> Result<Self, Misfit> {
        let along_motion = match candidate.along.as_slice() {
            [] => false,
            [one] if one == "dq" => true,
            other => {
                let expected = "none (the number itself) or [\"dq\"], along the motion, for a joint";
                return Err(Misfit::new("along", expected, format!("{other:?}")));
            }
        };
        if candidate.joints.is_none() && !candidate.per_direction.is_empty() {
            let expected = "`joints`, each of which then has numbers of its own";
            return Err(Misfit::new("per_direction", expected, "none"));
        }
        let named = candidate.joints.as_deref();
        let fits = |joint: &&JointOf| joint.slides == slides;
        let known = || joints.into_iter().flatten().filter(fits);
        let has = |name: &str| joints.is_none() || known().any(|joint| joint.name == name);
        if let Some(name) = named.into_iter().flatten().find(|name| !has(name)) {
            let all = known().map(|joint| format!("\"{}\"", joint.name)).collect::<Vec<_>>().join(", ");
            return Err(Misfit::new("joints", format!("{expected} ({all})"), format!("\"{name}\"")));
        }
        if joints.is_some() && known().next().is_none() {
            let (other, found) = if slides {
                ("\"nm\"", "a force, and no joint of the robot slides")
            } else {
                ("\"n\"", "a torque, and no joint of the robot turns")
            };
            return Err(Misfit::new("gives", other, found));
        }
        if named.is_some_and(<[String]>::is_empty) {
            return Err(Misfit::new("joints", "at least one", "none"));
        }
        let all = named.unwrap_or_default();
        if let Some(i) = (0..all.len()).find(|&i| all[..i].contains(&all[i])) {
            return Err(Misfit::new("joints", "each joint once", format!("\"{}\" twice", all[i].escape_debug())));
        }
        let place = |(i, joint): (usize, &JointOf)| {
            let own = named.map_or(Some(i), |named| named.iter().position(|one| one == joint.name));
            own.filter(|_| fits(&joint))
        };
        let places: Vec<Option<usize>> = joints.into_iter().flatten().enumerate().map(place).collect();
        let (variables, unit) = if slides { (&OF_SLIDES, "N") } else { (&VARIABLES, "N·m") };
        let acted_at = joints.into_iter().flatten().zip(&places).filter_map(|(joint, place)| place.map(|_| joint));
        let commands = commanded.then(|| (COMMAND, unit_of_commands(acted_at)));
        let variables: Vec<(&str, &str)> = variables.iter().copied().chain(commands).collect();
        let (formula, layout) = formula(candidate, &variables, named.map_or(1, <[String]>::len))?;
        require_unit(&formula, unit)?;
        let depends_on_time = formula.uses(TIME);
        let variables = variables.len();
        let divisors = formula.divisors(&|name| name < variables).map_err(Misfit::of)?;
        let (sided, surfaces) = sides_of(&formula).map_err(Misfit::of)?;
        let name = name.to_owned();
        Ok(Self {
            name,
            formula,
            layout,
            divisors,
            sided,
            surfaces,
            joints: places,
            along_motion,
            depends_on_time,
            variables,
        })
    }

    /// At how many joints of the robot it acts, and which one is the first.
    pub fn acts_at(&self) -> (usize, Option<usize>) {
        (self.joints.iter().flatten().count(), self.joints.iter().position(Option::is_some))
    }

    /// As it was written.
    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    pub fn depends_on_time(&self) -> bool {
        self.depends_on_time
    }
}

/// The unit in which all these joints are commanded; empty, which is none, where they differ.
fn unit_of_commands<'a>(mut joints: impl Iterator<Item = &'a JointOf<'a>>) -> &'static str {
    let first = joints.next().and_then(|joint| joint.command_unit);
    first.filter(|unit| joints.all(|joint| joint.command_unit == Some(*unit))).unwrap_or_default()
}

/// The formula with the side of each of its surfaces left open, and where these are.
fn sides_of(formula: &Formula) -> Result<(Program, Vec<Surface>), FormulaError> {
    let mut trees = Vec::new();
    let sided = Program::switched(formula.tree(), &mut trees)?;
    let surface = |tree: &Tree| match &tree.node {
        Node::Name { index: SPEED, .. } => Ok(Surface::Turn),
        _ => Program::compile(tree).map(Surface::Zero),
    };
    if trees.len() > MOST_SURFACES {
        let place = formula.tree().place.clone();
        let (expected, found) =
            (format!("at most {MOST_SURFACES} different arguments of `sign`"), trees.len().to_string());
        return Err(FormulaError { place, expected, found });
    }
    let surfaces = trees.iter().map(surface).collect::<Result<_, _>>()?;
    Ok((sided, surfaces))
}

/// On which side of zero this is; on none at zero.
fn side_of(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// The torque with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedTorque {
    torque: Arc<JointTorque>,
    values: Vec<f64>,
}

impl AppliedTorque {
    pub(crate) fn new(torque: &Arc<JointTorque>, values: &[f64]) -> Self {
        debug_assert_eq!(values.len(), torque.layout.numbers());
        Self { torque: Arc::clone(torque), values: values.to_vec() }
    }

    /// The torque (N·m) that the motion of joint `j` needs more.
    pub(crate) fn torque(&self, j: usize, at: JointInstant) -> f64 {
        let Some(names) = self.names(j, at) else { return 0.0 };
        let sign = if self.torque.along_motion { at.dq / at.dq.hypot(SLIDING_RAD_S) } else { 1.0 };
        sign * self.torque.formula.program().value(&names)
    }

    /// The same where the joint moves forwards, and where it moves backwards: both differ by what jumps when the motion turns.
    pub(crate) fn sides(&self, j: usize, at: JointInstant) -> (f64, f64) {
        let Some(names) = self.names(j, at) else { return (0.0, 0.0) };
        let torque = &*self.torque;
        if torque.surfaces.is_empty() {
            let value = torque.formula.program().value(&names);
            return (value, if torque.along_motion { -value } else { value });
        }
        let (mut sides, mut turn) = ([0.0; MOST_SURFACES], None);
        for (i, surface) in torque.surfaces.iter().enumerate() {
            match surface {
                Surface::Turn => turn = Some(i),
                Surface::Zero(program) => sides[i] = side_of(program.value(&names)),
            }
        }
        let mut of = |side: f64| {
            if let Some(i) = turn {
                sides[i] = side;
            }
            let value = torque.sided.run(&names, &sides, |_, _| 0.0);
            if torque.along_motion { side * value } else { value }
        };
        (of(1.0), of(-1.0))
    }

    /// Which part of the formula has no finite value at joint `j`, in words without an end.
    pub(crate) fn undefined(&self, j: usize, at: JointInstant) -> Option<String> {
        let part = self.torque.formula.undefined(&self.names(j, at)?)?;
        Some(format!("`{}` in `candidates.{}.formula` {}", part.text, self.torque.name, part.what))
    }

    /// Whether it divides by what moves.
    pub(crate) fn divides(&self) -> bool {
        !self.torque.divisors.is_empty()
    }

    /// Which part of the formula has a pole between two instants of joint `j`, in words without an end.
    pub(crate) fn pole(&self, j: usize, from: JointInstant, to: JointInstant) -> Option<String> {
        let (from, to) = (self.names(j, from)?, self.names(j, to)?);
        let part = self.torque.formula.pole_between(&self.torque.divisors, &from, &to)?;
        Some(format!("`{part}` in `candidates.{}.formula` grows beyond all bounds", self.torque.name))
    }

    /// The values of all names of the formula at joint `j`; nothing where it does not act there.
    fn names(&self, j: usize, at: JointInstant) -> Option<[f64; MOST_VARIABLES + MOST_COEFFICIENTS]> {
        let torque = &*self.torque;
        let place = torque.joints.get(j).copied().flatten()?;
        let mut names = [0.0; MOST_VARIABLES + MOST_COEFFICIENTS];
        names[..MOST_VARIABLES].copy_from_slice(&[at.q, at.dq, at.t, at.command]);
        // Without a command, coefficients stand in its place.
        let (first, end) = (torque.variables, torque.variables + torque.layout.coefficients());
        torque.layout.fill(&self.values, place, &mut names[first..end]);
        Some(names)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::candidate;
    use super::*;

    const CABLE: &str = "sentence = \"a cable turns the joint\"\nacts = \"joint\"\nformula = \"k*sin(q_rad)\"\njoints = [\"b\", \"a\"]\n\
                         per_direction = [\"k\"]\ncoefficients.k = { unit = \"N·m\", absent = 0.0, min = -5.0, max = 5.0 }\n";

    fn turning<'a>(name: &'a str, unit: &'static str) -> JointOf<'a> {
        JointOf { name, slides: false, command_unit: Some(unit) }
    }

    /// A torque of 3 N·m/rad times the command; where joints take different ones, its unit is not checked.
    #[test]
    fn a_formula_of_the_command_has_the_unit_of_the_commands() {
        let of = |unit: &str, joints: &[JointOf]| {
            let text = format!(
                "sentence = \"s\"\nacts = \"joint\"\nformula = \"k*command\"\n\
                 coefficients.k = {{ unit = \"{unit}\", absent = 0.0, min = -5.0, max = 5.0 }}\n"
            );
            JointTorque::of_robot("it", &candidate(&text), Some(joints))
        };
        let (one, other) = (turning("a", "rad"), turning("b", "V"));
        let applied = AppliedTorque::new(&Arc::new(of("N·m/rad", &[one]).unwrap()), &[3.0]);
        assert_eq!(applied.torque(0, JointInstant { t: 9.0, q: 8.0, dq: 7.0, command: 0.5 }), 1.5);
        assert_eq!(of("N·m/rad", &[other]).unwrap_err().key, "formula");
        assert!(of("N·m/V", &[other]).is_ok() && of("N·m/V", &[one, other]).is_ok());
        let arm = CABLE.replace("k*sin(q_rad)", "k*command");
        assert_eq!(JointTorque::of_arm("cable", &candidate(&arm), None).unwrap_err().key, "formula");
    }

    #[test]
    fn each_named_joint_has_its_own_numbers() {
        let joints = ["a", "b", "c"].map(str::to_owned);
        let torque = Arc::new(JointTorque::of_arm("cable", &candidate(CABLE), Some(&joints)).unwrap());
        let applied = AppliedTorque::new(&torque, &[2.0, 3.0]);
        let quarter = JointInstant { t: 0.0, q: std::f64::consts::FRAC_PI_2, dq: 0.0, command: 0.0 };
        let at = |j: usize| applied.torque(j, quarter);
        assert_eq!((at(0), at(1), at(2)), (3.0, 2.0, 0.0));
    }

    /// q = 0.5 rad, 2 rad/s: what turns with the motion has both signs, what turns with the position that of the position, 0 at 0.
    #[test]
    fn a_jump_has_both_sides_only_where_the_motion_turns() {
        let of = |formula: &str, more: &str| {
            let text = format!(
                "sentence = \"s\"\nacts = \"joint\"\nformula = \"{formula}\"\n{more}\n\
                 coefficients.k = {{ unit = \"N·m\", absent = 0.0, min = -5.0, max = 5.0 }}\n"
            );
            let torque = JointTorque::of_robot("it", &candidate(&text), Some(&[turning("a", "rad")])).unwrap();
            let applied = AppliedTorque::new(&Arc::new(torque), &[3.0]);
            move |q: f64| applied.sides(0, JointInstant { t: 0.0, q, dq: 2.0, command: 0.5 })
        };
        assert_eq!(of("k*sign(dq_rad_s)", "")(0.5), (3.0, -3.0));
        assert_eq!(of("k*(sign(dq_rad_s) + sign(q_rad))", "")(0.5), (6.0, 0.0));
        assert_eq!(of("k*sign(q_rad)", "")(0.0), (0.0, 0.0));
        assert_eq!(of("k*sign(q_rad)", "along = [\"dq\"]")(-0.5), (-3.0, 3.0));
        assert_eq!(of("k*cos(0*q_rad)", "along = [\"dq\"]")(0.5), (3.0, -3.0));
    }

    #[test]
    fn what_the_arm_lacks_is_refused() {
        let joints = ["a".to_owned()];
        assert_eq!(JointTorque::of_arm("cable", &candidate(CABLE), Some(&joints)).unwrap_err().found, "\"b\"");
        assert!(JointTorque::of_arm("cable", &candidate(CABLE), None).is_ok());
        let twice = CABLE.replace("[\"b\", \"a\"]", "[\"b\", \"b\"]");
        assert_eq!(JointTorque::of_arm("cable", &candidate(&twice), None).unwrap_err().found, "\"b\" twice");
        let speed = CABLE.replace("k*sin(q_rad)", "k*dq_rad_s");
        assert_eq!(JointTorque::of_arm("cable", &candidate(&speed), None).unwrap_err().key, "formula");
    }
}
