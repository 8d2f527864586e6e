//! A torque at one joint or several: a formula of its position, its speed and the time.

use std::sync::Arc;

use tunenet_formula::Formula;

use super::layout::Layout;
use super::{MOST_COEFFICIENTS, Misfit, formula, require_unit};
use crate::scene::Candidate;

/// What a formula of a joint may use, with its unit.
const VARIABLES: [(&str, &str); 3] = [("q_rad", "rad"), ("dq_rad_s", "rad/s"), ("t_s", "s")];
const TIME: usize = 2;
/// Speed at which the direction of a motion has found its sign, rad/s.
const SLIDING_RAD_S: f64 = 0.01;

/// The torque.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointTorque {
    formula: Formula,
    layout: Layout,
    /// Where each joint of the arm stands among those that it acts at.
    joints: Vec<Option<usize>>,
    /// Whether it points along the motion.
    along_motion: bool,
    depends_on_time: bool,
}

impl JointTorque {
    pub fn new(candidate: &Candidate, joints: Option<&[String]>) -> Result<Self, Misfit> {
        let along_motion = match candidate.along.as_slice() {
            [] => false,
            [one] if one == "dq" => true,
            other => {
                let expected = "none (the number itself) or [\"dq\"], along the motion, for a joint";
                return Err(Misfit::new("along", expected, format!("{other:?}")));
            }
        };
        if let Some(other) = candidate.gives.as_deref().filter(|gives| *gives != "nm") {
            let found = format!("\"{}\"", other.escape_debug());
            return Err(Misfit::new("gives", "\"nm\", the torque that an arm's motion needs more", found));
        }
        if candidate.joints.is_none() && !candidate.per_direction.is_empty() {
            let expected = "`joints`, each of which then has numbers of its own";
            return Err(Misfit::new("per_direction", expected, "none"));
        }
        let named = candidate.joints.as_deref();
        if let Some(name) = named.into_iter().flatten().find(|name| joints.is_some_and(|all| !all.contains(name))) {
            let known = joints.into_iter().flatten().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
            return Err(Misfit::new("joints", format!("joints of the arm ({known})"), format!("\"{name}\"")));
        }
        if named.is_some_and(<[String]>::is_empty) {
            return Err(Misfit::new("joints", "at least one", "none"));
        }
        let all = named.unwrap_or_default();
        if let Some(i) = (0..all.len()).find(|&i| all[..i].contains(&all[i])) {
            return Err(Misfit::new("joints", "each joint once", format!("\"{}\" twice", all[i].escape_debug())));
        }
        let place =
            |(i, name): (usize, &String)| named.map_or(Some(i), |named| named.iter().position(|one| one == name));
        let places = joints.into_iter().flatten().enumerate().map(place).collect();
        let (formula, layout) = formula(candidate, &VARIABLES, named.map_or(1, <[String]>::len))?;
        require_unit(&formula, "N·m")?;
        let depends_on_time = formula.uses(TIME);
        Ok(Self { formula, layout, joints: places, along_motion, depends_on_time })
    }

    /// As it was written.
    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    pub fn depends_on_time(&self) -> bool {
        self.depends_on_time
    }
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

    /// The torque (N·m) that the motion of joint `j` needs more at this instant, position and speed.
    pub(crate) fn torque(&self, j: usize, t: f64, q: f64, dq: f64) -> f64 {
        const COUNT: usize = VARIABLES.len();
        let torque = &*self.torque;
        let Some(place) = torque.joints.get(j).copied().flatten() else { return 0.0 };
        let mut names = [0.0; COUNT + MOST_COEFFICIENTS];
        names[..COUNT].copy_from_slice(&[q, dq, t]);
        torque.layout.fill(&self.values, place, &mut names[COUNT..COUNT + torque.layout.coefficients()]);
        let sign = if torque.along_motion { dq / dq.hypot(SLIDING_RAD_S) } else { 1.0 };
        sign * torque.formula.program().value(&names)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::candidate;
    use super::*;

    const CABLE: &str = "sentence = \"a cable turns the joint\"\nacts = \"joint\"\nformula = \"k*sin(q_rad)\"\njoints = [\"b\", \"a\"]\n\
                         per_direction = [\"k\"]\ncoefficients.k = { unit = \"N·m\", absent = 0.0, min = -5.0, max = 5.0 }\n";

    #[test]
    fn each_named_joint_has_its_own_numbers() {
        let joints = ["a", "b", "c"].map(str::to_owned);
        let torque = Arc::new(JointTorque::new(&candidate(CABLE), Some(&joints)).unwrap());
        let applied = AppliedTorque::new(&torque, &[2.0, 3.0]);
        let at = |j: usize| applied.torque(j, 0.0, std::f64::consts::FRAC_PI_2, 0.0);
        assert_eq!((at(0), at(1), at(2)), (3.0, 2.0, 0.0));
    }

    #[test]
    fn what_the_arm_lacks_is_refused() {
        let joints = ["a".to_owned()];
        assert_eq!(JointTorque::new(&candidate(CABLE), Some(&joints)).unwrap_err().found, "\"b\"");
        assert!(JointTorque::new(&candidate(CABLE), None).is_ok());
        let twice = CABLE.replace("[\"b\", \"a\"]", "[\"b\", \"b\"]");
        assert_eq!(JointTorque::new(&candidate(&twice), None).unwrap_err().found, "\"b\" twice");
        let speed = CABLE.replace("k*sin(q_rad)", "k*dq_rad_s");
        assert_eq!(JointTorque::new(&candidate(&speed), None).unwrap_err().key, "formula");
    }
}
