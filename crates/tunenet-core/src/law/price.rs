//! Price of a law: Bayesian information criterion (Schwarz 1978) and the length of its description (Rissanen 1978).

use std::f64::consts::LN_2;

use super::space::Space;
use super::term::{Factor, Term};

/// How much wider than their standard deviations intervals are: what the choice of the form adds, as measured on known laws.
pub(super) const WIDER: f64 = 1.07;

/// The price of a number by the criterion of Akaike, in twice the logarithmic likelihood.
pub(super) const AKAIKE: f64 = 2.0;

/// Bits of how many factors a term has: none, one or two.
const FACTORS_BITS: f64 = 1.584_962_500_721_156;
/// Bits of an exponent that is a whole number, and of one that is a half.
const WHOLE_BITS: f64 = 3.0;
const HALF_BITS: f64 = 4.5;

/// Twice the gain in logarithmic likelihood of `count` values with unknown noise.
pub(super) fn likelihood(count: usize, before: f64, after: f64) -> f64 {
    count as f64 * (before.max(f64::MIN_POSITIVE) / after.max(f64::MIN_POSITIVE)).ln()
}

/// How many numbers of these terms are fitted.
pub(super) fn constants(terms: &[Term]) -> usize {
    terms.iter().map(Term::constants).sum()
}

/// How many numbers of these terms the data chose: constants, and exponents that were rounded.
pub(super) fn chosen(terms: &[Term]) -> usize {
    terms.iter().map(|term| term.components + chosen_inside(&term.factors)).sum()
}

/// The same inside factors.
pub(super) fn chosen_inside(factors: &[Factor]) -> usize {
    factors.iter().map(|factor| factor.constants() + usize::from(factor.rounded.is_some())).sum()
}

/// Bits that say which terms these are, of so many factors that there are.
pub(super) fn bits(space: &Space, factors: usize, terms: &[Term]) -> f64 {
    let one = |term: &Term| {
        let each = term.factors.len() as f64 * (factors.max(1) as f64).log2();
        (space.directions.len() as f64).log2() + FACTORS_BITS + each
    };
    terms.iter().map(one).sum()
}

/// What the numbers of these terms cost: the information criterion of those that are fitted, and the bits of those that were rounded,
/// which the data chose as well.
pub(super) fn numbers(count: usize, terms: &[Term]) -> f64 {
    let rounded = terms.iter().flat_map(|term| &term.factors).filter_map(|factor| factor.rounded);
    let bits: f64 = rounded.map(|p| if p.fract() == 0.0 { WHOLE_BITS } else { HALF_BITS }).sum();
    constants(terms) as f64 * (count as f64).ln() + 2.0 * LN_2 * bits
}

/// The gain of the information criterion over none, so many constants being fitted.
pub(super) fn bic(gain: f64, count: usize, constants: usize) -> f64 {
    gain - constants as f64 * (count as f64).ln()
}

/// The score by which laws are ranked.
pub(super) fn score(bic: f64, bits: f64) -> f64 {
    bic - 2.0 * LN_2 * bits
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::*;

    /// A whole exponent costs 3 bits, a half one 4.5, an open one ln n; the coefficient ln n in any case.
    #[test]
    fn rounded_exponents_cost_their_bits() {
        let of = |rounded| {
            let factor = Factor { shape: Shape::Power, variable: 0, rounded };
            numbers(1000, &[Term::new(0, 1, vec![factor])]) - 1000.0_f64.ln()
        };
        assert!((of(Some(2.0)) - 8.0_f64.ln() * 2.0).abs() < 1e-12);
        assert!((of(Some(1.5)) - 9.0 * LN_2).abs() < 1e-12);
        assert!((of(None) - 1000.0_f64.ln()).abs() < 1e-12);
    }
}
