//! Effects that a user writes as a formula, `[candidates.NAME]`, in our own worlds.
//!
//! | file | subject |
//! |---|---|
//! | `flight` | an acceleration of a ball in flight |
//! | `contact` | what a bounce returns |
//! | `joint` | a torque at a joint |
//! | `layout` | which number belongs to which direction |

pub(crate) mod contact;
pub(crate) mod flight;
pub(crate) mod joint;
mod layout;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use tunenet_core::observation::Note;
use tunenet_core::simulator::{Coefficient, Effect, Phase};
use tunenet_formula::{CONSTANTS, Formula, FormulaError, Function, Name, Unit};

use crate::findings;
use crate::phase;
use crate::scene::{Candidate, CandidateCoefficient};
use contact::ContactFormula;
use flight::FlightForce;
use joint::{JointOf, JointTorque};
use layout::Layout;

/// Most coefficients of a formula.
const MOST_COEFFICIENTS: usize = 16;

/// A candidate that a formula defines: its entry in the catalogue, and how it acts.
#[derive(Debug, Clone)]
pub struct FormulaEffect {
    /// Its entry.
    pub effect: Effect,
    /// How it acts.
    pub(crate) acts: Acts,
    /// Its powers whose exponent is a coefficient and whose base has a unit, as they are written.
    powers: Vec<String>,
}

/// How a formula acts.
#[derive(Debug, Clone)]
pub(crate) enum Acts {
    Flight(Arc<FlightForce>),
    Contact(Arc<ContactFormula>),
    Joint(Arc<JointTorque>),
}

/// What is wrong with a candidate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misfit {
    /// The key in its table: `formula`.
    pub key: String,
    /// The place within the text of that key, where it has one.
    pub place: Option<Range<usize>>,
    /// What could stand there.
    pub expected: String,
    /// What stands there.
    pub found: String,
}

impl Misfit {
    fn new(key: &str, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { key: key.into(), place: None, expected: expected.into(), found: found.into() }
    }

    fn of(error: FormulaError) -> Self {
        Self { key: "formula".into(), place: Some(error.place), expected: error.expected, found: error.found }
    }
}

impl FormulaEffect {
    /// The effect that a candidate of a ball's file declares; `mass_kg` is the ball's, where it is known.
    ///
    /// # Errors
    /// Where its formula is none, or one of its keys does not fit.
    pub fn of_ball(name: &str, candidate: &Candidate, mass_kg: Option<f64>) -> Result<Self, Misfit> {
        refuse_key("joints", candidate.joints.is_some(), "an arm")?;
        let (acts, directions) = match phase::parse(&candidate.acts) {
            phase if phase != Phase::Segment && !candidate.valid.is_empty() => {
                return Err(Misfit::new("valid", "none, except in flight", "one"));
            }
            Phase::Segment => {
                let force = FlightForce::new(name, candidate, mass_kg)?;
                let count = force.directions();
                (Acts::Flight(Arc::new(force)), count)
            }
            Phase::Event => (Acts::Contact(Arc::new(ContactFormula::new(name, candidate)?)), 1),
            _ => return Err(Misfit::new("acts", "\"flight\" or \"contact\" for a ball", quoted(&candidate.acts))),
        };
        Ok(Self::made(name, candidate, directions, acts))
    }

    /// The effect that a candidate of an arm's file declares, on an arm with these joints; without them it is only checked.
    ///
    /// # Errors
    /// As [`of_ball`](Self::of_ball), and where it names a joint that the arm does not have.
    pub fn of_arm(name: &str, candidate: &Candidate, joints: Option<&[String]>) -> Result<Self, Misfit> {
        refuse_key("centre", candidate.centre.is_some(), "a ball")?;
        refuse_key("valid", !candidate.valid.is_empty(), "a ball")?;
        if phase::parse(&candidate.acts) != Phase::Joint {
            return Err(Misfit::new("acts", "\"joint\" for an arm", quoted(&candidate.acts)));
        }
        Ok(Self::at_joints(name, candidate, JointTorque::of_arm(name, candidate, joints)?))
    }

    /// The effect that a candidate of a robot's file declares, on a robot with these joints; without them it is only checked.
    ///
    /// # Errors
    /// As [`of_arm`](Self::of_arm).
    pub(crate) fn of_robot(name: &str, candidate: &Candidate, joints: Option<&[JointOf]>) -> Result<Self, Misfit> {
        refuse_key("centre", candidate.centre.is_some(), "a ball")?;
        refuse_key("valid", !candidate.valid.is_empty(), "a ball")?;
        if phase::parse(&candidate.acts) != Phase::Joint {
            return Err(Misfit::new("acts", "\"joint\" for a robot", quoted(&candidate.acts)));
        }
        Ok(Self::at_joints(name, candidate, JointTorque::of_robot(name, candidate, joints)?))
    }

    fn at_joints(name: &str, candidate: &Candidate, torque: JointTorque) -> Self {
        let count = candidate.joints.as_ref().map_or(1, Vec::len);
        Self::made(name, candidate, count, Acts::Joint(Arc::new(torque)))
    }

    /// A term of a law that is searched: `effect` is its entry, `along` the directions of its components. Nothing where one of
    /// them is none of a flight's.
    pub(crate) fn of_law(effect: Effect, term: tunenet_core::law::Term, along: &[String]) -> Option<Self> {
        let force = FlightForce::law(term, along)?;
        Some(Self { effect, acts: Acts::Flight(Arc::new(force)), powers: Vec::new() })
    }

    fn made(name: &str, candidate: &Candidate, directions: usize, acts: Acts) -> Self {
        let formula = match &acts {
            Acts::Flight(force) => force.formula(),
            Acts::Contact(contact) => Some(contact.formula()),
            Acts::Joint(torque) => Some(torque.formula()),
        };
        let powers = formula.map_or_else(Vec::new, |formula| {
            let written = |place: &Range<usize>| formula.text().get(place.clone()).unwrap_or_default().to_owned();
            formula.powers_of_units().iter().map(written).collect()
        });
        Self { effect: entry(name, candidate, directions), acts, powers }
    }

    /// What a user should know of it where it acts: that it is bound to the clock of the recordings, how a power is read.
    #[must_use]
    pub fn notes(&self) -> Vec<Note> {
        let name = &self.effect.name;
        let mut notes = Vec::new();
        let depends_on_time = match &self.acts {
            Acts::Flight(force) => force.depends_on_time(),
            Acts::Joint(torque) => torque.depends_on_time(),
            Acts::Contact(_) => false,
        };
        if depends_on_time {
            let text = format!("the formula of `{name}` depends on the time: it holds for this clock only");
            let remedy = "write it with what changes, or keep the clock of the recordings";
            notes.push(Note::new(findings::EFFECT_CLOCK, text, remedy));
        }
        for power in &self.powers {
            let text = format!("`{power}` in the formula of `{name}`: its base is read as a multiple of its unit");
            notes.push(Note::new(findings::EFFECT_POWER, text, ""));
        }
        notes
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.escape_debug())
}

fn refuse_key(key: &str, given: bool, of: &str) -> Result<(), Misfit> {
    if given {
        Err(Misfit::new(key, format!("a key of this kind of file; `{key}` is one of {of}"), "it"))
    } else {
        Ok(())
    }
}

/// The formula of a candidate over these variables and its coefficients, and the order of its numbers.
fn formula(candidate: &Candidate, variables: &[(&str, &str)], directions: usize) -> Result<(Formula, Layout), Misfit> {
    let keys: Vec<&String> = candidate.coefficients.keys().collect();
    if keys.len() > MOST_COEFFICIENTS {
        let expected = format!("at most {MOST_COEFFICIENTS} coefficients");
        return Err(Misfit::new("coefficients", expected, keys.len().to_string()));
    }
    if let Some(key) = keys.iter().find(|key| {
        CONSTANTS.contains(&key.as_str())
            || Function::named(key).is_some()
            || variables.iter().any(|(name, _)| *name == key.as_str())
    }) {
        let expected = "a name that is no variable, no function and no constant of mathematics";
        return Err(Misfit::new(&format!("coefficients.{key}"), expected, format!("`{key}`")));
    }
    if let Some(other) = candidate.per_direction.iter().find(|key| !keys.contains(key)) {
        let known = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        return Err(Misfit::new("per_direction", format!("names of its coefficients ({known})"), format!("`{other}`")));
    }
    let unit = |unit: &str| Unit::parse(unit);
    let names: Vec<Name> = variables
        .iter()
        .map(|(name, of)| Name::new(*name, unit(of)))
        .chain(candidate.coefficients.iter().map(|(key, c)| Name::new(key, unit(&c.unit))))
        .collect();
    let text = candidate.formula.as_deref().unwrap_or_default();
    let formula = Formula::parse(text, &names).map_err(Misfit::of)?;
    if formula.program().looks_back() {
        return Err(Misfit::new("formula", "a formula without `delay`, which needs an input", "one with it"));
    }
    for (i, key) in keys.iter().enumerate() {
        if !formula.uses(variables.len() + i) {
            return Err(Misfit::new("formula", format!("one that uses the coefficient `{key}`"), "one that does not"));
        }
    }
    absent_is_nothing(candidate, &formula, variables.len())?;
    let each = keys.iter().map(|key| candidate.per_direction.contains(key)).collect();
    Ok((formula, Layout::new(directions, each)))
}

/// A value between 0.4 and 1.6 at which a formula is tried for its name at position `i`: another one for every name and every `point`.
pub(crate) fn probe(i: usize, point: u32) -> f64 {
    0.4 + 1.2 * (0.618 * (i as f64 + 1.0) + 0.27 * f64::from(point)).fract()
}

/// Refuses a formula that gives something although its coefficients have their absent values.
fn absent_is_nothing(candidate: &Candidate, formula: &Formula, variables: usize) -> Result<(), Misfit> {
    if candidate.coefficients.values().all(|one| one.absent.is_none()) {
        return Ok(());
    }
    for point in 0..3_u32 {
        let mut values: Vec<f64> = (0..variables).map(|i| probe(i, point)).collect();
        values.extend(candidate.coefficients.values().map(|one| candidate.absent(one)));
        let given = formula.program().value(&values);
        if given.is_finite() && given.abs() > 1e-12 {
            let expected = "a formula that is 0 where its coefficients have their `absent` values";
            return Err(Misfit::new("formula", expected, format!("one that is {given:.3} somewhere")));
        }
    }
    Ok(())
}

/// Refuses a formula whose unit is known and is none of what it is to give.
fn require_unit(formula: &Formula, unit: &str) -> Result<(), Misfit> {
    Unit::parse(unit).map_or(Ok(()), |unit| formula.require_unit(&unit).map_err(Misfit::of))
}

/// The entry of a candidate with so many directions.
fn entry(name: &str, candidate: &Candidate, directions: usize) -> Effect {
    let own = |text: &str| Cow::Owned(text.to_owned());
    let several = |(key, c): (&String, &CandidateCoefficient)| -> Vec<(Coefficient, (f64, f64))> {
        let absent = candidate.absent(c);
        let one = Coefficient {
            key: own(key),
            unit: own(&c.unit),
            absent,
            min: c.min,
            max: c.max,
            typical: c.typical(c.absent.is_none()),
            number: None,
            shape: c.absent.is_none(),
            channels: None,
        };
        let plausible = c.plausible.unwrap_or((c.min, c.max));
        if candidate.per_direction.contains(key) && directions > 1 {
            (1..=directions).map(|number| (one.clone().numbered(number), plausible)).collect()
        } else {
            vec![(one, plausible)]
        }
    };
    let (coefficients, plausible) = candidate.coefficients.iter().flat_map(several).unzip();
    Effect {
        plausible,
        mistaken_for: candidate.mistaken_for.iter().map(|name| own(name)).collect(),
        ..Effect::new(own(name), phase::parse(&candidate.acts), own(&candidate.sentence), coefficients)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A candidate from the lines of its table.
    pub fn candidate(text: &str) -> Candidate {
        toml_edit::de::from_str(text).unwrap()
    }

    const SPRING: &str = "sentence = \"a thread holds the ball\"\nacts = \"flight\"\nalong = [\"x\"]\nformula = \"-k*x_m\"\n\
                          coefficients.k = { unit = \"1/s²\", absent = 0.0, min = 0.0, max = 50.0 }\n";

    #[test]
    fn an_entry_has_the_bounds_of_its_coefficients() {
        let effect = FormulaEffect::of_ball("spring", &candidate(SPRING), None).unwrap().effect;
        assert_eq!((effect.name.as_ref(), effect.phase), ("spring", Phase::Segment));
        let k = &effect.coefficients[0];
        assert_eq!((k.absent, k.min, k.max, k.typical, k.number), (0.0, 0.0, 50.0, 2.5, None));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_key() {
        for (from, to, key, wanted) in [
            ("-k*x_m", "-k*y", "formula", "expected one of x_m, y_m"),
            ("-k*x_m", "-k*vx_m_s", "formula", "expected a formula in m/s², found one in m/s³"),
            ("-k*x_m", "3.0 - k*x_m", "formula", "a formula that is 0 where"),
            ("-k*x_m", "-k*clamp(x_m, 1, -1)", "formula", "the lower bound before the upper one, found 1 and -1"),
            ("-k*x_m", "-2.5*x_m", "formula", "expected one that uses the coefficient `k`"),
            ("-k*x_m", "-k*delay(x_m, 0.1)", "formula", "a formula without `delay`"),
            ("along = [\"x\"]", "along = [\"q\"]", "along", "found \"q\""),
            ("along = [\"x\"]", "along = []", "along", "at least one"),
            ("along = [\"x\"]", "along = [\"x\", \"x\"]", "along", "each direction once"),
            ("along = [\"x\"]", "along = [\"x\"]\ngives = \"n\"", "gives", "`ball.mass_kg`"),
            ("along = [\"x\"]", "along = [\"x\"]\ngives = \"nm\"", "gives", "\"m_s2\" or \"n\""),
            ("along = [\"x\"]", "along = [\"x\"]\nper_direction = [\"j\"]", "per_direction", "(`k`)"),
            ("along = [\"x\"]", "along = [\"x\"]\njoints = [\"elbow\"]", "joints", "an arm"),
            ("\"flight\"", "\"joint\"", "acts", "\"flight\" or \"contact\" for a ball"),
            ("coefficients.k", "coefficients.e", "coefficients.e", "no constant of mathematics"),
        ] {
            assert!(SPRING.contains(from), "{from}");
            let refused = FormulaEffect::of_ball("spring", &candidate(&SPRING.replace(from, to)), None).unwrap_err();
            let said = format!("expected {}, found {}", refused.expected, refused.found);
            assert!(refused.key == key && said.contains(wanted), "{to}: {} {said}", refused.key);
        }
    }
}
