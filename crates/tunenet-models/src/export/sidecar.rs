//! What a model file cannot express, as TOML.

use std::path::Path;

use toml_edit::{Array, DocumentMut, Item, Table, value};

use crate::edit::Left;

/// An effect of the robot as a whole, or of its readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Whole {
    /// Its name in a simulation file.
    pub effect: String,
    /// Its numbers.
    pub numbers: Vec<WholeNumber>,
    /// Why a model file cannot hold it.
    pub why: String,
}

/// A number of such an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeNumber {
    /// Its key, which ends in its unit.
    pub key: String,
    /// Its value.
    pub value: f64,
    /// Its 95 % interval; `None` where it is not known.
    pub interval: Option<[f64; 2]>,
}

/// The first line of a sidecar.
const HEAD: &str = "# What the model file cannot express: simulate it around the model.\n";

/// Whether a text was written by [`sidecar`].
#[must_use]
pub fn is_sidecar(text: &str) -> bool {
    text.starts_with(HEAD)
}

/// A TOML with a table for each joint and quantity: `value`, `unit`, `interval` where it is known, and `why` the model file
/// cannot hold it; and one for each effect of the robot as a whole, with a table `interval`. Empty where there is nothing to say.
#[must_use]
pub fn sidecar(model: &Path, left: &[Left], whole: &[Whole]) -> String {
    if left.is_empty() && whole.is_empty() {
        return String::new();
    }
    let mut document = DocumentMut::new();
    document.decor_mut().set_prefix(HEAD);
    document["model"] = value(model.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default());
    let mut joints = Table::new();
    joints.set_implicit(true);
    for one in left {
        let change = &one.change;
        let joint = joints.entry(&change.joint).or_insert_with(|| {
            let mut table = Table::new();
            table.set_implicit(true);
            Item::Table(table)
        });
        let mut table = Table::new();
        table["value"] = value(change.value);
        table["unit"] = value(change.unit());
        if let Some(interval) = change.interval {
            table["interval"] = value(Array::from_iter(interval));
        }
        table["why"] = value(&one.why);
        joint[change.quantity.name()] = Item::Table(table);
    }
    if !left.is_empty() {
        document["joints"] = Item::Table(joints);
    }
    let mut robot = Table::new();
    robot.set_implicit(true);
    for one in whole {
        let mut table = Table::new();
        for number in &one.numbers {
            table[number.key.as_str()] = value(number.value);
        }
        table["why"] = value(&one.why);
        let mut intervals = Table::new();
        for (number, interval) in one.numbers.iter().filter_map(|number| Some((number, number.interval?))) {
            intervals[number.key.as_str()] = value(Array::from_iter(interval));
        }
        if !intervals.is_empty() {
            table["interval"] = Item::Table(intervals);
        }
        robot[one.effect.as_str()] = Item::Table(table);
    }
    if !whole.is_empty() {
        document["robot"] = Item::Table(robot);
    }
    document.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Change, Motion, Quantity};

    #[test]
    fn a_sidecar_reads_back() {
        let change = Change {
            joint: "arm \"1\".x".into(),
            motion: Motion::Prismatic,
            quantity: Quantity::DeadBand,
            value: 0.01,
            interval: Some([0.0, 0.02]),
        };
        let left = [Left { change, why: "MJCF has no attribute for it".into() }];
        let delay = WholeNumber { key: "delay_s".into(), value: 0.02, interval: Some([0.01, 0.03]) };
        let whole = [Whole { effect: "time_delay".into(), numbers: vec![delay], why: "it is one of readings".into() }];
        let text = sidecar("folder/arm.xml".as_ref(), &left, &whole);
        let read: DocumentMut = text.parse().unwrap();
        assert_eq!(read["model"].as_str(), Some("arm.xml"));
        assert!(is_sidecar(&text) && !is_sidecar("model = 1"));
        let table = &read["joints"]["arm \"1\".x"]["dead_band"];
        assert_eq!((table["value"].as_float(), table["unit"].as_str()), (Some(0.01), Some("m")));
        assert_eq!(table["interval"][1].as_float(), Some(0.02));
        let delay = &read["robot"]["time_delay"];
        assert_eq!((delay["delay_s"].as_float(), delay["interval"]["delay_s"][1].as_float()), (Some(0.02), Some(0.03)));
        assert_eq!(sidecar("arm.xml".as_ref(), &[], &[]), "");
    }
}
