//! The operators and functions of formulas: one table for every formula anywhere.

/// An operator or a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Function {
    /// `-x`
    Negate,
    /// `x + y`
    Add,
    /// `x - y`
    Subtract,
    /// `x * y`
    Multiply,
    /// `x / y`
    Divide,
    /// `x ^ y`
    Power,
    /// `abs(x)`
    Abs,
    /// `sign(x)`: −1, 0 or 1
    Sign,
    /// `min(x, y)`
    Min,
    /// `max(x, y)`
    Max,
    /// `sqrt(x)`
    Sqrt,
    /// `cbrt(x)`
    Cbrt,
    /// `exp(x)`
    Exp,
    /// `ln(x)`
    Ln,
    /// `sin(x)`, x in rad
    Sin,
    /// `cos(x)`, x in rad
    Cos,
    /// `tan(x)`, x in rad
    Tan,
    /// `atan2(y, x)`, in rad
    Atan2,
    /// `tanh(x)`
    Tanh,
    /// `clamp(x, low, high)`
    Clamp,
    /// `delay(input, seconds)`: what an input was that long before; only where inputs have a history
    Delay,
}

impl Function {
    /// Those that are called by name.
    pub const NAMED: [(&'static str, Self); 15] = [
        ("abs", Self::Abs),
        ("sign", Self::Sign),
        ("min", Self::Min),
        ("max", Self::Max),
        ("sqrt", Self::Sqrt),
        ("cbrt", Self::Cbrt),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("atan2", Self::Atan2),
        ("tanh", Self::Tanh),
        ("clamp", Self::Clamp),
        ("delay", Self::Delay),
    ];

    /// The function of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    /// How many values it takes.
    #[must_use]
    pub fn arity(self) -> usize {
        match self {
            Self::Clamp => 3,
            Self::Add
            | Self::Subtract
            | Self::Multiply
            | Self::Divide
            | Self::Power
            | Self::Min
            | Self::Max
            | Self::Atan2
            | Self::Delay => 2,
            _ => 1,
        }
    }

    /// Its value; of [`Delay`](Self::Delay), which only an evaluation with a history knows, that of its input.
    ///
    /// # Panics
    /// Where there are fewer values than its [arity](Self::arity).
    #[must_use]
    pub fn apply(self, v: &[f64]) -> f64 {
        match self {
            Self::Negate => -v[0],
            Self::Add => v[0] + v[1],
            Self::Subtract => v[0] - v[1],
            Self::Multiply => v[0] * v[1],
            Self::Divide => v[0] / v[1],
            Self::Power => v[0].powf(v[1]),
            Self::Abs => v[0].abs(),
            Self::Sign => sign(v[0]),
            Self::Min => v[0].min(v[1]),
            Self::Max => v[0].max(v[1]),
            Self::Sqrt => v[0].sqrt(),
            Self::Cbrt => v[0].cbrt(),
            Self::Exp => v[0].exp(),
            Self::Ln => v[0].ln(),
            Self::Sin => v[0].sin(),
            Self::Cos => v[0].cos(),
            Self::Tan => v[0].tan(),
            Self::Atan2 => v[0].atan2(v[1]),
            Self::Tanh => v[0].tanh(),
            // As `f64::clamp`, but for bounds in the wrong order, which a fit may try.
            Self::Clamp => v[0].max(v[1]).min(v[2]),
            Self::Delay => v[0],
        }
    }
}

/// −1, 0 or 1, and not a number of what is none.
pub(crate) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_function_takes_as_many_values_as_it_says() {
        for (name, function) in Function::NAMED {
            assert_eq!(Function::named(name), Some(function));
            let value = function.apply(&[0.5, 0.25, 0.75][..function.arity()]);
            assert!(value.is_finite(), "{name}: {value}");
        }
        assert_eq!(Function::named("sinh"), None);
    }

    #[test]
    fn sign_is_zero_at_zero_alone() {
        assert_eq!((sign(-0.1), sign(0.0), sign(1e-300)), (-1.0, 0.0, 1.0));
        assert!(sign(f64::NAN).is_nan());
        assert_eq!(Function::Clamp.apply(&[2.0, 0.0, 1.0]), 1.0);
        assert_eq!(Function::Clamp.apply(&[2.0, 1.0, 0.0]), 0.0);
    }
}
