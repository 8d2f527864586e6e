//! An effect: something that a simulation leaves out and a measurement may show.

use std::borrow::Cow;

use serde::Serialize;

use super::Parameter;
use crate::Result;

/// A name or a sentence of an effect: borrowed where it is built in, owned where a user declared the effect.
pub type Text = Cow<'static, str>;

/// Where an effect acts.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Between events.
    Segment,
    /// At events: where bodies touch, for one.
    Event,
    /// In how the motion was seen, not in the motion.
    Measurement,
    /// In a joint.
    Joint,
    /// In a sensor.
    Sensor,
    /// In an actuator.
    Actuator,
    /// Anywhere else: the word that groups the effect in answers.
    #[serde(untagged)]
    Other(Text),
}

/// One number of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coefficient {
    /// Its key under `[effects.NAME]`, with its unit: `c_1_m`.
    pub key: Text,
    /// Its unit in words: `1/m`.
    pub unit: Text,
    /// The value that means "absent": 0, or 1 for a factor.
    pub absent: f64,
    /// The least value that is simulated and fitted.
    pub min: f64,
    /// The greatest value that is simulated and fitted.
    pub max: f64,
    /// A value that is small but visible, as a distance from [`absent`](Self::absent): fits begin this far from it.
    pub typical: f64,
    /// Which of several under this key it is, from 1: that of joint 2, say. `None` where there is but one.
    pub number: Option<usize>,
    /// Whether it only shapes the effect (a width, a place) and cannot switch it off: fits begin at several of its values.
    pub shape: bool,
    /// As [`Parameter::channels`].
    #[serde(skip)]
    pub channels: Option<Vec<usize>>,
}

impl Coefficient {
    /// A coefficient from its key, its unit in words, the value that means "absent", its bounds and a typical distance
    /// from absent.
    #[must_use]
    pub const fn new(key: &'static str, unit: &'static str, absent: f64, (min, max): (f64, f64), typical: f64) -> Self {
        let (key, unit) = (Cow::Borrowed(key), Cow::Borrowed(unit));
        Self { key, unit, absent, min, max, typical, number: None, shape: false, channels: None }
    }

    /// The same as number `number` of several, from 1.
    #[must_use]
    pub const fn numbered(mut self, number: usize) -> Self {
        self.number = Some(number);
        self
    }

    /// The same as one that only [shapes](Self::shape) its effect.
    #[must_use]
    pub const fn shaping(mut self) -> Self {
        self.shape = true;
        self
    }
}

/// For which values of its coefficients an effect has a twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// For all of them.
    Any,
    /// Where none is below its absence, and one is above.
    Above,
}

impl Side {
    /// Whether values, each with its absence, lie on this side.
    #[must_use]
    pub fn holds(self, mut values: impl Iterator<Item = (f64, f64)>) -> bool {
        match self {
            Self::Any => true,
            Self::Above => {
                values.try_fold(false, |above, (v, absent)| (v >= absent).then_some(above || v > absent)) == Some(true)
            }
        }
    }
}

/// An effect that no recording distinguishes from another one, and what does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Twin {
    /// Its name.
    pub name: Text,
    /// On which side of its absence the other one looks like this one.
    pub side: Side,
    /// What distinguishes both, as something to do: to measure or to look up.
    pub separated_by: Text,
}

/// What the torque of an effect follows, where measured inputs drive a mechanism.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Follows {
    /// The speed of a joint.
    Speed,
    /// The rate at which motion or torque changes.
    Rate,
    /// The pose, within one joint.
    Pose,
    /// The pose, and how the base of the mechanism stands.
    Base,
    /// The load at the end of the mechanism.
    Load,
}

/// The motion that shows an effect, and how it shows there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Excitation {
    /// What its torque follows.
    pub follows: Follows,
    /// What it does in a motion in which that varies: a verb and its object, after the effect's name.
    pub signature: &'static str,
}

/// An effect as an entry of the catalogue: what it is, not how it acts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Effect {
    /// Its name in simulation files and answers: `quadratic_drag`.
    pub name: Text,
    /// Where it acts.
    pub phase: Phase,
    /// Its numbers, in order.
    pub coefficients: Vec<Coefficient>,
    /// For each coefficient: its physical bounds, within the bounds of the fit. Narrower where mass and size
    /// are known (the drag coefficient of a sphere is 0.1 to 1.5).
    pub plausible: Vec<(f64, f64)>,
    /// The settings of the scene on which the physical bounds rest, as users write them: if one of them is wrong, so are the
    /// bounds. Empty where they hold for any scene.
    pub plausible_rests_on: Vec<Text>,
    /// One sentence for users: what it is and what it does.
    pub sentence: Text,
    /// Whether every real thing of this kind shows it, however little: [`tune`](crate::tune::tune) then allows for it where the simulation
    /// leaves it out.
    pub always: bool,
    /// Whether it is a random effect: every event draws its own value, and the coefficient is their standard deviation.
    pub random: bool,
    /// Names of effects that some recordings cannot distinguish from it.
    pub mistaken_for: Vec<Text>,
    /// Effects that no recording at all distinguishes from it: they are always named together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exact_twins: Vec<Twin>,
    /// For each coefficient, the number of the simulation that it states anew, as users write it: a gain that the effect multiplies.
    /// Empty for an effect of which the simulation holds no number.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub restates: Vec<Text>,
    /// For each coefficient, the parameters of the simulator that together do the same: where all of these are tuned, nothing is left
    /// for the effect to explain. Empty for an effect that no parameters repeat.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub repeated_by: Vec<Vec<Text>>,
    /// Why it is implausible for this object: another effect that explains the recordings as well is preferred, and it is
    /// named only if there is none.
    pub implausible: Option<Text>,
    /// What is wrong in the simulation, rather than missing from it, and looks the same: an effect that leaves more than noise is
    /// then not named alone, nor one of recordings in one setup that no simulation explains down to their noise.
    pub feigned_by: Option<Text>,
    /// Whether it reads everything late by the same: inputs that act late, as through a delay or a lag, then look the same.
    pub late: bool,
    /// Largest share of the forecast error without it that may remain with it: above, it is not named alone from few recordings,
    /// because causes that are no effect resemble it. 1 where none do.
    pub forecast_share: f64,
    /// Which motion shows it, where measured inputs drive a mechanism. `None` where that is not known.
    #[serde(skip)]
    pub excitation: Option<Excitation>,
}

impl Effect {
    /// An effect that is plausible wherever it can be fitted, and that nothing is known to resemble.
    #[must_use]
    pub fn new(name: impl Into<Text>, phase: Phase, sentence: impl Into<Text>, coefficients: Vec<Coefficient>) -> Self {
        Self {
            name: name.into(),
            phase,
            plausible: coefficients.iter().map(|c| (c.min, c.max)).collect(),
            coefficients,
            plausible_rests_on: Vec::new(),
            sentence: sentence.into(),
            always: false,
            random: false,
            mistaken_for: Vec::new(),
            exact_twins: Vec::new(),
            restates: Vec::new(),
            repeated_by: Vec::new(),
            implausible: None,
            feigned_by: None,
            late: false,
            forecast_share: 1.0,
            excitation: None,
        }
    }

    /// The same where this motion shows it.
    #[must_use]
    pub fn excited_by(self, follows: Follows, signature: &'static str) -> Self {
        Self { excitation: Some(Excitation { follows, signature }), ..self }
    }

    /// Whether it is required, with unknown size: its physical bounds exclude its absence.
    #[must_use]
    pub fn required(&self) -> bool {
        let outside = |c: &Coefficient, (low, high): (f64, f64)| c.absent < low || c.absent > high;
        !self.coefficients.is_empty() && self.coefficients.iter().zip(&self.plausible).all(|(c, p)| outside(c, *p))
    }

    /// Whether coefficients with these values lie within their physical bounds, each with `slack` (its standard error, say).
    #[must_use]
    pub fn is_plausible(&self, values: &[f64], slack: &[f64]) -> bool {
        let each = values.iter().zip(slack).zip(&self.plausible);
        each.into_iter().all(|((value, slack), (low, high))| (low - slack..=high + slack).contains(value))
    }

    /// Its coefficients as parameters that may be tuned, each at its absent value, or at `values` where it is present.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) where one of `values` lies outside its bounds.
    pub fn parameters(&self, values: Option<&[f64]>) -> Result<Vec<Parameter>> {
        let value = |i: usize| values.map_or(self.coefficients[i].absent, |v| v[i]);
        let one = |(i, c): (usize, &Coefficient)| {
            let parameter = Parameter::new(self.parameter_name(i), c.unit.as_ref(), value(i), c.min, c.max)?;
            Ok(Parameter { channels: c.channels.clone(), ..parameter })
        };
        self.coefficients.iter().enumerate().map(one).collect()
    }

    /// The parameter name of coefficient `i` in a simulator that carries this effect: `quadratic_drag.c_1_m`, or
    /// `viscous_friction.nms_rad.2` where the coefficient has a number.
    #[must_use]
    pub fn parameter_name(&self, i: usize) -> String {
        let Coefficient { key, number, .. } = &self.coefficients[i];
        number.map_or_else(|| format!("{}.{key}", self.name), |number| format!("{}.{key}.{number}", self.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_needs_a_value_beyond_absence_and_none_before() {
        let of = |side: Side, values: &[f64]| side.holds(values.iter().map(|v| (*v, 1.0)));
        assert!(of(Side::Any, &[0.5]) && of(Side::Above, &[1.2]) && of(Side::Above, &[1.0, 1.2]));
        assert!(!of(Side::Above, &[0.9, 1.2]) && !of(Side::Above, &[1.0]));
    }

    #[test]
    fn an_effect_whose_plausible_range_excludes_absence_is_required() {
        let effect = |low: f64, high: f64| Effect {
            plausible: vec![(low, high)],
            ..Effect::new("drag", Phase::Segment, "", vec![Coefficient::new("c", "1", 0.0, (0.0, 10.0), 0.1)])
        };
        assert!(effect(0.03, 0.4).required() && effect(-2.0, -1.0).required());
        assert!(!effect(0.0, 0.4).required() && !effect(-1.0, 1.0).required());
    }
}
