//! Actuators: every kind is a set of gains, as MuJoCo makes it of the element and its class.

use super::known::OTHER_ACTUATORS;
use crate::given::Given;
use crate::robot::{Filter, Law};
use crate::{Error, Result};

/// A formula of the force, or of what lies before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// No bias; a fixed gain; no dynamics.
    Plain,
    /// A bias that is affine in length and speed.
    Affine,
    Integrator,
    Filter,
    /// One that is not taken on.
    Other,
}

/// Gains and ranges of an actuator before its joint is known.
#[derive(Debug, Clone)]
pub(super) struct Servo {
    gain: [f64; 3],
    bias: [f64; 3],
    gain_form: Form,
    bias_form: Form,
    dynamics: Form,
    time_constant_s: f64,
    pub gear: [f64; 6],
    pub delay_s: f64,
    command_range: [f64; 2],
    command_limited: Option<bool>,
    force_range: [f64; 2],
    force_limited: Option<bool>,
    /// Which share of the joint's range the command may cover; 0 where it states its own.
    inherit_range: f64,
}

impl Default for Servo {
    fn default() -> Self {
        Self {
            gain: [1.0, 0.0, 0.0],
            bias: [0.0; 3],
            gain_form: Form::Plain,
            bias_form: Form::Plain,
            dynamics: Form::Plain,
            time_constant_s: 1.0,
            gear: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            delay_s: 0.0,
            command_range: [0.0; 2],
            command_limited: None,
            force_range: [0.0; 2],
            force_limited: None,
            inherit_range: 0.0,
        }
    }
}

impl Servo {
    /// The same after an element of a class, or the actuator itself.
    pub fn update(&mut self, given: &Given) -> Result<()> {
        given.fill("gear", &mut self.gear)?;
        self.delay_s = given.not_negative("delay", self.delay_s)?;
        given.fill("ctrlrange", &mut self.command_range)?;
        given.fill("forcerange", &mut self.force_range)?;
        if given.get("ctrllimited").is_some() {
            self.command_limited = given.flag_or_auto("ctrllimited")?;
        }
        if given.get("forcelimited").is_some() {
            self.force_limited = given.flag_or_auto("forcelimited")?;
        }
        match given.own.tag.as_str() {
            "general" => self.general(given),
            "motor" => {
                (self.gain, self.bias) = ([1.0, 0.0, 0.0], [0.0; 3]);
                self.forms(Form::Plain, Form::Plain);
                Ok(())
            }
            "position" => self.position(given),
            "intvelocity" => {
                self.position(given)?;
                self.dynamics = Form::Integrator;
                Ok(())
            }
            "velocity" => {
                let kv = given.number("kv")?.unwrap_or(self.gain[0]);
                (self.gain, self.bias) = ([kv, 0.0, 0.0], [0.0, 0.0, -kv]);
                self.forms(Form::Affine, Form::Plain);
                Ok(())
            }
            "cylinder" => self.cylinder(given),
            tag if OTHER_ACTUATORS.contains(&tag) => {
                self.gain_form = Form::Other;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn forms(&mut self, bias: Form, dynamics: Form) {
        (self.gain_form, self.bias_form, self.dynamics) = (Form::Plain, bias, dynamics);
    }

    fn general(&mut self, given: &Given) -> Result<()> {
        let mut numbers = [0.0; 10];
        for (name, values) in [("gainprm", &mut self.gain), ("biasprm", &mut self.bias)] {
            numbers[..3].copy_from_slice(values.as_slice());
            given.fill(name, &mut numbers)?;
            values.copy_from_slice(&numbers[..3]);
        }
        numbers[0] = self.time_constant_s;
        given.fill("dynprm", &mut numbers)?;
        self.time_constant_s = numbers[0];
        let form = |name: &str, plain: &str, old: Form| match given.text(name) {
            None => old,
            Some(word) if word == plain => Form::Plain,
            Some("affine") => Form::Affine,
            Some("integrator") => Form::Integrator,
            Some("filter" | "filterexact") => Form::Filter,
            Some(_) => Form::Other,
        };
        self.gain_form = form("gaintype", "fixed", self.gain_form);
        self.bias_form = form("biastype", "none", self.bias_form);
        self.dynamics = form("dyntype", "none", self.dynamics);
        Ok(())
    }

    fn position(&mut self, given: &Given) -> Result<()> {
        let kp = given.number("kp")?.unwrap_or(self.gain[0]);
        (self.gain[0], self.bias[1]) = (kp, -kp);
        let kv = given.number("kv")?;
        let ratio = given.number("dampratio")?;
        if let (Some(kv), Some(ratio)) = (kv, ratio)
            && kv != 0.0
            && ratio != 0.0
        {
            let message = "expected `kv` or `dampratio`, found both";
            return Err(given.error("dampratio", message, "keep one of them"));
        }
        if kv.is_some() {
            self.bias[2] = -given.not_negative("kv", 0.0)?;
        }
        // A positive number stands for a damping ratio until the inertia of the joint is known.
        if ratio.is_some() && !(kv.is_some() && ratio == Some(0.0)) {
            self.bias[2] = given.not_negative("dampratio", 0.0)?;
        }
        self.forms(Form::Affine, self.dynamics);
        if given.get("timeconst").is_some() {
            self.time_constant_s = given.not_negative("timeconst", 0.0)?;
            self.dynamics = if self.time_constant_s > 0.0 { Form::Filter } else { Form::Plain };
        }
        self.inherit_range = given.not_negative("inheritrange", self.inherit_range)?;
        Ok(())
    }

    fn cylinder(&mut self, given: &Given) -> Result<()> {
        self.time_constant_s = given.not_negative("timeconst", self.time_constant_s)?;
        given.fill("bias", &mut self.bias)?;
        self.gain[0] = given.number("area")?.unwrap_or(self.gain[0]);
        if let Some(diameter) = given.number("diameter")? {
            self.gain[0] = std::f64::consts::FRAC_PI_4 * diameter * diameter;
        }
        self.forms(Form::Affine, Form::Filter);
        Ok(())
    }

    /// What is not taken on of it.
    pub fn left_out(&self) -> Option<&'static str> {
        if self.gain_form != Form::Plain || !matches!(self.bias_form, Form::Plain | Form::Affine) {
            return Some("a force that depends on its command otherwise than by a factor");
        }
        (self.dynamics == Form::Other).then_some("dynamics of its own between command and force")
    }

    /// The force. `inertia` is the effective one of the joint over the square of the gear, for damping ratios.
    pub fn law(&self, inertia: impl FnOnce() -> Option<f64>) -> Law {
        if self.left_out().is_some() {
            return Law::Other;
        }
        let mut bias = if self.bias_form == Form::Affine { self.bias } else { [0.0; 3] };
        let gain = self.gain[0];
        if self.ratio().is_some() {
            let damping = inertia().map(|inertia| bias[2] * 2.0 * (gain * inertia).max(0.0).sqrt());
            // A gear of 0 moves nothing: there is no such damping.
            let Some(damping) = damping.filter(|damping| damping.is_finite()) else { return Law::Other };
            bias[2] = -damping;
        }
        Law::Affine { gain, bias }
    }

    /// The damping ratio, where one stands for the damping.
    pub fn ratio(&self) -> Option<f64> {
        let servo = self.bias_form == Form::Affine && self.gain[0] == -self.bias[1] && self.bias[2] > 0.0;
        servo.then_some(self.bias[2])
    }

    pub fn filter(&self) -> Filter {
        match self.dynamics {
            Form::Filter if self.time_constant_s > 0.0 => Filter::LowPass { time_constant_s: self.time_constant_s },
            Form::Integrator => Filter::Integrator,
            _ => Filter::None,
        }
    }

    /// The range of commands; `joint` is that of its joint.
    pub fn command_range(&self, joint: Option<[f64; 2]>, given: &Given, auto: bool) -> Result<Option<[f64; 2]>> {
        let own = limits(self.command_range, self.command_limited, auto);
        let inherits = self.inherit_range > 0.0 && self.command_limited != Some(false);
        if own.is_some() || !inherits || self.dynamics == Form::Integrator {
            return checked(own, "ctrlrange", given);
        }
        let share = |[lower, upper]: [f64; 2]| {
            let (middle, half) = (f64::midpoint(lower, upper), self.inherit_range * (upper / 2.0 - lower / 2.0));
            [middle - half, middle + half]
        };
        let range = joint.map(share);
        if range.is_some_and(|range| range.iter().any(|end| !end.is_finite())) {
            let message = "`inheritrange`: expected a share of the joint's range, found one without end";
            return Err(given.error("inheritrange", message, "write 1, say"));
        }
        Ok(range)
    }

    /// Whether its range of forces is switched off.
    pub fn unlimited(&self) -> bool {
        self.force_limited == Some(false)
    }

    pub fn force_range(&self, given: &Given, auto: bool) -> Result<Option<[f64; 2]>> {
        checked(limits(self.force_range, self.force_limited, auto), "forcerange", given)
    }
}

/// The range where it limits: said so, or (`auto`) where it is a range and the file does not say.
pub(super) fn limits(range: [f64; 2], limited: Option<bool>, auto: bool) -> Option<[f64; 2]> {
    let limited = limited.unwrap_or(auto && range[0] < range[1]);
    limited.then_some(range)
}

/// Refuses a range whose first number is not the smaller one.
pub(super) fn checked(range: Option<[f64; 2]>, name: &str, given: &Given) -> Result<Option<[f64; 2]>> {
    match range {
        Some([lower, upper]) if lower >= upper => {
            let message = format!("`{name}`: expected the smaller number first, found {lower} {upper}");
            Err(Error::from_given(given, name, message))
        }
        other => Ok(other),
    }
}

impl Error {
    fn from_given(given: &Given, name: &str, message: String) -> Self {
        given.error(name, message, "correct the range, or write that it does not limit")
    }
}
