//! What a search for a law ends with.

use serde::Serialize;

use super::course::Course;
use super::gates::Gates;
use super::reason::Reason;
use super::shape::Role;
use super::space::Carried;
use super::term::Term;
use crate::observation::Observation;

/// A constant lies at an end of its range within this share of it.
const AT_BOUND: f64 = 1e-3;
/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is missing that these recordings could show.
    None,
    /// One law, which held-out recordings confirm.
    Law,
    /// Several laws, or one without held-out recordings.
    OneOf,
    /// What the catalogue names explains the recordings as well, or is the law.
    Named,
    /// Something is missing, and no law of the table explains it.
    Unknown,
}

/// One number of a law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Its key in the formula.
    pub key: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Its 95 % interval, wider by what the choice of the form leaves open.
    pub interval95: (f64, f64),
    /// What it is inside a factor; `None` of a coefficient.
    #[serde(skip)]
    pub role: Option<Role>,
}

/// An exponent that was rounded, with its interval before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rounded {
    /// The rounded value.
    pub value: f64,
    /// The interval of the fitted one.
    pub interval95: (f64, f64),
}

/// A term of a law.
#[derive(Debug, Clone, Serialize)]
pub struct FoundTerm {
    /// The term.
    #[serde(skip)]
    pub term: Term,
    /// The product of its factors as a formula; empty of a constant.
    pub formula: String,
    /// The names of its components.
    pub components: Vec<String>,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// Of each factor, its rounded constant.
    pub rounded: Vec<Option<Rounded>>,
    /// The variables that its factors use: their positions and names.
    #[serde(skip)]
    pub variables: Vec<(usize, String)>,
    /// How the host carries it: the bounds of its numbers.
    #[serde(skip)]
    pub carried: Carried,
}

/// A law.
#[derive(Debug, Clone, Serialize)]
pub struct Member {
    /// Its terms.
    pub terms: Vec<FoundTerm>,
    /// The effect of the catalogue that it is.
    pub alias: Option<&'static str>,
    /// Gain of the information criterion.
    pub bic_gain: f64,
    /// The same less the price of its structure.
    pub score: f64,
    /// How far its gain is behind the best.
    pub behind_best: f64,
    /// The length of its description.
    pub bits: f64,
    /// What its tests measured.
    pub gates: Gates,
    /// Between which values of each variable that it uses it was seen: position of the variable, and the range.
    pub valid: Vec<(String, (f64, f64))>,
    /// Whether it depends on the clock.
    pub depends_on_time: bool,
    /// Whether rollouts over one and a half times that range stay finite.
    pub bounded: bool,
    /// Root mean square of what fitted recordings leave, without the law and with it, as [`Gates::held_out_gap`].
    pub gap: (f64, f64),
    /// Its force along each variable that it uses.
    pub courses: Vec<Course>,
    /// The parameters of the simulator with it, in its order, and their 95 % intervals.
    pub parameters: Vec<(f64, (f64, f64))>,
}

/// A law that a test refused.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// The law in words.
    pub text: String,
    /// Its gain of the information criterion.
    pub bic_gain: f64,
    /// The test that it failed.
    pub gate: Reason,
    /// What its tests measured.
    pub gates: Gates,
}

/// How a recording was followed without a law and with the best one, the parameters fitted in both.
#[derive(Debug, Clone)]
pub struct Followed {
    /// What was used of it.
    pub seen: Observation,
    /// Noise of each channel in its unit.
    pub noise: Vec<f64>,
    /// Measured − predicted without a law, in units of the noise, shape `[sample · channel]`.
    pub without: Vec<f64>,
    /// The same with the law.
    pub with: Vec<f64>,
    /// When something sudden happened, s.
    pub events: Vec<f64>,
    /// Its nuisance parameters with the law: name, value, unit.
    pub nuisances: Vec<(String, f64, String)>,
}

/// The answer.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// In one word.
    pub verdict: Verdict,
    /// Why not more than that.
    pub reason: Option<Reason>,
    /// The laws, best first.
    pub members: Vec<Member>,
    /// Laws within the margin that a test refused.
    pub refused: Vec<Refused>,
    /// Evidence of a missing force about the model without a law, nats.
    pub base_force_nats: f64,
    /// What the catalogue's answer gains in the information criterion on the same recordings.
    pub rival_bic_gain: Option<f64>,
    /// Whether a test on held-out recordings refused the law that is the catalogue's answer.
    pub rival_refused: bool,
    /// What the best force that decays from a value of its own in each recording gains in the information criterion; `None` where the
    /// catalogue's answer leaves more than noise, where no law explains as much, or there is none.
    pub decay_bic_gain: Option<f64>,
    /// The positions of the recordings in which it was searched among those that were to be fitted.
    pub searched: Vec<usize>,
    /// How many recordings were held out.
    pub held_out: usize,
    /// Root mean square of the residuals in units of the noise, without a law and with the best.
    pub left: (f64, f64),
    /// How the recordings in which it was searched were followed, in their order; none without a law.
    #[serde(skip)]
    pub followed: Vec<Followed>,
    /// Rollouts in all.
    pub rollouts: usize,
}

impl Member {
    /// Whether a constant inside a factor lies at an end of the range that is searched, where its interval says nothing.
    #[must_use]
    pub fn is_at_bound(&self) -> bool {
        self.terms.iter().any(|term| {
            let each = term.numbers.iter().zip(&term.carried.effect.coefficients);
            each.filter(|(number, _)| number.role.is_some()).any(|(number, of)| {
                let room = AT_BOUND * (of.max - of.min);
                number.value <= of.min + room || number.value >= of.max - room
            })
        })
    }

    /// Whether the recordings leave the size of a term open: the intervals of all its coefficients hold 0. With a free exponent a coefficient is
    /// the force where the variable is 1, which says nothing of it where it was seen.
    #[must_use]
    pub fn is_without_size(&self) -> bool {
        let holds = |number: &Number| number.interval95.0 <= 0.0 && number.interval95.1 >= 0.0;
        let is_open = |term: &FoundTerm| term.numbers.iter().any(|number| number.role == Some(Role::Exponent));
        let of = |term: &FoundTerm| term.numbers.iter().filter(|number| number.role.is_none()).all(holds);
        self.terms.iter().any(|term| of(term) && !is_open(term))
    }

    /// The law in words: coefficients, formulas and directions.
    #[must_use]
    pub fn text(&self) -> String {
        self.terms.iter().map(FoundTerm::text).collect::<Vec<_>>().join(" + ")
    }
}

impl FoundTerm {
    /// The term in words: `a * speed^p along v`.
    #[must_use]
    pub fn text(&self) -> String {
        let along = self.components.join(", ");
        let sign = if self.components.len() == 1 { "a" } else { "(a)" };
        if self.formula.is_empty() {
            format!("{sign} along {along}")
        } else {
            format!("{sign} * {} along {along}", self.formula)
        }
    }
}
