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

/// What a decay multiplies: factors with their constants inside.
struct Amplitude {
    factors: Vec<Factor>,
    inner: Vec<f64>,
}

impl Amplitude {
    const CONSTANT: Self = Self { factors: Vec::new(), inner: Vec::new() };
}

/// How far the best force that decays surpasses a law of one term by the criterion of Akaike, in twice the logarithmic likelihood. Its factor is
/// none, one of the law without the other, or another one of the table: what holds the law as a special case is tested by how recordings
/// agree. `None` without a clock, and where no acceleration can be added to the law.
pub(super) fn surpasses(session: &Session, near: &Around, law: &Law) -> Option<f64> {
    let [term] = law.terms.as_slice() else { return None };
    let around = Around::law(session, near, law).ok()?;
    let rivals = Rivals::new(session, &around.response, law)?;
    let own = price::AKAIKE * price::chosen(&law.terms) as f64;
    let others = rivals.others(term, &law.numbers()[0]);
    others.par_iter().filter_map(|form| rivals.best(term, form, price::AKAIKE)).reduce_with(f64::max).map(|by| by + own)
}

/// What the best force that decays, in any direction, gains by the criterion of Schwarz over the simulation without a law: effects of the
/// catalogue were known before the data were seen. It is measured about a law that explains the recordings.
pub(super) fn bic_gain(session: &Session, near: &Around, law: &Law) -> Option<f64> {
    let around = Around::law(session, near, law).ok()?;
    let rivals = Rivals::new(session, &around.response, law)?;
    let space = session.host.space();
    let number = (around.response.count as f64).ln();
    let forms: Vec<Amplitude> = std::iter::once(Amplitude::CONSTANT).chain(rivals.table(&[])).collect();
    let along = |direction: usize| Term::new(direction, space.directions[direction].components.len(), Vec::new());
    let each = (0..space.directions.len()).into_par_iter().flat_map(|direction| {
        let term = along(direction);
        forms.par_iter().filter_map(|form| rivals.best(&term, form, number)).collect::<Vec<_>>()
    });
    each.reduce_with(f64::max).map(|over| over + session.gain(law))
}

/// Forces that decay, next to a law.
struct Rivals<'a> {
    search: Search<'a>,
    /// The sum of squares that the law leaves.
    squares: f64,
    /// For each time constant, the decay at every instant.
    decays: Vec<Vec<f64>>,
}

impl<'a> Rivals<'a> {
    fn new(session: &'a Session, response: &'a Response, law: &Law) -> Option<Self> {
        let space = session.host.space();
        let clock = space.variables.iter().position(|variable| variable.nature == Nature::Clock)?;
        let search = Search::new(space, response);
        let numbers = law.numbers();
        let terms = law.terms.iter().zip(&numbers);
        let columns = terms.map(|(term, own)| Column::sum(&search.columns(term, own), &own[..term.components]));
        let columns: Vec<Column> = columns.collect::<Option<_>>()?;
        let own = Column::sum(&columns, &vec![1.0; columns.len()])?;
        let squares = response.squares - 2.0 * own.dot(&response.left) + own.dot(&own);
        let range = &response.ranges[clock];
        let decay = |share: &f64| {
            let time_constant_s = share * (range.high - range.low);
            response.variable(clock).iter().map(|t| (-t / time_constant_s).exp()).collect()
        };
        let decays = SHARES.iter().map(decay).collect();
        Some(Self { search, squares, decays })
    }

    /// How far a form in the direction of a term surpasses the law at its best time constant, in twice the logarithmic likelihood less the
    /// price of its own numbers: a value for each recording, a direction, the time constant, and what is inside its factors.
    fn best(&self, term: &Term, form: &Amplitude, number: f64) -> Option<f64> {
        let response = self.search.response;
        let product = self.search.product(&form.factors, &form.inner);
        let chosen = response.parts.len() + term.components + price::chosen_inside(&form.factors);
        let gained = self.decays.iter().filter_map(|decay| {
            let decaying: Vec<f64> = product.iter().zip(decay).map(|(value, share)| value * share).collect();
            let gain = gain(response, term, &decaying)?;
            Some(price::likelihood(response.count, self.squares, response.squares - gain))
        });
        gained.reduce(f64::max).map(|most| most - number * chosen as f64)
    }

    /// The forms to compare with a term.
    fn others(&self, term: &Term, numbers: &[f64]) -> Vec<Amplitude> {
        let mut all = Vec::new();
        if !term.factors.is_empty() {
            all.push(Amplitude::CONSTANT);
        }
        if term.factors.len() > 1 {
            let each = term.factors.iter().zip(term.inner(numbers));
            all.extend(each.map(|(factor, inner)| Amplitude { factors: vec![factor.clone()], inner: inner.to_vec() }));
        }
        all.extend(self.table(&term.factors));
        all
    }

    /// A form for each factor of the table but these, with every constant of its grid.
    fn table(&self, but: &[Factor]) -> Vec<Amplitude> {
        let own = |factor: &&Factor| but.iter().any(|f| (f.shape, f.variable) == (factor.shape, factor.variable));
        let others = self.search.factors.iter().filter(|factor| !own(factor));
        let each = others.flat_map(|factor| {
            let grid = factor.grid(&self.search.response.ranges[factor.variable]);
            grid.into_iter().map(|inner| Amplitude { factors: vec![factor.clone()], inner })
        });
        each.collect()
    }
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
