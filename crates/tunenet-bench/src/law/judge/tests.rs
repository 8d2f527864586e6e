use super::*;
use crate::law::laws::{INSIDE, inside};
use crate::law::set::stream;

fn term(directions: &[&str], factors: &[(&str, &str, Option<f64>)]) -> SaidTerm {
    let factor = |(kind, variable, exponent): &(&str, &str, Option<f64>)| SaidFactor {
        kind: (*kind).into(),
        variable: (*variable).into(),
        constants: exponent
            .map(|value| SaidConstant { role: "exponent".into(), value, ..SaidConstant::default() })
            .into_iter()
            .collect(),
    };
    SaidTerm {
        directions: directions.iter().map(ToString::to_string).collect(),
        factors: factors.iter().map(factor).collect(),
        coefficients: vec![],
    }
}

fn law(terms: &[SaidTerm]) -> Answer {
    let member = Member { text: "law".into(), terms: terms.to_vec() };
    Answer { verdict: "law".into(), law_verdict: "law".into(), members: vec![member], ..Answer::default() }
}

fn named(verdict: &str, effects: &[&str], candidates: &[&str]) -> Answer {
    let effect = |name: &&str| Effect { name: (*name).into(), coefficients: vec![] };
    Answer {
        verdict: verdict.into(),
        effects: effects.iter().map(effect).collect(),
        candidates: candidates.iter().map(ToString::to_string).collect(),
        ..Answer::default()
    }
}

fn truth(name: &str) -> Term {
    inside(name, &mut stream("test", 1, name, 0))
}

fn exact(answer: &Answer, name: &str) -> bool {
    likeness(answer, Some(&truth(name))).first
}

#[test]
fn quadratic_drag_of_the_catalogue_is_the_square_of_the_speed_along_the_velocity() {
    let formula = law(&[term(&["v"], &[("power", "speed_m_s", Some(2.1))])]);
    assert!(exact(&formula, "drag-2") && exact(&named("named", &["quadratic_drag"], &[]), "drag-2"));
    assert!(!exact(&formula, "drag-2.5") && !exact(&named("named", &["linear_drag"], &[]), "drag-2"));
    assert!(exact(&named("named", &["linear_drag"], &[]), "drag-1"));
    assert!(exact(&named("named", &["wind"], &[]), "wind") && !exact(&named("named", &["magnus"], &[]), "wind"));
    assert!(!exact(&named("named", &["wind", "magnus"], &[]), "wind"));
}

#[test]
fn exponents_are_compared_after_rounding_to_halves() {
    let drag = |p| law(&[term(&["v"], &[("power", "speed_m_s", Some(p))])]);
    assert!(exact(&drag(1.3), "drag-1.5") && exact(&drag(1.7), "drag-1.5"));
    assert!(!exact(&drag(1.2), "drag-1.5") && !exact(&drag(1.8), "drag-1.5"));
}

#[test]
fn powers_of_one_variable_are_multiplied() {
    let product = term(&["r"], &[("power", "r_m", Some(-2.0)), ("power", "r_m", Some(1.0))]);
    assert!(exact(&law(&[product]), "inverse-r"));
    let root = "sqrt(x_m^2 + y_m^2)";
    let screened = term(&["r"], &[("power", root, Some(-1.0)), ("exp", root, None)]);
    assert!(exact(&law(&[screened]), "screened"));
    let drag = term(&["v"], &[("power", "sqrt(vx_m_s^2 + vy_m_s^2)", Some(2.0))]);
    assert!(exact(&law(&[drag]), "drag-at-centre"));
}

#[test]
fn a_sign_and_a_power_are_an_odd_power() {
    let ways = [
        term(&["dq_rad_s"], &[("odd_power", "dq_rad_s", Some(2.0))]),
        term(&["dq_rad_s"], &[("sign", "dq_rad_s", None), ("power", "dq_rad_s", Some(2.0))]),
        term(&["dq"], &[("power", "dq_rad_s", Some(2.0))]),
    ];
    for way in ways {
        assert!(exact(&law(std::slice::from_ref(&way)), "quadratic-damping"), "{way:?}");
    }
    assert!(!exact(&law(&[term(&["dq_rad_s"], &[("power", "dq_rad_s", Some(2.0))])]), "quadratic-damping"));
    let fades = term(&["dq_rad_s"], &[("stribeck", "dq_rad_s", None)]);
    assert!(exact(&law(&[fades]), "stribeck"));
    let cubic = term(&["dq_rad_s"], &[("odd_power", "q_rad", Some(3.0))]);
    assert!(exact(&law(std::slice::from_ref(&cubic)), "cubic-spring") && !exact(&law(&[cubic]), "sine-2q"));
    let spot = term(&["dq_rad_s"], &[("bump", "q_rad", None), ("odd_power", "dq_rad_s", None)]);
    assert!(exact(&law(&[spot]), "damped-spot"));
}

#[test]
fn directions_of_equations_are_their_states() {
    let by_states = law(&[term(&["vx_m_s", "vy_m_s"], &[])]);
    assert!(exact(&by_states, "field-at-centre") && exact(&law(&[term(&["x,y"], &[])]), "field-at-centre"));
    assert!(!exact(&law(&[term(&["x"], &[])]), "field-at-centre"));
    let around = law(&[term(&["around"], &[("power", "r_m", Some(-1.0))])]);
    assert!(!exact(&around, "inverse-r"));
}

#[test]
fn a_second_term_is_wrong_and_a_set_may_hold_the_truth() {
    let drag = term(&["v"], &[("power", "speed_m_s", Some(2.0))]);
    assert!(!exact(&law(&[drag.clone(), term(&["x", "y"], &[])]), "drag-2"));
    let mut set = law(&[term(&["v"], &[("log", "speed_m_s", None)])]);
    (set.verdict, set.law_verdict) = ("one_of".into(), "one_of".into());
    set.members.push(Member { text: "drag".into(), terms: vec![drag] });
    let like = likeness(&set, Some(&truth("drag-2")));
    assert!(like.any && !like.first);
    assert!(likeness(&named("one_of", &["magnus"], &["magnus", "wind"]), Some(&truth("wind"))).any);
    assert!(!likeness(&named("unknown", &[], &["wind"]), Some(&truth("wind"))).any);
    assert!(!likeness(&set, None).any);
}

/// Every law of the bench, said in the words of an answer, is itself and no other.
#[test]
fn no_two_laws_are_alike_but_those_of_two_arenas() {
    for (a, _) in INSIDE {
        for (b, _) in INSIDE {
            let twins = [["drag-2", "drag-at-centre"], ["wind", "field-at-centre"]];
            let alike = a == b || twins.iter().any(|pair| pair.contains(&a) && pair.contains(&b));
            assert_eq!(plain(&truth(a)) == plain(&truth(b)), alike, "{a} and {b}");
        }
    }
}

#[test]
fn intervals_are_compared_with_the_true_constants() {
    let mut truth = truth("screened");
    truth.size = -0.8;
    truth.factors[0].shape = Shape::Exp(1.5);
    let constant = |role: &str, value, interval95, fixed| SaidConstant {
        role: role.into(),
        value,
        interval95: Some(interval95),
        fixed,
        ..SaidConstant::default()
    };
    let mut said = term(&["r"], &[]);
    said.factors = vec![
        SaidFactor {
            kind: "exp".into(),
            variable: "r_m".into(),
            constants: vec![constant("scale", 1.6, [1.4, 1.8], false)],
        },
        SaidFactor {
            kind: "power".into(),
            variable: "r_m".into(),
            constants: vec![constant("exponent", -1.0, [-1.1, -0.9], true)],
        },
    ];
    said.coefficients = vec![constant("", -0.7, [-0.75, -0.65], false)];
    // The length is held, the size is not; an exponent that is set has no interval of its own.
    assert_eq!(covered(&law(&[said]), &truth), (1, 2));
    let mut brake = named("named", &["quadratic_drag"], &[]);
    brake.effects[0].coefficients = vec![SaidConstant { key: "c_1_m".into(), ..constant("", 0.3, [0.2, 0.4], false) }];
    let mut drag = super::tests::truth("drag-2");
    drag.size = -0.25;
    assert_eq!(covered(&brake, &drag), (1, 1));
    assert_eq!(covered(&brake, &truth), (0, 0));
}
