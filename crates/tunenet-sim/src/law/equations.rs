//! Equations as a host: terms are added to the derivatives of states that are no positions.

use std::sync::Arc;

use tunenet_core::Result;
use tunenet_core::law::{Carried, Direction, Host, Nature, Space, Term, Variable, Visit, Visiting};
use tunenet_core::observation::Circumstances;
use tunenet_core::simulator::{Effect, Prepared, Simulator};

use super::visiting::Following;
use super::{free_name, over};
use crate::SimulationFile;
use crate::equations::body::{States, written_length};
use crate::equations::law::{MOST_VARIABLES, Pointing, Quantity, Reach};
use crate::observed;
use crate::observed_equations::equations_of;
use crate::scene::EquationsScene;

/// The host.
pub struct EquationsHost {
    files: Vec<SimulationFile>,
    present: Vec<String>,
    space: Space,
    reach: Arc<Reach>,
    /// Positions of the states that are the axes, and the unit of what is added to each direction.
    axes: Vec<usize>,
    units: Vec<String>,
}

impl EquationsHost {
    /// Of the files of all setups; nothing where no state takes a term.
    pub fn new(files: &[&SimulationFile], present: &[&str]) -> tunenet_formats::Result<Option<Self>> {
        let scene = files[0].equations()?;
        let states = States::of(scene);
        let accelerated: Vec<usize> =
            (0..states.names.len()).filter(|i| states.pairs.iter().all(|(q, _)| q != i)).collect();
        let clock = states.names.len();
        let rates: Vec<usize> = states.pairs.iter().map(|(_, rate)| *rate).collect();
        let body = states.body();
        let mut variables = Vec::new();
        let mut quantities = Vec::new();
        for (i, name) in states.names.iter().enumerate() {
            // Of a body in the plane or in space the speed stands for its components.
            if body.as_ref().is_some_and(|all| all.iter().any(|(_, rate)| *rate == i)) {
                continue;
            }
            let nature = match (rates.contains(&i), accelerated.contains(&i)) {
                (true, _) => Nature::Rate,
                (false, true) => Nature::FirstOrder,
                (false, false) => Nature::Number,
            };
            variables.push(Variable { name: (*name).into(), unit: states.units[i].clone(), nature });
            quantities.push(Quantity::Slot(i));
        }
        if let Some(all) = &body {
            let (places, speeds): (Vec<usize>, Vec<usize>) = all.iter().copied().unzip();
            for (of, unit) in [(places, "m".to_owned()), (speeds.clone(), states.units[speeds[0]].clone())] {
                let name = written_length(&of, &states.names);
                variables.push(Variable { name, unit, nature: Nature::Number });
                quantities.push(Quantity::Length(of));
            }
        }
        variables.push(Variable { name: "t_s".into(), unit: "s".into(), nature: Nature::Clock });
        quantities.push(Quantity::Slot(clock));
        if accelerated.is_empty() || quantities.len() > MOST_VARIABLES {
            return Ok(None);
        }
        let (mut directions, mut pointing, mut units) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |names: Vec<String>, components: Vec<Pointing>, state: usize| {
            directions.push(Direction { components: names });
            pointing.push(components);
            units.push(over(&states.units[state], &[("s", 1.0)]));
        };
        for &i in &accelerated {
            add(vec![states.names[i].into()], vec![Pointing::Axis(i)], i);
        }
        if let Some(all) = &body {
            let (q, v): (Vec<usize>, Vec<usize>) = all.iter().copied().unzip();
            let axes = v.iter().map(|i| Pointing::Axis(*i)).collect();
            add(v.iter().map(|i| states.names[*i].to_owned()).collect(), axes, v[0]);
            add(vec!["v".into()], vec![Pointing::Along { vector: v.clone(), at: v.clone() }], v[0]);
            add(vec!["r".into()], vec![Pointing::Along { vector: q.clone(), at: v.clone() }], v[0]);
            if let (&[q1, q2], &[v1, v2]) = (q.as_slice(), v.as_slice()) {
                add(vec!["across".into()], vec![Pointing::Turned { vector: [v1, v2], at: [v1, v2] }], v1);
                add(vec!["around".into()], vec![Pointing::Turned { vector: [q1, q2], at: [v1, v2] }], v1);
            }
        }
        let parameters = files[0].parameters()?.into_iter().map(|p| p.name);
        let others = scene.states.keys().chain(scene.constants.keys()).cloned();
        let taken = others.chain(files[0].inputs().map(|(name, _)| name.to_owned())).chain(parameters).collect();
        let space = Space { axes: (0..accelerated.len()).collect(), directions, variables, taken };
        let reach = Arc::new(Reach { quantities, directions: pointing, clock });
        let files = files.iter().map(|file| (*file).clone()).collect();
        let present = present.iter().map(|name| (*name).to_owned()).collect();
        Ok(Some(Self { files, present, space, reach, axes: accelerated, units }))
    }

    /// A simulator with these terms, which predicts its outputs or its states.
    fn simulator(&self, terms: &[Carried], states: bool) -> Result<Box<dyn Simulator>> {
        let files: Vec<&SimulationFile> = self.files.iter().collect();
        let laws: Vec<Term> = terms.iter().map(|one| one.term.clone()).collect();
        let change = |_: &SimulationFile, system: crate::equations::System| {
            let system = system.with_law(&laws, &self.reach);
            if states { system.showing_states() } else { system }
        };
        let mut simulator = equations_of(&files, &change)?;
        let mut names = Vec::new();
        for one in terms {
            let name = free_name(&self.files[0], &one.effect.name);
            simulator = simulator.candidate(Effect { name: name.clone().into(), ..one.effect.clone() });
            names.push(name);
        }
        let free = self.present.iter().chain(&names).map(String::as_str);
        // Effects of the measurement stay at the values of the file.
        let free: Vec<&str> = free
            .filter(|name| self.files[0].candidate(name).is_some() || !self.present.iter().any(|p| p == name))
            .collect();
        if free.is_empty() { Ok(Box::new(simulator)) } else { simulator.with_effects(&free) }
    }
}

impl Host for EquationsHost {
    fn space(&self) -> &Space {
        &self.space
    }

    fn carrying(&self, terms: &[Carried]) -> Result<Box<dyn Visiting>> {
        let inner = self.simulator(terms, false)?;
        // Effects of the measurement that a diagnosis named compete with laws.
        let simulator = Box::new(observed::seen(&self.files[0], inner)?);
        let states = self.simulator(terms, true)?;
        let (reach, axes, count) = (Arc::clone(&self.reach), self.axes.clone(), self.reach.clock);
        let visits = move |recording: &Prepared, parameters: &[f64], nuisances: &[f64], instants: &[f64]| {
            let mut values = vec![0.0; instants.len() * count];
            let none = Circumstances::default();
            let known = recording.circumstances.as_deref().unwrap_or(&none);
            let run = states.rollout_driven(
                &parameters[..states.parameters().len()],
                nuisances,
                known,
                instants,
                &mut values,
            );
            run.map_err(|error| tunenet_core::Error::Simulator {
                at: "the equations".into(),
                message: format!("{error:?}"),
            })?;
            let one = |(row, t): (&[f64], &f64)| {
                let at: Vec<f64> = row.iter().copied().chain([*t]).collect();
                let (variables, components) = reach.visit(&at, &axes);
                Visit { variables, components }
            };
            Ok(values.chunks_exact(count).zip(instants).map(one).collect())
        };
        Ok(Box::new(Following { simulator, visits: Box::new(visits) }))
    }

    fn unit(&self, direction: usize, powers: &[(usize, f64)]) -> String {
        let powers: Vec<(&str, f64)> =
            powers.iter().map(|(v, p)| (self.space.variables[*v].unit.as_str(), *p)).collect();
        over(&self.units[direction], &powers)
    }
}

/// The name under which the range of a law's variable stands in a file; the length of a vector is a formula among the law's variables.
pub(super) fn range_name<'a>(scene: &'a EquationsScene, variable: &str) -> Option<&'a str> {
    let states = States::of(scene);
    let written = |quantity: &Quantity| match quantity {
        Quantity::Slot(_) => None,
        Quantity::Length(of) => Some(written_length(of, &states.names)),
    };
    let is =
        |(name, quantity): &(&str, Quantity)| *name == variable || written(quantity).is_some_and(|w| w == variable);
    states.quantities().into_iter().find(is).map(|(name, _)| name)
}

/// To which derivatives a component of that name adds, and what each addition is multiplied with.
pub(super) fn expressions(scene: &EquationsScene, component: &str) -> Vec<(String, Option<String>)> {
    let states = States::of(scene);
    let name = |i: usize| states.names[i].to_owned();
    let body = states.body().unwrap_or_default();
    let (q, v): (Vec<usize>, Vec<usize>) = body.iter().copied().unzip();
    let over = |of: &[usize], i: usize, sign: &str| {
        Some(format!("{sign}{} / {}", states.names[i], written_length(of, &states.names)))
    };
    match component {
        "v" if !body.is_empty() => v.iter().map(|i| (name(*i), over(&v, *i, ""))).collect(),
        "r" if !body.is_empty() => body.iter().map(|(place, rate)| (name(*rate), over(&q, *place, ""))).collect(),
        "across" if v.len() == 2 => vec![(name(v[0]), over(&v, v[1], "(-1) * ")), (name(v[1]), over(&v, v[0], ""))],
        "around" if v.len() == 2 => vec![(name(v[0]), over(&q, q[1], "(-1) * ")), (name(v[1]), over(&q, q[0], ""))],
        state => vec![(state.to_owned(), None)],
    }
}
