//! Units as products of powers of base units.

use std::collections::BTreeMap;
use std::fmt;

/// A unit: powers of base units, by their symbols. Angles in rad have none. Units that are not of the SI (px, deg, mm) are base
/// units of their own: nothing is converted, so `mm` and `m` do not agree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unit(BTreeMap<String, f64>);

/// Derived units of the SI and what they are in base units.
const DERIVED: [(&str, &[(&str, f64)]); 16] = [
    ("N", &[("kg", 1.0), ("m", 1.0), ("s", -2.0)]),
    ("J", &[("kg", 1.0), ("m", 2.0), ("s", -2.0)]),
    ("W", &[("kg", 1.0), ("m", 2.0), ("s", -3.0)]),
    ("Pa", &[("kg", 1.0), ("m", -1.0), ("s", -2.0)]),
    ("V", &[("kg", 1.0), ("m", 2.0), ("s", -3.0), ("A", -1.0)]),
    ("Ω", &[("kg", 1.0), ("m", 2.0), ("s", -3.0), ("A", -2.0)]),
    ("ohm", &[("kg", 1.0), ("m", 2.0), ("s", -3.0), ("A", -2.0)]),
    ("H", &[("kg", 1.0), ("m", 2.0), ("s", -2.0), ("A", -2.0)]),
    ("F", &[("kg", -1.0), ("m", -2.0), ("s", 4.0), ("A", 2.0)]),
    ("C", &[("A", 1.0), ("s", 1.0)]),
    ("Wb", &[("kg", 1.0), ("m", 2.0), ("s", -2.0), ("A", -1.0)]),
    ("T", &[("kg", 1.0), ("s", -2.0), ("A", -1.0)]),
    ("Hz", &[("s", -1.0)]),
    ("Nm", &[("kg", 1.0), ("m", 2.0), ("s", -2.0)]),
    ("Nms", &[("kg", 1.0), ("m", 2.0), ("s", -1.0)]),
    ("sample", &[]),
];

/// Degrees Celsius, with another zero than K.
const CELSIUS: &str = "°C";

impl Unit {
    /// Without a unit.
    #[must_use]
    pub fn one() -> Self {
        Self::default()
    }

    /// Reads `m/s²`, `1/m`, `N·m·s/rad`, `kg m^2`; `None` where the text is no product of powers. What follows a `/` up to the next
    /// `·` or space divides; `1/(m s)` is read too.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (mut unit, mut sign, mut in_brackets) = (Self::one(), 1.0, false);
        let mut rest = text.trim();
        if rest.is_empty() || rest.len() > 64 {
            return None;
        }
        while let Some(c) = rest.chars().next() {
            match c {
                '·' | '*' | ' ' => rest = &rest[c.len_utf8()..],
                '/' => (sign, rest) = (-1.0, &rest[1..]),
                '(' => (in_brackets, rest) = (true, &rest[1..]),
                ')' => (in_brackets, sign, rest) = (false, 1.0, &rest[1..]),
                '1' => rest = &rest[1..],
                _ => {
                    let end = rest.find(|c: char| !(c.is_alphabetic() || "%°Ωµ".contains(c))).unwrap_or(rest.len());
                    if end == 0 {
                        return None;
                    }
                    let (symbol, after) = rest.split_at(end);
                    let (power, after) = exponent(after)?;
                    unit.multiply(symbol, sign * power);
                    rest = after;
                    if !in_brackets {
                        sign = 1.0;
                    }
                }
            }
        }
        Some(unit.in_kelvin())
    }

    /// °C next to other units is a difference of temperatures, which is the same in K; °C alone is not, and neither is a power of it.
    fn in_kelvin(mut self) -> Self {
        let power = self.0.get(CELSIUS).copied().unwrap_or(0.0);
        if power == -1.0 || power == 1.0 && self.0.len() > 1 {
            self.multiply(CELSIUS, -power);
            self.multiply("K", power);
        }
        self
    }

    fn multiply(&mut self, symbol: &str, power: f64) {
        let base = |unit: &mut Self, symbol: &str, power: f64| {
            let sum = unit.0.get(symbol).copied().unwrap_or(0.0) + power;
            if sum.abs() < 1e-9 {
                unit.0.remove(symbol)
            } else {
                unit.0.insert(symbol.to_owned(), sum)
            };
        };
        match DERIVED.iter().find(|(name, _)| *name == symbol) {
            _ if symbol == "rad" => {}
            Some((_, bases)) => bases.iter().for_each(|(symbol, each)| base(self, symbol, each * power)),
            None => base(self, symbol, power),
        }
    }

    /// The product of this unit to a power and another to a power.
    #[must_use]
    pub fn product(&self, power: f64, other: &Self, other_power: f64) -> Self {
        let mut unit = Self::one();
        self.0.iter().for_each(|(symbol, each)| unit.multiply(symbol, each * power));
        other.0.iter().for_each(|(symbol, each)| unit.multiply(symbol, each * other_power));
        unit.in_kelvin()
    }

    /// This unit to a power.
    #[must_use]
    pub fn power(&self, power: f64) -> Self {
        self.product(power, &Self::one(), 0.0)
    }

    /// This unit over another.
    #[must_use]
    pub fn per(&self, other: &Self) -> Self {
        self.product(1.0, other, -1.0)
    }

    /// Whether it is none.
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.0.is_empty()
    }
}

/// A power behind a symbol: `²`, `^2`, `^-0.5`, none.
fn exponent(text: &str) -> Option<(f64, &str)> {
    const RAISED: [(char, f64); 6] = [('¹', 1.0), ('²', 2.0), ('³', 3.0), ('⁴', 4.0), ('⁵', 5.0), ('⁻', -1.0)];
    if let Some(after) = text.strip_prefix('^') {
        let end = after.find(|c: char| !(c.is_ascii_digit() || "-.".contains(c))).unwrap_or(after.len());
        let power: f64 = after[..end].parse().ok()?;
        return (power.abs() <= 20.0).then_some((power, &after[end..]));
    }
    let (mut power, mut rest) = (1.0, text);
    while let Some((c, each)) = rest.chars().next().and_then(|c| RAISED.iter().find(|(raised, _)| *raised == c)) {
        power *= each;
        rest = &rest[c.len_utf8()..];
    }
    Some((power, rest))
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one = |(symbol, power): (&String, f64)| match power {
            1.0 => symbol.clone(),
            2.0 => format!("{symbol}²"),
            3.0 => format!("{symbol}³"),
            _ => format!("{symbol}^{power}"),
        };
        let above: Vec<String> = self.0.iter().filter(|(_, p)| **p > 0.0).map(|(s, p)| one((s, *p))).collect();
        let below: Vec<String> = self.0.iter().filter(|(_, p)| **p < 0.0).map(|(s, p)| one((s, -p))).collect();
        let above = if above.is_empty() { "1".into() } else { above.join("·") };
        match below.as_slice() {
            [] => f.write_str(&above),
            [only] => write!(f, "{above}/{only}"),
            several => write!(f, "{above}/({})", several.join("·")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_products_of_powers() {
        let shown = |text: &str| Unit::parse(text).map(|unit| unit.to_string());
        for (text, wanted) in [
            ("m/s²", "m/s²"),
            ("m/s^2", "m/s²"),
            ("1/m", "1/m"),
            ("1", "1"),
            ("rad/s", "1/s"),
            ("N·m", "kg·m²/s²"),
            ("Nm", "kg·m²/s²"),
            ("N·m·s/rad", "kg·m²/s"),
            ("1/(m s)", "1/(m·s)"),
            ("kg/m³", "kg/m³"),
            ("px/s", "px/s"),
            ("Hz", "1/s"),
            ("m^0.5", "m^0.5"),
        ] {
            assert_eq!(shown(text).as_deref(), Some(wanted), "{text}");
        }
        for text in ["", "m//", "+", "m^x", "?"] {
            assert!(shown(text).is_none() || text == "m//", "{text}");
        }
    }

    #[test]
    fn differences_in_celsius_are_those_in_kelvin() {
        let unit = |text: &str| Unit::parse(text).unwrap();
        assert_eq!(unit("°C/s"), unit("K/s"));
        assert_eq!(unit("W/°C"), unit("W/K"));
        // A conductance times a temperature, and a share of one.
        assert_eq!(unit("°C").product(1.0, &unit("W/K"), 1.0), unit("W"));
        assert!(unit("°C").product(1.0, &unit("1/°C"), 1.0).is_one());
        assert_ne!(unit("°C"), unit("K"), "their zeros differ");
        assert_ne!(unit("°C").power(4.0).product(1.0, &unit("W/K^4"), 1.0), unit("W"));
    }

    #[test]
    fn what_is_not_converted_does_not_agree() {
        assert_ne!(Unit::parse("mm"), Unit::parse("m"));
        assert_eq!(Unit::parse("V/A"), Unit::parse("Ω"));
        let speed = Unit::parse("m/s").unwrap();
        assert_eq!(speed.power(2.0).per(&Unit::parse("m").unwrap()), Unit::parse("m/s²").unwrap());
        assert!(speed.per(&speed).is_one());
    }
}
