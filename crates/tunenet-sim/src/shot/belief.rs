//! What a tuned simulation file leaves uncertain of a ball, and draws from it.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use toml_edit::{InlineTable, Item, Value};
use tunenet_core::observation::Note;
use tunenet_core::{Error, Result};

use super::Task;
use crate::SimulationFile;
use crate::ball::effects::BallEffect;
use crate::ball::{Scene, State};
use crate::observed_ball::scene;
use crate::simulation_file::schema::number;

/// Half a 95 % interval of a normal distribution, in standard deviations.
const INTERVAL: f64 = 1.959_964;
/// The effect that turns every bounce by chance.
const SCATTER: &str = "bounce_scatter";

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
    /// The ball of `file`, let go as `task` says. Effects of the measurement are left out.
    ///
    /// # Errors
    /// [`Error::File`] where the file says nothing of the restitution, or that there is none; what its parameters refuse.
    pub fn new(file: &SimulationFile, task: &Task) -> Result<Self> {
        let parameters = file.parameters()?;
        let given = file.number("parameters.restitution.value");
        if given.is_none_or(|e| e <= 0.0) {
            let found = given.map_or("none".into(), |e| e.to_string());
            let message =
                format!("expected a restitution above 0, found {found}: without one no ball bounces to a hoop");
            return Err(Error::file(
                file.path(),
                message,
                "tune the simulation first: `tunenet tune … --out tuned.toml`",
            ));
        }
        let provenance = Provenance { file };
        let (mut quantities, mut changed) = (Vec::new(), Vec::new());
        for (parameter, role) in parameters.into_iter().zip([Role::Restitution, Role::Friction]) {
            let mut interval = provenance.interval(&parameter.name);
            if let Some((low, high)) = interval.filter(|(low, high)| !(*low..=*high).contains(&parameter.value)) {
                let (name, value) = (&parameter.name, parameter.value);
                let text =
                    format!("{name} is {value}, which is not what was tuned ({low} to {high}); it is taken as exact");
                changed.push(Note::new("plan.changed", text, "tune the file anew, or leave its value as it was"));
                interval = None;
            }
            let bounds = (parameter.min, parameter.max);
            quantities.push(Quantity { name: parameter.name, role, value: parameter.value, interval, bounds });
        }
        for present in file.effects() {
            let Some(effect) = BallEffect::find(&present.name) else { continue };
            for (c, value) in effect.coefficients.iter().zip(&present.values) {
                quantities.push(Quantity {
                    name: format!("{}.{}", effect.name, c.key),
                    role: Role::Coefficient(Box::new(effect)),
                    value: *value,
                    interval: provenance.of_effect(effect.name, c.key),
                    bounds: (c.min, c.max),
                });
            }
        }
        let known = vec![Alternative { weight: 1.0, quantities }];
        let mut belief = Self {
            base: scene(file),
            alternatives: known,
            release_sd: (task.release_position_sd_m, task.release_velocity_sd_m_s),
            notes: provenance.notes().into_iter().chain(changed).collect(),
        };
        belief.weigh(&provenance);
        Ok(belief)
    }

    /// What a person should know of it.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The ball at the values of the file.
    #[must_use]
    pub fn nominal(&self) -> Scene {
        let alternative = &self.alternatives[0];
        let values: Vec<f64> = alternative.quantities.iter().map(|q| q.value).collect();
        self.scene(alternative, &values, None)
    }

    /// So many balls, drawn with this seed. Explanations take turns by their weight.
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
        // Drawn first, so that the ball of an explanation does not decide how it is let go.
        let offset = State {
            position_m: std::array::from_fn(|_| at * normal()),
            velocity_m_s: std::array::from_fn(|_| speed * normal()),
            ..State::default()
        };
        let kick = [normal(), normal()];
        let values: Vec<f64> = alternative.quantities.iter().map(|q| q.draw(normal())).collect();
        Draw { ball: self.scene(alternative, &values, Some(kick)), offset }
    }

    /// The ball with these values; `kick` are standard normal numbers for its bounce.
    fn scene(&self, alternative: &Alternative, values: &[f64], kick: Option<[f64; 2]>) -> Scene {
        let mut scene = self.base.clone();
        let mut i = 0;
        while let Some(quantity) = alternative.quantities.get(i) {
            match &quantity.role {
                Role::Restitution => scene.restitution = values[i],
                Role::Friction => scene.friction += values[i],
                Role::Coefficient(effect) => {
                    let own = &values[i..i + effect.coefficients.len()];
                    if effect.name == SCATTER {
                        scene.contact.kicks_rad.extend(kick.map(|kick| kick.map(|k| (k * own[0]).clamp(-1.0, 1.0))));
                    }
                    (effect.apply)(&mut scene, own);
                    i += own.len() - 1;
                }
            }
            i += 1;
        }
        scene
    }

    /// Takes in the explanations among which a diagnosis could not choose.
    fn weigh(&mut self, provenance: &Provenance) {
        let Some(listed) = provenance.alternatives() else { return };
        let known = self.alternatives[0].clone();
        let mut alternatives: Vec<Alternative> = Vec::new();
        for table in listed {
            let Some(name) = table.get("name").and_then(Value::as_str) else { continue };
            let mut one = known.clone();
            // The explanation that the file holds is one of them, and stands for itself alone.
            one.quantities.retain(|q| !matches!(&q.role, Role::Coefficient(e) if provenance.is_alternative(e.name)));
            for quantity in &mut one.quantities {
                if let Some(value) = table.get(&quantity.name.replace('.', "_")).and_then(number) {
                    (quantity.value, quantity.interval) = (value.clamp(quantity.bounds.0, quantity.bounds.1), None);
                }
            }
            // An effect of the measurement leaves the ball as it is.
            if let Some(effect) = BallEffect::find(name) {
                for c in effect.coefficients {
                    let value = table.get(c.key).and_then(number).unwrap_or(c.absent).clamp(c.min, c.max);
                    let (name, role) = (format!("{}.{}", effect.name, c.key), Role::Coefficient(Box::new(effect)));
                    one.quantities.push(Quantity { name, role, value, interval: None, bounds: (c.min, c.max) });
                }
            }
            one.weight = table.get("weight").and_then(number).filter(|w| *w > 0.0).unwrap_or(1.0);
            alternatives.push(one);
        }
        if !alternatives.is_empty() {
            self.alternatives = alternatives;
        }
    }
}

impl Quantity {
    /// The value where a standard normal number falls, each side of the interval as wide as it is.
    fn draw(&self, normal: f64) -> f64 {
        let Some((low, high)) = self.interval else { return self.value };
        let half = if normal < 0.0 { self.value - low } else { high - self.value };
        (self.value + normal * half.max(0.0) / INTERVAL).clamp(self.bounds.0, self.bounds.1)
    }
}

/// What wrote a file, and how sure it was.
struct Provenance<'a> {
    file: &'a SimulationFile,
}

impl Provenance<'_> {
    fn item(&self, key: &str) -> Option<&Item> {
        self.file.item("provenance")?.as_table_like()?.get(key)
    }

    fn word(&self, key: &str) -> &str {
        self.item(key).and_then(Item::as_str).unwrap_or_default()
    }

    /// The 95 % interval of a parameter.
    fn interval(&self, name: &str) -> Option<(f64, f64)> {
        pair(self.item("interval95")?.as_table_like()?.get(&name.replace('.', "_"))?)
    }

    /// The 95 % interval of a coefficient: of a named effect, or tuned like a parameter.
    fn of_effect(&self, effect: &str, key: &str) -> Option<(f64, f64)> {
        let named = self.item("effects").and_then(Item::as_array).and_then(|all| {
            let tables = all.iter().filter_map(Value::as_inline_table);
            let mut own = tables.filter(|t| t.get("name").and_then(|n| n.as_str()) == Some(effect));
            let interval = own.next()?.get(&format!("{key}_interval95"))?.as_array()?;
            Some((number(interval.get(0)?)?, number(interval.get(1)?)?))
        });
        named.or_else(|| self.interval(&format!("{effect}.{key}")))
    }

    /// What a diagnosis was left with, each with its numbers.
    fn alternatives(&self) -> Option<Vec<&InlineTable>> {
        let listed = self.item("alternatives")?.as_array()?;
        Some(listed.iter().filter_map(Value::as_inline_table).collect())
    }

    fn is_alternative(&self, name: &str) -> bool {
        let named = |t: &&InlineTable| t.get("name").and_then(Value::as_str) == Some(name);
        self.alternatives().is_some_and(|all| all.iter().any(named))
    }

    fn notes(&self) -> Vec<Note> {
        let again = "tune it to a drop of this ball: `tunenet tune … --out tuned.toml`";
        match self.word("verdict") {
            "" => vec![Note::new(
                "plan.untuned",
                "nobody tuned this simulation: its values are taken as they stand, and the chance of success says nothing \
                 of how wrong they are",
                again,
            )],
            "poor_fit" => vec![Note::new(
                "plan.poor_fit",
                "this simulation was tuned, but does not do what was measured",
                "ask `tunenet diagnose` what it lacks, and plan with the file that it writes",
            )],
            "one_of" if self.alternatives().is_none() => vec![Note::new(
                "plan.one_explanation",
                "several effects explain what was measured, and the file holds the numbers of one alone",
                "record what `tunenet diagnose` proposes next, and diagnose again",
            )],
            _ => Vec::new(),
        }
    }
}

fn pair(item: &Item) -> Option<(f64, f64)> {
    let array = item.as_array()?;
    let (low, high) = (number(array.get(0)?)?, number(array.get(1)?)?);
    (low <= high).then_some((low, high))
}
