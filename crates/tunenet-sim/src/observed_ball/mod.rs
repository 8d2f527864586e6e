//! The ball as core sees it: a [`Simulator`] whose rollouts are positions or bounce times.

pub(crate) mod acting;
mod effects;
mod flight;
mod prepare;

use tunenet_ball::releases;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{
    Assumed, Effect, Parameter, Preparation, Prepared, ProposedStart, RolloutResult, Scale, Segmented, Simulator,
};
use tunenet_core::{Error, Result};
use tunenet_formats::kind_name;

use crate::ball::effects::Body;
use crate::ball::{Scene, State, impact_times, positions};
use crate::formula_effect::FormulaEffect;
use crate::scene::{BallParameters, Release};
use crate::simulation_file::SimulationFile;
use acting::Acting;

/// Gravity as it is written where nobody measured it, m/s² ...
const USUAL_GRAVITY_M_S2: [f64; 3] = [9.8, 9.81, 9.80665];
/// ... and between which values it lies where most people live, m/s².
const GRAVITY_M_S2: (f64, f64) = (9.79, 9.83);

/// A number of the start that the file leaves to the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Nuisance {
    Position(usize),
    Velocity(usize),
    /// About an axis along the surface.
    Spin(usize),
    Surface,
    Height,
    Time,
}

impl Nuisance {
    fn name(self) -> (String, &'static str) {
        let axis = |i: usize| ["x", "y", "z"][i];
        match self {
            Self::Position(i) => (format!("release.{}", axis(i)), "m"),
            Self::Velocity(i) => (format!("release.velocity_{}", axis(i)), "m/s"),
            Self::Spin(i) => (format!("release.spin_{}", axis(i)), "rad/s"),
            Self::Surface => ("surface.height".into(), "m"),
            Self::Height => ("release.height".into(), "m"),
            Self::Time => ("release.time".into(), "s"),
        }
    }
}

/// A ball's simulation file, observed as positions or as bounce times.
///
/// Nuisance parameters of a recording of positions are what the file leaves out of the start position, the start velocity and
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
    nuisances: Vec<Nuisance>,
    body: Body,
    /// Effects of the file, at its values.
    fixed: Vec<(Acting, Vec<f64>)>,
    /// Effects whose coefficients follow the parameters.
    free: Vec<Acting>,
    /// Effects whose coefficients every recording has for itself, as nuisance parameters.
    per_recording: Vec<Acting>,
    /// Effects that the file declares as formulas.
    formulas: Vec<FormulaEffect>,
    forced: bool,
    /// Whether there is no surface.
    flight_only: bool,
}

impl ObservedBall {
    /// The ball of `file`, observed as `kind`.
    ///
    /// # Errors
    /// [`Error::Observation`] where a ball cannot be observed so; what the file's parameters refuse.
    pub fn new(file: &SimulationFile, kind: Kind) -> tunenet_formats::Result<Self> {
        let ball = file.ball()?;
        let release = ball.release.clone();
        let surface_height_m = ball.surface.height_m;
        let (channels, nuisances) = match kind {
            Kind::Positions => (Channel::positions(), start_nuisances(&release, surface_height_m)),
            Kind::EventTimes => {
                let height = release.height_m.is_none().then_some(Nuisance::Height);
                (tunenet_ball::bounce_time_channels(), height.into_iter().chain([Nuisance::Time]).collect())
            }
            _ => {
                let expected = "positions or bounce times for a simulation of kind \"ball\"".into();
                return Err(Error::Observation {
                    what: "the observation".into(),
                    expected,
                    found: kind_name(kind).into(),
                }
                .into());
            }
        };
        let parameters = file.parameters()?;
        let scene = ball.simulated();
        let body = ball.body();
        let formulas = file.formulas()?;
        let (free, per_recording) = (Vec::new(), Vec::new());
        let (forced, flight_only) = (false, false);
        let mut new = Self {
            scene,
            release,
            surface_height_m,
            parameters,
            channels,
            kind,
            nuisances,
            body,
            fixed: Vec::new(),
            free,
            per_recording,
            formulas,
            forced,
            flight_only,
        };
        let present = file.effects().into_iter();
        new.fixed = present.filter_map(|e| Some((new.find_effect(&e.name)?, e.values))).collect();
        Ok(new)
    }

    /// The same, with the coefficients free of those effects that `file`, its own, asks to tune: they follow its parameters.
    ///
    /// # Errors
    /// [`Error::Setting`] where this kind of observation cannot show one of them.
    pub fn with_tuned_effects(self, file: &SimulationFile) -> tunenet_formats::Result<Self> {
        let present = file.effects();
        let free: Vec<&str> = present.iter().filter(|effect| effect.tune).map(|effect| effect.name.as_str()).collect();
        Ok(self.freed(&free)?)
    }

    /// The same, which uses recordings that their checks reject, and says so among their notes.
    #[must_use]
    pub fn forced(self, forced: bool) -> Self {
        Self { forced, ..self }
    }

    /// How a recording with these nuisance parameters starts.
    #[must_use]
    pub fn start(&self, nuisances: &[f64]) -> State {
        let parameters: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        self.world(&parameters, nuisances).1
    }

    /// The scene with these parameters, and the start with these nuisance parameters.
    pub(crate) fn world(&self, parameters: &[f64], nuisances: &[f64]) -> (Scene, State, f64) {
        let (BallParameters { restitution, friction }, coefficients) = BallParameters::split(parameters);
        let mut scene = Scene { friction, restitution, ..self.scene.clone() };
        self.apply_effects(&mut scene, coefficients, nuisances);
        let mut start = State {
            position_m: self.release.position_m.unwrap_or_default(),
            velocity_m_s: self.release.velocity_m_s.unwrap_or_default(),
            spin_rad_s: self.release.spin_rad_s.unwrap_or_default(),
        };
        let mut height = self.release.height_m;
        let mut time_s = self.release.time_s.unwrap_or(0.0);
        scene.surface_height_m = self.surface_height_m.unwrap_or(0.0);
        for (nuisance, &value) in self.nuisances.iter().zip(nuisances) {
            match *nuisance {
                Nuisance::Position(axis) => start.position_m[axis] = value,
                Nuisance::Velocity(axis) => start.velocity_m_s[axis] = value,
                Nuisance::Spin(axis) => start.spin_rad_s[axis] = value,
                Nuisance::Surface => scene.surface_height_m = value,
                Nuisance::Height => height = Some(value),
                Nuisance::Time => time_s = value,
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

    /// When a rollout whose first instant is `first_s` begins, s.
    pub(crate) fn begins_s(&self, first_s: f64) -> f64 {
        self.release.time_s.unwrap_or(first_s)
    }

    /// The nuisance parameters of a rollout that is not compared with anything: released at `time_s` above the origin.
    #[must_use]
    pub fn nuisances_at_rest(&self, time_s: f64) -> Vec<f64> {
        self.nuisances.iter().map(|u| if *u == Nuisance::Time { time_s } else { 0.0 }).collect()
    }

    /// How many impacts happen until `end_s`, at most a thousand.
    ///
    /// # Errors
    /// [`Error::Simulator`] where the ball cannot be followed.
    pub fn impacts_within(&self, parameters: &[f64], nuisances: &[f64], end_s: f64) -> Result<usize> {
        let (scene, start, time_s) = self.world(parameters, nuisances);
        let times = impact_times(&scene, &start, time_s, 1000)
            .map_err(|message| Error::Simulator { at: "the scene's values".into(), message })?;
        Ok(times.partition_point(|t| *t <= end_s))
    }

    /// The natural scales of a drop with these nuisance parameters, released at `start_s`: heights from rest, in heights of fall;
    /// time from the apex of the first flight.
    #[must_use]
    pub fn scale(&self, nuisances: &[f64], start_s: f64) -> Scale {
        let parameters: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        let (scene, start, _) = self.world(&parameters, nuisances);
        let gravity = scene.gravity_m_s2;
        let origin = scene.surface_height_m + scene.radius_m;
        let rise = start.velocity_m_s[2];
        let length = (start.position_m[2] - origin + rise * rise / (2.0 * gravity)).max(1e-3);
        Scale { origin, length, start_s: start_s + rise / gravity, time_s: (length / gravity).sqrt() }
    }

    fn wrong_kind(&self, seen: &Observation) -> Error {
        Error::Observation {
            what: "the observation".into(),
            expected: kind_name(self.kind).into(),
            found: kind_name(seen.kind()).into(),
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
        let preparation = match self.kind {
            Kind::EventTimes => self.prepare_bounces(seen)?,
            _ if self.flight_only => self.prepare_flight(seen)?,
            _ => self.prepare_positions(seen)?,
        };
        self.with_nuisances_of_effects(preparation)
    }

    fn effects(&self) -> Vec<Effect> {
        self.absent_effects()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        Ok(Box::new(self.freed(names)?))
    }

    fn assumed(&self) -> Vec<Assumed> {
        let value = self.scene.gravity_m_s2;
        if !USUAL_GRAVITY_M_S2.contains(&value) {
            return Vec::new();
        }
        let scene = Scene { gravity_m_s2: GRAVITY_M_S2.1, ..self.scene.clone() };
        let at_upper = Box::new(Self { scene, ..self.clone() });
        vec![Assumed { setting: "world.gravity_m_s2", value, range: GRAVITY_M_S2, unit: "m/s²", at_upper }]
    }

    fn segmented(&self) -> Option<&dyn Segmented> {
        Some(self)
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let (scene, start, time_s) = self.world(parameters, nuisances);
        if self.kind == Kind::Positions {
            let begin = self.begins_s(clock[0]);
            return Ok(positions(&scene, &start, begin, clock, values)?);
        }
        let last = clock[clock.len() - 1].max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of impacts, checked to be small"
        )]
        let count =
            if last < 1e6 { last as usize + 1 } else { return Err(format!("{last} impacts are too many").into()) };
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

/// Its free segments are flights, its events contacts, and its hidden state the spin.
impl Segmented for ObservedBall {
    fn free_segment(&self) -> Option<Box<dyn Simulator>> {
        Some(Box::new(self.flight_only()?))
    }

    fn with_hidden_state(&self) -> Option<Box<dyn Simulator>> {
        Some(Box::new(self.spinning()?))
    }

    fn with_hidden_state_at_events(&self) -> Option<Box<dyn Simulator>> {
        Some(Box::new(self.let_go_spinning()?))
    }

    fn proposed_starts(&self, prepared: &Prepared, nuisances: &[f64], unmeasured: &[usize]) -> Vec<ProposedStart> {
        releases::proposed(prepared, nuisances, unmeasured)
    }
}

/// What the file leaves out of a start that is observed as positions.
fn start_nuisances(release: &Release, surface_height_m: Option<f64>) -> Vec<Nuisance> {
    let mut nuisances = Vec::new();
    match (release.position_m, release.height_m) {
        (Some(_), _) => {}
        // The height fixes z through the surface; a drop from rest at a known instant stays on its vertical line.
        (None, Some(_)) => nuisances.extend([Nuisance::Position(0), Nuisance::Position(1)]),
        (None, None) => nuisances.extend([0, 1, 2].map(Nuisance::Position)),
    }
    if release.velocity_m_s.is_none() {
        nuisances.extend([0, 1, 2].map(Nuisance::Velocity));
    }
    if surface_height_m.is_none() {
        nuisances.push(Nuisance::Surface);
    }
    nuisances
}
