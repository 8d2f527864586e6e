//! Structure of a hypothesis: the same effects in every object's simulator, and which parameters are free.

use crate::Result;
use crate::diagnose::Subject;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::catalogue::{Carrier, Entry, carrier};
use crate::simulator::{Parameter, Simulator};

/// An effect that stands at known values: no coefficient of it is free.
#[derive(Clone)]
pub(in crate::diagnose) struct FixedEffect {
    pub entry: Entry,
    /// Its coefficients, shape `[object][coefficient]`.
    pub values: Vec<Vec<f64>>,
}

impl FixedEffect {
    /// The value of a simulator's parameter, where it is one of its coefficients.
    pub fn value(&self, object: usize, name: &str) -> Option<f64> {
        let effect = &self.entry.of[object];
        let k = (0..effect.coefficients.len()).find(|&k| effect.parameter_name(k) == name)?;
        Some(self.values[object][k])
    }
}

/// A shared parameter that more than one recording may share.
pub(in crate::diagnose) struct Global {
    pub parameter: Parameter,
    /// Whose it is; `None` for a measurement effect, which all objects share.
    pub object: Option<usize>,
    /// The position of its effect among the structure's, and of the coefficient in it.
    pub effect: Option<(usize, usize)>,
    /// For a coefficient: the value that means absent, and a small visible distance from it.
    pub absent: Option<(f64, f64)>,
    /// Whether it is a coefficient that only shapes its effect.
    pub shape: bool,
}

/// Simulators with the same effects, and the shared parameters of all of them.
///
/// The tuned parameters come first, object by object, then the coefficients, effect by effect; so a structure with one more
/// effect has the same numbers at the same places.
pub(in crate::diagnose) struct Structure<'a> {
    /// Positions in the catalogue.
    pub effects: Vec<usize>,
    simulators: Vec<Carrier<'a>>,
    pub globals: Vec<Global>,
    /// For each object: the values of all its simulator's parameters.
    values: Vec<Vec<f64>>,
    /// For each object: which of them are free, as (parameter, global).
    slots: Vec<Vec<(usize, usize)>>,
}

impl<'a> Structure<'a> {
    /// The structure with these `effects`; each of `spared`, an effect and an object, stands at absence in that object.
    pub fn new(
        subjects: &[Subject<'a>],
        sets: &[Set],
        catalogue: &[Entry],
        effects: &[usize],
        (given, spared): (&[FixedEffect], &[(usize, usize)]),
        chance: bool,
    ) -> Result<Self> {
        let entries: Vec<&Entry> = effects.iter().map(|&e| &catalogue[e]).collect();
        let scatter = catalogue.iter().filter(|e| chance && e.chance());
        let known = given.iter().map(|g| &g.entry);
        let carried: Vec<&Entry> = entries.iter().copied().chain(scatter).chain(known).collect();
        let simulators = subjects.iter().map(|s| carrier(s, &carried)).collect::<Result<Vec<_>>>()?;
        let start = |(object, simulator): (usize, &Carrier)| -> Vec<f64> {
            let stands = |name: &str| given.iter().find_map(|g| g.value(object, name));
            simulator.parameters().iter().map(|p| stands(&p.name).unwrap_or(p.value)).collect()
        };
        let values = simulators.iter().enumerate().map(start).collect();
        let mut structure = Self {
            effects: effects.to_vec(),
            simulators,
            globals: Vec::new(),
            values,
            slots: vec![Vec::new(); subjects.len()],
        };
        for (object, subject) in subjects.iter().enumerate() {
            let parameters = subject.simulator.parameters();
            let observed = |i: usize| sets.iter().any(|s| s.object == object && s.prepared.silent[i].is_none());
            for i in (0..parameters.len()).filter(|&i| parameters[i].tune && observed(i)) {
                let (parameter, object_of) = (parameters[i].clone(), Some(object));
                let global = Global { parameter, object: object_of, effect: None, absent: None, shape: false };
                structure.add(global, object);
            }
        }
        let present: Vec<usize> = (0..subjects.len()).filter(|&o| sets.iter().any(|s| s.object == o)).collect();
        for (position, entry) in entries.iter().enumerate() {
            for (k, coefficient) in entry.of[0].coefficients.iter().enumerate().filter(|(k, _)| entry.seen[*k]) {
                for &object in present.iter().filter(|&&o| !spared.contains(&(effects[position], o))) {
                    let name = entry.of[object].parameter_name(k);
                    let known = structure.simulators[object].parameters().iter().find(|p| p.name == name).cloned();
                    let parameter = known.ok_or_else(|| crate::Error::Simulator {
                        at: format!("with `{}`", entry.name),
                        message: format!("it has no parameter `{name}`"),
                    })?;
                    let shared = entry.shared() && object != present[0];
                    if shared {
                        let place = structure.globals.len() - 1;
                        structure.link(&name, object, place);
                        continue;
                    }
                    let global = Global {
                        parameter,
                        object: (!entry.shared()).then_some(object),
                        effect: Some((position, k)),
                        absent: Some((coefficient.absent, coefficient.typical)),
                        shape: coefficient.shape,
                    };
                    structure.add(global, object);
                }
            }
        }
        Ok(structure)
    }

    /// Whether tuned parameters of every object do the same as an effect.
    pub fn repeats(&self, entry: &Entry) -> bool {
        let tuned = |object: usize, name: &str| {
            let mut own = self.globals.iter().filter(|global| global.effect.is_none() && global.object == Some(object));
            own.any(|global| global.parameter.name == name)
        };
        let mut objects = entry.of.iter().enumerate().filter(|(object, _)| !self.slots[*object].is_empty()).peekable();
        objects.peek().is_some()
            && objects.all(|(object, effect)| {
                let mut seen = effect.repeated_by.iter().zip(&entry.seen).filter(|(_, seen)| **seen).peekable();
                seen.peek().is_some() && seen.all(|(names, _)| names.iter().all(|name| tuned(object, name)))
            })
    }

    /// The same with every shared parameter fixed at these values.
    pub fn frozen(mut self, globals: &[f64]) -> Self {
        self.values = (0..self.values.len()).map(|object| self.parameters(object, globals)).collect();
        self.slots.iter_mut().for_each(Vec::clear);
        self.globals.clear();
        self
    }

    /// The same with another value of a parameter that is not free.
    pub fn with_value(mut self, object: usize, parameter: usize, value: f64) -> Self {
        self.values[object][parameter] = value;
        self
    }

    fn add(&mut self, global: Global, object: usize) {
        let name = global.parameter.name.clone();
        self.globals.push(global);
        self.link(&name, object, self.globals.len() - 1);
    }

    fn link(&mut self, name: &str, object: usize, place: usize) {
        if let Some(i) = self.simulators[object].parameters().iter().position(|p| p.name == name) {
            self.slots[object].push((i, place));
        }
    }

    pub fn simulator(&self, object: usize) -> &(dyn Simulator + 'a) {
        &*self.simulators[object]
    }

    /// All parameters of an object's simulator with these shared parameters.
    pub fn parameters(&self, object: usize, globals: &[f64]) -> Vec<f64> {
        let mut values = self.values[object].clone();
        self.slots[object].iter().for_each(|&(i, place)| values[i] = globals[place]);
        values
    }

    /// The shared parameters that an object's recordings touch.
    pub fn places(&self, object: usize) -> Vec<usize> {
        self.slots[object].iter().map(|slot| slot.1).collect()
    }

    /// The shared parameters of the structure's effect at `position`.
    pub fn of_effect(&self, position: usize) -> Vec<usize> {
        (0..self.globals.len()).filter(|&g| self.globals[g].effect.is_some_and(|(p, _)| p == position)).collect()
    }

    /// The shared parameters where `from` (a structure without the last effects, or with others) leaves them; what it does not
    /// have stands as in the simulator, absent.
    pub fn carry(&self, from: &Structure, globals: &[f64]) -> Vec<f64> {
        let same =
            |g: &Global| from.globals.iter().position(|f| f.object == g.object && f.parameter.name == g.parameter.name);
        self.globals.iter().map(|g| same(g).map_or(g.parameter.value, |place| globals[place])).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnose::tests::zoo::{entry, in_swings};

    #[test]
    fn values_are_carried_to_a_structure_with_more_effects_and_frozen_ones_are_not_free() {
        in_swings(&[], 2, 0, |context| {
            let (bare, more) =
                (context.structure(&[]).unwrap(), context.structure(&[entry(context, "rest_angle")]).unwrap());
            assert_eq!((bare.globals.len(), more.globals.len()), (1, 2));
            assert_eq!(more.carry(&bare, &[1.7]), [1.7, 0.0]);
            assert_eq!((more.places(0), more.of_effect(0)), (vec![0, 1], vec![1]));
            assert_eq!(more.parameters(0, &[1.7, 0.2]), [1.7, 0.2]);
            let moved = context.structure(&[]).unwrap().with_value(0, 0, 9.0);
            assert_eq!(moved.parameters(0, &[1.7]), [1.7], "a free parameter has its own value");
            let spared = crate::diagnose::hypothesis::context::Context {
                spared: vec![(entry(context, "rest_angle"), 0)].into(),
                ..context.clone()
            };
            let without = spared.structure(&[entry(context, "rest_angle")]).unwrap();
            assert_eq!((without.globals.len(), without.parameters(0, &[1.7])), (1, vec![1.7, 0.0]));
            let frozen = more.frozen(&[1.7, 0.2]);
            assert!(frozen.globals.is_empty());
            assert_eq!(frozen.parameters(0, &[]), [1.7, 0.2]);
        });
    }

    #[test]
    fn a_tuned_parameter_repeats_an_effect_that_names_it() {
        in_swings(&[], 2, 0, |context| {
            let bare = context.structure(&[]).unwrap();
            let mut known = context.catalogue[entry(context, "rest_angle")].clone();
            assert!(!bare.repeats(&known));
            known.of[0].repeated_by = vec![vec!["length".into()]];
            assert!(bare.repeats(&known));
            let other = context.catalogue[entry(context, "viscous_friction")].clone();
            assert!(!bare.repeats(&other) && !bare.frozen(&[1.7]).repeats(&known));
        });
    }
}
