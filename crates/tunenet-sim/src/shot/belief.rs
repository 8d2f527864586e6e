//! Monte Carlo draws from the uncertainty of a tuned simulation file of a ball.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use toml_edit::{InlineTable, Value};
use tunenet_core::observation::Note;
use tunenet_core::statistics::NORMAL_95;
use tunenet_formats::{Error, Result};

use super::Task;
use super::provenance::Provenance;
use crate::SimulationFile;
use crate::ball::effects::{BallEffect, DRAG, SCATTER};
use crate::ball::{Scene, State};
use crate::findings;
use crate::observed_ball::acting::apply_formula;
use crate::scene::BallParameters;
use crate::simulation_file::schema::number;

/// Where a file keeps the drag that recordings leave open.
const OPEN_DRAG: &str = "open_drag";

/// An open drag of less than this is worth no word, 1/m: it moves a shot over a metre by about a centimetre.
const WIDE_1_M: f64 = 0.01;

/// What a number of a ball is.
#[derive(Debug, Clone)]
enum Role {
    Restitution,
    Friction,
    /// A coefficient of an effect; all of one stand together, in its order.
    Coefficient(Box<BallEffect>),
}

/// A number with what is known of it.
#[derive(Debug, Clone)]
struct Quantity {
    name: String,
    role: Role,
    value: f64,
    /// 95 %, where the file says; else the value is taken as it is.
    interval: Option<(f64, f64)>,
    bounds: (f64, f64),
}

/// One explanation of what was measured, with its share of the belief.
#[derive(Debug, Clone)]
struct Alternative {
    weight: f64,
    quantities: Vec<Quantity>,
}

/// A ball as its simulation file describes it: the values, how far they may be off, and the explanations that are left.
#[derive(Debug, Clone)]
pub struct Belief {
    base: Scene,
    /// The ball of the file.
    nominal: Vec<Quantity>,
    alternatives: Vec<Alternative>,
    release_sd: (f64, f64),
    notes: Vec<Note>,
}

/// One drawn ball with what happens to its release.
#[derive(Debug, Clone)]
pub struct Draw {
    /// The ball.
    pub ball: Scene,
    /// Added to the place (m) and the velocity (m/s) of the release.
    pub offset: State,
}

impl Belief {
    /// The ball of `file`, let go as `task` says. Effects of the measurement are left out, and
    /// formulas act with the numbers of the file.
    ///
    /// # Errors
    /// [`Error::File`] where the file says nothing of the restitution, or that there is none; what its parameters refuse.
    pub fn new(file: &SimulationFile, task: &Task) -> Result<Self> {
        let parameters = file.parameters()?;
        let given = file.written_value(BallParameters::RESTITUTION);
        if given.is_none_or(|e| e <= 0.0) {
            let found = given.map_or("none".into(), |e| e.to_string());
            let message = format!("expected a restitution above 0, found {found}: without one no ball bounces");
            return Err(Error::file(
                file.path(),
                message,
                "tune the simulation first: `tunenet tune … --out tuned.toml`",
            ));
        }
        let provenance = Provenance { file };
        let (mut quantities, mut changed) = (Vec::new(), Vec::new());
        for parameter in parameters {
            let role = if parameter.name == BallParameters::FRICTION { Role::Friction } else { Role::Restitution };
            let interval = provenance.interval(&parameter.name);
            let interval = unless_edited(&parameter.name, parameter.value, interval, &mut changed);
            let bounds = (parameter.min, parameter.max);
            quantities.push(Quantity { name: parameter.name, role, value: parameter.value, interval, bounds });
        }
        for present in file.effects() {
            let Some(effect) = BallEffect::find(&present.name) else { continue };
            for (c, value) in effect.coefficients.iter().zip(&present.values) {
                let name = format!("{}.{}", effect.name, c.key);
                let interval = provenance.of_effect(effect.name, &c.key);
                let interval = unless_edited(&name, *value, interval, &mut changed);
                let (role, bounds) = (Role::Coefficient(Box::new(effect)), (c.min, c.max));
                quantities.push(Quantity { name, role, value: *value, interval, bounds });
            }
        }
        let edited = !changed.is_empty();
        let mut base = file.ball()?.simulated();
        for formula in file.formulas()? {
            if let Some(present) = file.effects().iter().find(|present| present.name == formula.effect.name) {
                apply_formula(&formula, &mut base, &present.values);
            }
        }
        let mut belief = Self {
            base,
            nominal: quantities.clone(),
            alternatives: vec![Alternative { weight: 1.0, quantities }],
            release_sd: (task.release.position_sd_m, task.release.velocity_sd_m_s),
            notes: provenance.notes().into_iter().chain(changed).collect(),
        };
        belief.weigh(&provenance, edited);
        Ok(belief)
    }

    /// What a user should know of it.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The ball at the values of the file.
    #[must_use]
    pub fn nominal(&self) -> Scene {
        let values: Vec<f64> = self.nominal.iter().map(|q| q.value).collect();
        self.scene(&self.nominal, &values, None)
    }

    /// `count` balls drawn with this seed. Explanations are sampled in proportion to their weight.
    #[must_use]
    pub fn draws(&self, count: usize, seed: u64) -> Vec<Draw> {
        let total: f64 = self.alternatives.iter().map(|a| a.weight).sum();
        (0..count).map(|i| self.draw((i as f64 + 0.5) / count as f64 * total, seed, i as u64)).collect()
    }

    fn draw(&self, place: f64, seed: u64, number: u64) -> Draw {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        let mut left = place;
        let chosen = self.alternatives.iter().find(|a| {
            left -= a.weight;
            left <= 0.0
        });
        let alternative = chosen.unwrap_or(&self.alternatives[0]);
        let (at, speed) = self.release_sd;
        // Drawn first, so that the ball of an explanation does not decide how it is released.
        let offset = State {
            position_m: std::array::from_fn(|_| at * normal()),
            velocity_m_s: std::array::from_fn(|_| speed * normal()),
            ..State::default()
        };
        let deflection = [normal(), normal()];
        let values: Vec<f64> = alternative.quantities.iter().map(|q| q.draw(normal())).collect();
        Draw { ball: self.scene(&alternative.quantities, &values, Some(deflection)), offset }
    }

    /// The ball with these values; `deflection` are standard normal numbers for the tilt of its bounce.
    fn scene(&self, quantities: &[Quantity], values: &[f64], deflection: Option<[f64; 2]>) -> Scene {
        let mut scene = self.base.clone();
        let mut i = 0;
        while let Some(quantity) = quantities.get(i) {
            match &quantity.role {
                Role::Restitution => scene.restitution = values[i],
                Role::Friction => scene.friction += values[i],
                Role::Coefficient(effect) => {
                    let coefficients = &values[i..i + effect.coefficients.len()];
                    if effect.name == SCATTER {
                        scene.contact.tilts_rad.extend(
                            deflection.map(|deflection| deflection.map(|k| (k * coefficients[0]).clamp(-1.0, 1.0))),
                        );
                    }
                    (effect.apply)(&mut scene, coefficients);
                    i += coefficients.len() - 1;
                }
            }
            i += 1;
        }
        scene
    }

    /// Takes in the explanations among which a diagnosis could not choose, or every drag that recordings left open.
    /// Of a file whose values were `changed` since, both belong to other values and are passed over.
    fn weigh(&mut self, provenance: &Provenance, changed: bool) {
        if changed {
            return;
        }
        let known = self.alternatives[0].clone();
        if let Some(listed) = provenance.list("alternatives") {
            let name = |table: &InlineTable| table.get("name").and_then(Value::as_str).and_then(BallEffect::find);
            let explained = listed.into_iter().filter(|table| table.contains_key("name"));
            let all: Vec<Alternative> = explained.map(|table| known.with(name(table), table, provenance)).collect();
            if !all.is_empty() {
                self.alternatives = all;
            }
        } else if let (Some(listed), false) = (provenance.list(OPEN_DRAG), self.holds(DRAG)) {
            let drag = BallEffect::find(DRAG);
            if !listed.iter().all(|table| self.understands(drag.as_ref(), table)) {
                let text = "`open_drag` in the file is not in tunenet's form: no drag is assumed";
                self.notes.push(Note::new(findings::PLAN_OPEN_DRAG, text, "tune the file again, or remove that line"));
                return;
            }
            let all: Vec<Alternative> = listed.into_iter().map(|table| known.with(drag, table, provenance)).collect();
            if !all.is_empty() {
                self.notes.extend(range(&all));
                self.alternatives = all;
            }
        }
    }

    /// Whether a table of open drag has all that tunenet writes: a strength, a weight, and what was tuned with it.
    fn understands(&self, drag: Option<&BallEffect>, table: &InlineTable) -> bool {
        let of = |key: &str| table.get(key).and_then(number).unwrap_or(f64::NAN);
        let strength = drag.and_then(|effect| effect.coefficients.first());
        let tuned = |q: &Quantity| {
            let value = of(&q.name.replace('.', "_"));
            // The restitution of a ball that bounces is above 0, and was tuned.
            match q.role {
                Role::Restitution => value > 0.0 && value <= q.bounds.1,
                _ => value.is_nan() || (q.bounds.0..=q.bounds.1).contains(&value),
            }
        };
        strength.is_some_and(|c| (c.min..=c.max).contains(&of(&c.key)))
            && (0.0..=1.0).contains(&of("weight"))
            && self.nominal.iter().all(tuned)
    }

    /// Whether the file holds an effect of this name.
    fn holds(&self, name: &str) -> bool {
        self.nominal.iter().any(|q| matches!(&q.role, Role::Coefficient(effect) if effect.name == name))
    }
}

impl Alternative {
    /// The same ball with one more effect (an effect of the measurement leaves it as it is), all numbers as in `table`.
    fn with(&self, effect: Option<BallEffect>, table: &InlineTable, provenance: &Provenance) -> Self {
        let mut one = self.clone();
        // The explanation that the file holds is one of them, and stands for itself alone.
        one.quantities.retain(|q| !matches!(&q.role, Role::Coefficient(e) if provenance.is_alternative(e.name)));
        for quantity in &mut one.quantities {
            let key = quantity.name.replace('.', "_");
            if let Some(value) = table.get(&key).and_then(number) {
                quantity.value = value.clamp(quantity.bounds.0, quantity.bounds.1);
                quantity.interval = interval(table, &key, quantity.value);
            }
        }
        if let Some(effect) = effect {
            for c in effect.coefficients {
                let value = table.get(&c.key).and_then(number).unwrap_or(c.absent).clamp(c.min, c.max);
                one.quantities.push(Quantity {
                    name: format!("{}.{}", effect.name, c.key),
                    role: Role::Coefficient(Box::new(effect)),
                    value,
                    interval: interval(table, &c.key, value),
                    bounds: (c.min, c.max),
                });
            }
        }
        one.weight = table.get("weight").and_then(number).filter(|w| *w >= 0.0).unwrap_or(1.0);
        one
    }
}

/// The interval of a value, unless the value was edited since; that is reported.
fn unless_edited(name: &str, value: f64, interval: Option<(f64, f64)>, notes: &mut Vec<Note>) -> Option<(f64, f64)> {
    let (low, high) = interval?;
    if (low..=high).contains(&value) {
        return interval;
    }
    let text =
        format!("{name} is {value}, which is outside the tuned interval ({low} to {high}); it is taken as exact");
    notes.push(Note::new(findings::PLAN_CHANGED, text, "tune the file again, or restore the value"));
    None
}

/// The 95 % interval next to a number of a table, where it holds that number.
fn interval(table: &InlineTable, key: &str, value: f64) -> Option<(f64, f64)> {
    let list = table.get(&format!("{key}_interval95"))?.as_array()?;
    let (low, high) = (number(list.get(0)?)?, number(list.get(1)?)?);
    (low..=high).contains(&value).then_some((low, high))
}

/// Says how far drag is open; `None` where it hardly is.
fn range(open: &[Alternative]) -> Option<Note> {
    let of = |a: &Alternative| a.quantities.last().map_or(0.0, |q| q.value);
    let least = open.iter().filter(|a| a.weight > 0.0).map(of).fold(f64::INFINITY, f64::min);
    let greatest = open.iter().filter(|a| a.weight > 0.0).map(of).fold(f64::NEG_INFINITY, f64::max);
    (greatest - least > WIDE_1_M).then(|| {
        let text = format!(
            "the measurement leaves air drag uncertain (c from {least:.3} to {greatest:.3} 1/m): the \
             balls that are drawn have all of it"
        );
        Note::new(findings::PLAN_OPEN_DRAG, text, "a recording with more or higher bounces reduces this")
    })
}

impl Quantity {
    /// The value where a standard normal number falls, each side of the interval as wide as it is.
    fn draw(&self, normal: f64) -> f64 {
        let Some((low, high)) = self.interval else { return self.value };
        let half = if normal < 0.0 { self.value - low } else { high - self.value };
        (self.value + normal * half.max(0.0) / NORMAL_95).clamp(self.bounds.0, self.bounds.1)
    }
}
