//! A term of a law: a direction with its linear coefficients times at most two factors of one variable each.

use std::borrow::Cow;

use super::shape::{Range, Role, Shape};
use super::space::{Carried, Host, Space};
use crate::simulator::{Coefficient, Effect, Phase};

/// A function of one variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// The function.
    pub shape: Shape,
    /// The position of the variable.
    pub variable: usize,
    /// The exponent where it is no longer fitted, because it is a multiple of one half; of frequencies of angles likewise.
    pub rounded: Option<f64>,
}

impl Factor {
    pub(super) fn new(shape: Shape, variable: usize) -> Self {
        Self { shape, variable, rounded: None }
    }

    /// How many of its constants are fitted.
    #[must_use]
    pub fn constants(&self) -> usize {
        self.open().len()
    }

    /// What its fitted constants are. A constant that can be rounded is the only one of its shape.
    pub(super) fn open(&self) -> &'static [Role] {
        &self.shape.roles()[usize::from(self.rounded.is_some())..]
    }

    /// Constants with which a search begins.
    pub(super) fn grid(&self, range: &Range) -> Vec<Vec<f64>> {
        if self.open().is_empty() { vec![Vec::new()] } else { self.shape.grid(range) }
    }

    /// Whether a term may have it as a second factor.
    pub(super) fn multiplies(&self, other: &Self) -> bool {
        let waves = self.shape == Shape::Wave && other.shape == Shape::Wave;
        // A sign only turns over another function of its own variable.
        let turns = self.variable == other.variable && (self.shape.jumps() || other.shape.jumps());
        // Powers of one variable are one power.
        let powers = self.variable == other.variable && self.shape.is_power() && other.shape.is_power();
        self != other && !waves && !turns && !powers
    }

    /// What it is at the ends of its constant, itself first; nothing where it is the same everywhere.
    pub(super) fn limits(&self) -> Vec<Option<Self>> {
        let as_is = |shape, rounded| Some(Self { shape, variable: self.variable, rounded });
        let mut all = vec![Some(self.clone())];
        if self.rounded.is_some() {
            return all;
        }
        match self.shape {
            Shape::Power | Shape::Exp | Shape::Bump | Shape::Cos | Shape::Wave => all.push(None),
            Shape::Sin => all.push(as_is(Shape::OddPower, Some(1.0))),
            Shape::Tanh => all.extend([as_is(Shape::OddPower, Some(1.0)), as_is(Shape::Sign, None)]),
            Shape::Log => all.extend([as_is(Shape::Power, Some(1.0)), None]),
            Shape::Saturation => all.extend([as_is(Shape::Power, Some(-1.0)), None]),
            Shape::Stribeck => all.push(as_is(Shape::Sign, None)),
            Shape::OddPower | Shape::Sign | Shape::Window => {}
        }
        all
    }

    /// The factor with its constant at multiples of one half (an exponent) or at whole numbers (the frequency of an angle); none
    /// where it is not written in such.
    pub(super) fn multiples(&self, unit: &str) -> Vec<Self> {
        let at = |values: &[f64]| values.iter().map(|v| Self { rounded: Some(*v), ..self.clone() }).collect();
        match self.shape {
            Shape::Power => at(&[-3.0, -2.5, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]),
            Shape::OddPower => at(&[0.5, 1.0, 1.5, 2.0, 2.5, 3.0]),
            Shape::Sin | Shape::Cos if unit == "rad" => at(&[1.0, 2.0, 3.0]),
            _ => Vec::new(),
        }
    }

    #[inline]
    fn value(&self, x: f64, side: f64, constants: &[f64]) -> f64 {
        match self.rounded {
            Some(whole) => self.shape.value(x, side, &[whole]),
            None => self.shape.value(x, side, constants),
        }
    }
}

/// A direction times factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// The position of the direction.
    pub direction: usize,
    /// How many components it has.
    pub components: usize,
    /// The factors: none for a constant.
    pub factors: Vec<Factor>,
}

impl Term {
    pub(super) fn new(direction: usize, components: usize, factors: Vec<Factor>) -> Self {
        Self { direction, components, factors }
    }

    /// How many numbers it has: a coefficient for each component, then the constants of the factors in order.
    #[must_use]
    pub fn constants(&self) -> usize {
        self.components + self.factors.iter().map(Factor::constants).sum::<usize>()
    }

    /// Whether none of its constants is rounded.
    pub(super) fn is_open(&self) -> bool {
        self.factors.iter().all(|factor| factor.rounded.is_none())
    }

    /// Whether each factor's constant is rounded.
    pub(super) fn is_closed(&self) -> bool {
        self.factors.iter().all(|factor| factor.rounded.is_some())
    }

    /// Of its numbers, the fitted constants of each factor.
    pub(super) fn inner<'n>(&self, numbers: &'n [f64]) -> Vec<&'n [f64]> {
        let mut rest = &numbers[self.components..];
        let each = self.factors.iter().map(|factor| {
            let (own, after) = rest.split_at(factor.constants());
            rest = after;
            own
        });
        each.collect()
    }

    /// Whether the term bends sharply where a variable is 0, with these numbers: a power below 1 of a variable of either sign.
    #[must_use]
    pub fn bends(&self, numbers: &[f64]) -> bool {
        let sharp = |(factor, own): (&Factor, &[f64])| {
            let exponent = factor.rounded.or_else(|| own.first().copied());
            factor.shape == Shape::OddPower && exponent.is_some_and(|p| p < 1.0)
        };
        self.factors.iter().zip(self.inner(numbers)).any(sharp)
    }

    /// The same with every rounded constant free.
    pub(super) fn opened(&self) -> Self {
        let factors = self.factors.iter().map(|f| Factor::new(f.shape, f.variable)).collect();
        Self { factors, ..self.clone() }
    }

    /// The product of the factors, from all numbers of the term, the values of all variables, and on which side of 0 each is.
    #[must_use]
    #[inline]
    pub fn product(&self, numbers: &[f64], variables: &[f64], sides: &[f64]) -> f64 {
        let (mut at, mut value) = (self.components, 1.0);
        for factor in &self.factors {
            let end = at + factor.constants();
            value *= factor.value(variables[factor.variable], sides[factor.variable], &numbers[at..end]);
            at = end;
        }
        value
    }

    /// The keys of its numbers, and what those inside factors are.
    #[must_use]
    pub fn keys(&self, space: &Space) -> Vec<(String, Option<Role>)> {
        let names = &space.directions[self.direction].components;
        let coefficient =
            |name: &String| space.free_name(if names.len() == 1 { "a".to_owned() } else { format!("a_{name}") });
        let mut keys: Vec<(String, Option<Role>)> = names.iter().map(|name| (coefficient(name), None)).collect();
        for (i, factor) in self.factors.iter().enumerate() {
            let number = if self.factors.len() > 1 { (i + 1).to_string() } else { String::new() };
            let open = factor.shape.roles().iter().skip(usize::from(factor.rounded.is_some()));
            let key = |role: &Role| space.free_name(format!("{}{number}", role.letter()));
            keys.extend(open.map(|role| (key(role), Some(*role))));
        }
        keys
    }

    /// The product of the factors as a formula; empty where there are none.
    #[must_use]
    pub fn formula(&self, space: &Space) -> String {
        if let [one, other] = self.factors.as_slice()
            && (one.shape, one.variable) == (Shape::OddPower, other.variable)
            && other.shape == Shape::OddPower
            && let (Some(a), Some(b)) = (one.rounded, other.rounded)
        {
            return magnitude(&space.variables[one.variable].name, &(a + b).to_string());
        }
        let keys = self.keys(space);
        let mut at = self.components;
        let mut parts = Vec::new();
        let has =
            |shape: Shape, variable: usize| self.factors.iter().any(|f| (f.shape, f.variable) == (shape, variable));
        for factor in &self.factors {
            let x = &space.variables[factor.variable].name;
            let own: Vec<&str> = keys[at..at + factor.constants()].iter().map(|(key, _)| key.as_str()).collect();
            at += factor.constants();
            let rounded = factor.rounded.map(|whole| whole.to_string());
            let first = rounded.as_deref().or(own.first().copied()).unwrap_or_default();
            // |x|^p sign(x) times sign(x) is |x|^p.
            match factor.shape {
                Shape::OddPower if has(Shape::Sign, factor.variable) => parts.push(magnitude(x, first)),
                Shape::Sign if has(Shape::OddPower, factor.variable) => {}
                shape => parts.push(written(shape, x, first, own.get(1).copied().unwrap_or_default())),
            }
        }
        // A saturation divides what stands before it.
        let (below, above): (Vec<String>, Vec<String>) = parts.into_iter().partition(|part| part.starts_with(ONE_OVER));
        if above.is_empty() {
            return below.join(" * ");
        }
        let below: String = below.iter().map(|part| part.replacen(ONE_OVER, "/", 1)).collect();
        above.join(" * ") + &below
    }

    /// The variables to whose power the coefficients refer, with their exponents: those whose exponent is written as a number.
    fn powers(&self) -> Vec<(usize, f64)> {
        let own = |f: &Factor| {
            let power = matches!(f.shape, Shape::Power | Shape::OddPower);
            Some((f.variable, f.rounded.filter(|_| power)?))
        };
        self.factors.iter().filter_map(own).collect()
    }

    /// The unit of its coefficients.
    #[must_use]
    pub fn unit(&self, host: &dyn Host) -> String {
        host.unit(self.direction, &self.powers())
    }

    /// The unit of a constant inside, from its role and the variable's unit.
    #[must_use]
    pub fn inner_units(&self, space: &Space) -> Vec<String> {
        let each = self.factors.iter().flat_map(|factor| {
            let unit = space.variables[factor.variable].unit.clone();
            let open = factor.shape.roles().iter().skip(usize::from(factor.rounded.is_some()));
            open.map(move |role| match role {
                Role::Exponent => "1".to_owned(),
                Role::Scale | Role::Place | Role::Width => unit.clone(),
                Role::Frequency if unit == "rad" => "1".to_owned(),
                Role::Frequency => format!("1/{unit}"),
                Role::Phase => "rad".to_owned(),
            })
        });
        each.collect()
    }

    /// The term with the bounds of its numbers, the coefficients within `greatest` either way.
    pub(super) fn carried(&self, host: &dyn Host, ranges: &[Range], number: usize, greatest: f64) -> Carried {
        let space = host.space();
        let units = std::iter::repeat_n(self.unit(host), self.components).chain(self.inner_units(space));
        let mut bounds = vec![(-greatest, greatest); self.components];
        for factor in &self.factors {
            let inner = (0..factor.constants()).map(|i| factor.shape.bounds(i, &ranges[factor.variable]));
            bounds.extend(inner);
        }
        let name = if number == 0 { "law".to_owned() } else { format!("law_{}", number + 1) };
        let keys = self.keys(space);
        let coefficients = keys.into_iter().zip(units).zip(bounds).map(|(((key, role), unit), (min, max))| {
            let absent = if role.is_none() { 0.0 } else { min };
            let typical = 0.1 * (max - min);
            let (key, unit) = (Cow::Owned(key), Cow::Owned(unit));
            Coefficient { key, unit, absent, min, max, typical, number: None, shape: role.is_some(), channels: None }
        });
        let effect = Effect::new(name, Phase::Segment, "a law that the recordings show", coefficients.collect());
        Carried { term: self.clone(), effect }
    }

    /// Whether it depends on the clock.
    #[must_use]
    pub fn depends_on_time(&self) -> bool {
        self.factors.iter().any(|factor| factor.shape == Shape::Wave)
    }
}

/// How a saturation begins.
const ONE_OVER: &str = "1/";

/// A shape as a formula of its variable, its first and its second constant.
fn written(shape: Shape, x: &str, a: &str, b: &str) -> String {
    match shape {
        Shape::Power | Shape::OddPower if a == "1" => x.to_owned(),
        Shape::Power => format!("{x}^{}", bracketed(a)),
        Shape::OddPower if a == "3" => format!("{x}^3"),
        Shape::OddPower if a == "2" => format!("abs({x}) * {x}"),
        Shape::OddPower => format!("abs({x})^{a} * sign({x})"),
        Shape::Exp => format!("exp(-{x}/{a})"),
        Shape::Bump => format!("exp(-(({x} - {a})/{b})^2)"),
        Shape::Sin if a == "1" => format!("sin({x})"),
        Shape::Cos if a == "1" => format!("cos({x})"),
        Shape::Sin => format!("sin({a}*{x})"),
        Shape::Cos => format!("cos({a}*{x})"),
        Shape::Wave => format!("cos({a}*{x} + {b})"),
        Shape::Tanh => format!("tanh({x}/{a})"),
        Shape::Log => format!("ln(1 + {x}/{a})"),
        Shape::Saturation => format!("{ONE_OVER}(1 + {x}/{a})"),
        Shape::Stribeck => format!("exp(-({x}/{a})^2) * sign({x})"),
        Shape::Sign => format!("sign({x})"),
        Shape::Window => String::new(),
    }
}

/// `abs(x)^a`.
fn magnitude(x: &str, a: &str) -> String {
    match a {
        "1" => format!("abs({x})"),
        "2" => format!("{x}^2"),
        _ => format!("abs({x})^{a}"),
    }
}

fn bracketed(exponent: &str) -> String {
    if exponent.starts_with('-') { format!("({exponent})") } else { exponent.to_owned() }
}
