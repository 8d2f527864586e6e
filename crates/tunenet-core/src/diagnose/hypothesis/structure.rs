//! Structure of a hypothesis: the same effects in every object's simulator, and which parameters are free.

use crate::Result;
use crate::diagnose::Subject;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::{Carrier, Entry, carrier};
use crate::simulator::{Parameter, Simulator};

/// An effect whose coefficients are fixed at known values.
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

/// A parameter that recordings share: a tuned parameter of an object, or a coefficient of an effect.
pub(in crate::diagnose) struct SharedParameter {
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
/// effect has the same parameters at the same positions. The position of a shared parameter is its column in the Jacobian.
pub(in crate::diagnose) struct Structure<'a> {
    /// Positions in the catalogue.
    pub effects: Vec<usize>,
    simulators: Vec<Carrier<'a>>,
    pub shared: Vec<SharedParameter>,
    /// For each object: the values of all its simulator's parameters.
    values: Vec<Vec<f64>>,
    /// For each object: which of them are free, as (parameter, column).
    columns: Vec<Vec<(usize, usize)>>,
}

impl<'a> Structure<'a> {
    /// The structure with these `effects`; for each of `spared`, an effect and an object, the effect is absent in that object.
    /// `with_random` says whether simulators bring the draws of random effects.
    pub fn new(
        subjects: &[Subject<'a>],
        recordings: &[PreparedRecording],
        catalogue: &[Entry],
        effects: &[usize],
        (given, spared): (&[FixedEffect], &[(usize, usize)]),
        with_random: bool,
    ) -> Result<Self> {
        let entries: Vec<&Entry> = effects.iter().map(|&e| &catalogue[e]).collect();
        let random = catalogue.iter().filter(|e| with_random && e.is_random_effect());
        let known = given.iter().map(|g| &g.entry);
        let carried: Vec<&Entry> = entries.iter().copied().chain(random).chain(known).collect();
        let simulators = subjects.iter().map(|s| carrier(s, &carried)).collect::<Result<Vec<_>>>()?;
        let start = |(object, simulator): (usize, &Carrier)| -> Vec<f64> {
            let fixed_value = |name: &str| given.iter().find_map(|g| g.value(object, name));
            simulator.parameters().iter().map(|p| fixed_value(&p.name).unwrap_or(p.value)).collect()
        };
        let values = simulators.iter().enumerate().map(start).collect();
        let mut structure = Self {
            effects: effects.to_vec(),
            simulators,
            shared: Vec::new(),
            values,
            columns: vec![Vec::new(); subjects.len()],
        };
        for (object, subject) in subjects.iter().enumerate() {
            let parameters = subject.simulator.parameters();
            let observed = |i: usize| recordings.iter().any(|r| r.object == object && r.prepared.silent[i].is_none());
            for i in (0..parameters.len()).filter(|&i| parameters[i].tune && observed(i)) {
                let (parameter, object_of) = (parameters[i].clone(), Some(object));
                let shared = SharedParameter { parameter, object: object_of, effect: None, absent: None, shape: false };
                structure.add(shared, object);
            }
        }
        let present: Vec<usize> = (0..subjects.len()).filter(|&o| recordings.iter().any(|r| r.object == o)).collect();
        for (position, entry) in entries.iter().enumerate() {
            for (k, coefficient) in entry.of[0].coefficients.iter().enumerate().filter(|(k, _)| entry.seen[*k]) {
                for &object in present.iter().filter(|&&o| !spared.contains(&(effects[position], o))) {
                    let name = entry.of[object].parameter_name(k);
                    let known = structure.simulators[object].parameters().iter().find(|p| p.name == name).cloned();
                    let parameter = known.ok_or_else(|| crate::Error::Simulator {
                        at: format!("with `{}`", entry.name),
                        message: format!("it has no parameter `{name}`"),
                    })?;
                    let is_added = entry.shared() && object != present[0];
                    if is_added {
                        let column = structure.shared.len() - 1;
                        structure.link(&name, object, column);
                        continue;
                    }
                    let shared = SharedParameter {
                        parameter,
                        object: (!entry.shared()).then_some(object),
                        effect: Some((position, k)),
                        absent: Some((coefficient.absent, coefficient.typical)),
                        shape: coefficient.shape,
                    };
                    structure.add(shared, object);
                }
            }
        }
        Ok(structure)
    }

    /// Whether tuned parameters of every object do the same as an effect.
    pub fn repeats(&self, entry: &Entry) -> bool {
        let tuned = |object: usize, name: &str| {
            let mut own = self.shared.iter().filter(|shared| shared.effect.is_none() && shared.object == Some(object));
            own.any(|shared| shared.parameter.name == name)
        };
        let mut objects =
            entry.of.iter().enumerate().filter(|(object, _)| !self.columns[*object].is_empty()).peekable();
        objects.peek().is_some()
            && objects.all(|(object, effect)| {
                let mut seen = effect.repeated_by.iter().zip(&entry.seen).filter(|(_, seen)| **seen).peekable();
                seen.peek().is_some() && seen.all(|(names, _)| names.iter().all(|name| tuned(object, name)))
            })
    }

    /// The same with every shared parameter fixed at these values.
    pub fn frozen(mut self, values: &[f64]) -> Self {
        self.values = (0..self.values.len()).map(|object| self.parameters(object, values)).collect();
        self.columns.iter_mut().for_each(Vec::clear);
        self.shared.clear();
        self
    }

    /// The same with another value of a parameter that is not free.
    pub fn with_value(mut self, object: usize, parameter: usize, value: f64) -> Self {
        self.values[object][parameter] = value;
        self
    }

    fn add(&mut self, shared: SharedParameter, object: usize) {
        let name = shared.parameter.name.clone();
        self.shared.push(shared);
        self.link(&name, object, self.shared.len() - 1);
    }

    fn link(&mut self, name: &str, object: usize, column: usize) {
        if let Some(i) = self.simulators[object].parameters().iter().position(|p| p.name == name) {
            self.columns[object].push((i, column));
        }
    }

    pub fn simulator(&self, object: usize) -> &(dyn Simulator + 'a) {
        &*self.simulators[object]
    }

    /// All parameters of an object's simulator with these values of the shared parameters.
    pub fn parameters(&self, object: usize, shared: &[f64]) -> Vec<f64> {
        let mut values = self.values[object].clone();
        self.columns[object].iter().for_each(|&(i, column)| values[i] = shared[column]);
        values
    }

    /// The columns of the shared parameters on which an object's recordings depend.
    pub fn columns(&self, object: usize) -> Vec<usize> {
        self.columns[object].iter().map(|(_, column)| *column).collect()
    }

    /// Columns of an effect's coefficients that can switch it off, each with the value that means absence; not those that only shape it.
    pub fn switches(&self, position: usize) -> impl Iterator<Item = (usize, f64)> {
        let own = self.of_effect(position).into_iter().filter(|&column| !self.shared[column].shape);
        own.map(|column| (column, self.shared[column].absent.map_or(0.0, |(absent, _)| absent)))
    }

    /// The columns of the shared parameters that belong to the structure's effect at `position`.
    pub fn of_effect(&self, position: usize) -> Vec<usize> {
        let own = |&column: &usize| self.shared[column].effect.is_some_and(|(p, _)| p == position);
        (0..self.shared.len()).filter(own).collect()
    }

    /// Values of the shared parameters from `values`, those of the structure `from` (without the last effects, or with others). A
    /// parameter that `from` does not have keeps its value in the simulator: its effect is absent.
    pub fn carry(&self, from: &Structure, values: &[f64]) -> Vec<f64> {
        let column_in = |shared: &SharedParameter| {
            let same = |other: &SharedParameter| {
                other.object == shared.object && other.parameter.name == shared.parameter.name
            };
            from.shared.iter().position(same)
        };
        let value =
            |shared: &SharedParameter| column_in(shared).map_or(shared.parameter.value, |column| values[column]);
        self.shared.iter().map(value).collect()
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
            assert_eq!((bare.shared.len(), more.shared.len()), (1, 2));
            assert_eq!(more.carry(&bare, &[1.7]), [1.7, 0.0]);
            assert_eq!((more.columns(0), more.of_effect(0)), (vec![0, 1], vec![1]));
            assert_eq!(more.parameters(0, &[1.7, 0.2]), [1.7, 0.2]);
            let moved = context.structure(&[]).unwrap().with_value(0, 0, 9.0);
            assert_eq!(moved.parameters(0, &[1.7]), [1.7], "a free parameter has its own value");
            let spared = crate::diagnose::hypothesis::context::Context {
                spared: vec![(entry(context, "rest_angle"), 0)].into(),
                ..context.clone()
            };
            let without = spared.structure(&[entry(context, "rest_angle")]).unwrap();
            assert_eq!((without.shared.len(), without.parameters(0, &[1.7])), (1, vec![1.7, 0.0]));
            let frozen = more.frozen(&[1.7, 0.2]);
            assert!(frozen.shared.is_empty());
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
