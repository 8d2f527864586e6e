//! A ball in flight as a host.

use rapier3d::math::Vector;
use tunenet_core::law::{Carried, Direction, Host, Nature, Space, Term, Variable, Visit, Visiting};
use tunenet_core::observation::Kind;
use tunenet_core::simulator::{Effect, Prepared, Simulator};
use tunenet_core::{Error, Origin, Result};

use super::visiting::Following;
use super::{free_name, over};
use crate::ball::World;
use crate::formula_effect::FormulaEffect;
use crate::formula_effect::flight::{FlightForce, LAW_VARIABLES, VARIABLES, law_variables};
use crate::observed;
use crate::{ObservedBall, SimulationFile};

/// Directions of a law, as words of `along`: the forces that a ball meets, at most two components each.
const DIRECTIONS: [&[&str]; 6] = [&["v"], &["z"], &["x"], &["y"], &["x", "y"], &["across"]];
/// Those that are the axes.
const AXES: [usize; 3] = [2, 3, 1];

/// The host.
pub struct BallHost {
    file: SimulationFile,
    ball: ObservedBall,
    space: Space,
}

impl BallHost {
    /// Of a file, with these effects of it free.
    pub fn new(file: &SimulationFile, present: &[&str]) -> tunenet_formats::Result<Self> {
        let mut ball = ObservedBall::new(file, Kind::Positions)?;
        // Effects of the measurement stay at the values of the file.
        let shown: Vec<&str> = present.iter().copied().filter(|name| ball.find_effect(name).is_some()).collect();
        ball = ball.freed(&shown)?;
        let variable = |i: &usize| {
            let (name, unit) = VARIABLES[*i];
            let nature = if unit == "s" { Nature::Clock } else { Nature::Number };
            Variable { name: name.into(), unit: unit.into(), nature }
        };
        let direction =
            |words: &&[&str]| Direction { components: words.iter().map(|word| (*word).to_owned()).collect() };
        let space = Space {
            directions: DIRECTIONS.iter().map(direction).collect(),
            variables: LAW_VARIABLES.iter().map(variable).collect(),
            axes: AXES.to_vec(),
            taken: Vec::new(),
        };
        Ok(Self { file: file.clone(), ball, space })
    }
}

impl Host for BallHost {
    fn space(&self) -> &Space {
        &self.space
    }

    fn carrying(&self, terms: &[Carried]) -> Result<Box<dyn Visiting>> {
        let mut ball = self.ball.clone();
        let mut names = Vec::new();
        for one in terms {
            let name = free_name(&self.file, &one.effect.name);
            let effect = Effect { name: name.clone().into(), ..one.effect.clone() };
            let along = &self.space.directions[one.term.direction].components;
            let formula = FormulaEffect::of_law(effect, one.term.clone(), along).ok_or_else(|| Error::Setting {
                origin: Origin::Caller,
                name: "along",
                expected: "directions of a flight".into(),
                found: along.join(", "),
            })?;
            ball = ball.with_formula(formula);
            names.push(name);
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let ball = ball.freed(&names)?;
        // Effects of the measurement that a diagnosis named compete with laws.
        let simulator = Box::new(observed::seen(&self.file, ball.clone())?);
        let components: Vec<FlightForce> = DIRECTIONS
            .iter()
            .filter_map(|words| {
                let term = Term { direction: 0, components: words.len(), factors: Vec::new() };
                FlightForce::law(term, &words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
            })
            .collect();
        let visits = move |recording: &Prepared, parameters: &[f64], nuisances: &[f64], instants: &[f64]| {
            visits(&ball, &components, recording, (parameters, nuisances), instants)
        };
        Ok(Box::new(Following { simulator, visits: Box::new(visits) }))
    }

    fn unit(&self, _direction: usize, powers: &[(usize, f64)]) -> String {
        let powers: Vec<(&str, f64)> =
            powers.iter().map(|(v, p)| (self.space.variables[*v].unit.as_str(), *p)).collect();
        over("m/s²", &powers)
    }

    fn alias(&self, term: &Term, exponent: Option<f64>) -> Option<&'static str> {
        let words = DIRECTIONS[term.direction];
        let variable = term.factors.first().map(|factor| self.space.variables[factor.variable].name.as_str());
        match (words, variable, exponent) {
            (&["v"], Some("speed_m_s"), Some(2.0)) => Some("quadratic_drag"),
            (&["v"], Some("speed_m_s"), Some(1.0)) => Some("linear_drag"),
            (&["x"] | &["y"] | &["x", "y"], None, None) => Some("wind"),
            (&["z"], None, None) => Some("effective_gravity"),
            _ => None,
        }
    }
}

fn visits(
    ball: &ObservedBall,
    components: &[FlightForce],
    recording: &Prepared,
    (parameters, nuisances): (&[f64], &[f64]),
    instants: &[f64],
) -> Result<Vec<Visit>> {
    let (scene, start, _) = ball.world(&parameters[..ball.parameters().len()], nuisances);
    let begin = ball.begins_s(recording.seen.clock()[0]);
    let refused = |message: String| Error::Simulator { at: "the scene's values".into(), message };
    let mut world = World::new(&scene, &start, begin).map_err(refused)?;
    let mut all = Vec::with_capacity(instants.len());
    for &t in instants {
        world.advance_to(t.max(begin)).map_err(refused)?;
        let state = world.state();
        let (x, v) = (Vector::from_array(state.position_m), Vector::from_array(state.velocity_m_s));
        let components = components.iter().map(|force| force.vectors(x, v)).collect();
        all.push(Visit { variables: law_variables(t, x, v).to_vec(), components });
    }
    Ok(all)
}
