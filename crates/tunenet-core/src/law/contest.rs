//! Comparison of models of which none holds the other (Cox 1961), by the criterion of Schwarz in the response linearised about named effects
//! (Ljung 1999, section 4.5): whether a force of the table of shapes, a push at every contact, or a drift of the measurement explains
//! recordings as well in the place of an effect.

use super::around::Around;
use super::colour::Colour;
use super::drift::drifts;
use super::evidence::{Shared, residual_force};
use super::linear::{Candidate, Search, solved};
use super::pooled;
use super::price;
use super::refit::Session;
use super::response::{Column, INSTANTS, Response};
use super::space::{Host, Space, Visit};
use crate::Result;
use crate::estimate::jacobian::Columns;
use crate::estimate::{Point, RolloutLog};
use crate::simulator::{Effect, Prepared};
use crate::statistics::dot;

/// A force of which the named effects can do all but this share (of squares) is one of them in other words.
const SAME: f64 = 0.01;
/// A unit direction whose rest without one axis is shorter than this is along that axis.
const LEAST_REST: f64 = 1e-6;
/// Of so many of the best forces of one factor a second one is searched.
const PAIRED: usize = 3;

/// What forces and drifts say of effects that were named.
#[derive(Debug, Clone, PartialEq)]
pub struct Contest {
    /// The evidence for a force that they leave, in nats.
    pub left_force_nats: f64,
    /// How far the best force, push or drift in the place of one or of all of them surpasses them by the criterion of Schwarz, in twice the
    /// logarithmic likelihood; `None` where they have no coefficients to compare with.
    pub ahead: Option<f64>,
    /// How many of the effects have coefficients to compare with.
    pub compared: usize,
    /// Rollouts that this took.
    pub rollouts: usize,
}

/// Compares effects, whose coefficients are parameters of `host`, with every force of one factor, every push at contacts and every drift of
/// the measurement. A fit of all ended at `known`, if any did.
///
/// # Errors
/// Where the simulator refuses the recordings there.
pub fn contest(host: &dyn Host, effects: &[Effect], recordings: &[Prepared], known: Option<&Point>) -> Result<Contest> {
    let simulator = host.carrying(&[])?;
    linearised(host, recordings, known, |session, around, rollouts| {
        let left = session.cleaned(&session.base.residuals);
        let left_force_nats = residual_force(&around.response, &left, &around.columns, Shared::Free);
        let absent = |effect: &Effect, parameter: usize| {
            let name = &simulator.parameters()[parameter].name;
            let own = (0..effect.coefficients.len()).find(|&i| effect.parameter_name(i) == *name)?;
            Some((parameter, effect.coefficients[own].absent))
        };
        let of = |effect: &Effect| session.free.iter().filter_map(|&i| absent(effect, i)).collect::<Vec<_>>();
        let each: Vec<Vec<(usize, f64)>> = effects.iter().map(of).filter(|own| !own.is_empty()).collect();
        let all = (each.len() > 1).then(|| each.concat());
        let named = &around.response;
        let others = Others::new(host.space(), session, named, recordings);
        let ahead = each.iter().chain(&all).filter_map(|own| {
            let without = without(session, &around.columns, own, named);
            let gain = price::likelihood(session.count, without.squares, named.squares);
            others.best(&without, named).map(|other| other - price::bic(gain, session.count, own.len()))
        });
        Contest { left_force_nats, ahead: ahead.reduce(f64::max), compared: each.len(), rollouts }
    })
}

/// How much the best force of one factor, push at contacts or drift of the measurement explains that the simulation of `host` leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Strongest {
    /// What it gains by the criterion of Schwarz, in twice the logarithmic likelihood; `None` where nothing can be fitted.
    pub bic_gain: Option<f64>,
    /// Rollouts that this took.
    pub rollouts: usize,
}

/// The best of what no catalogue holds, for effects without coefficients that could be compared with it one by one: random effects, whose draws
/// take up what a force would explain. `host` simulates without them. A fit of all ended at `known`, if any did.
///
/// # Errors
/// Where the simulator refuses the recordings there.
pub fn strongest(host: &dyn Host, recordings: &[Prepared], known: Option<&Point>) -> Result<Strongest> {
    linearised(host, recordings, known, |session, around, rollouts| {
        let response = &around.response;
        let others = Others::new(host.space(), session, response, recordings);
        Strongest { bic_gain: others.best(response, response), rollouts }
    })
}

/// What `of` says of the fit of all recordings, in the colour of what it leaves, and of the response about it; its last argument counts rollouts.
fn linearised<T>(
    host: &dyn Host,
    recordings: &[Prepared],
    known: Option<&Point>,
    of: impl FnOnce(&Session, &Around, usize) -> T,
) -> Result<T> {
    let log = RolloutLog::default();
    let white = pooled(recordings, &[]);
    let first = match known {
        Some(known) => Session::again(host, recordings, (&white, Colour::WHITE, known), &log),
        None => Session::new(host, recordings, (&white, Colour::WHITE, None), &log, usize::MAX),
    }?;
    let colour = Colour::of(recordings, &first.base.residuals);
    let noise = colour.slow_noise(recordings, &white);
    let session = if colour.is_white() {
        first
    } else {
        Session::again(host, recordings, (&noise, colour, &first.base.point), &log)?
    };
    let around = Around::base(&session, &log)?;
    Ok(of(&session, &around, log.count()))
}

/// What is in no catalogue.
struct Others<'a> {
    space: &'a Space,
    /// A push at contacts, at every instant of the response.
    pushes: Vec<f64>,
    /// Drifts of the measurement, each as a change of every recording's predictions.
    drifts: Vec<Vec<Vec<f64>>>,
}

impl<'a> Others<'a> {
    fn new(space: &'a Space, session: &Session, response: &Response, recordings: &[Prepared]) -> Self {
        let drifts = drifts(recordings, session.noise, &session.base.residuals);
        Self { space, pushes: pushes(response, recordings), drifts }
    }

    /// What the best of a force, a push and a drift gains over `without` by the criterion of Schwarz, those aside that the effects of `named`
    /// can do.
    fn best(&self, without: &Response, named: &Response) -> Option<f64> {
        let each = [
            force(self.space, without, named),
            flattened(self.space, without, named),
            push(self.space, without, named, &self.pushes),
            drift(without, named, &self.drifts),
        ];
        each.into_iter().flatten().reduce(f64::max)
    }
}

/// The response where the parameters `own` have the values that mean "absent", and nothing else has moved.
fn without(session: &Session, columns: &[Columns], own: &[(usize, f64)], named: &Response) -> Response {
    let point = &session.base.point;
    let mut residuals = session.base.residuals.clone();
    let kept = columns.iter().zip(&mut residuals).map(|(one, left)| {
        let mut kept = Columns { indices: Vec::new(), shared: Vec::new(), nuisances: one.nuisances.clone() };
        for (index, column) in one.indices.iter().zip(&one.shared) {
            if let Some((_, absent)) = own.iter().find(|(parameter, _)| parameter == index) {
                let way = point.parameters[*index] - absent;
                left.iter_mut().zip(column).for_each(|(left, slope)| *left -= way * slope);
            } else {
                kept.indices.push(*index);
                kept.shared.push(column.clone());
            }
        }
        kept
    });
    let kept: Vec<Columns> = kept.collect();
    named.leaving(residuals, &kept)
}

/// Whether a change, as it is next to the effects of a simulation and without them, is one that these can make.
fn is_known(without: &Column, named: &Column) -> bool {
    named.dot(named) <= SAME * without.dot(without)
}

/// What the best force of one factor gains by the criterion of Schwarz, those aside that the effects of `named` can do. Of two forces, as of a
/// wind that turns about a place, the bits that chose the second count as well.
fn force(space: &Space, without: &Response, named: &Response) -> Option<f64> {
    let (search, known) = (Search::new(space, without), Search::new(space, named));
    // What these forces change together, and whether the named effects can.
    let is_other = |forces: &[&Candidate]| {
        let of = |search: &Search| -> Vec<Column> {
            forces.iter().flat_map(|force| search.columns(&force.terms[0], &force.numbers[0])).collect()
        };
        let columns = of(&search);
        let all: Vec<&Column> = columns.iter().collect();
        let sizes = solved(&all, &without.left).map(|(_, sizes)| sizes);
        let sum = |columns: &[Column]| Column::sum(columns, sizes.as_ref()?);
        sum(&columns).zip(sum(&of(&known))).is_some_and(|(without, named)| !is_known(&without, &named))
    };
    let bic = |force: &Candidate| force.score - price::score(0.0, price::bits(space, search.kinds, &force.terms));
    let singles = search.singles();
    let best = singles.iter().filter(|force| is_other(&[force])).map(bic).reduce(f64::max);
    let pairs = singles.iter().take(PAIRED).filter_map(|first| {
        let mut search = Search::new(space, without);
        search.known = search.columns(&first.terms[0], &first.numbers[0]);
        let second = search.singles().into_iter().next()?;
        is_other(&[first, &second]).then(|| second.score - price::numbers(without.count, &first.terms))
    });
    pairs.chain(best).reduce(f64::max)
}

/// The same of the best force of constant size along the rest of a direction that lacks one axis, as of a brake that acts along the floor.
fn flattened(space: &Space, without: &Response, named: &Response) -> Option<f64> {
    let is_axis = |direction: &usize| space.axes.contains(direction);
    let is_single = |direction: &usize| space.directions[*direction].components.len() == 1;
    let directions = (0..space.directions.len()).filter(|one| !is_axis(one) && is_single(one));
    let rests = directions.flat_map(|direction| (0..space.axes.len()).map(move |lacking| (direction, lacking)));
    let each = rests.filter_map(|(direction, lacking)| {
        let along = |visit: &Visit| {
            let mut rest = visit.components[direction][0].clone();
            rest[lacking] = 0.0;
            let length = dot(&rest, &rest).sqrt();
            // A direction along the axis it lacks has no rest.
            if length > LEAST_REST { rest.iter().map(|one| one / length).collect() } else { vec![0.0; rest.len()] }
        };
        let column = without.accelerated(along);
        let (gain, _) = solved(&[&column], &without.left)?;
        let likelihood = price::likelihood(without.count, without.squares, without.squares - gain);
        (!is_known(&column, &named.accelerated(along))).then(|| price::bic(likelihood, without.count, 1))
    });
    each.reduce(f64::max)
}

/// The same of the best push that acts for a moment at every contact, as of a floor that moves along.
fn push(space: &Space, without: &Response, named: &Response, pushes: &[f64]) -> Option<f64> {
    let each = (0..space.directions.len()).filter_map(|direction| {
        let columns = without.columns(direction, pushes);
        let (gain, sizes) = solved(&columns.iter().collect::<Vec<_>>(), &without.left)?;
        let sum = Column::sum(&columns, &sizes)?;
        let known = is_known(&sum, &Column::sum(&named.columns(direction, pushes), &sizes)?);
        let likelihood = price::likelihood(without.count, without.squares, without.squares - gain);
        (!known).then(|| price::bic(likelihood, without.count, sizes.len()))
    });
    each.reduce(f64::max)
}

/// The same of the best drift of the measurement.
fn drift(without: &Response, named: &Response, drifts: &[Vec<Vec<f64>>]) -> Option<f64> {
    let each = drifts.iter().filter_map(|change| {
        let column = without.changed(change);
        let (gain, sizes) = solved(&[&column], &without.whole)?;
        let likelihood = price::likelihood(without.count, without.squares, without.squares - gain);
        (!is_known(&column, &named.changed(change))).then(|| price::bic(likelihood, without.count, sizes.len()))
    });
    each.reduce(f64::max)
}

/// At every instant of the response 1 where the piece of it in which a recording has an event lasts, and else 0.
fn pushes(response: &Response, recordings: &[Prepared]) -> Vec<f64> {
    let each = response.parts.iter().zip(recordings).flat_map(|(part, recording)| {
        let clock = recording.seen.clock();
        let pieces = part.visits.len();
        let (first, span_s) = (clock[0], (clock[clock.len() - 1] - clock[0]) / pieces as f64);
        let in_piece = |piece: usize| {
            let begin = first + span_s * piece as f64;
            f64::from(u8::from(recording.events.iter().any(|event| (begin..begin + span_s).contains(event))))
        };
        (0..pieces).flat_map(move |piece| std::iter::repeat_n(in_piece(piece), INSTANTS)).collect::<Vec<f64>>()
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::super::shape::{Range, Shape};
    use super::super::space::{Carried, Visiting};
    use super::super::term::{Factor, Term};
    use super::super::tests::line::{Line, observed};
    use super::*;
    use crate::simulator::{Preparation, Simulator};

    const GRAVITY_M_S2: f64 = 9.8;

    /// A point that falls with a resistance in proportion to its velocity.
    struct Resisted {
        line: Line,
        resistance: Carried,
    }

    impl Resisted {
        fn new() -> Self {
            let line = Line::new();
            let velocity = Factor { shape: Shape::OddPower, variable: 1, rounded: Some(1.0) };
            let range = || Range { low: -20.0, high: 20.0, least: -20.0, greatest: 20.0 };
            let term = Term::new(0, 1, vec![velocity]);
            let resistance = term.carried(&line, &[range(), range(), range()], 0, 10.0);
            Self { line, resistance }
        }
    }

    impl Host for Resisted {
        fn space(&self) -> &Space {
            self.line.space()
        }

        fn carrying(&self, terms: &[Carried]) -> Result<Box<dyn Visiting>> {
            self.line.carrying(&[std::slice::from_ref(&self.resistance), terms].concat())
        }

        fn unit(&self, direction: usize, powers: &[(usize, f64)]) -> String {
            self.line.unit(direction, powers)
        }
    }

    fn contest_of(path_m: &dyn Fn(f64, f64) -> f64) -> Contest {
        let host = Resisted::new();
        let simulator = host.carrying(&[]).unwrap();
        let one =
            |(v0, seed): (f64, u64)| match simulator.prepare(&observed(1.5, 1e-3, seed, &|t| path_m(v0, t))).unwrap() {
                Preparation::Usable(prepared) => *prepared,
                Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
            };
        let recordings: Vec<Prepared> = [(-0.5, 3), (2.0, 4), (-3.0, 5)].into_iter().map(one).collect();
        contest(&host, std::slice::from_ref(&host.resistance.effect), &recordings, None).unwrap()
    }

    /// x(t) = (v0 + g/b)(1 − e^(−bt))/b − g t/b.
    #[test]
    fn a_true_effect_stays_ahead_of_every_other_force() {
        let b = 0.4;
        let fall = GRAVITY_M_S2 / b;
        let found = contest_of(&|v0, t| (v0 + fall) * (1.0 - (-b * t).exp()) / b - fall * t);
        assert!(found.ahead.is_some_and(|ahead| ahead < 0.0) && found.compared == 1, "{found:?}");
        assert!(found.left_force_nats < 1.0 && found.rollouts < 500, "{found:?}");
    }

    /// A pure fall, and x(t) = v0 t − g t²/2 + a(1 − cos ωt)/ω² of a force a cos ωt.
    #[test]
    fn a_force_that_is_left_out_explains_much_and_noise_little() {
        let strongest_of = |path_m: &dyn Fn(f64) -> f64| {
            let host = Line::new();
            let prepared = |seed: u64| match host.simulator().prepare(&observed(1.5, 1e-3, seed, path_m)).unwrap() {
                Preparation::Usable(prepared) => *prepared,
                Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
            };
            let recordings: Vec<Prepared> = [3, 4, 5].into_iter().map(prepared).collect();
            strongest(&host, &recordings, None).unwrap()
        };
        let fall = |t: f64| 2.0 * t - 0.5 * GRAVITY_M_S2 * t * t;
        let noise = strongest_of(&fall);
        assert!(noise.bic_gain.is_some_and(|gain| gain < 6.0) && noise.rollouts < 500, "{noise:?}");
        let forced = strongest_of(&|t| fall(t) + 0.5 * (1.0 - (3.0 * t).cos()) / 9.0);
        assert!(forced.bic_gain.is_some_and(|gain| gain > 100.0), "{forced:?}");
    }

    /// A spring to the start: x(t) = (v0/ω) sin ωt − (g/ω²)(1 − cos ωt).
    #[test]
    fn a_wrong_effect_falls_behind_or_leaves_a_force() {
        let frequency = 1.2_f64;
        let found = contest_of(&|v0, t| {
            let turned = frequency * t;
            v0 / frequency * turned.sin() - GRAVITY_M_S2 / frequency.powi(2) * (1.0 - turned.cos())
        });
        assert!(found.ahead.is_some_and(|ahead| ahead > 100.0), "{found:?}");
    }

    /// x(t) = (v0 t − g t²/2)(1 + k t).
    #[test]
    fn a_scale_that_drifts_surpasses_a_wrong_effect() {
        let found = contest_of(&|v0, t| (v0 * t - 0.5 * GRAVITY_M_S2 * t * t) * (1.0 + 0.02 * t));
        assert!(found.ahead.is_some_and(|ahead| ahead > 0.0), "{found:?}");
    }

    #[test]
    fn a_push_acts_in_the_piece_that_holds_an_event() {
        let host = Line::new();
        let Preparation::Usable(mut prepared) =
            host.simulator().prepare(&observed(1.5, 1e-3, 7, &|t| -4.9 * t * t)).unwrap()
        else {
            panic!("refused")
        };
        prepared.events = vec![0.75];
        let recordings = [*prepared];
        let log = RolloutLog::default();
        let white = pooled(&recordings, &[]);
        let session = Session::new(&host, &recordings, (&white, Colour::WHITE, None), &log, usize::MAX).unwrap();
        let response = Around::base(&session, &log).unwrap().response;
        let pushes = pushes(&response, &recordings);
        assert_eq!(pushes.len(), response.instants());
        let middle = pushes.iter().position(|push| *push > 0.0).unwrap();
        assert_eq!(pushes.iter().sum::<f64>(), INSTANTS as f64);
        let share = middle as f64 / pushes.len() as f64;
        assert!((share - 0.5).abs() <= 1.0 / 40.0, "{share}");
    }
}
