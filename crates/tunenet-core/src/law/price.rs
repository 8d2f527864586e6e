//! Price of a law: Bayesian information criterion (Schwarz 1978) and the length of its description (Rissanen 1978).

use std::f64::consts::LN_2;

use super::space::Space;
use super::term::Term;

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

/// Bits that say which terms these are, of so many factors that there are.
pub(super) fn bits(space: &Space, factors: usize, terms: &[Term]) -> f64 {
    let one = |term: &Term| {
        let each = term.factors.iter().map(|factor| {
            let rounded = factor.rounded.map_or(0.0, |p| if p.fract() == 0.0 { WHOLE_BITS } else { HALF_BITS });
            (factors.max(1) as f64).log2() + rounded
        });
        (space.directions.len() as f64).log2() + FACTORS_BITS + each.sum::<f64>()
    };
    terms.iter().map(one).sum()
}

/// The gain of the information criterion over none.
pub(super) fn bic(gain: f64, count: usize, constants: usize) -> f64 {
    gain - constants as f64 * (count as f64).ln()
}

/// The score by which laws are ranked.
pub(super) fn score(bic: f64, bits: f64) -> f64 {
    bic - 2.0 * LN_2 * bits
}
