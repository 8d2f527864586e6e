//! An arm whose motion was measured: its torques are computed from the motion by inverse dynamics.
//!
//! ```text
//! log → checks → even clock, smoothed positions, their slopes (Recorded) → rigid torques and payload columns (input)
//!     → friction, gain, … (Imperfections) → means over the windows of the measured torques
//! ```
//!
//! Positions are smoothed by a Butterworth filter without delay ([`CUTOFF_HZ`]) and differentiated; measured speeds are only
//! checked against them. Torques are averaged over windows of half a period of the cut-off, the measured and the predicted
//! alike: so white noise stays white, and what friction does within a window is in both.

mod acting;
mod checks;
mod file;
mod filter;
mod recorded;
mod reference;
mod signs;
mod suspicions;
mod torque;

use std::sync::Arc;

use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Note, Observation};
use tunenet_core::observation::{Check, State};
use tunenet_core::simulator::{Effect, Parameter, Preparation, Prepared, Rejected, RolloutResult, Simulator};
use tunenet_core::{Error, Origin, Result};
use tunenet_formats::kind_name;

use crate::findings;

pub use checks::suspect_units;
pub use file::{replayed, replays};
pub use reference::with_reference;
pub use suspicions::suspect;

use crate::arm::effects::{ALL, Imperfections};
use crate::arm::model_file::JointFriction;
use crate::arm::{Frame, Model};
use crate::formula_effect::FormulaEffect;
use acting::Acting;
use recorded::{Recorded, columns};
use torque::{Arm, Means, cube};

/// Cut-off of the smoothing, Hz: arms move below 2 Hz, and slopes of slower motion are exact.
pub const CUTOFF_HZ: f64 = 10.0;
/// Fewest windows that are worth a fit.
const FEWEST_WINDOWS: usize = 20;

/// What a parameter of a replayed arm changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Mass,
    Com(usize),
    Gain,
}

impl Role {
    fn of(name: &str) -> Option<Self> {
        match name {
            "payload_mass" => Some(Self::Mass),
            "payload_com_x" => Some(Self::Com(0)),
            "payload_com_y" => Some(Self::Com(1)),
            "payload_com_z" => Some(Self::Com(2)),
            "torque_gain" => Some(Self::Gain),
            _ => None,
        }
    }
}

/// An arm that replays measured motions, as a simulator that core can tune: it predicts the torques of its joints.
///
/// A recording is a log of joints ([`Kind::Joints`]) with positions and torques, or currents with torque constants. With a
/// reference next to it ([`with_reference`]) the prediction is of the difference of both runs' torques.
#[derive(Debug, Clone)]
pub struct ReplayedArm {
    arm: Arc<Arm>,
    /// Friction that the URDF itself has.
    known: Imperfections,
    current_gain_nm_a: Option<Vec<f64>>,
    cutoff_hz: f64,
    payload_size_m: f64,
    parameters: Vec<Parameter>,
    roles: Vec<Role>,
    fixed: Vec<(Acting, Vec<f64>)>,
    free: Vec<Acting>,
    /// Effects that the file declares as formulas.
    formulas: Vec<FormulaEffect>,
    channels: Vec<Channel>,
}

impl ReplayedArm {
    /// The arm `model` with its payload in the frame `payload`, under this gravity (m/s²). Of the parameters the names are fixed:
    /// `payload_mass` (kg), `payload_com_x`, `_y`, `_z` (m, in the payload's frame) and `torque_gain` (measured over true).
    ///
    /// # Errors
    /// [`Error::Setting`] where a parameter has another name.
    pub fn new(model: Model, payload: Frame, gravity_m_s2: f64, parameters: Vec<Parameter>) -> Result<Self> {
        let joints = model.degrees();
        let role = |p: &Parameter| {
            Role::of(&p.name).ok_or_else(|| Error::Setting {
                origin: Origin::File,
                name: "parameters",
                expected: "payload_mass, payload_com_x, _y, _z or torque_gain".into(),
                found: format!("`{}`", p.name),
            })
        };
        let roles = parameters.iter().map(role).collect::<Result<Vec<_>>>()?;
        let mut known = Imperfections::none(joints);
        for (j, joint) in model.joints().into_iter().enumerate() {
            known.viscous_nms_rad[j] = joint.damping;
            known.coulomb_nm[j] = joint.friction;
        }
        let channels = (1..=joints).map(|j| Channel::new(format!("tau{j}"), "N·m")).collect();
        Ok(Self {
            arm: Arc::new(Arm { model, payload, gravity_m_s2 }),
            known,
            current_gain_nm_a: None,
            cutoff_hz: CUTOFF_HZ,
            payload_size_m: 0.0,
            parameters,
            roles,
            fixed: Vec::new(),
            free: Vec::new(),
            formulas: Vec::new(),
            channels,
        })
    }

    /// The same with the N·m of each joint for 1 A.
    ///
    /// # Errors
    /// [`Error::Setting`] where there is not one for each joint.
    pub fn with_current_gain(mut self, nm_a: Vec<f64>) -> Result<Self> {
        if nm_a.len() != self.arm.joints() {
            let (expected, found) =
                (format!("{} numbers, one for each joint", self.arm.joints()), nm_a.len().to_string());
            return Err(Error::Setting { origin: Origin::Caller, name: "arm.current_gain_nm_a", expected, found });
        }
        self.current_gain_nm_a = Some(nm_a);
        Ok(self)
    }

    /// The same with another cut-off of the smoothing, Hz.
    #[must_use]
    pub fn with_cutoff(mut self, hz: f64) -> Self {
        self.cutoff_hz = hz;
        self
    }

    /// The same with effects that a user wrote as formulas.
    #[must_use]
    pub fn with_formulas(mut self, formulas: Vec<FormulaEffect>) -> Self {
        self.formulas = formulas;
        self
    }

    /// The catalogue, then the formulas.
    fn known_effects(&self) -> impl Iterator<Item = Acting> {
        ALL.into_iter()
            .map(Acting::BuiltIn)
            .chain(self.formulas.iter().map(|formula| Acting::Formula(Box::new(formula.clone()))))
    }

    fn find(&self, name: &str) -> Result<Acting> {
        self.known_effects().find(|effect| effect.name() == name).ok_or_else(|| {
            let known: Vec<String> = self.known_effects().map(|e| e.name().to_owned()).collect();
            let expected = format!("an effect of an arm ({})", known.join(", "));
            Error::Setting { origin: Origin::Caller, name: "effects", expected, found: format!("`{name}`") }
        })
    }

    /// The same with an effect at these values.
    ///
    /// # Errors
    /// [`Error::Setting`] where it is unknown, or has not so many numbers.
    pub fn with_fixed(mut self, name: &str, values: &[f64]) -> Result<Self> {
        let effect = self.find(name)?;
        let expected = effect.numbers(self.arm.joints());
        if values.len() != expected {
            let (expected, found) = (format!("{expected} numbers of `{name}`"), values.len().to_string());
            return Err(Error::Setting { origin: Origin::Caller, name: "effects", expected, found });
        }
        self.fixed.push((effect, values.to_vec()));
        Ok(self)
    }

    /// The names of the joints that a log has to have, in order.
    #[must_use]
    pub fn joint_names(&self) -> Vec<String> {
        self.arm.model.joints().iter().map(|j| j.name.clone()).collect()
    }

    /// The friction of every joint, viscous (N·m·s/rad) and Coulomb's (N·m): the URDF's own, and what effects add at these
    /// `parameters`.
    #[must_use]
    pub fn friction(&self, parameters: &[f64]) -> Vec<JointFriction> {
        let (_, _, arm) = self.decoded(parameters);
        let one = |(j, joint): (usize, String)| JointFriction {
            joint,
            damping: arm.viscous_nms_rad[j],
            friction: arm.coulomb_nm[j],
        };
        self.joint_names().into_iter().enumerate().map(one).collect()
    }

    /// Measured torques of a run (`prefix` "r": of its reference), row-major.
    fn torques(&self, seen: &Observation, prefix: &str) -> Vec<f64> {
        let torques = columns(seen, &format!("{prefix}tau"));
        let (columns, gains) = if torques.is_empty() {
            (columns(seen, &format!("{prefix}i")), self.current_gain_nm_a.clone())
        } else {
            (torques, None)
        };
        let gain = |j: usize| gains.as_ref().map_or(1.0, |g| g[j]);
        (0..seen.len())
            .flat_map(|i| columns.iter().enumerate().map(move |(j, &c)| (i, j, c)))
            .map(|(i, j, c)| gain(j) * seen.row(i)[c])
            .collect()
    }

    /// What was measured in a run alone and what its arm needs, over windows of so many cells about these instants.
    fn torques_of(&self, log: &Recorded, cells: usize, clock: &[f64]) -> Result<signs::Torques> {
        let n = self.arm.joints();
        let window_s = cells as f64 * log.step_s;
        let averaged = |values: &[f64]| {
            let means = Means::new(values, n, log.start_s, log.step_s);
            let mut all = vec![0.0; clock.len() * n];
            clock.iter().zip(all.chunks_exact_mut(n)).for_each(|(t, row)| means.at(*t, window_s, row));
            all
        };
        let input = self.arm.input(log, None)?;
        let start: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        let (_, com, _) = self.decoded(&start);
        let shown = |mass: f64| averaged(&self.arm.shown(&input, &cube(mass, com, self.payload_size_m), &self.known));
        let (bare, held) = (shown(0.0), shown(1.0));
        let payload = held.iter().zip(&bare).map(|(held, bare)| held - bare).collect();
        Ok(signs::Torques { measured: averaged(&log.torque), bare, payload })
    }

    /// The payload and everything beyond rigid bodies, with these values of all parameters.
    fn decoded(&self, parameters: &[f64]) -> (f64, [f64; 3], Imperfections) {
        let (mut mass, mut com, mut arm) = (0.0, [0.0; 3], self.known.clone());
        for (role, value) in self.roles.iter().zip(parameters) {
            match *role {
                Role::Mass => mass = *value,
                Role::Com(axis) => com[axis] = *value,
                Role::Gain => arm.gain.iter_mut().for_each(|gain| *gain *= value),
            }
        }
        for (effect, values) in &self.fixed {
            effect.apply(&mut arm, values);
        }
        let mut rest = &parameters[self.roles.len()..];
        for effect in &self.free {
            let (values, others) = rest.split_at(effect.numbers(self.arm.joints()));
            effect.apply(&mut arm, values);
            rest = others;
        }
        com.iter_mut().zip(arm.com_offset_m).for_each(|(at, offset)| *at += offset);
        (mass, com, arm)
    }
}

impl Simulator for ReplayedArm {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Joints
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::Joints {
            let (expected, found) = ("joint series, as an arm's log has".into(), kind_name(seen.kind()).into());
            return Err(Error::Observation { what: "the recording".into(), expected, found });
        }
        let joints = self.arm.model.joints();
        let mut checks = checks::checks(seen, &joints, self.current_gain_nm_a.is_some());
        if let Some(note) = checks.iter().find(|c| c.state == State::Failed).and_then(Check::note) {
            return Ok(Preparation::Rejected(Box::new(Rejected { note, checks })));
        }
        let log = Recorded::new(seen, "", &self.torques(seen, ""), self.cutoff_hz);
        let reference = (!columns(seen, "rq").is_empty())
            .then(|| Recorded::new(seen, "r", &self.torques(seen, "r"), self.cutoff_hz));
        let cells = filter::whole((0.5 / (log.step_s * log.cutoff_hz)).round().max(1.0));
        let complete = |b: &usize| {
            let cells = b * cells..(b + 1) * cells;
            log.trusted[cells.clone()].iter().all(|t| *t)
                && reference.as_ref().is_none_or(|r| r.trusted[cells].iter().all(|t| *t))
        };
        let windows: Vec<usize> = (0..log.len() / cells).filter(complete).collect();
        if windows.len() < FEWEST_WINDOWS {
            let text = format!(
                "{} windows of {:.3} s remain between the ends; at least {FEWEST_WINDOWS} are needed",
                windows.len(),
                cells as f64 * log.step_s
            );
            let note = Note::new(findings::JOINTS_SHORT, text, "record for longer, without gaps");
            let check =
                Check { kind: note.kind, state: State::Failed, text: note.text.clone(), remedy: note.remedy.clone() };
            checks.push(check);
            return Ok(Preparation::Rejected(Box::new(Rejected { note, checks })));
        }
        let n = self.arm.joints();
        let (mut clock, mut values) = (Vec::new(), Vec::new());
        for &b in &windows {
            clock.push(log.start_s + ((b * cells) as f64 + 0.5 * (cells - 1) as f64) * log.step_s);
            for j in 0..n {
                let mean = |log: &Recorded| {
                    (b * cells..(b + 1) * cells).map(|i| log.torque[i * n + j]).sum::<f64>() / cells as f64
                };
                values.push(mean(&log) - reference.as_ref().map_or(0.0, mean));
            }
        }
        let ours = Observation::new(Kind::Joints, self.channels.clone(), clock, values)?;
        let mut prepared = Prepared::whole(ours, self.parameters.len());
        let other = |j: usize| reference.as_ref().map_or(0.0, |r| r.noise_nm[j]);
        let noise = |j: usize| (log.noise_nm[j].hypot(other(j))) / (cells as f64).sqrt();
        prepared.noise = Some((0..n).map(noise).collect());
        let motion = Input::new(self.arm.input(&log, reference.as_ref())?, Hold::Linear);
        prepared.circumstances = Some(Arc::new(Circumstances::driven_by(vec![motion])));
        prepared.memoryless = true;
        let torques = self.torques_of(&log, cells, prepared.seen.clock())?;
        checks.push(signs::signs(&torques, &joints, columns(seen, "tau").is_empty()));
        if reference.is_some() && checks.iter().all(|c| c.state != State::Failed) {
            checks.push(signs::swapped(&prepared, &torques, n));
        }
        if let Some(note) = checks.iter().find(|c| c.state == State::Failed).and_then(Check::note) {
            return Ok(Preparation::Rejected(Box::new(Rejected { note, checks })));
        }
        let present = self.fixed.iter().map(|(effect, _)| effect).chain(&self.free);
        prepared.notes = checks.iter().filter_map(Check::note).chain(present.flat_map(Acting::notes)).collect();
        prepared.checks = checks;
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn effects(&self) -> Vec<Effect> {
        let taken = |e: &Acting| self.fixed.iter().map(|(f, _)| f).chain(&self.free).any(|f| f.name() == e.name());
        self.known_effects().filter(|e| !taken(e)).map(|e| e.entry(self.arm.joints())).collect()
    }

    /// A coefficient of joint 2 becomes the parameter `viscous_friction.nms_rad.2`.
    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut arm = self.clone();
        for name in names {
            let effect = self.find(name)?;
            if arm.free.iter().any(|e| e.name() == *name) {
                let (expected, found) = ("each effect once".into(), format!("`{name}`"));
                return Err(Error::Setting { origin: Origin::Caller, name: "effects", expected, found });
            }
            let at = arm.fixed.iter().position(|(e, _)| e.name() == *name);
            let present = at.map(|i| arm.fixed.remove(i).1);
            arm.parameters.extend(effect.entry(self.arm.joints()).parameters(present.as_deref())?);
            arm.free.push(effect);
        }
        Ok(Box::new(arm))
    }

    fn rollout(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) -> RolloutResult {
        Err("a replayed arm needs a measured motion".into())
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        _: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let (mass, com, arm) = self.decoded(parameters);
        let n = self.arm.joints();
        let input = circumstances.inputs[0].series();
        let shown = self.arm.shown(input, &cube(mass, com, self.payload_size_m), &arm);
        let (first, last) = (input.clock()[0], input.clock()[input.len() - 1]);
        let step = (last - first) / (input.len() - 1) as f64;
        let cutoff = self.cutoff_hz.min(0.2 / step);
        let window = (0.5 / (step * cutoff)).round().max(1.0) * step;
        let means = Means::new(&shown, n, first, step);
        for (t, row) in clock.iter().zip(values.chunks_exact_mut(n)) {
            means.at(t - arm.delay_s, window, row);
        }
        Ok(())
    }
}
