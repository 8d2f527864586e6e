//! Where fits begin: where a diagnosis ended.

use tunenet_core::diagnose::Diagnosis;
use tunenet_core::law::Point;
use tunenet_core::simulator::{Parameter, Prepared};

/// Where the diagnosis ended, for a simulator with these parameters and recordings that it prepared; what the diagnosis does not know begins as
/// the file and the recordings have it. `None` where the recordings were not fitted whole.
#[must_use]
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
