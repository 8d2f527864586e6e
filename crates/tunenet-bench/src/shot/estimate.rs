//! From what was seen to a tuned simulation file, by the code under test alone.
//!
//! An uncalibrated camera shows a ball that drifts: lengths in its picture are wrong by as much as the ball came nearer,
//! but instants are not. So the track is cut into flights, and what is tuned to is when they end.

use std::path::Path;

use anyhow::Result;
use serde::{Deserialize, Serialize};
use tunenet_ball::bounces;
use tunenet_core::diagnose::{self, Recording, Subject, Verdict};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::{self, tune};
use tunenet_sim::{Session, SimulationFile, simulator};

use super::super::tuning::apex;
use super::drop::clock;
use super::world::RADIUS_M;
use crate::scene::GRAVITY_M_S2;
use tunenet_cli::view::toml::alternatives::{fitted, open_to};
use tunenet_video_protocol::synthetic::Places;

/// Before a ball vanishes over an edge it flies lower than the table.
const LAST_FRAMES: usize = 3;
/// A ball that goes out of sight moves by more than this within its last frames, px; one that lies still is only lost.
const MOVES_PX: f64 = 2.0;
/// Between fewer bounces there is no flight to measure, and a drop is to be repeated.
pub const FEWEST_BOUNCES: usize = 2;
/// Fewer are no recording to tune to: a release and a restitution always fit two.
const FEWEST_TUNED: usize = 3;
/// What is planned with where a video shows nothing.
const UNKNOWN: f64 = 0.7;

/// A list without tables.
const NOTHING: &str = "[]";

/// A number with its 95 % interval.
type Ranged = (f64, (f64, f64));

/// What is plausible of a ball.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BallEstimate {
    pub restitution: Ranged,
    /// Effects with their coefficients.
    pub effects: Vec<(String, Vec<(String, Ranged)>)>,
    /// As `tune` or `diagnose` says it; empty where nothing could be tuned to.
    pub verdict: String,
    /// The explanations that are left where several are, as a list of TOML tables with their numbers.
    pub alternatives: String,
    /// The drag that is left open, in the same way.
    pub open_drag: String,
}

impl BallEstimate {
    /// A number that is taken as exact.
    pub fn exact(restitution: f64) -> Self {
        Self::new((restitution, (restitution, restitution)), String::new())
    }

    fn new(restitution: Ranged, verdict: String) -> Self {
        let (alternatives, open_drag) = (NOTHING.into(), NOTHING.into());
        Self { restitution, effects: Vec::new(), verdict, alternatives, open_drag }
    }

    /// Writes its values into a simulation file.
    fn put_into(&self, file: &mut SimulationFile) -> Result<()> {
        // Without any rebound there is no shot to plan.
        file.set_value("restitution", self.restitution.0.max(0.05));
        for (name, coefficients) in &self.effects {
            let values: Vec<(&str, f64)> = coefficients.iter().map(|(key, (v, _))| (key.as_str(), *v)).collect();
            file.add_effect(name, &values)?;
        }
        Ok(())
    }

    /// The simulation file that it makes, with its provenance.
    pub fn file(&self) -> Result<SimulationFile> {
        let mut file = scene(None)?;
        self.put_into(&mut file)?;
        let list = |(low, high): (f64, f64)| format!("[{low:?}, {high:?}]");
        let mut effects = Vec::new();
        for (name, coefficients) in &self.effects {
            let intervals = coefficients.iter().map(|(key, (_, i))| format!(", {key}_interval95 = {}", list(*i)));
            effects.push(format!("{{ name = \"{name}\"{} }}", intervals.collect::<String>()));
        }
        let list_of =
            |key: &str, tables: &str| if tables == NOTHING { String::new() } else { format!("{key} = {tables}\n") };
        let text = format!(
            "{}\n[provenance]\nverdict = \"{}\"\ninterval95 = {{ restitution = {} }}\neffects = [{}]\n{}{}",
            file.text(),
            self.verdict,
            list(self.restitution.1),
            effects.join(", "),
            list_of("alternatives", &self.alternatives),
            list_of("open_drag", &self.open_drag),
        );
        Ok(SimulationFile::parse(Path::new("tuned.toml"), &text)?)
    }
}

/// What a user knows of the ball, and of how it was dropped.
fn scene(fall_m: Option<f64>) -> Result<SimulationFile> {
    let fall = fall_m.map_or(String::new(), |fall| format!("release.height_m = {fall:?}\n"));
    let text = format!(
        "kind = \"ball\"\nball.radius_m = {RADIUS_M}\n{fall}world.gravity_m_s2 = {GRAVITY_M_S2}\n\
         [parameters.restitution]\nvalue = 0.5\nmin = 0.0\nmax = 1.0\n"
    );
    Ok(SimulationFile::parse(Path::new("ball.toml"), &text)?)
}

/// A video as it is read.
pub struct Read {
    /// When the ball bounced, s.
    pub bounces_s: Vec<f64>,
}

impl Read {
    pub fn new(track: Option<&Places>) -> Self {
        let Some(track) = track else { return Self { bounces_s: Vec::new() } };
        let last = track.seen.iter().rposition(|seen| *seen).map_or(0, |last| last + 1);
        let seen: Vec<f64> = track.v_px.iter().zip(&track.seen).filter(|(_, seen)| **seen).map(|(v, _)| *v).collect();
        let ending = &seen[seen.len().saturating_sub(LAST_FRAMES + 1)..];
        let (low, high) = ending.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let gone = last < track.seen.len() && high - low > MOVES_PX;
        let end = if gone { last.saturating_sub(LAST_FRAMES) } else { last };
        let shown = clock().into_iter().zip(&track.v_px).zip(&track.seen).take(end).filter(|(_, seen)| **seen);
        let (times, up): (Vec<f64>, Vec<f64>) = shown.map(|((t, v), _)| (t, -v)).unzip();
        Self { bounces_s: bounces(&times, &up) }
    }

    /// Whether this drop is to be repeated: it shows too little. What was seen of a ball before it left is as good as ever.
    pub fn flagged(&self) -> bool {
        self.bounces_s.len() < FEWEST_BOUNCES
    }

    /// Whether there is enough of it to tune to.
    fn lists(&self) -> bool {
        self.bounces_s.len() >= FEWEST_TUNED
    }

    /// The restitution alone, tuned to this drop. Two bounces are too few for `tune`; between them lies 2 e v / g, where
    /// v is the speed of the known fall.
    pub fn tuned(&self, fall_m: f64) -> Result<BallEstimate> {
        let two = || match self.bounces_s[..] {
            [first, second] => GRAVITY_M_S2 * (second - first) / (8.0 * GRAVITY_M_S2 * fall_m).sqrt(),
            _ => UNKNOWN,
        };
        Ok(tuned(&self.bounces_s, fall_m)?.unwrap_or_else(|| BallEstimate::exact(two().clamp(0.05, 1.0))))
    }
}

/// Tuned to a list of bounces; `None` where that is not possible.
pub fn tuned(bounces_s: &[f64], fall_m: f64) -> Result<Option<BallEstimate>> {
    if bounces_s.len() < FEWEST_TUNED {
        return Ok(None);
    }
    tuned_to(&[tunenet_ball::bounce_times(bounces_s.to_vec())?], fall_m)
}

fn tuned_to(seen: &[Observation], fall_m: f64) -> Result<Option<BallEstimate>> {
    let ball = simulator(&scene(Some(fall_m))?, Kind::EventTimes, &Session::default())?;
    let outcome = tune(&ball, seen, None, &tune::Settings::default())?;
    let Some(found) = outcome.parameters.iter().find(|p| p.name == "restitution" && p.identified) else {
        return Ok(None);
    };
    let verdict = serde_json::to_value(outcome.verdict)?.as_str().unwrap_or_default().to_owned();
    Ok(Some(BallEstimate::new((found.value, found.interval95), verdict)))
}

/// What several drops of one ball from one height show.
pub struct Several {
    seen: Vec<Observation>,
    fall_m: f64,
}

impl Several {
    pub fn new(drops: &[Read], fall_m: f64) -> Result<Self> {
        let lists = drops.iter().filter(|drop| drop.lists());
        let seen =
            lists.map(|d| tunenet_ball::bounce_times(d.bounces_s.clone())).collect::<tunenet_core::Result<_>>()?;
        Ok(Self { seen, fall_m })
    }

    /// The restitution alone, tuned to all of them; `None` where none can be tuned to.
    pub fn tuned(&self) -> Result<Option<BallEstimate>> {
        if self.seen.is_empty() { Ok(None) } else { tuned_to(&self.seen, self.fall_m) }
    }

    /// What a diagnosis of them finds; `None` where it finds nothing to plan with.
    pub fn diagnosed(&self) -> Result<Option<BallEstimate>> {
        if self.seen.is_empty() {
            return Ok(None);
        }
        let simulator = simulator(&scene(Some(self.fall_m))?, Kind::EventTimes, &Session::default())?;
        let subjects = [Subject { name: "ball".into(), simulator: simulator.as_ref() }];
        let recordings: Vec<Recording> = (1..)
            .zip(&self.seen)
            .map(|(i, seen)| Recording { name: format!("drop {i}"), object: 0, held_out: false, seen })
            .collect();
        let settings = diagnose::Settings { set_aside: false, ..diagnose::Settings::default() };
        let found = tunenet_ball::diagnose(&subjects, &recordings, &settings, &|_| {})?;
        let Some(e) = found.parameters.iter().find(|p| p.name == "restitution") else { return Ok(None) };
        let effects = found.effects().iter().map(|named| {
            let one =
                |c: &diagnose::Fitted| Some((c.key.to_string(), c.values.first().map(|v| (v.value, v.interval95))?));
            (named.effect.name.to_string(), named.coefficients.iter().filter_map(one).collect())
        });
        let verdict = serde_json::to_value(found.verdict())?.as_str().unwrap_or_default().to_owned();
        let effects = effects.collect();
        // As `tunenet diagnose` writes them into its file.
        let named = found.effects().iter().map(|e| e.effect.name.as_ref());
        let sure: Vec<&str> = named.filter(|name| !found.names().contains(name)).collect();
        let alternatives = match found.verdict() {
            Verdict::OneOf => fitted(simulator.as_ref(), &found.names(), &sure, &self.seen, None).to_string(),
            _ => NOTHING.into(),
        };
        let restitution = (e.value, e.interval95);
        let estimate = BallEstimate { restitution, effects, verdict, alternatives, open_drag: NOTHING.into() };
        let closed = matches!(found.verdict(), Verdict::None | Verdict::Named);
        Ok(Some(if closed { self.with_open_drag(estimate)? } else { estimate }))
    }

    /// An estimate from them with the drag that they leave open, as `tunenet tune` and `tunenet diagnose` write it
    /// into their files.
    pub fn with_open_drag(&self, estimate: BallEstimate) -> Result<BallEstimate> {
        let mut tuned = scene(Some(self.fall_m))?;
        estimate.put_into(&mut tuned)?;
        let sure: Vec<&str> = estimate.effects.iter().map(|e| e.0.as_str()).collect();
        let open_drag = open_to(&tuned, &sure, &self.seen)?.to_string();
        Ok(BallEstimate { open_drag, ..estimate })
    }
}

/// The rule `√(first rebound / fall)` on raw pixels: the lowest place seen is the table.
pub fn apex_on_pixels(track: Option<&Places>, fall_m: f64) -> f64 {
    let Some(track) = track else { return UNKNOWN };
    let floor = track.v_px.iter().copied().fold(f64::MIN, f64::max);
    let unit = fall_m / (floor - track.v_px[0]).max(1.0);
    let heights: Vec<f64> = track.v_px.iter().map(|v| (floor - v) * unit).collect();
    apex(fall_m, &clock(), &heights)
}

/// All that there is to know of a ball.
pub fn known(ball: &super::ball::ShotBall) -> BallEstimate {
    let exact = |v: f64| (v, (v, v));
    let one = |name: &str, key: &str, value: f64| (name.to_owned(), vec![(key.to_owned(), exact(value))]);
    // A normal that is turned by an angle turns a rebound by more, as the way there turns as well.
    let tilt = ball.scatter_rad * ball.restitution / (1.0 + ball.restitution);
    let mut effects = vec![
        one("quadratic_drag", "c_1_m", ball.drag_1_m),
        one("bounce_friction", "mu", ball.friction),
        one("bounce_scatter", "sd_rad", tilt),
    ];
    if ball.exponent != 0.0 {
        effects.push(one("speed_dependent_restitution", "exponent", ball.exponent));
    }
    BallEstimate { effects, ..BallEstimate::new(exact(ball.restitution), "named".into()) }
}
