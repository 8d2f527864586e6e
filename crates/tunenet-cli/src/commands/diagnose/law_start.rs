//! Where a search for a law begins: what the diagnosis found.

use tunenet_core::diagnose::{Diagnosis, NamedEffect};
use tunenet_core::law::{Named, Point};
use tunenet_core::simulator::{Parameter, Prepared};

/// Where the diagnosis ended, for the simulation in which a law is searched: what it does not know is where fits begin.
pub fn known(diagnosis: &Diagnosis, parameters: &[Parameter], fitted: &[Prepared]) -> Option<Point> {
    let tuned =
        |p: &Parameter| diagnosis.parameters.iter().find(|one| one.name == p.name).map_or(p.value, |one| one.value);
    let ended: Vec<_> = diagnosis.explained.iter().filter(|one| !one.held_out && one.segment.is_none()).collect();
    let same = ended.len() == fitted.len();
    let nuisances = fitted.iter().zip(&ended).map(|(recording, ended)| {
        let value = |(p, begin): (&Parameter, f64)| {
            let found = ended.nuisances.iter().find(|(name, ..)| *name == p.name);
            found.map_or(begin, |(_, value, _)| value.clamp(p.min, p.max))
        };
        recording.nuisances.iter().zip(recording.nuisance_values()).map(value).collect()
    });
    same.then(|| Point { parameters: parameters.iter().map(tuned).collect(), nuisances: nuisances.collect() })
}

/// An effect of a diagnosis of one object, with what was found of it.
pub fn named(one: &NamedEffect) -> Named {
    let values = one.coefficients.iter().flat_map(|fitted| &fitted.values).map(|value| value.value);
    Named { name: one.effect.name.to_string(), values: values.collect() }
}
