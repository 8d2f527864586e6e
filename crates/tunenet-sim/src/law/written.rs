//! A law that was found, as candidates of a simulation file with their values: what a user would write.

use std::fmt::Write as _;

use tunenet_core::law::{FoundTerm, Member, Number};
use tunenet_core::simulator::Parameter;
use tunenet_formats::Result;

use super::equations::{expressions, range_name};
use super::free_name;
use crate::SimulationFile;
use crate::equations::body::States;
use crate::simulation_file::Domain;

/// `file` with the parameters (in the order of `parameters`) and every term of `law` as a candidate and as an effect.
///
/// # Errors
/// Where the file cannot hold it.
pub fn written(file: &SimulationFile, parameters: &[Parameter], law: &Member) -> Result<SimulationFile> {
    let mut file = file.clone();
    for (parameter, (value, _)) in parameters.iter().zip(&law.parameters) {
        match parameter.name.split_once('.') {
            Some((effect, key)) => file.add_effect(effect, &[(key, *value)])?,
            None if parameter.tune => file.set_value(&parameter.name, *value),
            None => {}
        }
    }
    for term in &law.terms {
        let name = free_name(&file, &term.carried.effect.name);
        let text = format!("{}\n{}", file.text().trim_end(), tables(&file, &name, law, term)?);
        file = SimulationFile::parse(file.path(), &text)?;
    }
    Ok(file)
}

/// The tables of one term.
fn tables(file: &SimulationFile, name: &str, law: &Member, term: &FoundTerm) -> Result<String> {
    let mut text = format!("\n[candidates.{name}]\nsentence = \"a law that the recordings show\"\n");
    let product = |coefficient: &str| {
        if term.formula.is_empty() { coefficient.to_owned() } else { format!("{coefficient} * {}", term.formula) }
    };
    let ball = file.domain() == Domain::Ball;
    let (linear, inner) = term.numbers.split_at(term.components.len());
    if ball {
        let along: Vec<String> = term.components.iter().map(|word| format!("\"{word}\"")).collect();
        line(&mut text, "acts", "\"flight\"");
        line(&mut text, "along", &format!("[{}]", along.join(", ")));
        line(&mut text, "formula", &format!("\"{}\"", product("a")));
        line(&mut text, "gives", "\"m_s2\"");
        if linear.len() > 1 {
            line(&mut text, "per_direction", "[\"a\"]");
        }
        valid(&mut text, law.valid.iter().map(|(name, range)| (name.as_str(), *range)));
    } else {
        let scene = file.equations()?;
        let is_body = States::of(scene).body().is_some();
        line(&mut text, "acts", if is_body { "\"flight\"" } else { "\"joint\"" });
        let mut adds: Vec<(String, String)> = Vec::new();
        for (component, number) in term.components.iter().zip(linear) {
            for (state, factor) in expressions(scene, component) {
                let factor = factor.map(|f| format!(" * {f}")).unwrap_or_default();
                let formula = format!("{}{factor}", product(&number.key));
                match adds.iter_mut().find(|(known, _)| *known == state) {
                    Some((_, sum)) => *sum = format!("{sum} + {formula}"),
                    None => adds.push((state, formula)),
                }
            }
        }
        for (state, formula) in adds {
            line(&mut text, &format!("adds.{state}"), &format!("\"{formula}\""));
        }
        let named = law.valid.iter().filter_map(|(name, range)| Some((range_name(scene, name)?, *range)));
        valid(&mut text, named);
    }
    let bounds: Vec<(f64, f64)> = term.carried.effect.coefficients.iter().map(|c| (c.min, c.max)).collect();
    for (i, number) in term.numbers.iter().enumerate() {
        // The directions of a ball's formula share one coefficient, with a number each.
        if ball && i > 0 && i < linear.len() {
            continue;
        }
        let key = if ball && i == 0 { "a" } else { &number.key };
        let all = if ball && i == 0 { linear } else { std::slice::from_ref(number) };
        let (low, high) = all.iter().fold(bounds[i], |(low, high), n| (low.min(n.value), high.max(n.value)));
        let absent = if number.role.is_none() { Some(0.0) } else { (!ball).then_some(low) };
        writeln!(text, "[candidates.{name}.coefficients.{key}]").expect("a string takes all");
        line(&mut text, "unit", &format!("\"{}\"", number.unit));
        if let Some(absent) = absent {
            line(&mut text, "absent", &format!("{absent:?}"));
        }
        line(&mut text, "min", &format!("{low:?}"));
        line(&mut text, "max", &format!("{high:?}"));
        line(&mut text, "typical", &format!("{:?}", 0.05 * (high - low)));
    }
    writeln!(text, "[effects.{name}]").expect("a string takes all");
    if ball && linear.len() > 1 {
        line(&mut text, "a", &format!("[{}]", linear.iter().map(value).collect::<Vec<_>>().join(", ")));
    } else {
        for number in linear {
            line(&mut text, if ball { "a" } else { &number.key }, &value(number));
        }
    }
    for number in inner {
        line(&mut text, &number.key, &value(number));
    }
    Ok(text)
}

/// The ranges in which it was seen, to six digits.
fn valid<'a>(text: &mut String, ranges: impl Iterator<Item = (&'a str, (f64, f64))>) {
    let short = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
    let each: Vec<String> =
        ranges.map(|(name, (low, high))| format!("{name} = [{:?}, {:?}]", short(low), short(high))).collect();
    if !each.is_empty() {
        line(text, "valid", &format!("{{ {} }}", each.join(", ")));
    }
}

fn value(number: &Number) -> String {
    format!("{:?}", number.value)
}

fn line(text: &mut String, key: &str, value: &str) {
    writeln!(text, "{key} = {value}").expect("a string takes all");
}
