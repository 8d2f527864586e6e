//! Formulas of a user at joints, against closed forms and the effects that they write anew.

use super::*;
use crate::formula_effect::FormulaEffect;
use crate::formula_effect::joint::JointOf;
use crate::formula_effect::tests::candidate;

/// A formula of these joints, with coefficients `a` and, where it is there, `b`.
fn formula(text: &str, more: &str, joints: &[JointOf]) -> Acting {
    let one = |key: &&str| format!("coefficients.{key} = {{ min = -9.0, max = 9.0, absent = 0.0, unit = \"?\" }}");
    let coefficients: Vec<String> = ["a", "b"].iter().filter(|key| text.contains(**key)).map(one).collect();
    let coefficients = coefficients.join("\n");
    let text = format!("sentence = \"s\"\nacts = \"joint\"\nformula = \"{text}\"\n{more}\n{coefficients}");
    Acting::Formula(Box::new(FormulaEffect::of_robot("own", &candidate(&text), Some(joints)).unwrap()))
}

const fn joint(name: &'static str, slides: bool) -> JointOf<'static> {
    JointOf { name, slides, command_unit: Some("rad") }
}

const HINGE: [JointOf; 1] = [joint("hinge", false)];

/// A free rotor of 0.05 kg·m² with a formula, from 0.3 rad at rest.
fn rotor(text: &str, more: &str, values: &[f64], step_s: f64) -> Vec<f64> {
    let joint = JointNumbers { armature: 0.05 - 1e-9, ..JointNumbers::free(Drive::Torque) };
    let mut robot = pendulum(0.0, 0.1, joint, &[], step_s);
    robot.layout.effects.push(formula(text, more, &HINGE));
    rolled(&robot, vec![command(|_| 0.0), on_until(9.0)], &[0.3, 0.0], values, &clock(3.0))
}

/// J q'' + b q' + a q = 0.
#[test]
fn a_spring_and_a_damper_swing_as_their_closed_form() {
    let found = rotor("a*q_rad + b*dq_rad_s", "", &[2.0, 0.04], 0.001);
    let (decay, stiffness) = (0.5 * 0.04 / 0.05, 2.0 / 0.05_f64);
    let rate = (stiffness - decay * decay).sqrt();
    let exact = |t: &f64| 0.3 * (-decay * t).exp() * ((rate * t).cos() + decay / rate * (rate * t).sin());
    let exact: Vec<f64> = clock(3.0).iter().map(exact).collect();
    let error = root_mean_square(&found, &exact);
    assert!(error < 2e-5, "{error}");
    // Of second order: half the step leaves a quarter.
    let finer = root_mean_square(&rotor("a*q_rad + b*dq_rad_s", "", &[2.0, 0.04], 0.0005), &exact);
    assert!((error / finer - 4.0).abs() < 0.5, "{error} {finer}");
}

/// A mass on a spring with dry friction loses 2 c/k of its amplitude in each half period, and rests once the spring asks for less than c.
#[test]
fn what_jumps_as_the_motion_turns_holds_the_joint() {
    let (a, b): (f64, f64) = (2.0, 0.11);
    let times = clock(3.0);
    let half = std::f64::consts::PI * (0.05 / a).sqrt();
    for (text, more) in [("a*q_rad + b*sign(dq_rad_s)", ""), ("a*q_rad + sign(dq_rad_s)*b", "")] {
        let found = rotor(text, more, &[a, b], 0.001);
        // 0.3, −0.19, 0.08, and there 2 · 0.08 > 0.11 still: 0.03 rad on the other side it stays.
        let at = |t: f64| found[times.partition_point(|time| *time < t - 0.005)];
        assert!((at(half) + 0.19).abs() < 1e-3 && (at(2.0 * half) - 0.08).abs() < 1e-3, "{found:?}");
        let rest = at(2.9);
        assert!((rest - 0.03).abs() < 1e-3 && at(2.0) == rest, "{rest} {}", at(2.0));
    }
}

/// J q'' = −a c for a command c of 0.4, to which a free rotor does not listen otherwise: from rest, q = q0 − a c t²/(2 J).
#[test]
fn a_formula_of_the_command_reads_it_at_every_step() {
    let joint = JointNumbers { armature: 0.05 - 1e-9, ..JointNumbers::free(Drive::Torque) };
    let mut robot = pendulum(0.0, 0.1, joint, &[], 0.001);
    robot.layout.effects.push(formula("a*command", "", &HINGE));
    let inputs = || vec![command(|_| 0.4), command(|_| 0.0)];
    let found = rolled(&robot, inputs(), &[0.3, 0.0], &[0.02], &clock(2.0));
    let exact: Vec<f64> = clock(2.0).iter().map(|t| 0.3 - 0.02 * 0.4 * t * t / (2.0 * 0.05)).collect();
    let error = root_mean_square(&found, &exact);
    assert!(error < 1e-9, "{error}");
}

/// A command that passes 0 is a pole of its inverse.
#[test]
fn a_division_by_the_command_is_refused_where_it_passes_zero() {
    let mut robot = pendulum(0.5, 0.12, servo(), &[], 0.001);
    robot.layout.effects.push(formula("a/command", "", &HINGE));
    let inputs = |from: f64| vec![command(move |t| from - t), on_until(4.0)];
    let run = |from: f64| tried(&robot, inputs(from), &[0.1, 0.0], &[0.01], &clock(2.0));
    let why = run(1.0).unwrap_err();
    assert!(why.contains("`a/command` in `candidates.own.formula` grows beyond all bounds at 0.999"), "{why}");
    assert!(run(5.0).is_ok());
}

/// `along = ["dq"]` is dry friction of that size.
#[test]
fn a_formula_along_the_motion_is_coulomb_friction() {
    let goal = || vec![command(|t| (2.0 * t).sin()), on_until(4.0)];
    let mut robot = pendulum(0.5, 0.12, JointNumbers { coulomb: 0.02, ..servo() }, &[], 0.001);
    robot.layout.effects.push(formula("a + 0*q_rad", "along = [\"dq\"]", &HINGE));
    let found = rolled(&robot, goal(), &[0.1, 0.0], &[0.1], &clock(6.0));
    let known = rolled(&pendulum(0.5, 0.12, servo(), &[], 0.001), goal(), &[0.1, 0.0], &[], &clock(6.0));
    assert!(root_mean_square(&found, &known) < 1e-12, "{}", root_mean_square(&found, &known));
    // Absent, it changes nothing at all.
    let less = pendulum(0.5, 0.12, JointNumbers { coulomb: 0.02, ..servo() }, &[], 0.001);
    assert_eq!(
        rolled(&robot, goal(), &[0.1, 0.0], &[0.0], &clock(6.0)),
        rolled(&less, goal(), &[0.1, 0.0], &[], &clock(6.0))
    );
}

/// The same spring and friction as effects of the catalogue, at the second joint of two and behind a compliant gear.
#[test]
fn chains_and_gears_have_the_same_formulas() {
    let both = [joint("j1", false), joint("j2", false)];
    let inputs = || vec![command(|t| (2.0 * t).sin()), command(|t| (3.0 * t).sin()), on_until(5.0)];
    let start = [0.1, 0.0, 0.0, 0.0];
    let mut written = robot(arm(DOUBLE), Vec::new(), vec![servo(); 2], &[], 0.001);
    written.layout.effects.push(formula("a*q_rad + b*sign(dq_rad_s)", "joints = [\"j2\"]", &both));
    let found = rolled(&written, inputs(), &start, &[1.5, 0.2], &clock(6.0));
    let known = robot(arm(DOUBLE), Vec::new(), vec![servo(); 2], &["joint_spring", "coulomb_friction"], 0.001);
    let known = rolled(&known, inputs(), &start, &[0.0, 1.5, 0.0, 0.2], &clock(6.0));
    assert!(root_mean_square(&found, &known) < 1e-9, "{}", root_mean_square(&found, &known));

    let one = || vec![command(|t| (2.0 * t).sin()), on_until(5.0)];
    let mut written = pendulum(0.5, 0.12, servo(), &["joint_elasticity"], 0.001);
    written.layout.effects.push(formula("a*q_rad + b*sign(dq_rad_s)", "", &HINGE));
    let found = rolled(&written, one(), &[0.1, 0.0], &[0.01, 1.5, 0.2], &clock(6.0));
    let known = pendulum(0.5, 0.12, servo(), &["joint_elasticity", "joint_spring", "coulomb_friction"], 0.001);
    let known = rolled(&known, one(), &[0.1, 0.0], &[0.01, 1.5, 0.2], &clock(6.0));
    // The motor's friction jumps with the motor's speed, the formula's with that of the link.
    assert!(root_mean_square(&found, &known) < 1e-3, "{}", root_mean_square(&found, &known));
}

#[test]
fn a_slide_has_its_own_variables_and_gives_a_force() {
    let of = |text: &str, gives: &str, joints: &[JointOf]| {
        let text = format!(
            "sentence = \"s\"\nacts = \"joint\"\nformula = \"{text}\"\n{gives}\n\
             coefficients.a = {{ min = -9.0, max = 9.0, absent = 0.0, unit = \"N/m\" }}\n"
        );
        FormulaEffect::of_robot("own", &candidate(&text), Some(joints)).map_err(|misfit| (misfit.key, misfit.expected))
    };
    let slide = [joint("rail", true), joint("hinge", false)];
    assert!(of("a*q_m", "gives = \"n\"", &slide).is_ok());
    assert_eq!(of("a*q_m", "", &slide).unwrap_err().0, "formula");
    assert_eq!(of("a*q_m", "gives = \"n\"", &HINGE).unwrap_err(), ("gives".into(), "\"nm\"".into()));
    let named = of("a*q_m", "gives = \"n\"\njoints = [\"hinge\"]", &slide).unwrap_err();
    assert_eq!(named, ("joints".into(), "joints that slide (\"rail\")".into()));
    assert_eq!(of("a*q_m", "gives = \"m_s2\"", &slide).unwrap_err().0, "gives");
}
