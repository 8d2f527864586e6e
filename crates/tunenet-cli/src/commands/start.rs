//! What `tune` starts from: said before any recording is read, so that no recording is blamed for it.

use tunenet_core::Origin;
use tunenet_formats::{Error, Result};
use tunenet_sim::SimulationFile;

use crate::args::Tune;

/// Refuses a start from which nothing can be tuned.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) where `--set` or `--initial` is to blame, [`Error::File`] where the
/// simulation file is.
pub fn check(options: &Tune, file: &SimulationFile) -> Result<()> {
    let parameters = file.parameters()?;
    if !parameters.iter().any(|p| p.tune) && !file.tunes_an_effect() {
        let named = |set: &&String| set.starts_with("parameters.") && set.contains(".tune");
        if let Some(last) = options.simulation.set.iter().rev().find(named) {
            let expected = "at least one parameter that may be tuned".into();
            return Err(tunenet_core::Error::Setting {
                origin: Origin::Flag,
                name: "--set",
                expected,
                found: format!("none after `{last}`"),
            }
            .into());
        }
        let message = "expected at least one parameter with `tune = true`, found none";
        let first = &parameters[0].name;
        let hint = format!(
            "write it under [parameters.{first}], or add `--set parameters.{first}.tune=true`; an effect has such a key too"
        );
        return Err(Error::file(file.path(), message, hint));
    }
    for (name, value) in &options.initial {
        let refuse = |expected: String, found: String| {
            Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "--initial", expected, found }.into())
        };
        let Some(parameter) = parameters.iter().find(|p| p.name == *name) else {
            let known: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
            return refuse(format!("a parameter ({})", known.join(", ")), format!("`{name}`"));
        };
        if !(parameter.min..=parameter.max).contains(value) {
            return refuse(format!("{} to {} for `{name}`", parameter.min, parameter.max), value.to_string());
        }
    }
    Ok(())
}
