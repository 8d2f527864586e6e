//! Overrides of single keys: `--set TABLE.KEY=VALUE`, and what a manifest says of a recording.

use toml_edit::{Item, Table, TableLike, Value};
use tunenet_core::Origin;
use tunenet_formats::Result;

use super::domain::Domain;
use super::{SimulationFile, check, number, scene};

impl SimulationFile {
    /// Overrides one key, as `--set TABLE.KEY=VALUE` does. `start.NAME=VALUE` sets `start.NAME.value`.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where the text is not of that form, the key is unknown, or the value
    /// does not fit it.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let Some((path, text)) = assignment.split_once('=') else {
            return refuse("TABLE.KEY=VALUE".into(), format!("`{assignment}`"));
        };
        self.set_all(&[(path.trim(), text.trim())])
    }

    /// Overrides several keys, which have to fit together only in the end; the file is as before where they do not.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn set_all(&mut self, assignments: &[(&str, &str)]) -> Result<()> {
        let mut changed = self.clone();
        for (path, text) in assignments {
            changed.assign(path, text)?;
        }
        if let Some((path, _, expected, found)) = check::contradiction(changed.domain(), changed.document.root()) {
            return refuse(format!("{expected} for `{path}`"), found);
        }
        let paths = || assignments.iter().map(|(path, _)| format!("`{path}`")).collect::<Vec<_>>().join(", ");
        match scene(changed.domain(), &changed.document) {
            Ok(scene) => changed.scene = scene,
            Err(e) => return refuse(format!("a value that fits {}", paths()), e.message().to_owned()),
        }
        *self = changed;
        Ok(())
    }

    fn assign(&mut self, path: &str, text: &str) -> Result<()> {
        let longer = format!("{path}.value");
        let state = self.domain().declares() && path.starts_with("start.") && path.matches('.').count() == 1;
        let path = if state { longer.as_str() } else { path };
        let Some(key) = self.domain().find(path) else {
            let known = self.domain().siblings(path).join(", ");
            return refuse(format!("a key of a simulation file ({known})"), format!("`{path}`"));
        };
        let value: Value = text.parse().unwrap_or_else(|_| number(text).map_or_else(|| Value::from(text), Value::from));
        if !key.shape.accepts(&value) {
            return refuse(format!("{} for `{path}`", key.shape.expected()), format!("`{text}`"));
        }
        let parts: Vec<&str> = path.split('.').collect();
        if self.domain().declares() {
            self.declared(&parts)?;
        }
        let mut table: &mut dyn TableLike = self.document.root_mut();
        for part in &parts[..parts.len() - 1] {
            let item = table.entry(part).or_insert(Item::Table(Table::new()));
            let Some(inner) = item.as_table_like_mut() else {
                return refuse(format!("`{part}` as a [table]"), "something else in the file".into());
            };
            table = inner;
        }
        table.insert(parts[parts.len() - 1], Item::Value(value));
        if let (Domain::Arm, ["parameters", name, "value"]) = (self.domain(), parts.as_slice()) {
            // Who says a value knows it: what an earlier tuning was sure of it is another value's.
            self.document.remove(&format!("provenance.interval95.{name}"));
        }
        Ok(())
    }

    /// Refuses a parameter, an initial state, a setting, a constant or an input that the file does not declare: nothing reads a misspelt one.
    fn declared(&self, parts: &[&str]) -> Result<()> {
        let (what, table, name) = match parts {
            [table @ "parameters", name, ..] => ("a parameter", table, name),
            [table @ "start", name, ..] => ("an initial state", table, name),
            [table @ "settings", name, ..] => ("a setting", table, name),
            [table @ "constants", name, ..] => ("a constant", table, name),
            [table @ "joints", name, ..] => ("a joint", table, name),
            [table @ "loads", name, ..] => ("a load", table, name),
            // A robot's commands are inputs by the names of its joints.
            [table @ "inputs", name, ..] if self.domain() != Domain::Robot => ("an input", table, name),
            _ => return Ok(()),
        };
        let known = self.keys(table);
        // Without any settings the program's own stand in the manifest alone.
        if known.iter().any(|key| key == name) || (*table == "settings" && known.is_empty()) {
            return Ok(());
        }
        let listed = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        refuse(format!("{what} of the file ({listed})"), format!("`{name}`"))
    }

    /// The keys of a table.
    fn keys(&self, table: &str) -> Vec<String> {
        let item = self.document.item(table).and_then(Item::as_table_like);
        item.map_or_else(Vec::new, |table| table.iter().map(|(key, _)| key.to_owned()).collect())
    }
}

fn refuse<T>(expected: String, found: String) -> Result<T> {
    Err(tunenet_core::Error::Setting { origin: Origin::Caller, name: "--set", expected, found }.into())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const FILE: &str = "kind = \"process\"\n[process]\ncommand = [\"true\"]\nchannels = [\"x_m\"]\n[parameters.mass]\nvalue = 1.0\n\
                        min = 0.1\nmax = 9.0\nunit = \"kg\"\n[start.x_m]\nvalue = 0.0\n[settings]\nload_kg = 0.2\n";

    #[test]
    fn a_state_or_a_setting_that_the_file_lacks_is_refused() {
        let mut file = SimulationFile::parse(Path::new("cart.toml"), FILE).unwrap();
        file.set_all(&[("start.x_m", "0.3"), ("settings.load_kg", "0.5")]).unwrap();
        for (key, known) in [
            ("start.y_m", "an initial state of the file (x_m)"),
            ("settings.load", "(load_kg)"),
            ("inputs.u_v.default", "an input of the file (none)"),
        ] {
            let message = file.set(&format!("{key}=0.4")).unwrap_err().to_string();
            assert!(message.contains(known), "{message}");
        }
        // A file without settings leaves them all to its manifest.
        let mut free = SimulationFile::parse(Path::new("cart.toml"), FILE.split("[settings]").next().unwrap()).unwrap();
        free.set("settings.load=0.4").unwrap();
    }
}
