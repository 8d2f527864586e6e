//! Whether two laws are the same: direction, kinds and variables of all factors, exponents after rounding to halves. Lengths,
//! widths, frequencies and sizes are not compared; how often their intervals hold the truth is counted.

use std::collections::{BTreeMap, BTreeSet};

use super::answer::{Answer, Effect, Member, SaidConstant, SaidFactor, SaidTerm};
use super::term::{Direction, Factor, Shape, Term, Variable};

/// A term without its numbers: equal where two ways of writing mean the same.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Plain {
    way: Way,
    /// What is done to each variable; powers of one variable are multiplied into one.
    variables: BTreeMap<String, Part>,
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Way {
    Velocity,
    Radial,
    Axes(BTreeSet<String>),
    Joint,
    /// A direction that no law of this bench has.
    Other(String),
}

#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    /// Whether it changes its sign with the variable.
    odd: bool,
    /// Twice the exponent.
    halves: i64,
    /// `exp`, `bump`, `wave` and so on, sorted.
    shapes: Vec<String>,
}

/// How an answer compares with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Likeness {
    /// Whether the first of the answer is the truth, and whether any is.
    pub first: bool,
    pub any: bool,
}

/// Compares; `truth` is `None` where nothing of the grammar is hidden.
pub fn likeness(answer: &Answer, truth: Option<&Term>) -> Likeness {
    let Some(truth) = truth.map(|term| vec![plain(term)]) else { return Likeness { first: false, any: false } };
    let all = said(answer);
    Likeness { first: all.first() == Some(&truth), any: all.contains(&truth) }
}

/// The laws of an answer, best first.
fn said(answer: &Answer) -> Vec<Vec<Plain>> {
    let laws = answer.members.iter().map(|member| sorted(member.terms.iter().map(plain_of_said).collect()));
    let catalogue = |names: &[&str]| sorted(names.iter().map(|name| catalogued(name)).collect());
    let names: Vec<&str> = answer.effects.iter().map(|effect| effect.name.as_str()).collect();
    match answer.verdict.as_str() {
        "law" | "named" if answer.by_law() => laws.take(1).collect(),
        "named" => vec![catalogue(&names)],
        "one_of" if answer.by_law() => laws.collect(),
        "one_of" => {
            let left = answer.candidates.iter().map(|name| catalogue(&[name]));
            (!names.is_empty()).then(|| catalogue(&names)).into_iter().chain(left).collect()
        }
        _ => vec![],
    }
}

fn sorted(mut terms: Vec<Plain>) -> Vec<Plain> {
    terms.sort();
    terms
}

/// An effect of the catalogue as the law that it is.
fn catalogued(name: &str) -> Plain {
    let power = |halves| BTreeMap::from([("speed".to_owned(), Part { halves, ..Part::default() })]);
    let axes = |all: &[&str]| Way::Axes(all.iter().map(ToString::to_string).collect());
    match name {
        "linear_drag" => Plain { way: Way::Velocity, variables: power(2) },
        "quadratic_drag" => Plain { way: Way::Velocity, variables: power(4) },
        "wind" => Plain { way: axes(&["x", "y"]), variables: BTreeMap::new() },
        "effective_gravity" => Plain { way: axes(&["z"]), variables: BTreeMap::new() },
        other => Plain { way: Way::Other(other.into()), variables: BTreeMap::new() },
    }
}

fn plain(term: &Term) -> Plain {
    let axes = |all: &[&str]| Way::Axes(all.iter().map(ToString::to_string).collect());
    let way = match term.direction {
        Direction::Velocity => Way::Velocity,
        Direction::Radial => Way::Radial,
        Direction::Level(_) => axes(&["x", "y"]),
        Direction::Vertical => axes(&["z"]),
        Direction::Joint => Way::Joint,
    };
    let mut variables = Variables::default();
    for Factor { variable, shape } in &term.factors {
        let name = own_name(*variable);
        match shape {
            Shape::Power(p) => variables.power(name, *p, false),
            Shape::Odd(p) => variables.power(name, *p, true),
            Shape::Exp(_) => variables.shape(name, "exp"),
            Shape::Bump { .. } => variables.shape(name, "bump"),
            Shape::Wave { .. } => variables.shape(name, "wave"),
            Shape::Log(_) => variables.shape(name, "log"),
            Shape::Stribeck(_) => {
                variables.power(name, 0.0, true);
                variables.shape(name, "bump");
            }
        }
    }
    Plain { way, variables: variables.finished() }
}

fn plain_of_said(term: &SaidTerm) -> Plain {
    let mut variables = Variables::default();
    let way = way(&term.directions, &mut variables);
    for factor in &term.factors {
        let name = named_variable(&factor.variable);
        let exponent = constant(factor, "exponent").map_or(1.0, |p| p.value);
        match factor.kind.as_str() {
            "power" => variables.power(&name, exponent, false),
            "odd_power" => variables.power(&name, exponent, true),
            "sign" => variables.power(&name, 0.0, true),
            "cos" | "sin" => variables.shape(&name, "wave"),
            // A bump at 0 that changes its sign.
            "stribeck" => {
                variables.power(&name, 0.0, true);
                variables.shape(&name, "bump");
            }
            other => variables.shape(&name, other),
        }
    }
    Plain { way, variables: variables.finished() }
}

fn constant<'a>(factor: &'a SaidFactor, role: &str) -> Option<&'a SaidConstant> {
    factor.constants.iter().find(|constant| constant.role == role)
}

/// The direction of a term; that of a joint's rate is a factor as well.
fn way(directions: &[String], variables: &mut Variables) -> Way {
    let tokens: Vec<&str> =
        directions.iter().flat_map(|one| one.split(',')).map(str::trim).filter(|one| !one.is_empty()).collect();
    match tokens[..] {
        ["v"] => return Way::Velocity,
        ["r"] => return Way::Radial,
        ["dq"] => {
            variables.power("dq", 0.0, true);
            return Way::Joint;
        }
        ["dq_rad_s" | "q" | "q_rad" | "none" | "joint"] | [] => return Way::Joint,
        _ => {}
    }
    let axes: Option<BTreeSet<String>> = tokens.iter().map(|token| axis(token)).collect();
    axes.map_or_else(|| Way::Other(tokens.join(",")), Way::Axes)
}

/// The axis of a direction: its letter, or the state of the velocity along it.
fn axis(token: &str) -> Option<String> {
    let letter = match token {
        "x" | "x_m" | "vx_m_s" => "x",
        "y" | "y_m" | "vy_m_s" => "y",
        "z" | "z_m" | "vz_m_s" => "z",
        _ => return None,
    };
    Some(letter.into())
}

fn own_name(variable: Variable) -> &'static str {
    match variable {
        Variable::Speed => "speed",
        Variable::Radius => "r",
        Variable::Height => "z",
        Variable::Time => "t",
        Variable::Angle => "q",
        Variable::Rate => "dq",
    }
}

/// The same names for the variables of an answer. Of equations the distance and the speed are written as roots.
fn named_variable(said: &str) -> String {
    let own = match said {
        root if root.starts_with("sqrt(v") => "speed",
        root if root.starts_with("sqrt(") => "r",
        "speed_m_s" | "speed" => "speed",
        "r_m" | "r" => "r",
        "z_m" | "z" => "z",
        "t_s" | "t" => "t",
        "q_rad" | "q" => "q",
        "dq_rad_s" | "dq" => "dq",
        other => other,
    };
    own.to_owned()
}

/// Powers and shapes, gathered by variable.
#[derive(Default)]
struct Variables(BTreeMap<String, (bool, f64, Vec<String>)>);

impl Variables {
    fn power(&mut self, name: &str, exponent: f64, odd: bool) {
        let one = self.0.entry(name.to_owned()).or_default();
        // Of what is never negative the sign says nothing.
        let signed = !matches!(name, "speed" | "r" | "z" | "t");
        one.0 ^= odd && signed;
        one.1 += exponent;
    }

    fn shape(&mut self, name: &str, shape: &str) {
        self.0.entry(name.to_owned()).or_default().2.push(shape.to_owned());
    }

    fn finished(self) -> BTreeMap<String, Part> {
        let part = |(odd, exponent, mut shapes): (bool, f64, Vec<String>)| {
            shapes.sort();
            Part { odd, halves: halves(exponent), shapes }
        };
        let all = self.0.into_iter().map(|(name, one)| (name, part(one)));
        all.filter(|(_, part)| *part != Part::default()).collect()
    }
}

/// Twice the exponent, rounded.
fn halves(exponent: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "exponents are small")]
    let twice = (2.0 * exponent).round().clamp(-1e6, 1e6) as i64;
    twice
}

/// Of the constants of an answer that is the truth: how many have an interval, and how many of these intervals hold the true
/// value. What has no true value of its own is left out: phases, the sizes of oscillations, and exponents that are set.
pub fn covered(answer: &Answer, truth: &Term) -> (usize, usize) {
    let wanted = vec![plain(truth)];
    if !said(answer).contains(&wanted) {
        return (0, 0);
    }
    let intervals: Vec<(f64, [f64; 2])> = if answer.by_law() {
        let is = |member: &&Member| sorted(member.terms.iter().map(plain_of_said).collect()) == wanted;
        answer.members.iter().find(is).map_or_else(Vec::new, |member| of_member(member, truth))
    } else {
        // Of a set of the catalogue only the best has coefficients.
        let [effect] = &answer.effects[..] else { return (0, 0) };
        if vec![catalogued(&effect.name)] == wanted { of_effect(effect, truth) } else { vec![] }
    };
    let holds = |(value, [low, high]): &(f64, [f64; 2])| (*low..=*high).contains(value);
    (intervals.iter().filter(|one| holds(one)).count(), intervals.len())
}

/// The size of a truth along an axis.
fn size_along(truth: &Term, axis: &str) -> f64 {
    match (truth.direction, axis) {
        (Direction::Level(angle), "x") => truth.size * angle.cos(),
        (Direction::Level(angle), "y") => truth.size * angle.sin(),
        _ => truth.size,
    }
}

fn of_effect(effect: &Effect, truth: &Term) -> Vec<(f64, [f64; 2])> {
    let value = |key: &str| match key {
        // Written as brakes, and downwards.
        "c_1_m" | "b_1_s" | "dg_m_s2" => Some(-truth.size),
        "ax_m_s2" => Some(size_along(truth, "x")),
        "ay_m_s2" => Some(size_along(truth, "y")),
        _ => None,
    };
    effect.coefficients.iter().filter_map(|one| Some((value(&one.key)?, one.interval95?))).collect()
}

fn of_member(member: &Member, truth: &Term) -> Vec<(f64, [f64; 2])> {
    let mut all = Vec::new();
    let oscillates = truth.factors.iter().any(|factor| matches!(factor.shape, Shape::Wave { .. }));
    for term in &member.terms {
        for coefficient in term.coefficients.iter().filter(|_| !oscillates) {
            let axis = axis(&coefficient.direction).unwrap_or_default();
            all.extend(coefficient.interval95.map(|interval| (size_along(truth, &axis), interval)));
        }
        for factor in &term.factors {
            for constant in factor.constants.iter().filter(|constant| !constant.fixed) {
                let Some(value) = inner(truth, &named_variable(&factor.variable), &factor.kind, &constant.role) else {
                    continue;
                };
                // A width and a frequency may be written with either sign.
                let interval = constant.interval95.map(|[low, high]| {
                    let turned = constant.value < 0.0 && matches!(constant.role.as_str(), "width" | "frequency");
                    if turned { [-high, -low] } else { [low, high] }
                });
                all.extend(interval.map(|interval| (value, interval)));
            }
        }
    }
    all
}

/// The true value of a constant within a factor.
fn inner(truth: &Term, variable: &str, kind: &str, role: &str) -> Option<f64> {
    truth.factors.iter().filter(|factor| own_name(factor.variable) == variable).find_map(|factor| {
        match (factor.shape, kind, role) {
            (Shape::Power(p), "power" | "odd_power", "exponent") | (Shape::Odd(p), "odd_power", "exponent") => Some(p),
            (Shape::Exp(scale), "exp", "scale")
            | (Shape::Log(scale), "log", "scale")
            | (Shape::Stribeck(scale), "stribeck", "scale") => Some(scale),
            (Shape::Bump { place, .. }, "bump", "place") => Some(place),
            (Shape::Bump { width, .. }, "bump", "width") => Some(width),
            (Shape::Wave { frequency, .. }, "cos" | "sin", "frequency") => Some(frequency),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests;
