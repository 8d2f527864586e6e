//! The ball as core sees it: a [`Simulator`] whose rollouts are positions or bounce times.

use tunenet_core::observation::{Arcs, Channel, Kind, LocalEstimate, Note, Observation};
use tunenet_core::simulator::{Effect, Parameter, Phase, Preparation, Prepared, Scale, Simulator};
use tunenet_core::tune::channel_noise;
use tunenet_core::{Error, Result};

use crate::ball::effects::{ALL, BallEffect, Body};
use crate::ball::{Scene, State, impact_times, positions};
use crate::simulation_file::{Release, SimulationFile};

/// What passes for gravity, as a share of the file's: air alone halves it for a light ball.
const PLAUSIBLE_GRAVITY: std::ops::Range<f64> = 0.25..2.0;
/// A flight strays from a parabola by less than this share of its range, air included.
const WORST_MISFIT_SHARE: f64 = 0.05;
/// Heights of the first fall that bounce times may come from, m.
const PLAUSIBLE_FALL_M: std::ops::Range<f64> = 1e-5..1e3;
/// Bounces whose intervals give the restitution at the speed of the first impacts.
const LEADING_INTERVALS: usize = 4;

/// The effect that is chance.
const SCATTER: &str = "bounce_scatter";
/// How far a bounce may turn the normal, rad, and at how many bounces of a record it may; later ones are next to rest.
const GREATEST_KICK_RAD: f64 = 0.5;
const MOST_KICKS: usize = 12;

/// A record that spans less than this along every axis, m, shows no motion.
const LEAST_MOTION_M: f64 = 1e-6;

/// A number of the start that the file leaves to the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unknown {
    Position(usize),
    Velocity(usize),
    Surface,
    Height,
    Time,
}

impl Unknown {
    fn name(self) -> (String, &'static str) {
        let axis = |i: usize| ["x", "y", "z"][i];
        match self {
            Self::Position(i) => (format!("release.{}", axis(i)), "m"),
            Self::Velocity(i) => (format!("release.velocity_{}", axis(i)), "m/s"),
            Self::Surface => ("surface.height".into(), "m"),
            Self::Height => ("release.height".into(), "m"),
            Self::Time => ("release.time".into(), "s"),
        }
    }
}

/// A ball's simulation file, observed as positions or as bounce times.
///
/// Own unknowns of a recording of positions are whatever the file leaves out of the start position, the start velocity and
/// the surface's height; of bounce times, the height of the first fall and its instant. A record is cut at blows and,
/// where the release is unknown, to the samples after it.
#[derive(Debug, Clone)]
pub struct ObservedBall {
    scene: Scene,
    release: Release,
    surface_height_m: Option<f64>,
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
    kind: Kind,
    unknown: Vec<Unknown>,
    body: Body,
    /// Effects of the file, at its values.
    fixed: Vec<(BallEffect, Vec<f64>)>,
    /// Effects whose coefficients follow the parameters.
    free: Vec<BallEffect>,
}

impl ObservedBall {
    /// The ball of `file`, observed as `kind`.
    ///
    /// # Errors
    /// [`Error::Observation`] where a ball cannot be observed so; what the file's parameters refuse.
    pub fn new(file: &SimulationFile, kind: Kind) -> Result<Self> {
        let release = file.release();
        let surface_height_m = file.number("surface.height_m");
        let (channels, unknown) = match kind {
            Kind::Positions => (Channel::positions(), unknown_start(&release, surface_height_m)),
            Kind::BounceTimes => {
                let height = release.height_m.is_none().then_some(Unknown::Height);
                (Channel::bounce_times(), height.into_iter().chain([Unknown::Time]).collect())
            }
            _ => {
                let expected = "positions or bounce times for a simulation of kind \"ball\"".into();
                return Err(Error::Observation { what: "the observation".into(), expected, found: kind.name().into() });
            }
        };
        let parameters = file.parameters()?;
        let scene = scene(file);
        let mass_kg = file.number("ball.mass_kg");
        let body = Body { radius_m: scene.radius_m, mass_kg, gravity_m_s2: scene.gravity_m_s2 };
        let fixed = file.effects().into_iter().filter_map(|e| Some((BallEffect::find(&e.name)?, e.values))).collect();
        let free = Vec::new();
        Ok(Self { scene, release, surface_height_m, parameters, channels, kind, unknown, body, fixed, free })
    }

    /// Whether this kind of observation can show an effect that is not there yet.
    fn can_take(&self, effect: &BallEffect) -> bool {
        // Beside a tuned coefficient of friction its addition is the same thing twice.
        let twin = effect.name == "bounce_friction" && self.parameters[1].tune;
        !twin && (effect.heard || self.kind == Kind::Positions)
    }

    /// Whether the recording's own unknowns include the tilt of the normal at each bounce.
    fn scatters(&self) -> bool {
        let fixed = self.fixed.iter().any(|(e, values)| e.name == SCATTER && values[0] > 0.0);
        self.kind == Kind::Positions && (fixed || self.free.iter().any(|e| e.name == SCATTER))
    }

    /// The tilts of the normal as own unknowns: about x and y, for each bounce of the record.
    fn kicks(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        let bounces = Arcs::cut(seen, self.scene.gravity_m_s2).map_or(0, |arcs| arcs.contacts.len());
        let name = |bounce: usize, axis: &str| format!("bounce.{}.tilt_about_{axis}", bounce + 1);
        let each = (0..bounces.min(MOST_KICKS)).flat_map(|bounce| [name(bounce, "x"), name(bounce, "y")]);
        each.map(|name| Parameter::new(name, "rad", 0.0, -GREATEST_KICK_RAD, GREATEST_KICK_RAD)).collect()
    }

    /// The scene with these parameters, and the start with these own unknowns.
    fn world(&self, parameters: &[f64], own: &[f64]) -> (Scene, State, f64) {
        let mut scene = Scene { restitution: parameters[0], friction: parameters[1], ..self.scene.clone() };
        for (effect, values) in &self.fixed {
            (effect.apply)(&mut scene, values);
        }
        let mut start = State {
            position_m: self.release.position_m.unwrap_or_default(),
            velocity_m_s: self.release.velocity_m_s.unwrap_or_default(),
            spin_rad_s: self.release.spin_rad_s.unwrap_or_default(),
        };
        let mut height = self.release.height_m;
        let mut time_s = self.release.time_s.unwrap_or(0.0);
        scene.surface_height_m = self.surface_height_m.unwrap_or(0.0);
        let mut rest = &parameters[2..];
        for effect in &self.free {
            let (values, after) = rest.split_at(effect.coefficients.len());
            (effect.apply)(&mut scene, values);
            rest = after;
        }
        if let Some(kicks) = own.get(self.unknown.len()..) {
            scene.contact.kicks_rad = kicks.chunks_exact(2).map(|kick| [kick[0], kick[1]]).collect();
        }
        for (unknown, &value) in self.unknown.iter().zip(own) {
            match *unknown {
                Unknown::Position(axis) => start.position_m[axis] = value,
                Unknown::Velocity(axis) => start.velocity_m_s[axis] = value,
                Unknown::Surface => scene.surface_height_m = value,
                Unknown::Height => height = Some(value),
                Unknown::Time => time_s = value,
            }
        }
        if let Some(height) = height {
            let normal = scene.normal();
            let [x, y, _] = start.position_m;
            let below = scene.surface_height_m - (normal[0] * x + normal[1] * y) / normal[2];
            start.position_m[2] = below + scene.radius_m + height;
        }
        (scene, start, time_s)
    }

    fn prepare_positions(&self, seen: &Observation) -> Result<Preparation> {
        if (0..3).all(|axis| span(seen.column(axis)) < LEAST_MOTION_M) {
            let text = format!("the ball does not move in any of the {} samples", seen.len());
            return Ok(Preparation::Rejected(Note::new("motion.none", text, "check the columns and their units")));
        }
        // Stamps count from 1970; a start that the data supply needs no more than the differences, and keeps its digits.
        let moved = self.release.time_s.is_none().then(|| seen.from_zero());
        let seen = moved.as_ref().unwrap_or(seen);
        let wild = seen.wild();
        let kept = seen.without(&wild);
        let seen = kept.as_ref().unwrap_or(seen);
        let Some(arcs) = Arcs::cut(seen, self.scene.gravity_m_s2) else { return Err(self.wrong_kind(seen)) };
        // A known start also explains the time before it.
        let begin = if self.release.time_s.is_some() { 0 } else { arcs.usable.start };
        let Ok(usable) = seen.slice(begin..arcs.usable.end) else {
            let text = format!("only {} of {} samples are undisturbed free motion", arcs.usable.len(), seen.len());
            return Ok(Preparation::Rejected(Note::new(
                "motion.disturbed",
                text,
                "record a drop that nothing touches but the surface",
            )));
        };
        let lowest = usable.column(2).fold(f64::INFINITY, f64::min);
        let contact = arcs.contacts.iter().map(|c| c.height_m).reduce(f64::min);
        // The start lies above the surface, however the noise has it.
        let surface = contact.unwrap_or(lowest).min(arcs.start_m[2]) - self.scene.radius_m - 1e-9;
        let range = (0..3).map(|axis| span(usable.column(axis))).fold(0.1, f64::max);
        let fastest =
            (2.0 * self.scene.gravity_m_s2 * range).sqrt() + arcs.start_m_s.iter().map(|v| v.abs()).sum::<f64>();
        let begin_s = usable.clock()[0];
        // The start's own instant is the first sample; where only the position is known, it was released at rest then.
        let own = self.unknown.iter().map(|&unknown| {
            let (name, unit) = unknown.name();
            let (value, reach) = match unknown {
                Unknown::Position(axis) => (arcs.start_m[axis], range),
                Unknown::Velocity(axis) => (arcs.start_m_s[axis], fastest),
                _ => (surface, range),
            };
            Parameter::new(name, unit, value, value - reach, value + reach)
        });
        let mut prepared = Prepared::whole(usable, self.parameters.len());
        prepared.own = own.collect::<Result<_>>()?;
        prepared.notes.clone_from(&arcs.notes);
        if kept.is_some() {
            let places: Vec<String> = wild.iter().take(4).map(|i| (i + 1).to_string()).collect();
            let more = if wild.len() > 4 { " and others" } else { "" };
            let text = format!("sample {}{more} leaps far away and back, and was set aside", places.join(", "));
            prepared.notes.push(Note::new("samples.wild", text, "correct or remove it"));
        }
        if arcs.contacts.is_empty() {
            if let Some(note) = self.unlike_a_fall(&arcs) {
                return Ok(Preparation::Rejected(note));
            }
            let duration = seen.clock()[seen.len() - 1] - seen.clock()[0];
            let text = format!(
                "the ball does not bounce within the {duration:.2} s of the record, so nothing is said about its contacts"
            );
            let note = Note::new("contact.none", text, "record until after the first bounce, better the third");
            prepared.silent.fill(Some(note));
        }
        prepared.local[0] = arcs.restitution().map(|l| LocalEstimate { value: l.value.clamp(0.0, 1.0), ..l });
        let start_s = self.release.time_s.unwrap_or(begin_s);
        prepared.scale = Some(self.scale(&prepared.own_values(), start_s));
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    /// Why a motion without a bounce is no flight either, where it is none.
    fn unlike_a_fall(&self, arcs: &Arcs) -> Option<Note> {
        let (apparent, misfit) = (arcs.apparent_gravity_m_s2?, arcs.misfit_share?);
        let gravity = self.scene.gravity_m_s2;
        // Five standard deviations: a short noisy flight is none of its own fault.
        let slack = 5.0 * apparent.sd;
        let plausible = PLAUSIBLE_GRAVITY.start * gravity - slack..PLAUSIBLE_GRAVITY.end * gravity + slack;
        let like = plausible.contains(&apparent.value) && misfit < WORST_MISFIT_SHARE;
        (!like).then(|| {
            let text = if misfit > 1.0 {
                "the height does not change".to_string()
            } else if misfit < WORST_MISFIT_SHARE {
                format!("this is no ball in flight: it falls at {:.3e} m/s², expected near {gravity}", apparent.value)
            } else {
                format!(
                    "this is no bounce and no flight: no parabola comes nearer than {:.0} % of the motion",
                    100.0 * misfit
                )
            };
            Note::new(
                "motion.unlike",
                text,
                "check the units and the sign of z, the unit of the time, and which column is which",
            )
        })
    }

    /// The own unknowns of a rollout that is not compared with anything: let go at `time_s` above the origin.
    #[must_use]
    pub fn own_at_rest(&self, time_s: f64) -> Vec<f64> {
        self.unknown.iter().map(|u| if *u == Unknown::Time { time_s } else { 0.0 }).collect()
    }

    /// How many impacts happen until `end_s`, at most a thousand.
    ///
    /// # Errors
    /// [`Error::Simulator`] where the ball cannot be followed.
    pub fn impacts_within(&self, parameters: &[f64], own: &[f64], end_s: f64) -> Result<usize> {
        let (scene, start, time_s) = self.world(parameters, own);
        let times = impact_times(&scene, &start, time_s, 1000)
            .map_err(|message| Error::Simulator { at: "the scene's values".into(), message })?;
        Ok(times.partition_point(|t| *t <= end_s))
    }

    /// The natural scales of a drop with these own unknowns, released at `start_s`: heights from rest, in heights of fall;
    /// time from the apex of the first flight.
    #[must_use]
    pub fn scale(&self, own: &[f64], start_s: f64) -> Scale {
        let parameters: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        let (scene, start, _) = self.world(&parameters, own);
        let gravity = scene.gravity_m_s2;
        let origin = scene.surface_height_m + scene.radius_m;
        let rise = start.velocity_m_s[2];
        let length = (start.position_m[2] - origin + rise * rise / (2.0 * gravity)).max(1e-3);
        Scale { origin, length, start_s: start_s + rise / gravity, time_s: (length / gravity).sqrt() }
    }

    fn prepare_bounces(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::BounceTimes {
            return Err(self.wrong_kind(seen));
        }
        let times = seen.values();
        let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
        let noise = channel_noise(seen)[0];
        let local = leading_restitution(&intervals, noise);
        let restitution = local.map_or(0.7, |l| l.value).clamp(0.05, 1.0);
        let gravity = self.scene.gravity_m_s2;
        let approach = gravity * intervals[0] / (2.0 * restitution);
        let height = approach * approach / (2.0 * gravity);
        if !PLAUSIBLE_FALL_M.contains(&height) {
            let text = format!("the first interval of {} s would need a fall of {height:.3e} m", intervals[0]);
            return Ok(Preparation::Rejected(Note::new(
                "bounces.implausible",
                text,
                "check the unit of the times: seconds",
            )));
        }
        let time = times[0] - self.release.height_m.map_or(approach / gravity, |h| (2.0 * h / gravity).sqrt());
        let own = self.unknown.iter().map(|&unknown| {
            let (name, unit) = unknown.name();
            let (value, low, high) = match unknown {
                Unknown::Height => (height, height * 0.01, height * 100.0),
                _ => (time, time - 10.0 * intervals[0], time + 10.0 * intervals[0]),
            };
            Parameter::new(name, unit, value, low, high)
        });
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        prepared.own = own.collect::<Result<_>>()?;
        prepared.local[0] = local;
        prepared.silent[1] = Some(Note::new(
            "friction.unseen",
            "bounce times say nothing about friction",
            "record positions of a throw along the surface",
        ));
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn wrong_kind(&self, seen: &Observation) -> Error {
        Error::Observation {
            what: "the observation".into(),
            expected: self.kind.name().into(),
            found: seen.kind().name().into(),
        }
    }
}

impl Simulator for ObservedBall {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        self.kind
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let preparation =
            if self.kind == Kind::BounceTimes { self.prepare_bounces(seen) } else { self.prepare_positions(seen) }?;
        let Preparation::Usable(mut prepared) = preparation else { return Ok(preparation) };
        // A record without a bounce is silent about contacts alone.
        let phases = self.free.iter().flat_map(|e| vec![e.phase; e.coefficients.len()]);
        for (silent, phase) in prepared.silent[2..].iter_mut().zip(phases) {
            if phase == Phase::Flight {
                *silent = None;
            }
        }
        if self.scatters() {
            prepared.own.extend(self.kicks(&prepared.seen)?);
        }
        Ok(Preparation::Usable(prepared))
    }

    fn effects(&self) -> Vec<Effect> {
        let present =
            |name: &str| self.fixed.iter().any(|(e, _)| e.name == name) || self.free.iter().any(|e| e.name == name);
        ALL.iter().filter(|e| !present(e.name) && self.can_take(e)).map(|e| e.entry(&self.body)).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut ball = self.clone();
        for name in names {
            let found =
                BallEffect::find(name).filter(|e| self.can_take(e) && !ball.free.iter().any(|f| f.name == e.name));
            let Some(effect) = found else {
                let known = ball.effects().iter().map(|e| e.name).collect::<Vec<_>>().join(", ");
                let expected = format!("an effect of a ball seen as {} ({known})", self.kind.name());
                return Err(Error::Setting { name: "effects", expected, found: format!("`{name}`") });
            };
            let at = ball.fixed.iter().position(|(e, _)| e.name == *name);
            let present = at.map(|i| ball.fixed.remove(i).1);
            let parameters = effect.entry(&self.body).parameters(present.as_deref())?;
            // Chance is not rolled out; its size follows from the tilts that a recording brings.
            let tune = effect.name != SCATTER;
            ball.parameters.extend(parameters.into_iter().map(|p| Parameter { tune, ..p }));
            ball.free.push(effect);
        }
        Ok(Box::new(ball))
    }

    fn rollout(
        &self,
        parameters: &[f64],
        own: &[f64],
        clock: &[f64],
        values: &mut [f64],
    ) -> std::result::Result<(), String> {
        let (scene, start, time_s) = self.world(parameters, own);
        if self.kind == Kind::Positions {
            let begin = self.release.time_s.unwrap_or(clock[0]);
            return positions(&scene, &start, begin, clock, values);
        }
        let last = clock[clock.len() - 1].max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of impacts, checked to be small"
        )]
        let count = if last < 1e6 { last as usize + 1 } else { return Err(format!("{last} impacts are too many")) };
        let times = impact_times(&scene, &start, time_s, count)?;
        let Some(&rest) = times.last() else { return Err("the ball never reaches the surface".into()) };
        for (value, index) in values.iter_mut().zip(clock) {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below `count`")]
            let index = index.max(0.0) as usize;
            // A ball that has come to rest makes no more impacts: the sum of its intervals has converged.
            *value = times.get(index).copied().unwrap_or(rest);
        }
        Ok(())
    }
}

/// What the file leaves out of a start that is observed as positions.
fn unknown_start(release: &Release, surface_height_m: Option<f64>) -> Vec<Unknown> {
    let mut unknown = Vec::new();
    match (release.position_m, release.height_m) {
        (Some(_), _) => {}
        // The height fixes z through the surface; a drop from rest at a known instant stays on its vertical line.
        (None, Some(_)) => unknown.extend([Unknown::Position(0), Unknown::Position(1)]),
        (None, None) => unknown.extend([0, 1, 2].map(Unknown::Position)),
    }
    if release.velocity_m_s.is_none() {
        unknown.extend([0, 1, 2].map(Unknown::Velocity));
    }
    if surface_height_m.is_none() {
        unknown.push(Unknown::Surface);
    }
    unknown
}

/// The scene of a ball's file without its effects; its restitution and friction come from the parameters.
#[must_use]
pub fn scene(file: &SimulationFile) -> Scene {
    let number = |path: &str| file.number(path).unwrap_or(0.0);
    let default = Scene::default();
    Scene {
        gravity_m_s2: file.number("world.gravity_m_s2").unwrap_or(default.gravity_m_s2),
        radius_m: file.number("ball.radius_m").unwrap_or(default.radius_m),
        mass_kg: file.number("ball.mass_kg").unwrap_or(default.mass_kg),
        surface_height_m: number("surface.height_m"),
        surface_tilt_about_x_rad: number("surface.tilt_about_x_rad"),
        surface_tilt_about_y_rad: number("surface.tilt_about_y_rad"),
        friction: 0.0,
        restitution: 0.0,
        ..default
    }
}

/// The restitution at the first impacts: how the logarithm of the interval falls over the first few, long intervals
/// counting more.
fn leading_restitution(intervals: &[f64], noise_s: f64) -> Option<LocalEstimate> {
    let leading = &intervals[..intervals.len().min(LEADING_INTERVALS)];
    let weight: f64 = leading.iter().map(|t| t * t).sum();
    let mean = |of: &dyn Fn(usize, f64) -> f64| {
        leading.iter().enumerate().map(|(k, t)| t * t * of(k, *t)).sum::<f64>() / weight
    };
    let (middle, level) = (mean(&|k, _| k as f64), mean(&|_, t| t.ln()));
    let square = mean(&|k, _| (k as f64 - middle).powi(2));
    let slope = mean(&|k, t| (k as f64 - middle) * (t.ln() - level)) / square;
    let value = slope.exp();
    // An interval's error is √2 of a time's; its logarithm's is that over the interval.
    let sd = value * 2f64.sqrt() * noise_s / (weight * square).sqrt();
    (leading.len() >= 2 && value.is_finite())
        .then_some(LocalEstimate { value: value.clamp(0.0, 1.0), sd: sd.max(1e-9) })
}

fn span(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}
