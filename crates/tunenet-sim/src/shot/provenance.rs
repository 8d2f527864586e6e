//! What a simulation file says of where its numbers come from: how sure they are, and which others were possible.

use toml_edit::{InlineTable, Item, Value};
use tunenet_core::observation::Note;

use crate::SimulationFile;
use crate::findings;
use crate::simulation_file::schema::number;

/// What wrote a file, and how sure it was.
pub(super) struct Provenance<'a> {
    pub file: &'a SimulationFile,
}

impl Provenance<'_> {
    fn item(&self, key: &str) -> Option<&Item> {
        self.file.item("provenance")?.as_table_like()?.get(key)
    }

    fn word(&self, key: &str) -> &str {
        self.item(key).and_then(Item::as_str).unwrap_or_default()
    }

    /// The 95 % interval of a parameter.
    pub fn interval(&self, name: &str) -> Option<(f64, f64)> {
        pair(self.item("interval95")?.as_table_like()?.get(&name.replace('.', "_"))?)
    }

    /// The 95 % interval of a coefficient: of a named effect, or tuned like a parameter.
    pub fn of_effect(&self, effect: &str, key: &str) -> Option<(f64, f64)> {
        let named = self.item("effects").and_then(Item::as_array).and_then(|all| {
            let tables = all.iter().filter_map(Value::as_inline_table);
            let mut own = tables.filter(|t| t.get("name").and_then(|n| n.as_str()) == Some(effect));
            let interval = own.next()?.get(&format!("{key}_interval95"))?.as_array()?;
            Some((number(interval.get(0)?)?, number(interval.get(1)?)?))
        });
        named.or_else(|| self.interval(&format!("{effect}.{key}")))
    }

    /// A list of explanations, each with its numbers.
    pub fn list(&self, key: &str) -> Option<Vec<&InlineTable>> {
        let listed = self.item(key)?.as_array()?;
        Some(listed.iter().filter_map(Value::as_inline_table).collect())
    }

    pub fn is_alternative(&self, name: &str) -> bool {
        let named = |t: &&InlineTable| t.get("name").and_then(Value::as_str) == Some(name);
        self.list("alternatives").is_some_and(|all| all.iter().any(named))
    }

    pub fn notes(&self) -> Vec<Note> {
        let again = "tune it to a drop of this ball: `tunenet tune … --out tuned.toml`";
        match self.word("verdict") {
            "" => vec![Note::new(
                findings::PLAN_UNTUNED,
                "this simulation was never tuned: its values are used as they are, and the success probability says nothing \
                 of how wrong they are",
                again,
            )],
            "poor_fit" => vec![Note::new(
                findings::PLAN_POOR_FIT,
                "this simulation was tuned, but does not match the measurement",
                "ask `tunenet diagnose` what it lacks, and plan with the file that it writes",
            )],
            "one_of" if self.list("alternatives").is_none() => vec![Note::new(
                findings::PLAN_ONE_EXPLANATION,
                "several effects explain the measurement, and the file has only the numbers of one",
                "record what `tunenet diagnose` proposes next, and diagnose again",
            )],
            _ => Vec::new(),
        }
    }
}

fn pair(item: &Item) -> Option<(f64, f64)> {
    let array = item.as_array()?;
    let (low, high) = (number(array.get(0)?)?, number(array.get(1)?)?);
    (low <= high).then_some((low, high))
}
