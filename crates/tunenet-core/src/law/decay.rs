//! A rival outside the table of shapes: a force that decays from a value of its own in each recording, which is a hidden state of first order.
//! It is compared with a law by the criterion of Akaike (1974) in the response linearised about the law (Ljung 1999, section 4.5). Along one
//! path height falls as time passes, so that a few recordings may agree with a law of height by chance.

use rayon::prelude::*;

use super::around::Around;
use super::linear::{Search, solved};
use super::price;
use super::refit::{Law, Session};
use super::response::{Column, Response};
use super::space::Nature;
use super::term::{Factor, Term};

/// Time constants, as shares of the clock's range.
const SHARES: [f64; 10] = [0.1, 0.15, 0.22, 0.33, 0.5, 0.75, 1.1, 1.7, 2.5, 4.0];
/// Rounds in which the values of the recordings and their common direction are fitted in turn.
const ROUNDS: usize = 4;

/// A force that decays: its factors with their constants inside.
struct Form {
    factors: Vec<Factor>,
    inner: Vec<f64>,
}

/// How far the best force that decays surpasses a law of one term by the criterion of Akaike, in twice the logarithmic likelihood. Its factor is
/// none, one of the law without the other, or another one of the table: what holds the law as a special case is tested by how recordings
/// agree. `None` without a clock, and where no acceleration can be added to the law.
pub(super) fn surpasses(session: &Session, near: &Around, law: &Law) -> Option<f64> {
    let [term] = law.terms.as_slice() else { return None };
    let space = session.host.space();
    let clock = space.variables.iter().position(|variable| variable.nature == Nature::Clock)?;
    let around = Around::law(session, near, law).ok()?;
    let response = &around.response;
    let search = Search::new(space, response);
    let numbers = &law.numbers()[0];
    let own = Column::sum(&search.columns(term, numbers), &numbers[..term.components])?;
    let squares = response.squares - 2.0 * own.dot(&response.left) + own.dot(&own);
    let times = response.variable(clock);
    let range = &response.ranges[clock];
    let of = |form: &Form| {
        let product = search.product(&form.factors, &form.inner);
        // A value for each recording, a direction, and the time constant.
        let chosen = response.parts.len() + term.components + price::chosen_inside(&form.factors);
        let price = price::AKAIKE * (chosen as f64 - price::chosen(&law.terms) as f64);
        let gained = SHARES.iter().filter_map(|share| {
            let time_constant_s = share * (range.high - range.low);
            let decaying = product.iter().zip(times).map(|(value, t)| value * (-t / time_constant_s).exp());
            let gain = gain(response, term, &decaying.collect::<Vec<_>>())?;
            Some(price::likelihood(response.count, squares, response.squares - gain) - price)
        });
        gained.reduce(f64::max)
    };
    forms(&search, term, numbers).par_iter().filter_map(of).reduce_with(f64::max)
}

/// The forms to compare with a term.
fn forms(search: &Search, term: &Term, numbers: &[f64]) -> Vec<Form> {
    let mut all = Vec::new();
    if !term.factors.is_empty() {
        all.push(Form { factors: Vec::new(), inner: Vec::new() });
    }
    if term.factors.len() > 1 {
        let each = term.factors.iter().zip(term.inner(numbers));
        all.extend(each.map(|(factor, inner)| Form { factors: vec![factor.clone()], inner: inner.to_vec() }));
    }
    let own = |factor: &Factor| term.factors.iter().any(|f| (f.shape, f.variable) == (factor.shape, factor.variable));
    for factor in search.factors.iter().filter(|factor| !own(factor)) {
        let grid = factor.grid(&search.response.ranges[factor.variable]);
        all.extend(grid.into_iter().map(|inner| Form { factors: vec![factor.clone()], inner }));
    }
    all
}

/// What such values gain along the directions of a term, with a size for each recording and one direction in common: alternating least squares
/// (Gabriel and Zamir 1979).
fn gain(response: &Response, term: &Term, values: &[f64]) -> Option<f64> {
    let columns = response.own_columns(term.direction, values);
    let (mut gain, mut numbers) = solved(&columns.iter().collect::<Vec<_>>(), &response.left)?;
    let components = term.components;
    if components == 1 {
        return Some(gain);
    }
    for _ in 0..ROUNDS {
        let mut direction = vec![0.0; components];
        for own in numbers.chunks_exact(components) {
            let along: f64 = own.iter().zip(&numbers).map(|(a, b)| a * b).sum();
            direction.iter_mut().zip(own).for_each(|(sum, a)| *sum += a * along.signum());
        }
        let each = columns.chunks_exact(components).map(|own| Column::sum(own, &direction));
        let each: Vec<Column> = each.collect::<Option<_>>()?;
        let (_, sizes) = solved(&each.iter().collect::<Vec<_>>(), &response.left)?;
        let component = |k: usize| {
            let each: Vec<Column> = columns.iter().skip(k).step_by(components).cloned().collect();
            Column::sum(&each, &sizes)
        };
        let along: Vec<Column> = (0..components).map(component).collect::<Option<_>>()?;
        let (found, direction) = solved(&along.iter().collect::<Vec<_>>(), &response.left)?;
        gain = found;
        numbers = sizes.iter().flat_map(|size| direction.iter().map(move |a| size * a)).collect();
    }
    Some(gain)
}
