//! De-trended flights: what a recording would have been, had nothing but gravity acted between contacts.
//!
//! The velocities right before and after a contact show the contact's effect, independent of forces in flight and of the
//! camera's distortion, as long as these are smooth. So each flight is described by a polynomial of its own; the change of
//! velocity along the surface at each contact is kept, and the flights in between become parabolas under gravity only, with
//! noise that gives the velocities the uncertainty they have.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use tunenet_core::observation::Observation;
use tunenet_core::statistics::{mean, median};

/// Samples nearer to a contact, in usual steps, may hold both sides of it.
const GUARD_STEPS: f64 = 0.5;
/// Fewest samples of a flight, and those from which on its acceleration may change.
const FEWEST: usize = 6;
const FEWEST_CUBIC: usize = 9;
/// A cubic has to take this share of a parabola's mean square away.
const CUBIC_SHARE: f64 = 0.5;
/// A tracker's errors last for some samples: velocities are so many times less certain than of white noise, at the most.
const MOST_LASTING: f64 = 2.0;
/// A change of speed is there from this many of its standard deviations, and this share of the speed, on.
const SURE: f64 = 4.0;
const SHARE: f64 = 0.1;
/// Ends this near to landing, as a share of the flight, are left out: the next contact is not seen.
const AIRBORNE_SHARE: f64 = 0.95;

/// A de-trended recording.
pub(super) struct Detrended {
    /// With noise as large as makes velocities as uncertain as they are.
    pub seen: Observation,
    /// Without, on the same clock.
    pub ideal: Observation,
    /// Standard deviation of each channel; 0 of one that does not move.
    pub noise: Vec<f64>,
    /// What the best tilt of surface or camera leaves of the changes of speed, squared and in units of their variance.
    pub beyond_tilt: f64,
}

/// One flight along one axis: velocities at its ends with their variance, and how far the samples stray.
struct Along {
    begin: (f64, f64),
    end: (f64, f64),
    sd: f64,
}

/// One flight.
struct Flight {
    /// From contact to contact, or from or to the end of the record, s.
    span: (f64, f64),
    range: Range<usize>,
    axes: [Along; 3],
}

/// De-trends `seen`, positions with z up, between `contacts` under gravity `g` (m/s², downwards). `None` where nothing falls, flights are too few or
/// too short, or where no contact surely takes speed along the surface. Noise is drawn from `seed`, and `wider` times as large as
/// the velocities need.
pub(super) fn detrend(seen: &Observation, contacts: &[f64], g: f64, (seed, wider): (u64, f64)) -> Option<Detrended> {
    if g <= 0.0 {
        return None;
    }
    let flights = flights(seen, contacts);
    // The longest chain of flights one after the other.
    let chains = flights.split(Option::is_none).max_by_key(|chain| chain.len())?;
    let chain: Vec<&Flight> = chains.iter().flatten().collect();
    if chain.len() < 2 {
        return None;
    }
    let slope = scale_slope(seen, &chain);
    let middle = mean(chain.iter().flat_map(|f| f.range.clone()).map(|k| seen.row(k)[0]));
    let across = mean(chain.iter().flat_map(|f| f.range.clone()).map(|k| seen.row(k)[1]));
    let normal: Vec<(f64, f64)> = chain.windows(2).map(|w| (-w[0].axes[2].end.0, w[1].axes[2].begin.0)).collect();
    if normal.iter().any(|(before, after)| *before <= 0.0 || *after <= 0.0) {
        return None;
    }
    let restitution = normal.iter().map(|(b, a)| a * b).sum::<f64>() / normal.iter().map(|(b, _)| b * b).sum::<f64>();
    // Velocities along the surface after each contact, and how sure their changes are.
    let mut speeds = [vec![chain[0].axes[0].end.0], vec![chain[0].axes[1].end.0]];
    let (mut noise, mut tilts) = ([0.0f64; 3], [Tilt::default(), Tilt::default()]);
    for (i, pair) in chain.windows(2).enumerate() {
        let (before, after) = (pair[0], pair[1]);
        let at = |axis: usize| before.range.end.checked_sub(1).map_or(0.0, |k| seen.row(k)[axis]);
        let weight = (leverage(before) + leverage(after)).sqrt();
        let normal_change = normal[i].0 + normal[i].1;
        let (mut change, mut variance, mut speed, mut along) = (0.0, 0.0f64, 0.0, 0.0);
        let mut doubts = [0.0f64; 2];
        for axis in 0..2 {
            let ((u, a), (v, b)) = (before.axes[axis].end, after.axes[axis].begin);
            let leaning = slope * (at(axis) - [middle, across][axis]) * normal_change;
            let sd = (a + b + leaning.powi(2)).sqrt();
            doubts[axis] = sd / weight;
            tilts[axis].add(v - u, normal_change, sd);
            let last = *speeds[axis].last()?;
            speeds[axis].push(last + v - u);
            change += (v - u).powi(2);
            variance = variance.max(sd * sd);
            speed += u * u;
            along += u * (v - u);
        }
        // Nothing is asked of the heights but when the ball touches the surface.
        noise[2] = noise[2].max(before.axes[2].sd.max(after.axes[2].sd));
        if along < 0.0 && change > SURE * SURE * variance && change > SHARE * SHARE * speed {
            for (noise, doubt) in noise.iter_mut().zip(doubts) {
                *noise = noise.max(doubt);
            }
        }
    }
    if noise[0].max(noise[1]) <= 0.0 {
        return None;
    }
    for sd in &mut noise {
        *sd *= wider;
    }
    let beyond_tilt = tilts.iter().map(Tilt::left).sum();
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let (mut clock, mut rows, mut ideals) = (Vec::new(), Vec::new(), Vec::new());
    let (mut start_s, mut place, mut rise) = (0.0, [0.0; 2], 0.0);
    for (i, flight) in chain.iter().enumerate() {
        let measured = flight.span.1 - flight.span.0;
        let length = if i == 0 { measured } else { 2.0 * rise / g };
        let shown = if i + 1 == chain.len() { measured.min(AIRBORNE_SHARE * length) } else { length };
        let count = flight.range.len();
        let [x, y, z] = [0, 1, 2].map(|_| white(count, &mut draw));
        for (j, white) in x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).enumerate() {
            let t = shown * (j as f64 + 0.5) / count as f64;
            let height =
                if i == 0 { (length - t) * (normal[0].0 - 0.5 * g * (length - t)) } else { t * (rise - 0.5 * g * t) };
            let ideal = [place[0] + speeds[0][i] * t, place[1] + speeds[1][i] * t, height];
            let strays = |axis: usize| noise[axis] * white[axis];
            clock.push(start_s + t);
            ideals.push(ideal);
            rows.push([0, 1, 2].map(|axis| ideal[axis] + strays(axis)));
        }
        place = [0, 1].map(|axis| place[axis] + speeds[axis][i] * length);
        rise = restitution * if i == 0 { normal[0].0 } else { rise };
        start_s += length;
    }
    let begin = clock.first().copied()?;
    for t in &mut clock {
        *t -= begin;
    }
    // Both belong to the recording, and so to its setup.
    let made = |clock, rows: &[[f64; 3]]| Some(seen.same_circumstances(Observation::positions(clock, rows).ok()?));
    let (ideal, seen) = (made(clock.clone(), &ideals)?, made(clock, &rows)?);
    Some(Detrended { seen, ideal, noise: noise.to_vec(), beyond_tilt })
}

/// Changes of speed along one axis and those across the surface: a tilt, of surface or camera, turns some of the one into
/// the other, always to the same side.
#[derive(Default)]
struct Tilt {
    both: f64,
    normal_changes: f64,
    changes: f64,
}

impl Tilt {
    fn add(&mut self, change: f64, normal_change: f64, sd: f64) {
        if sd > 0.0 {
            self.both += change * normal_change / (sd * sd);
            self.normal_changes += normal_change * normal_change / (sd * sd);
            self.changes += change * change / (sd * sd);
        }
    }

    fn left(&self) -> f64 {
        if self.normal_changes > 0.0 {
            (self.changes - self.both * self.both / self.normal_changes).max(0.0)
        } else {
            0.0
        }
    }
}

/// The flights between the contacts; `None` for one with too few samples.
fn flights(seen: &Observation, contacts: &[f64]) -> Vec<Option<Flight>> {
    let clock = seen.clock();
    let (Some(first), Some(last)) = (clock.first(), clock.last()) else { return Vec::new() };
    let usual = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
    let ends: Vec<f64> = [*first].into_iter().chain(contacts.iter().copied()).chain([*last]).collect();
    let one = |(i, span): (usize, &[f64])| {
        let guard = |at: f64, inner: bool| if inner { at } else { at - 2.0 * GUARD_STEPS * usual };
        let (from, to) = (span[0] + GUARD_STEPS * usual, span[1] - GUARD_STEPS * usual);
        let from = if i == 0 { guard(from, false) } else { from };
        let to = if i == contacts.len() { to + 2.0 * GUARD_STEPS * usual } else { to };
        let range = clock.partition_point(|t| *t < from)..clock.partition_point(|t| *t <= to);
        if range.len() < FEWEST {
            return None;
        }
        let axes = [0, 1, 2].map(|axis| along(seen, range.clone(), axis, (span[0], span[1])));
        let [Some(x), Some(y), Some(z)] = axes else { return None };
        Some(Flight { span: (span[0], span[1]), range, axes: [x, y, z] })
    };
    ends.windows(2).enumerate().map(one).collect()
}

/// A parabola through the samples of one axis, or a cubic where that follows them far better.
fn along(seen: &Observation, range: Range<usize>, axis: usize, span: (f64, f64)) -> Option<Along> {
    let times: Vec<f64> = range.clone().map(|k| seen.clock()[k] - span.0).collect();
    let values = DVector::from_iterator(times.len(), range.map(|k| seen.row(k)[axis]));
    let fit = |terms: usize| {
        let basis = DMatrix::from_fn(times.len(), terms, |i, j| times[i].powi(i32::try_from(j).unwrap_or(0)));
        let inverse = (basis.transpose() * &basis).try_inverse()?;
        let numbers = &inverse * (basis.transpose() * &values);
        let strays = &values - &basis * &numbers;
        let variance = strays.norm_squared() / (times.len() - terms) as f64;
        Some((terms, inverse, numbers, strays, variance))
    };
    let parabola = fit(3)?;
    let cubic = if times.len() >= FEWEST_CUBIC { fit(4) } else { None };
    let (terms, inverse, numbers, strays, variance) = match cubic {
        Some(cubic) if cubic.4 < CUBIC_SHARE * parabola.4 => cubic,
        _ => parabola,
    };
    let (sd, lasting) = (variance.sqrt(), lasting(strays.as_slice()));
    let slope = |t: f64| {
        let power = |j: usize| i32::try_from(j).unwrap_or(1) - 1;
        let row = DVector::from_fn(terms, |j, _| if j == 0 { 0.0 } else { j as f64 * t.powi(power(j)) });
        (row.dot(&numbers), (lasting * sd).powi(2) * (row.transpose() * &inverse * &row)[(0, 0)])
    };
    Some(Along { begin: slope(0.0), end: slope(span.1 - span.0), sd: lasting * sd })
}

/// How much less certain errors that last make a slope than white ones: of a first-order autoregression with correlation ρ
/// of neighbours, √((1 + ρ)/(1 − ρ)).
fn lasting(strays: &[f64]) -> f64 {
    let square: f64 = strays.iter().map(|v| v * v).sum();
    if square <= 0.0 {
        return 1.0;
    }
    let rho = strays.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / square;
    ((1.0 + rho) / (1.0 - rho).max(f64::MIN_POSITIVE)).max(1.0).sqrt().min(MOST_LASTING)
}

/// White noise of unit size for `count` samples, without what would change a parabola through them.
fn white(count: usize, draw: &mut ChaCha8Rng) -> Vec<f64> {
    let drawn = DVector::from_fn(count, |_, _| draw.sample::<f64, _>(StandardNormal));
    let basis = DMatrix::from_fn(count, 3, |i, j| (i as f64 / count as f64).powi(i32::try_from(j).unwrap_or(0)));
    let Some(inverse) = (basis.transpose() * &basis).try_inverse() else { return drawn.as_slice().to_vec() };
    let left = &drawn - &basis * (inverse * (basis.transpose() * &drawn));
    let size = (left.norm_squared() / (count as f64 - 3.0)).sqrt();
    left.iter().map(|v| v / size).collect()
}

/// The variance of a line's slope through a flight's samples, in units of their variance over time squared.
fn leverage(flight: &Flight) -> f64 {
    let length = flight.span.1 - flight.span.0;
    12.0 / (flight.range.len() as f64 * length * length)
}

/// How much the picture's scale may change with height, 1/m, at the most: a camera that looks down tilts what rises, which
/// looks like a change of speed along the surface. Flights show it as they bend otherwise at their tops than near the ground.
fn scale_slope(seen: &Observation, chain: &[&Flight]) -> f64 {
    let low = chain.iter().flat_map(|f| f.range.clone()).map(|k| seen.row(k)[2]).fold(f64::INFINITY, f64::min);
    let (mut both, mut square, mut left, mut degrees_of_freedom) = (0.0, 0.0, 0.0, 0.0);
    for flight in chain {
        let times: Vec<f64> = flight.range.clone().map(|k| seen.clock()[k] - flight.span.0).collect();
        let heights = DVector::from_iterator(times.len(), flight.range.clone().map(|k| seen.row(k)[2] - low));
        // Air bends a flight as a cubic does.
        let terms = if times.len() >= FEWEST_CUBIC { 4 } else { 3 };
        let basis = DMatrix::from_fn(times.len(), terms, |i, j| times[i].powi(i32::try_from(j).unwrap_or(0)));
        let Some(inverse) = (basis.transpose() * &basis).try_inverse() else { continue };
        let rest = |v: &DVector<f64>| v - &basis * (&inverse * (basis.transpose() * v));
        let (shape, strays) = (rest(&heights.map(|h| h * h)), rest(&heights));
        both -= shape.dot(&strays);
        square += shape.norm_squared();
        left += strays.norm_squared();
        degrees_of_freedom += (times.len() - terms) as f64;
    }
    if square <= 0.0 {
        return 0.0;
    }
    let sd = (left / f64::max(degrees_of_freedom, 1.0) / square).sqrt();
    (both / square).abs() + 2.0 * sd
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    /// Three flights at 30 Hz with restitution 0.7 that a push of -0.6 m/s² slows all the way, each contact keeping `kept` of
    /// the speed along the surface; noise of 1 mm.
    fn throw(kept: [f64; 2]) -> (Observation, Vec<f64>) {
        let mut draw = ChaCha8Rng::seed_from_u64(5);
        let (mut clock, mut rows, mut contacts) = (Vec::new(), Vec::new(), Vec::new());
        let (mut begin, mut x, mut u, mut w) = (0.0, 0.0, 1.2, 2.0);
        let mut z = 0.4f64;
        for keep in [kept[0], kept[1], 1.0] {
            let length = (w + f64::sqrt(w * w + 2.0 * G * z)) / G;
            let mut k = f64::ceil((begin + 1e-9) * 30.0);
            while k / 30.0 < begin + length {
                let t = k / 30.0 - begin;
                let mut noise = || 0.001 * draw.sample::<f64, _>(StandardNormal);
                clock.push(k / 30.0);
                rows.push([x + u * t - 0.3 * t * t + noise(), 0.0, z + w * t - G / 2.0 * t * t + noise()]);
                k += 1.0;
            }
            x += u * length - 0.3 * length * length;
            (u, w) = (keep * (u - 0.6 * length), -0.7 * (w - G * length));
            (z, begin) = (0.0, begin + length);
            contacts.push(begin);
        }
        contacts.pop();
        (Observation::positions(clock, &rows).unwrap(), contacts)
    }

    #[test]
    fn a_push_in_flight_is_no_loss_at_contact() {
        let (seen, contacts) = throw([1.0, 1.0]);
        assert!(detrend(&seen, &contacts, G, (0, 1.0)).is_none());
    }

    #[test]
    fn what_contacts_take_stays_and_what_flights_take_goes() {
        let (seen, contacts) = throw([0.6, 1.0]);
        let detrended = detrend(&seen, &contacts, G, (0, 1.0)).unwrap();
        assert!(detrended.noise[0] > 0.001 && detrended.noise[1] == 0.0, "{:?}", detrended.noise);
        // 1.2 m/s less the push until the first contact; no push is left, so that speed stays until there.
        let fall = contacts[0];
        let before = 1.2 - 0.6 * fall;
        let x: Vec<f64> = detrended.seen.column(0).collect();
        let first = detrended.seen.clock().partition_point(|t| *t < fall);
        let clock = detrended.seen.clock();
        let slope = |a: usize, b: usize| (x[b] - x[a]) / (clock[b] - clock[a]);
        assert!((slope(0, first - 1) - before).abs() < 0.2 * before);
        assert!((slope(first + 1, first + 12) - 0.6 * before).abs() < 0.2 * before);
        // One loss and then none, at any speed across the surface, is no tilt.
        assert!(detrended.beyond_tilt > 6.0, "{}", detrended.beyond_tilt);
    }
}
