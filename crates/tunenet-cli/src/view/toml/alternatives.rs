//! What each explanation would be in numbers, where recordings cannot choose between several.

use toml_edit::{Array, InlineTable};
use tunenet_core::observation::Observation;
use tunenet_core::simulator::Simulator;
use tunenet_core::tune::{Outcome, Settings, shares, tune};
use tunenet_sim::{SimulationFile, open_drag};

/// A number of an explanation: the name of its parameter, its value, its 95 % interval.
pub type Stated = (String, f64, (f64, f64));

/// Each of these explanations in addition to what is certain. The one whose numbers are `stated` already has these.
pub fn fitted(
    simulator: &dyn Simulator,
    names: &[&str],
    sure: &[&str],
    seen: &[Observation],
    stated: Option<&(&str, Vec<Stated>)>,
) -> Array {
    let one = |name: &&str| {
        let names: Vec<&str> = sure.iter().copied().chain([*name]).collect();
        let with = simulator.with_effects(&names).ok()?;
        let outcome = tune(&with, seen, None, &Settings::default()).ok()?;
        let mut one = InlineTable::new();
        one.insert("name", (*name).into());
        let found = outcome.parameters.iter().filter(|found| found.identified);
        let found: Vec<Stated> = found.map(|found| (found.name.clone(), found.value, found.interval95)).collect();
        let numbers = stated.filter(|(of, _)| of == name).map_or(&found, |(_, numbers)| numbers);
        // Its own coefficients stand there without its name.
        for (key, value, interval95) in numbers {
            let own = key.strip_prefix(*name).and_then(|rest| rest.strip_prefix('.'));
            put(&mut one, own.unwrap_or(key), *value, *interval95);
        }
        (one.len() > 1).then_some((one, outcome))
    };
    let (tables, fits): (Vec<InlineTable>, Vec<Outcome>) = names.iter().filter_map(one).unzip();
    weighed(tables, &shares(&fits))
}

/// Every drag that `seen` leaves open for the ball of a tuned file in addition to what is certain.
pub fn open_to(tuned: &SimulationFile, sure: &[&str], seen: &[Observation]) -> tunenet_formats::Result<Array> {
    let possible = open_drag::possible(tuned, sure, seen)?;
    let weights: Vec<f64> = possible.iter().map(|held| held.share).collect();
    let tables = possible.iter().map(|held| {
        let mut one = InlineTable::new();
        one.insert("c_1_m", held.value.into());
        held.fitted.iter().for_each(|(name, value, interval)| put(&mut one, name, *value, *interval));
        one
    });
    Ok(weighed(tables.collect(), &weights))
}

fn put(table: &mut InlineTable, name: &str, value: f64, (low, high): (f64, f64)) {
    let key = name.replace('.', "_");
    table.insert(format!("{key}_interval95"), Array::from_iter([low, high]).into());
    table.insert(key, value.into());
}

fn weighed(tables: Vec<InlineTable>, weights: &[f64]) -> Array {
    let each = tables.into_iter().zip(weights);
    each.map(|(mut table, weight)| {
        table.insert("weight", (*weight).into());
        table
    })
    .collect()
}
