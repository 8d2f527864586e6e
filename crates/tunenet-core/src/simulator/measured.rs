//! A simulator as a camera and its clock see it.

use super::effects::{Act, MeasurementEffect, find};
use super::{
    Assumed, Effect, Parameter, Preparation, Prepared, ProposedStart, RolloutError, RolloutResult, Segmented,
    Simulator, measurement_effects,
};
use crate::observation::{Channel, Circumstances, Kind, Observation};
use crate::{Error, Origin, Result};

/// Rounds of the fixed point `t = stamp + delay(z(t))`. Each gains a factor of delay times speed, at most a tenth or so.
const READOUT_ROUNDS: usize = 4;
/// Parts of an exposure, each of which is averaged by Gauss and Legendre's rule of two nodes: exact up to the third power,
/// and where a path kinks within an exposure, only the part that holds the kink errs (by less than a thousandth of the
/// change of speed times the exposure).
const EXPOSURE_PARTS: usize = 8;
/// The two nodes of a part, as shares of it.
const IN_PART: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// `inner`, seen through effects of the measurement (see [`measurement_effects`]).
///
/// A rollout asks the inner simulator at the true instants behind the stamps, and turns what it answers into what is
/// observed. Effects act in the order of the catalogue: the clock, the exposure and the shutter decide the instants;
/// tilt, perspective, lens, aspect and scale change the values. With every effect absent it is `inner`, bit for bit, and as
/// fast.
///
/// Parameters are those of `inner`, then the coefficients of the effects that are free. Effects that are fixed (as those
/// of a file are) have no parameters.
///
/// A simulator that starts at the first instant it is asked for, because a recording's start is a nuisance parameter,
/// starts at the first *true* instant here. So an offset of the clock changes nothing there, as it should, and every
/// other effect leaves the meaning of the start alone, up to half an exposure.
#[derive(Debug, Clone)]
pub struct Measured<S> {
    inner: S,
    fixed: Vec<(usize, &'static MeasurementEffect, Vec<f64>)>,
    free: Vec<(usize, &'static MeasurementEffect)>,
    parameters: Vec<Parameter>,
}

/// Nodes and weights of the mean over −½ to ½.
fn exposure_nodes() -> Vec<(f64, f64)> {
    let parts = EXPOSURE_PARTS as f64;
    let node = |part: usize, share: f64| ((part as f64 + share) / parts - 0.5, 0.5 / parts);
    (0..EXPOSURE_PARTS).flat_map(|part| IN_PART.map(|share| node(part, share))).collect()
}

/// What acts in one rollout: its place in the order of action, the effect, its coefficients.
type Active<'a> = (usize, &'static MeasurementEffect, &'a [f64]);

impl<S: Simulator> Measured<S> {
    /// `inner` with the coefficients of these effects as further parameters, at their absent values and free to tune.
    ///
    /// ```
    /// # use tunenet_core::{observation::{Channel, Observation, Kind}, simulator::{Measured, Parameter, RolloutResult, Simulator, rollout}};
    /// struct Fall(Vec<Parameter>, Vec<Channel>);
    /// impl Simulator for Fall {
    ///     fn parameters(&self) -> &[Parameter] { &self.0 }
    ///     fn channels(&self) -> &[Channel] { &self.1 }
    ///     fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
    ///         clock.iter().zip(values).for_each(|(t, v)| *v = -0.5 * p[0] * t * t);
    ///         Ok(())
    ///     }
    /// }
    /// let fall = Fall(vec![Parameter::new("gravity", "m/s²", 10.0, 0.0, 20.0)?], vec![Channel::new("z", "m")]);
    /// let seen = Measured::new(&fall, &["time_scale", "length_scale"])?;
    /// assert_eq!(seen.parameters()[1].name, "time_scale.factor");
    /// // One second of a clock that runs at double speed is half a second.
    /// assert_eq!(rollout(&seen, &[10.0, 2.0, 1.1], &[], &[1.0])?, [-1.25 * 1.1]);
    /// # Ok::<(), tunenet_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Setting`] where one of `names` is no effect that observations of this kind can show, or stands there twice.
    pub fn new(inner: S, names: &[&str]) -> Result<Self> {
        Self { parameters: inner.parameters().to_vec(), inner, fixed: Vec::new(), free: Vec::new() }.freed(names)
    }

    /// The same with one more effect, at these values in the order of its coefficients.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Parameter`] where a value lies outside its bounds.
    pub fn fixed(mut self, name: &str, values: &[f64]) -> Result<Self> {
        let (place, effect) = self.unused(name)?;
        effect.entry().parameters(Some(values))?;
        self.fixed.push((place, effect, values.to_vec()));
        self.fixed.sort_by_key(|(place, ..)| *place);
        Ok(self)
    }

    fn freed(mut self, names: &[&str]) -> Result<Self> {
        for name in names {
            let at = self.fixed.iter().position(|(_, e, _)| e.name == *name);
            let present = at.map(|i| self.fixed.remove(i).2);
            let (place, effect) = self.unused(name)?;
            self.parameters.extend(effect.entry().parameters(present.as_deref())?);
            self.free.push((place, effect));
        }
        Ok(self)
    }

    /// The effect of this name, if it is not there already.
    fn unused(&self, name: &str) -> Result<(usize, &'static MeasurementEffect)> {
        let refuse = |expected: String| Error::Setting {
            origin: Origin::Caller,
            name: "effects",
            expected,
            found: format!("`{name}`"),
        };
        let kind = self.inner.kind();
        let known = || measurement_effects(kind).into_iter().map(|e| e.name).collect::<Vec<_>>().join(", ");
        let found =
            find(name, kind).ok_or_else(|| refuse(format!("an effect that {} can show ({})", kind.name(), known())))?;
        if self.has(name) {
            return Err(refuse("each effect once".into()));
        }
        Ok(found)
    }

    /// Another simulator with the same parameters, seen as this one is.
    fn around(&self, inner: Box<dyn Simulator>) -> Box<dyn Simulator> {
        let (fixed, free, parameters) = (self.fixed.clone(), self.free.clone(), self.parameters.clone());
        Box::new(Measured { inner, fixed, free, parameters })
    }

    fn has(&self, name: &str) -> bool {
        self.fixed.iter().any(|(_, e, _)| e.name == name) || self.free.iter().any(|(_, e)| e.name == name)
    }

    /// What acts with these coefficients of the free effects.
    fn active<'a>(&'a self, mut coefficients: &'a [f64]) -> std::result::Result<Vec<Active<'a>>, String> {
        let mut active: Vec<_> = self.fixed.iter().map(|(place, e, values)| (*place, *e, values.as_slice())).collect();
        for (place, effect) in &self.free {
            let (values, rest) = coefficients.split_at(effect.coefficients.len());
            coefficients = rest;
            for (c, value) in effect.coefficients.iter().zip(values) {
                if !(c.min..=c.max).contains(value) {
                    let (name, key, min, max) = (effect.name, &c.key, c.min, c.max);
                    return Err(format!("`{name}.{key}` is {value}, but has to lie within {min} and {max}"));
                }
            }
            active.push((*place, effect, values));
        }
        active.retain(|(_, effect, values)| !effect.is_absent(values));
        active.sort_by_key(|(place, ..)| *place);
        Ok(active)
    }

    /// One rollout of the inner simulator.
    fn run(
        &self,
        p: &[f64],
        nuisances: &[f64],
        circumstances: Option<&Circumstances>,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        match circumstances {
            Some(known) => self.inner.rollout_driven(p, nuisances, known, clock, values),
            None => self.inner.rollout(p, nuisances, clock, values),
        }
    }

    /// Asks the inner simulator at instants in any order; values row-major `[instant, channel]`.
    fn ask(
        &self,
        p: &[f64],
        nuisances: &[f64],
        circumstances: Option<&Circumstances>,
        instants: &[f64],
    ) -> std::result::Result<Vec<f64>, RolloutError> {
        let width = self.channels().len();
        let mut values = vec![0.0; instants.len() * width];
        if instants.is_sorted() {
            self.run(p, nuisances, circumstances, instants, &mut values)?;
            return Ok(values);
        }
        let mut order: Vec<usize> = (0..instants.len()).collect();
        order.sort_by(|&a, &b| instants[a].total_cmp(&instants[b]));
        let rising: Vec<f64> = order.iter().map(|&i| instants[i]).collect();
        let mut sorted = values.clone();
        self.run(p, nuisances, circumstances, &rising, &mut sorted)?;
        for (row, &i) in sorted.chunks_exact(width).zip(&order) {
            values[i * width..(i + 1) * width].copy_from_slice(row);
        }
        Ok(values)
    }

    /// What is observed of values on these channels.
    fn seen(&self, active: &[Active], row: &mut [f64]) -> RolloutResult {
        for (_, effect, c) in active {
            match effect.act {
                Act::Point(map) => {
                    let point = [row[0], row[1], row[2]];
                    let Some(moved) = map(point, c) else {
                        let refused = format!("`{}` of {c:?} puts the point {point:?} behind the camera", effect.name);
                        return Err(refused.into());
                    };
                    row.copy_from_slice(&moved);
                }
                Act::Length(map) => {
                    let lengths = row.iter_mut().zip(self.inner.channels()).filter(|(_, c)| c.unit == "m");
                    lengths.for_each(|(value, _)| *value = map(*value, c));
                }
                Act::Clock { .. } | Act::Exposure(_) | Act::Readout(_) => {}
            }
        }
        Ok(())
    }

    /// What is observed at the stamps of `clock`.
    fn observe(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: Option<&Circumstances>,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let (p, coefficients) = parameters.split_at(self.inner.parameters().len());
        let active = self.active(coefficients)?;
        if active.is_empty() {
            return self.run(p, nuisances, circumstances, clock, values);
        }
        if self.kind() == Kind::EventTimes {
            self.run(p, nuisances, circumstances, clock, values)?;
            for (_, effect, c) in &active {
                if let Act::Clock { to_seen, .. } = effect.act {
                    for time in values.iter_mut() {
                        *time = to_seen(*time, c);
                    }
                }
            }
            return Ok(());
        }

        let exposure = active.iter().find_map(|(_, e, c)| match e.act {
            Act::Exposure(length) => Some(length(c)),
            _ => None,
        });
        let nodes = if exposure.is_some() { exposure_nodes() } else { vec![(0.0, 1.0)] };
        let nodes = nodes.as_slice();
        let length = exposure.unwrap_or(0.0);
        // The clock's faults came one after the other, so they are undone from the last to the first.
        let to_true = |stamp: f64| {
            active.iter().rev().fold(stamp, |t, (_, e, c)| match e.act {
                Act::Clock { to_true, .. } => to_true(t, c),
                _ => t,
            })
        };
        let stamps = clock.iter().flat_map(|t| nodes.iter().map(move |(share, _)| t + length * share));
        let stamps: Vec<f64> = stamps.map(to_true).collect();
        let mut inner = self.ask(p, nuisances, circumstances, &stamps)?;
        let width = self.channels().len();
        for (_, effect, c) in &active {
            let Act::Readout(delay) = effect.act else { continue };
            for _ in 0..READOUT_ROUNDS {
                let late = |(t, row): (&f64, &[f64])| t + delay(row[2], c);
                let instants: Vec<f64> = stamps.iter().zip(inner.chunks_exact(width)).map(late).collect();
                inner = self.ask(p, nuisances, circumstances, &instants)?;
            }
        }
        for (rows, out) in inner.chunks_exact_mut(width * nodes.len()).zip(values.chunks_exact_mut(width)) {
            out.fill(0.0);
            for (row, (_, weight)) in rows.chunks_exact_mut(width).zip(nodes) {
                self.seen(&active, row)?;
                out.iter_mut().zip(row.iter()).for_each(|(o, v)| *o += weight * v);
            }
        }
        Ok(())
    }
}

impl<S: Simulator> Segmented for Measured<S> {
    fn free_segment(&self) -> Option<Box<dyn Simulator>> {
        Some(self.around(self.inner.segmented()?.free_segment()?))
    }

    fn with_hidden_state(&self) -> Option<Box<dyn Simulator>> {
        Some(self.around(self.inner.segmented()?.with_hidden_state()?))
    }

    fn with_hidden_state_at_events(&self) -> Option<Box<dyn Simulator>> {
        Some(self.around(self.inner.segmented()?.with_hidden_state_at_events()?))
    }

    fn proposed_starts(&self, prepared: &Prepared, nuisances: &[f64], unmeasured: &[usize]) -> Vec<ProposedStart> {
        let inner = self.inner.segmented();
        inner.map_or_else(Vec::new, |inner| inner.proposed_starts(prepared, nuisances, unmeasured))
    }
}

impl<S: Simulator> Simulator for Measured<S> {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        self.inner.channels()
    }

    fn kind(&self) -> Kind {
        self.inner.kind()
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        Ok(match self.inner.prepare(seen)? {
            Preparation::Usable(mut prepared) => {
                prepared.local.resize(self.parameters.len(), None);
                prepared.silent.resize(self.parameters.len(), None);
                Preparation::Usable(prepared)
            }
            rejected @ Preparation::Rejected(_) => rejected,
        })
    }

    /// Those of the inner simulator: physical ones.
    fn effects(&self) -> Vec<Effect> {
        self.inner.effects()
    }

    /// Takes effects of the measurement as well; the coefficients of the physical ones come first.
    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let (measurement, physical): (Vec<&str>, Vec<&str>) =
            names.iter().partition(|name| find(name, self.kind()).is_some());
        let inner = self.inner.with_effects(&physical)?;
        let before: Vec<&str> = self.free.iter().map(|(_, e)| e.name).collect();
        let mut outer = Measured::new(inner, &before)?;
        outer.fixed.clone_from(&self.fixed);
        Ok(Box::new(outer.freed(&measurement)?))
    }

    fn assumed(&self) -> Vec<Assumed> {
        let each = self.inner.assumed().into_iter();
        each.map(|one| Assumed { at_upper: self.around(one.at_upper), ..one }).collect()
    }

    fn segmented(&self) -> Option<&dyn Segmented> {
        self.inner.segmented().map(|_| self as &dyn Segmented)
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        self.observe(parameters, nuisances, None, clock, values)
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        self.observe(parameters, nuisances, Some(circumstances), clock, values)
    }
}
