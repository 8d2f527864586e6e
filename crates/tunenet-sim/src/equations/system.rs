//! Equations of a file as programs over one array of values, with every name, unit and circle checked.

use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;
use tunenet_core::law::Term;
use tunenet_core::observation::Channel;
use tunenet_formula::{CONSTANTS, Formula, FormulaError, Function, Name, Program, Unit};

use super::Misfit;
use super::body::CLOCK;
use super::law::{LawTerm, Quantity, Reach};
use super::lower::Lowering;
use super::parts::{Compiled, Delayed, Slots, Surface, is_name_within};
use super::{smoothness, valid};
use crate::formula_effect::probe;
use crate::scene::{Candidate, EquationsScene};

/// Most of each: states, events, inputs.
const MOST: usize = 64;
/// Most places at which a `sign` jumps, or an `abs` of an event bends.
const MOST_SURFACES: usize = 64;
/// Endings of names that are letters of other things as often as units.
const AMBIGUOUS: [&str; 7] = ["A", "°C", "C", "J", "K", "V", "W"];

/// A parameter of the file: its name, and its unit where the file says one.
pub type Declared<'a> = (&'a str, Option<&'a str>);

/// What a candidate adds to a derivative.
#[derive(Debug, Clone)]
pub(super) struct Added {
    pub state: usize,
    pub program: Program,
}

/// A candidate: where its coefficients stand, and when it is absent.
#[derive(Debug, Clone)]
pub(super) struct Adds {
    pub coefficients: Range<usize>,
    pub absent: Vec<f64>,
    pub terms: Vec<Added>,
    /// Whether one of them bends sharply somewhere.
    pub bends: bool,
}

impl Adds {
    /// Whether its coefficients in the array of values are not the absent ones.
    pub fn acts(&self, values: &[f64]) -> bool {
        values[self.coefficients.clone()] != self.absent
    }
}

/// An event: when it happens, and what states are then.
#[derive(Debug, Clone)]
pub(super) struct EventOf {
    pub when: Compiled,
    /// Where that formula stands, for messages.
    pub path: String,
    pub then: Vec<Then>,
}

/// What a state is after an event.
#[derive(Debug, Clone)]
pub(super) struct Then {
    pub state: usize,
    pub program: Program,
    /// As it was written, and where, for messages.
    pub written: Formula,
    pub path: String,
}

/// The equations of a file.
#[derive(Debug, Clone)]
pub struct System {
    pub(super) states: Vec<String>,
    /// For each state, the position of its start in the file.
    pub(super) starts: Vec<usize>,
    pub(super) slots: Slots,
    pub(super) constants: Vec<f64>,
    pub(super) derivatives: Vec<Program>,
    /// Whether one of them bends sharply somewhere.
    pub(super) bends: bool,
    /// The derivatives as they were written, for messages.
    pub(super) written: Arc<[Formula]>,
    pub(super) outputs: Vec<Program>,
    pub(super) candidates: Vec<Adds>,
    /// Terms of a law that is searched; their numbers follow the coefficients of the candidates.
    pub(super) laws: Vec<LawTerm>,
    pub(super) events: Vec<EventOf>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) delayed: Vec<Delayed>,
    /// Positions of what does not change during a rollout, and how it follows from parameters, constants and coefficients.
    pub(super) fixed: Vec<(usize, Compiled)>,
    /// Whether an output depends on the side of a surface.
    pub(super) outputs_switch: bool,
}

/// The unit of a name: what its table says, or what it ends in.
fn unit(name: &str, said: Option<&str>) -> Option<Unit> {
    let ending = || Channel::from_header(name).map(|channel| channel.unit);
    said.map(str::to_owned).or_else(ending).as_deref().and_then(Unit::parse)
}

/// The unit of a number that the file gives no unit: its name says one, unless that is as likely no unit.
fn likely_unit(name: &str) -> Option<Unit> {
    let channel = Channel::from_header(name)?;
    if AMBIGUOUS.contains(&channel.unit.as_str()) { None } else { Unit::parse(&channel.unit) }
}

impl System {
    /// Compiles the equations of a file with these parameters.
    ///
    /// # Errors
    /// With the key, and the place within its formula, where a name is unknown or not distinct, a formula is none, units contradict
    /// each other, a derivative is missing, or there is too much of something.
    pub fn new(scene: &EquationsScene, parameters: &[Declared]) -> Result<Self, Misfit> {
        let scope = Scope::of(scene, parameters)?;
        complete(scene)?;
        let mut lowering = Lowering::new(&scope.slots);
        let states: Vec<String> = scene.states.keys().cloned().collect();
        let (mut derivatives, mut written) = (Vec::with_capacity(states.len()), Vec::with_capacity(states.len()));
        let mut bends = false;
        for (name, text) in scene.states.keys().map(|name| (name, &scene.derivatives[name])) {
            let formula = scope.parse(&format!("derivatives.{name}"), text, scope.per_second(name), None)?;
            let lowered = lowering.lower(&format!("derivatives.{name}"), &formula, None, None)?;
            bends |= smoothness::bends(&lowered.tree, &scope.slots.still());
            derivatives.push(lowered.program);
            written.push(formula);
        }
        let (mut outputs, mut outputs_switch) = (Vec::new(), false);
        for header in scene.headers() {
            let path = format!("{}.{header}", if scene.outputs.is_empty() { "states" } else { "outputs" });
            if Channel::from_header(&header)
                .is_none_or(|channel| channel.unit == "s" && ["t", "time"].contains(&channel.name.as_str()))
            {
                let of_states = if scene.outputs.is_empty() { ", or [outputs] with such names" } else { "" };
                let expected = format!(
                    "a lower-case channel that ends in its unit and is not the clock, such as `angle_rad` or, without a unit, `count_1`{of_states}"
                );
                return Err(Misfit::new(&path, expected, format!("`{header}`")));
            }
            let text = scene.outputs.get(&header).unwrap_or(&header);
            let formula = scope.parse(&path, text, unit(&header, None), None)?;
            let output = lowering.lower(&path, &formula, None, None)?;
            outputs_switch |= output.tree.any(&|node| is_name_within(node, &(scope.slots.count..usize::MAX)));
            outputs.push(output.program);
        }
        let mut events = Vec::new();
        for (name, event) in &scene.events {
            let path = format!("events.{name}.when");
            let formula = scope.parse(&path, &event.when, None, None)?;
            let when = lowering.lower_event(&path, &formula)?;
            if event.then.is_empty() {
                let expected = "`then.STATE = \"formula\"`: what a state is afterwards";
                return Err(Misfit::new(&format!("events.{name}"), expected, "none"));
            }
            let mut then = Vec::new();
            for (state, text) in &event.then {
                let path = format!("events.{name}.then.{state}");
                let i = scope.state(&path, state)?;
                let formula = scope.parse(&path, text, scope.names[i].unit.clone(), None)?;
                let program = lowering.lower(&path, &formula, None, None)?.program;
                then.push(Then { state: i, program, written: formula, path });
            }
            events.push(EventOf { when, path, then });
        }
        let mut candidates = Vec::new();
        let mut at = scope.slots.coefficients.start;
        for (number, (name, candidate)) in scene.candidates.iter().enumerate() {
            let own = at..at + candidate.coefficients.len();
            at = own.end;
            valid::ranges(scene, name, candidate)?;
            candidates.push(adds(&scope, &mut lowering, number, (name, candidate), own)?);
        }
        let Lowering { surfaces, delayed, fixed, count, .. } = lowering;
        if surfaces.len() > MOST_SURFACES {
            return Err(Misfit::new(
                "derivatives",
                format!("at most {MOST_SURFACES} arguments of `sign` and, in events, of `abs`"),
                surfaces.len().to_string(),
            ));
        }
        let system = Self {
            starts: states.iter().filter_map(|name| scene.start.get_index_of(name)).collect(),
            states,
            slots: Slots { count, ..scope.slots },
            constants: scene.constants.values().copied().collect(),
            derivatives,
            bends,
            written: written.into(),
            outputs,
            candidates,
            laws: Vec::new(),
            events,
            surfaces,
            delayed,
            fixed,
            outputs_switch,
        };
        system.absent_is_nothing(scene)?;
        Ok(system)
    }

    /// Computes what does not change during a rollout.
    pub(super) fn fix(&self, values: &mut [f64]) {
        for (slot, of) in &self.fixed {
            values[*slot] = of.program.value(values);
        }
    }

    /// Refuses a candidate that adds something although its coefficients have their absent values.
    fn absent_is_nothing(&self, scene: &EquationsScene) -> Result<(), Misfit> {
        for ((name, candidate), adds) in scene.candidates.iter().zip(&self.candidates) {
            for (term, state) in adds.terms.iter().zip(candidate.adds.keys()) {
                for point in 0..3_u32 {
                    let mut values: Vec<f64> = (0..self.slots.count).map(|i| probe(i, point)).collect();
                    values[self.slots.constants.clone()].copy_from_slice(&self.constants);
                    values[adds.coefficients.clone()].copy_from_slice(&adds.absent);
                    self.fix(&mut values);
                    // An input that is not delayed is the input.
                    for delayed in &self.delayed {
                        if delayed.by.value(&values) == 0.0 {
                            values[delayed.slot] = values[self.slots.inputs.start + delayed.input];
                        }
                    }
                    let added = term.program.value(&values);
                    if added.is_finite() && added.abs() > 1e-12 {
                        let path = format!("candidates.{name}.adds.{state}");
                        let expected = "a formula that is 0 where its coefficients have their `absent` values";
                        return Err(Misfit::new(&path, expected, format!("one that is {added:.3} somewhere")));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Every state has a derivative and a start, and nothing else has.
fn complete(scene: &EquationsScene) -> Result<(), Misfit> {
    let known = || scene.states.keys().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    for name in scene.states.keys() {
        if !scene.derivatives.contains_key(name) {
            return Err(Misfit::new(
                "derivatives",
                format!("a derivative of every state ({})", known()),
                format!("none of `{name}`"),
            ));
        }
        if !scene.start.contains_key(name) {
            let expected = format!("[start.{name}] with a `value`: where the state starts");
            return Err(Misfit::new(&format!("states.{name}"), expected, "none"));
        }
    }
    for (table, names) in [("derivatives", names(&scene.derivatives)), ("start", names(&scene.start))] {
        if let Some(other) = names.iter().find(|name| !scene.states.contains_key(**name)) {
            return Err(Misfit::new(
                &format!("{table}.{other}"),
                format!("a state ({})", known()),
                format!("`{other}`"),
            ));
        }
    }
    Ok(())
}

fn names<T>(all: &IndexMap<String, T>) -> Vec<&str> {
    all.keys().map(String::as_str).collect()
}

/// What a candidate adds, and that every coefficient is used.
fn adds(
    scope: &Scope,
    lowering: &mut Lowering,
    number: usize,
    (name, candidate): (&str, &Candidate),
    own: Range<usize>,
) -> Result<Adds, Misfit> {
    let path = format!("candidates.{name}");
    if candidate.adds.is_empty() {
        return Err(Misfit::new(&path, "`adds.STATE = \"formula\"`: what it adds to a derivative", "none"));
    }
    let (mut terms, mut used, mut bends) = (Vec::new(), vec![false; own.len()], false);
    for (state, text) in &candidate.adds {
        let path = format!("{path}.adds.{state}");
        let i = scope.state(&path, state)?;
        let formula = scope.parse(&path, text, scope.per_second(state), Some(candidate))?;
        for (k, used) in used.iter_mut().enumerate() {
            *used |= formula.uses(scope.names.len() + k);
        }
        let lowered = lowering.lower(&path, &formula, Some((scope.names.len(), own.start)), Some(number))?;
        bends |= smoothness::bends(&lowered.tree, &scope.slots.still());
        terms.push(Added { state: i, program: lowered.program });
    }
    if let Some((_, key)) = used.iter().zip(candidate.coefficients.keys()).find(|(used, _)| !**used) {
        let path = format!("{path}.coefficients.{key}");
        return Err(Misfit::new(&path, format!("a formula under `adds` that uses `{key}`"), "none"));
    }
    let absent = candidate.coefficients.values().map(|c| candidate.absent(c)).collect();
    Ok(Adds { coefficients: own, absent, terms, bends })
}

/// The names that every formula of a file may use, in the order of the array of values.
struct Scope {
    names: Vec<Name>,
    slots: Slots,
    states: usize,
}

impl Scope {
    fn of(scene: &EquationsScene, parameters: &[Declared]) -> Result<Self, Misfit> {
        for (what, count) in
            [("states", scene.states.len()), ("inputs", scene.inputs.len()), ("events", scene.events.len())]
        {
            if count > MOST {
                return Err(Misfit::new(what, format!("at most {MOST}"), count.to_string()));
            }
        }
        if scene.states.is_empty() {
            return Err(Misfit::new("states", "at least one [states.NAME]", "none"));
        }
        let mut all: Vec<(String, Name)> = Vec::new();
        for (name, state) in &scene.states {
            all.push((format!("states.{name}"), Name::new(name, unit(name, state.unit.as_deref()))));
        }
        let clock = all.len();
        all.push((String::new(), Name::new(CLOCK, Unit::parse("s"))));
        for (name, input) in &scene.inputs {
            let unit = input.channel(name).and_then(|channel| Unit::parse(&channel.unit));
            all.push((format!("inputs.{name}"), Name::new(name, unit)));
        }
        let inputs = clock + 1..all.len();
        for (name, said) in parameters {
            let unit = said.map_or_else(|| likely_unit(name), Unit::parse);
            all.push((format!("parameters.{name}"), Name::new(*name, unit)));
        }
        let parameters = inputs.end..all.len();
        for name in scene.constants.keys() {
            all.push((format!("constants.{name}"), Name::new(name, likely_unit(name))));
        }
        let constants = parameters.end..all.len();
        let coefficients =
            constants.end..constants.end + scene.candidates.values().map(|c| c.coefficients.len()).sum::<usize>();
        for (i, (path, name)) in all.iter().enumerate() {
            distinct(path, &name.name, &all[..i])?;
        }
        for (name, candidate) in &scene.candidates {
            for key in candidate.coefficients.keys() {
                distinct(&format!("candidates.{name}.coefficients.{key}"), key, &all)?;
            }
        }
        let count = coefficients.end;
        let slots = Slots { clock, inputs, parameters, constants, coefficients, count };
        Ok(Self { names: all.into_iter().map(|(_, name)| name).collect(), slots, states: scene.states.len() })
    }

    /// The position of a state.
    fn state(&self, path: &str, name: &str) -> Result<usize, Misfit> {
        let states = &self.names[..self.states];
        states.iter().position(|known| known.name == name).ok_or_else(|| {
            let known = states.iter().map(|known| format!("`{}`", known.name)).collect::<Vec<_>>().join(", ");
            Misfit::new(path, format!("a state ({known})"), format!("`{name}`"))
        })
    }

    /// The unit of a state's derivative, where it is known.
    fn per_second(&self, state: &str) -> Option<Unit> {
        let known = self.names[..self.states].iter().find(|known| known.name == state)?;
        Some(known.unit.as_ref()?.per(&Unit::parse("s")?))
    }

    /// A formula of these names and, of a candidate, its coefficients, in the unit that it has to have where that is known.
    fn parse(&self, path: &str, text: &str, wanted: Option<Unit>, of: Option<&Candidate>) -> Result<Formula, Misfit> {
        let own = of.into_iter().flat_map(|candidate| &candidate.coefficients);
        let names: Vec<Name> =
            self.names.iter().cloned().chain(own.map(|(key, c)| Name::new(key, Unit::parse(&c.unit)))).collect();
        let misfit = |error: FormulaError| Misfit::within(path, error);
        let formula = Formula::parse(text, &names).map_err(misfit)?;
        if let Some(wanted) = wanted {
            formula.require_unit(&wanted).map_err(misfit)?;
        }
        Ok(formula)
    }
}

/// Refuses a name that something else has, or that is a function or a constant of mathematics.
fn distinct(path: &str, name: &str, others: &[(String, Name)]) -> Result<(), Misfit> {
    if CONSTANTS.contains(&name) || Function::named(name).is_some() {
        let expected = "a name that is no function and no constant of mathematics";
        return Err(Misfit::new(path, expected, format!("`{name}`")));
    }
    let Some((other, _)) = others.iter().find(|(_, known)| known.name == name) else { return Ok(()) };
    let there = other.split('.').next().filter(|table| !table.is_empty());
    let found = match there {
        Some(table) => format!("`{name}` under [{table}] too"),
        None => format!("`{name}`, which is the clock"),
    };
    Err(Misfit::new(path, "a name that nothing else has", found))
}

impl System {
    /// The same with terms of a law, whose numbers follow the coefficients of its candidates.
    #[must_use]
    pub(crate) fn with_law(mut self, terms: &[Term], reach: &Arc<Reach>) -> Self {
        for term in terms {
            let owner = self.candidates.len() + self.laws.len();
            let mut sides = Vec::new();
            for factor in &term.factors {
                let slot = match &reach.quantities[factor.variable] {
                    Quantity::Slot(slot) if factor.shape.jumps() => self.surface(*slot, owner),
                    _ => None,
                };
                sides.push(slot);
            }
            self.laws.push(LawTerm::new(term, reach, sides));
        }
        self
    }

    /// The side of a state, as a switching surface of its own.
    fn surface(&mut self, slot: usize, owner: usize) -> Option<usize> {
        let of = Self::reading(slot)?;
        let side = self.slots.count;
        self.slots.count += 1;
        self.surfaces.push(Surface { of, side, owners: vec![Some(owner)] });
        Some(side)
    }

    /// A formula that reads one state or the clock.
    fn reading(slot: usize) -> Option<Compiled> {
        let names: Vec<Name> = (0..=slot).map(|i| Name::new(format!("value_{i}"), None)).collect();
        let formula = Formula::parse(&format!("value_{slot}"), &names).ok()?;
        Some(Compiled { tree: formula.tree().clone(), program: formula.program().clone() })
    }

    /// The same, which writes its states instead of its outputs.
    #[must_use]
    pub(crate) fn showing_states(mut self) -> Self {
        self.outputs = (0..self.states.len()).filter_map(|i| Some(Self::reading(i)?.program)).collect();
        self.outputs_switch = false;
        self
    }
}
