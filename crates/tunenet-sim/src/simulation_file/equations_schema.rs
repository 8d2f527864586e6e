//! What no key alone can say of a simulation file of equations.

use std::ops::Range;

use toml_edit::{DocumentMut, Item, Table, Value};

use super::declared_check::{self, Wrong};
use super::declared_schema::Declares;
use super::schema::{Definition, lookup};
use crate::equations::{Misfit, System};
use crate::scene::EquationsScene;

/// The parameters of the equations that `tunenet init equations` writes.
pub(super) const SAMPLES: &[Definition] = &[
    Definition {
        name: "length",
        unit: "m",
        default: [1.0, 0.2, 2.0],
        tune: true,
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        within: "any size",
        meaning: "A number that formulas use, by a name of yours: here the pendulum's length",
    },
    Definition {
        name: "damping",
        unit: "1/s",
        default: [0.1, 0.0, 2.0],
        tune: true,
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        within: "any size",
        meaning: "Another: how fast the swing dies away",
    },
];

/// The first thing that no key alone shows to be wrong: its path, its place, what is expected and what is found.
pub(super) fn contradiction(root: &Table) -> Option<Wrong> {
    declared_check::contradiction(root, Declares::Equations).or_else(|| equations(root))
}

fn equations(root: &Table) -> Option<Wrong> {
    if lookup(root, "derivatives").is_none() || lookup(root, "states").is_none() {
        let missing = if lookup(root, "states").is_none() { "states" } else { "derivatives" };
        return Some((missing.into(), 0..0, format!("a table [{missing}]"), "none".into()));
    }
    // A value of the wrong kind was refused with its key.
    let scene: EquationsScene = toml_edit::de::from_document(DocumentMut::from(root.clone())).ok()?;
    let all = lookup(root, "parameters").and_then(Item::as_table_like);
    let unit = |item: &'_ Item| item.as_table_like().and_then(|table| table.get("unit")?.as_str().map(str::to_owned));
    let parameters: Vec<(&str, Option<String>)> =
        all.into_iter().flat_map(|all| all.iter()).map(|(name, item)| (name, unit(item))).collect();
    let parameters: Vec<(&str, Option<&str>)> =
        parameters.iter().map(|(name, unit)| (*name, unit.as_deref())).collect();
    let Misfit { path, place, expected, found } = System::new(&scene, &parameters).err()?;
    let item = lookup(root, &path);
    let whole = item.and_then(Item::span).unwrap_or(0..0);
    let span = place.zip(item.and_then(Item::as_value)).and_then(|(place, value)| within(value, place));
    Some((path, span.unwrap_or(whole), expected, found))
}

/// Where a part of a text stands in the file: behind one quote, or behind three and perhaps the end of their line. With escapes,
/// which move it, nothing is known.
fn within(value: &Value, place: Range<usize>) -> Option<Range<usize>> {
    let (span, text) = (value.span()?, value.as_str()?);
    let before = match span.len().checked_sub(text.len())? {
        2 => 1,
        6 => 3,
        7 => 4,
        8 => 5,
        _ => return None,
    };
    let start = span.start + before;
    Some(start + place.start..start + place.end)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{Domain, SimulationFile, template};

    #[test]
    fn a_mistake_is_at_its_character_and_values_may_be_overridden() {
        let text = template(Domain::Equations);
        let line = |part: &str| text.lines().position(|line| line.contains(part)).unwrap() + 1;
        for (from, to, place, wanted) in [
            ("sin(angle_rad)", "sin(angel_rad)", (line("sin("), 35), "found `angel_rad`"),
            (
                "= \"rate_rad_s\"\nrate",
                "= \"\\u0072\\u0061te_rad_s + q\"\nrate",
                (line("= \"rate_rad_s\""), 13),
                "found `q`",
            ),
            (
                "= \"rate_rad_s\"\nrate",
                "= '''\nrate_rad_s + q'''\nrate",
                (line("= \"rate_rad_s\"") + 1, 14),
                "found `q`",
            ),
            ("[derivatives]\n", "[derivatives]\nq_m = \"1\"\n", (line("[derivatives]") + 1, 7), "expected a state"),
            ("adds.rate_rad_s", "add.rate_rad_s", (line("adds.rate"), 1), "found `candidates.dry_friction.add`"),
            ("gravity = 9.81", "gravity = \"9.81\"", (line("gravity = 9.81"), 11), "expected a number"),
            ("[start.rate_rad_s]\nvalue = 0.0\n", "", (line("[states.rate_rad_s]"), 1), "expected [start.rate_rad_s]"),
            (
                "value = 0.0\n",
                "value = \"first\"\n",
                (line("[start.rate_rad_s]") + 1, 9),
                "`outputs` has no `rate_rad_s`",
            ),
        ] {
            assert!(text.contains(from), "{from}");
            let refused = SimulationFile::parse(Path::new("swing.toml"), &text.replacen(from, to, 1)).unwrap_err();
            let refused = refused.to_string();
            let start = format!("swing.toml:{}:{}: ", place.0, place.1);
            assert!(refused.starts_with(&start) && refused.contains(wanted), "{start}{wanted}\n{refused}");
        }
        let mut file = SimulationFile::parse(Path::new("swing.toml"), &text).unwrap();
        file.set_all(&[("constants.gravity", "1.62"), ("start.angle_rad", "0.1")]).unwrap();
        assert_eq!(file.equations().unwrap().constants["gravity"], 1.62);
        for (change, wanted) in [
            ("constants.mass=1", "a constant of the file (gravity, gain)"),
            ("derivatives.angle_rad=rate", "found `rate`"),
            ("settings.mass=1", "a key of a simulation file"),
        ] {
            let refused = file.set(change).unwrap_err().to_string();
            assert!(refused.contains(wanted), "{change}: {refused}");
        }
    }
}
