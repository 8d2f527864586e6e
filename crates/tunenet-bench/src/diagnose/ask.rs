//! The code under test, asked about recordings. Nothing but the recordings goes in.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use tunenet_ball::diagnose;
use tunenet_core::diagnose::{Diagnosis, Recording, Settings, Subject, Verdict};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::Simulator;
use tunenet_sim::law::contested;
use tunenet_sim::{Session, SimulationFile, simulator};

use super::blind::RADIUS_M;
use super::trial::Answer;
use crate::scene::GRAVITY_M_S2;

/// What a person would know of the scene beforehand: the ball's size. Its mass is left open, as an effect of any size is to
/// be found.
const SCENE: &str = "\
kind = \"ball\"

[parameters.restitution]
value = 0.5
min = 0.0
max = 1.0

[parameters.friction]
value = 0.0
min = 0.0
max = 2.0
tune = false
";

/// What a person would declare who suspects one of six causes: forms that are known up to their numbers, in this page's words.
const FORMULAS: &str = "\
[candidates.fan]
sentence = \"a fan blows within a band of heights\"
acts = \"flight\"
along = [\"x\", \"y\"]
formula = \"a * exp(-((z_m - h) / w)^2)\"
per_direction = [\"a\"]
coefficients.a = { unit = \"m/s²\", absent = 0.0, min = -10.0, max = 10.0 }
coefficients.h = { unit = \"m\", min = 0.0, max = 2.0 }
coefficients.w = { unit = \"m\", min = 0.05, max = 1.0 }

[candidates.shear]
sentence = \"a wind grows with height\"
acts = \"flight\"
along = [\"x\", \"y\"]
formula = \"s * z_m\"
per_direction = [\"s\"]
coefficients.s = { unit = \"1/s²\", absent = 0.0, min = -10.0, max = 10.0 }

[candidates.constant_brake]
sentence = \"a brake of constant force\"
acts = \"flight\"
along = [\"v\"]
formula = \"-b\"
coefficients.b = { unit = \"m/s²\", absent = 0.0, min = 0.0, max = 10.0 }

[candidates.vortex]
sentence = \"air turns around a vertical axis\"
acts = \"flight\"
along = [\"around\"]
formula = \"k * sqrt(x_m^2 + y_m^2)\"
coefficients.k = { unit = \"1/s²\", absent = 0.0, min = -20.0, max = 20.0 }

[candidates.magnet]
sentence = \"a magnet under the floor\"
acts = \"flight\"
along = [\"z\"]
formula = \"-m / (1 + (z_m / d)^2)^2\"
coefficients.m = { unit = \"m/s²\", absent = 0.0, min = 0.0, max = 60.0 }
coefficients.d = { unit = \"m\", min = 0.02, max = 0.5 }

[candidates.updraught]
sentence = \"an updraught that grows with the time\"
acts = \"flight\"
along = [\"z\"]
formula = \"u * t_s\"
coefficients.u = { unit = \"m/s³\", absent = 0.0, min = -10.0, max = 10.0 }
";

/// A throw that was asked for.
pub struct RequestedThrow {
    pub position_m: [f64; 3],
    pub velocity_m_s: [f64; 3],
}

/// Who is asked.
pub struct Asked {
    file: SimulationFile,
    simulator: Box<dyn Simulator>,
}

impl Asked {
    pub fn new() -> Result<Self> {
        Self::of("", &[])
    }

    /// Asks with the mass of the ball, kg, in the file.
    pub fn with_mass(mass_kg: f64) -> Result<Self> {
        Self::of("", &[format!("ball.mass_kg={mass_kg}")])
    }

    /// Asks with formulas of six effects in the file.
    pub fn with_formulas() -> Result<Self> {
        Self::of(FORMULAS, &[])
    }

    fn of(more: &str, keys: &[String]) -> Result<Self> {
        let text = format!("ball.radius_m = {RADIUS_M}\n{SCENE}\n{more}");
        let mut file = SimulationFile::parse(Path::new("blind.toml"), &text)?;
        file.set(&format!("world.gravity_m_s2={GRAVITY_M_S2}"))?;
        for key in keys {
            file.set(key)?;
        }
        let simulator = simulator(&file, Kind::Positions, &Session::default())?;
        Ok(Self { file, simulator })
    }

    /// The answer to `seen`, judged by `held_out`, and the throw that it asks for next.
    pub fn ask(&self, seen: &[Observation], held_out: &[Observation]) -> Result<(Answer, Option<RequestedThrow>)> {
        let subjects = [Subject { name: "ball".into(), simulator: self.simulator.as_ref() }];
        let one = |(number, seen, held_out)| {
            let kind = if held_out { "held out" } else { "drop" };
            Recording { name: format!("{kind} {number}"), object: 0, held_out, seen }
        };
        let recordings: Vec<Recording> = seen
            .iter()
            .enumerate()
            .map(|(i, o)| one((i + 1, o, false)))
            .chain(held_out.iter().enumerate().map(|(i, o)| one((i + 1, o, true))))
            .collect();
        let settings = Settings { set_aside: false, ..Settings::default() };
        let began = Instant::now();
        let diagnosis = diagnose(&subjects, &recordings, &settings, &|_| {})?;
        let all: Vec<&Observation> = seen.iter().chain(held_out).collect();
        let diagnosis = contested(&self.file, diagnosis, &all);
        let seconds = began.elapsed().as_secs_f64();
        Ok((answer(&diagnosis, seconds)?, throw(&diagnosis)))
    }
}

fn answer(diagnosis: &Diagnosis, seconds: f64) -> Result<Answer> {
    let gap = diagnosis.gap.as_ref();
    let owned = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let effects: Vec<&str> = diagnosis.effects().iter().map(|e| e.effect.name.as_ref()).collect();
    Ok(Answer {
        verdict: serde_json::to_value(diagnosis.verdict())?.as_str().unwrap_or_default().into(),
        effects: if diagnosis.verdict() == Verdict::Named { owned(&effects) } else { vec![] },
        candidates: if diagnosis.verdict() == Verdict::Named { vec![] } else { owned(&diagnosis.names()) },
        held_out_m: gap.and_then(|g| Some(g.held_out?.after)),
        forecast_m: gap.and_then(|g| Some(g.forecast?.after)),
        rollouts: diagnosis.rollouts as u64,
        seconds,
    })
}

/// The start of the throw that is asked for, where it is one; what it leaves unsaid is a drop from a metre.
fn throw(diagnosis: &Diagnosis) -> Option<RequestedThrow> {
    let settings = &diagnosis.next_experiment.as_ref()?.settings;
    if settings.is_empty() {
        return None;
    }
    let number = |name: &str, unsaid: f64| settings.iter().find(|(n, _)| n == name).map_or(unsaid, |(_, v)| *v);
    let axes = ["x", "y", "z"];
    let height = number("release.height", 1.0) + RADIUS_M;
    Some(RequestedThrow {
        position_m: axes.map(|axis| number(&format!("release.{axis}"), if axis == "z" { height } else { 0.0 })),
        velocity_m_s: axes.map(|axis| number(&format!("release.velocity_{axis}"), 0.0)),
    })
}
