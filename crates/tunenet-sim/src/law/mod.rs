//! Hosts of a search for a law: simulators whose equations of motion take further terms.
//!
//! | file | subject |
//! |---|---|
//! | `ball` | accelerations of a ball in flight |
//! | `equations` | what is added to derivatives |
//! | `written` | a law that was found as a candidate of a simulation file |
//! | `contested` | named effects against what no catalogue holds |
//! | `known` | where fits begin |
//! | `outside` | where a simulation leaves the range in which it was seen |

mod ball;
mod contested;
mod equations;
mod known;
mod outside;
mod visiting;
mod written;

use tunenet_core::law::Host;
use tunenet_core::observation::Kind;
use tunenet_formats::Result;
use tunenet_formula::Unit;

use crate::SimulationFile;
use crate::simulation_file::Domain;

pub use contested::contested;
pub use known::known;
pub use outside::outside;
pub use written::written;

/// A host, or a sentence that says why there is no place for a law.
pub type Placed = std::result::Result<Box<dyn Host>, &'static str>;

/// The host that `files` describe, one for each setup of the recordings, observed as `kind`. Effects that `present` names keep their
/// coefficients free.
///
/// # Errors
/// As [`observed::in_setups`](crate::observed::in_setups).
pub fn host(files: &[&SimulationFile], kind: Kind, present: &[&str]) -> Result<Placed> {
    Ok(match (files[0].domain(), kind) {
        (Domain::Ball, Kind::Positions) if files.len() > 1 => {
            Err("a law of a ball is searched in recordings of one setup only")
        }
        (Domain::Ball, Kind::Positions) => Ok(Box::new(ball::BallHost::new(files[0], present)?)),
        (Domain::Ball, _) => Err("a law of a ball is searched in recordings of positions only"),
        (Domain::Equations, Kind::Other) => match equations::EquationsHost::new(files, present)? {
            Some(host) => Ok(Box::new(host)),
            None => Err("these equations have no state to whose derivative a law could be added"),
        },
        (Domain::Equations, _) => Err("a law of equations is searched in recordings of their outputs only"),
        (Domain::Process, _) => {
            Err("an external program has no place for a law: write the model as equations, or declare candidates")
        }
        (Domain::Robot, _) => {
            Err("a law is not searched in joints that follow commands: `diagnose` without --law names their effects")
        }
        (Domain::Arm, _) => Err("a law is not searched in an arm: write formulas of its joints as candidates"),
    })
}

/// `unit` over powers of other units, as text.
fn over(unit: &str, powers: &[(&str, f64)]) -> String {
    let Some(start) = Unit::parse(unit) else { return unit.to_owned() };
    let product = powers.iter().fold(start, |unit, (other, power)| match Unit::parse(other) {
        Some(other) => unit.product(1.0, &other, -power),
        None => unit,
    });
    product.to_string()
}

/// A name that starts as `wanted` and that `file` does not use yet.
fn free_name(file: &SimulationFile, wanted: &str) -> String {
    let parameters = file.parameters().unwrap_or_default();
    let taken = |name: &str| {
        file.candidate(name).is_some()
            || file.effects().iter().any(|e| e.name == name)
            || parameters.iter().any(|p| p.name == name)
    };
    let mut name = wanted.to_owned();
    while taken(&name) {
        name.push_str("_more");
    }
    name
}
