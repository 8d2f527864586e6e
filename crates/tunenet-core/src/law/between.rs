//! Comprehensive models (Atkinson 1970): where recordings do not distinguish a power of a variable from an exponential of it, a product of
//! both lies between them and explains as much.

use super::forms::is_same;
use super::refit::{Law, Session};
use super::response::Response;
use super::shape::Shape;
use super::term::{Factor, Term};
use crate::estimate::Point;

/// A law `a * x^p` or `a * exp(-x/c)`: its coefficients and its constant, and where its fit ended.
struct Single<'a> {
    point: &'a Point,
    term: &'a Term,
    coefficients: Vec<f64>,
    constant: f64,
}

/// Of these laws, those of one factor of this shape.
fn singles(laws: &[Law], shape: Shape) -> impl Iterator<Item = Single<'_>> {
    laws.iter().filter_map(move |law| {
        let [term] = law.terms.as_slice() else { return None };
        let [factor] = term.factors.as_slice() else { return None };
        let numbers = law.numbers().swap_remove(0);
        let (coefficients, inner) = numbers.split_at(term.components);
        let constant = factor.rounded.or_else(|| inner.first().copied())?;
        (factor.shape == shape).then(|| Single {
            point: &law.fit.point,
            term,
            coefficients: coefficients.to_vec(),
            constant,
        })
    })
}

/// Whole exponents between 0 and `p`, without both.
fn between_zero_and(p: f64) -> impl Iterator<Item = f64> {
    (1_i8..).map(f64::from).take_while(move |n| *n < p.abs()).map(move |n| n * p.signum())
}

/// `x^n exp(-x/c)` for every whole n, with the numbers of a geometric mean of the power and of the exponential.
fn means(power: &Single, exponential: &Single) -> Vec<(Term, Vec<f64>)> {
    let (p, c) = (power.constant, exponential.constant);
    let variable = power.term.factors[0].variable;
    let alike = power.term.direction == exponential.term.direction
        && variable == exponential.term.factors[0].variable
        && power.coefficients.iter().zip(&exponential.coefficients).all(|(a, b)| a * b > 0.0);
    let mean = |n: f64| {
        let share = n / p;
        let each = power.coefficients.iter().zip(&exponential.coefficients);
        let mut numbers: Vec<f64> =
            each.map(|(a, b)| a.abs().powf(share) * b.abs().powf(1.0 - share) * a.signum()).collect();
        numbers.push(c / (1.0 - share));
        let rounded = Factor { rounded: Some(n), ..Factor::new(Shape::Power, variable) };
        let factors = vec![Factor::new(Shape::Exp, variable), rounded];
        (Term::new(power.term.direction, power.term.components, factors), numbers)
    };
    if alike { between_zero_and(p).map(mean).collect() } else { Vec::new() }
}

/// Fits of the products that lie between a power and an exponential among `laws`.
pub(super) fn between(session: &Session, response: &Response, laws: &[Law]) -> Vec<Law> {
    let mut found = Vec::new();
    for exponential in singles(laws, Shape::Exp) {
        for power in singles(laws, Shape::Power) {
            for (term, numbers) in means(&power, &exponential) {
                let terms = [term];
                if laws.iter().any(|law| is_same(&law.terms, &terms)) {
                    continue;
                }
                let fitted = session.on(response, &terms, &[numbers], exponential.point.clone());
                found.extend(fitted.and_then(|law| session.finish(response, &law)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between 8/x² and 2 exp(-x/3) the geometric mean is 4 exp(-x/6)/x; between 8/x and it nothing is whole.
    #[test]
    fn a_product_is_the_geometric_mean_of_a_power_and_an_exponential() {
        let point = || Point { parameters: Vec::new(), nuisances: Vec::new() };
        let factor = |shape, rounded| Factor { rounded, ..Factor::new(shape, 0) };
        let (inverse, square) = (factor(Shape::Power, Some(-1.0)), factor(Shape::Power, Some(-2.0)));
        let term = |factor| Term::new(0, 1, vec![factor]);
        let exponential = term(factor(Shape::Exp, None));
        let found = |power: &Term, a: f64| {
            let constant = power.factors[0].rounded.unwrap();
            let power = Single { point: &point(), term: power, coefficients: vec![a], constant };
            let exponential = Single { point: &point(), term: &exponential, coefficients: vec![2.0], constant: 3.0 };
            means(&power, &exponential)
        };
        let all = found(&term(square), 8.0);
        assert_eq!(all.len(), 1);
        let (product, numbers) = &all[0];
        assert_eq!(product.factors, [factor(Shape::Exp, None), inverse.clone()]);
        assert!((numbers[0] - 4.0).abs() < 1e-12 && (numbers[1] - 6.0).abs() < 1e-12, "{numbers:?}");
        assert!(found(&term(inverse), 8.0).is_empty());
        assert!(found(&term(factor(Shape::Power, Some(-2.0))), -8.0).is_empty());
    }
}
