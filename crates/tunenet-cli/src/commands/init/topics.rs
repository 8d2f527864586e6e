//! Which topic of a log has the positions of a robot's joints, and which has their commands.

use std::collections::BTreeMap;

use anyhow::Result;
use tunenet_core::{Error, Origin};
use tunenet_formats::{JointQuantity, NamedColumn};
use tunenet_sim::robot::Drive;

use super::place::{Place, position};
use crate::args::Init;
use crate::view::text::listed;

/// The topic with the positions of most joints, or the one that `--topic` names; `None` of a recording without topics.
///
/// # Errors
/// [`Error::Setting`] where several have as many, or `--topic` names none.
pub fn measured<'a>(
    options: &Init,
    found: &[NamedColumn],
    joints: &(impl Iterator<Item = &'a str> + Clone),
) -> Result<Option<String>> {
    let refuse = |expected: String, found: String| {
        Err(Error::Setting { origin: Origin::Flag, name: "--topic", expected, found }.into())
    };
    let mut topics: BTreeMap<&str, usize> = BTreeMap::new();
    for column in found {
        if let Some(topic) = &column.topic {
            topics.entry(topic).or_default();
        }
    }
    let names = || listed(topics.keys().copied());
    match &options.topic {
        Some(topic) if topics.contains_key(topic.as_str()) => return Ok(Some(topic.clone())),
        Some(topic) if topics.is_empty() => return refuse("a log with topics".into(), format!("`{topic}`")),
        Some(topic) => return refuse(format!("a topic with numbers ({})", names()), format!("`{topic}`")),
        None => {}
    }
    for (topic, count) in &mut topics {
        let within = found.iter().filter(|column| column.topic.as_deref() == Some(*topic));
        *count = joints.clone().filter(|joint| position(joint, &within).is_some()).count();
    }
    let most = topics.values().copied().max().unwrap_or(0);
    let mut best = topics.iter().filter(|(_, count)| **count == most).map(|(topic, _)| *topic);
    match (best.next(), best.next()) {
        (_, Some(_)) if most > 0 => {
            let several = listed(topics.iter().filter(|(_, count)| **count == most).map(|(topic, _)| *topic));
            refuse("the topic with the positions of the joints".into(), format!("several with as many: {several}"))
        }
        (Some(topic), None) => Ok(Some(topic.to_owned())),
        // What `--joints` names stands in one of them, or nowhere.
        (first, _) => {
            let named = |column: &&NamedColumn| {
                options.joints.iter().any(|(_, asked)| asked.split(':').next() == Some(column.name.as_str()))
            };
            let named = found.iter().find(named).and_then(|column| column.topic.clone());
            Ok(named.or(first.map(str::to_owned)))
        }
    }
}

/// The only column of commands to a joint with one of these names. Where none is called one, it is the joint's column in the only other topic
/// that has one.
///
/// # Errors
/// [`Error::Setting`] where several topics have one.
pub fn commands(names: &[&str], drive: Drive, found: &[NamedColumn], states: Option<&str>) -> Result<Option<Place>> {
    let wanted = quantity(drive);
    let of = |column: &NamedColumn| names.iter().find_map(|name| column.of_joint(name));
    let all = |fits: &dyn Fn(&NamedColumn) -> bool| found.iter().filter(|column| fits(column)).collect::<Vec<_>>();
    let stated =
        all(&|column| of(column).is_some_and(|of| of.command && of.quantity.is_some() && of.quantity == wanted));
    let bare = all(&|column| of(column).is_some_and(|of| of.command && of.quantity.is_none()));
    // A second topic of the same kind, whose name does not say what it is.
    let other = all(&|column| {
        column.topic.is_some()
            && column.topic.as_deref() != states
            && of(column).is_some_and(|of| of.quantity == wanted)
    });
    // Of a motor that is driven by torques, a table often has these alone.
    let driving = all(&|column| {
        drive == Drive::Torque
            && column.topic.is_none()
            && of(column).is_some_and(|of| of.quantity == Some(JointQuantity::Effort))
    });
    let some = [stated, bare, other, driving].into_iter().find(|some| !some.is_empty());
    let Some(some) = some else { return Ok(None) };
    match some.as_slice() {
        [one] => Ok(Some(Place::of(one))),
        several => {
            let places = several.iter().map(|column| match &column.topic {
                Some(topic) => format!("{topic}:{}", column.name),
                None => column.name.clone(),
            });
            let places: Vec<String> = places.collect();
            let found = listed(places.iter().map(String::as_str));
            let expected = format!("the column with the commands of `{}`, as JOINT=COLUMN:COMMAND", names[0]);
            let found = format!("several that may be it: {found}");
            Err(Error::Setting { origin: Origin::Flag, name: "--joints", expected, found }.into())
        }
    }
}

/// What the commands of a drive are; `None` of a voltage, which has no word of its own.
fn quantity(drive: Drive) -> Option<JointQuantity> {
    match drive {
        Drive::Position => Some(JointQuantity::Position),
        Drive::Velocity => Some(JointQuantity::Velocity),
        Drive::Torque => Some(JointQuantity::Effort),
        Drive::Voltage => None,
    }
}
