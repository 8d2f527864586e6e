//! Comprehensive models (Atkinson 1970): where recordings span less than a decade of a variable, x^p and exp(-x/c), which fall with it, are
//! nearly x^n exp(-x/c) with a whole n; x^p and ln(1 + x/c), which rise slower than it, are nearly x/(1 + x/c) (Michaelis and Menten 1913).
//! A law of one factor of these shapes is therefore compared with the product.

use super::forms::is_same;
use super::refit::{Law, Session};
use super::response::Response;
use super::shape::{Range, Shape};
use super::term::{Factor, Term};

/// Exponents of a product.
const WHOLE: [f64; 3] = [-1.0, -2.0, -3.0];

/// Products that rise or fall as fast as a law of one factor in the middle of the data, and are as large there. A whole power stays as it is.
fn products(term: &Term, numbers: &[f64], ranges: &[Range]) -> Vec<(Term, Vec<f64>)> {
    let [factor] = term.factors.as_slice() else { return Vec::new() };
    let (coefficients, inner) = numbers.split_at(term.components);
    let Some(constant) = factor.rounded.or_else(|| inner.first().copied()) else { return Vec::new() };
    let range = &ranges[factor.variable];
    let middle = (range.low * range.high).sqrt();
    // The factor there, and its slope on logarithmic axes.
    let (value, slope) = match factor.shape {
        Shape::Power if factor.rounded.is_none_or(|p| p.fract() != 0.0) => (middle.powf(constant), constant),
        Shape::Exp => ((-middle / constant).exp(), -middle / constant),
        Shape::Log => {
            let (share, value) = (middle / constant, (middle / constant).ln_1p());
            (value, share / ((1.0 + share) * value))
        }
        _ => return Vec::new(),
    };
    let product = |shape: Shape, scale: f64, power: f64, there: f64| {
        let mut numbers: Vec<f64> = coefficients.iter().map(|c| c * value / there).collect();
        numbers.push(scale);
        let rounded = Factor { rounded: Some(power), ..Factor::new(Shape::Power, factor.variable) };
        let factors = vec![Factor::new(shape, factor.variable), rounded];
        (Term::new(term.direction, term.components, factors), numbers)
    };
    if slope > 0.0 && slope < 1.0 {
        return vec![product(Shape::Saturation, middle * slope / (1.0 - slope), 1.0, middle * slope)];
    }
    let falling = |n: f64| {
        let scale = middle / (n - slope);
        product(Shape::Exp, scale, n, middle.powf(n) * (-middle / scale).exp())
    };
    WHOLE.into_iter().filter(|n| *n > slope).map(falling).collect()
}

/// Fits of the products that are near one of `laws`, each form once.
pub(super) fn between(session: &Session, response: &Response, laws: &[Law]) -> Vec<Law> {
    let mut found: Vec<Law> = Vec::new();
    for law in laws {
        let [term] = law.terms.as_slice() else { continue };
        for (term, numbers) in products(term, &law.numbers()[0], &response.ranges) {
            let terms = [term];
            if laws.iter().chain(&found).any(|other| is_same(&other.terms, &terms)) {
                continue;
            }
            let fitted = session.on(response, &terms, &[numbers], law.fit.point.clone());
            found.extend(fitted.and_then(|law| session.finish(response, &law)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: Range = Range { low: 1.0, high: 4.0, least: 1.0, greatest: 4.0 };

    fn of(shape: Shape, rounded: Option<f64>, numbers: &[f64]) -> Vec<(Term, Vec<f64>)> {
        let factor = Factor { rounded, ..Factor::new(shape, 0) };
        products(&Term::new(0, 1, vec![factor]), numbers, &[RANGE])
    }

    /// In the middle, 2, 8 x^-1.5 falls as exp(-x/4)/x does, and 3 exp(-x/0.8) as exp(-x/4)/x² and exp(-3x/4)/x do.
    #[test]
    fn a_product_has_the_size_and_the_slope_of_the_law_in_the_middle() {
        let value = |n: f64, numbers: &[f64]| numbers[0] * 2.0_f64.powf(n) * (-2.0 / numbers[1]).exp();
        let found = of(Shape::Power, Some(-1.5), &[8.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0.factors[1].rounded, Some(-1.0));
        assert!((found[0].1[1] - 4.0).abs() < 1e-12, "{found:?}");
        assert!((value(-1.0, &found[0].1) - 8.0 * 2.0_f64.powf(-1.5)).abs() < 1e-12, "{found:?}");
        let found = of(Shape::Exp, None, &[3.0, 0.8]);
        let scales: Vec<f64> = found.iter().map(|(_, numbers)| numbers[1]).collect();
        assert!((scales[0] - 4.0 / 3.0).abs() < 1e-12 && (scales[1] - 4.0).abs() < 1e-12, "{scales:?}");
        assert!((value(-2.0, &found[1].1) - 3.0 * (-2.5_f64).exp()).abs() < 1e-12, "{found:?}");
    }

    /// In the middle, 2, 6 √x rises as x/(1 + x/2) does, and ln(1 + x/c) as fast as another.
    #[test]
    fn what_rises_slower_than_its_variable_is_compared_with_a_saturation() {
        let found = of(Shape::Power, Some(0.5), &[6.0]);
        assert_eq!((found.len(), found[0].0.factors[1].rounded), (1, Some(1.0)));
        let value = |x: f64| found[0].1[0] * x / (1.0 + x / found[0].1[1]);
        assert!((found[0].1[1] - 2.0).abs() < 1e-12 && (value(2.0) - 6.0 * 2.0_f64.sqrt()).abs() < 1e-12, "{found:?}");
        let found = of(Shape::Log, None, &[1.0, 0.7]);
        let (law, product) = (|x: f64| (x / 0.7).ln_1p(), |x: f64| found[0].1[0] * x / (1.0 + x / found[0].1[1]));
        for x in [2.0, 2.002] {
            assert!((law(x) - product(x)).abs() < 1e-6, "{found:?}");
        }
        assert!(of(Shape::Power, Some(1.5), &[1.0]).is_empty());
    }

    /// A whole power, and what rises or falls slower than 1/x, has no product of this kind; what falls far faster has those of all exponents.
    #[test]
    fn only_what_falls_faster_than_one_over_x_has_a_product() {
        assert!(of(Shape::Power, Some(-2.0), &[1.0]).is_empty());
        assert!(of(Shape::Power, Some(-0.5), &[1.0]).is_empty());
        assert!(of(Shape::Power, None, &[1.0, 1.6]).is_empty());
        assert!(of(Shape::Exp, None, &[1.0, 5.0]).is_empty());
        assert_eq!(of(Shape::Exp, None, &[1.0, 1e-3]).len(), WHOLE.len());
    }
}
