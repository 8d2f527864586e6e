//! Joint messages as rows: joints matched by name, quantities settled by the first message.

use super::message::JointMessage;
use crate::findings;
use crate::quantity::{Family, Quantity};
use crate::shown::{counted, list};
use tunenet_core::observation::{Channel, Note};

/// Most joints that a note names.
const MOST_NAMED: usize = 12;

/// The joints and quantities of a series, from its first message.
#[derive(Debug)]
pub(crate) struct Joints {
    names: Vec<String>,
    /// Position, velocity, effort: which are there.
    present: [bool; 3],
    /// Messages left out because they lack a joint or a quantity.
    partial: usize,
    /// Joints of such messages that are not among these.
    strange: Vec<String>,
    /// Joints of the messages that were not requested.
    others: Vec<String>,
}

impl Joints {
    /// Settles the joints, or says why the message cannot. They are those of `wanted`, in that order; without any, those of the
    /// message, in its own.
    pub fn new(first: &JointMessage, wanted: &[String]) -> std::result::Result<Self, String> {
        if first.name.is_empty() {
            return Err("expected joint names, found none".into());
        }
        for (i, name) in first.name.iter().enumerate() {
            if first.name[..i].contains(name) {
                return Err(format!("expected each joint once, found `{name}` twice"));
            }
        }
        let arrays = arrays(first);
        for (array, what) in arrays.iter().zip(["position", "velocity", "effort"]) {
            if !array.is_empty() && array.len() != first.name.len() {
                return Err(format!("expected {} values of `{what}`, found {}", first.name.len(), array.len()));
            }
        }
        // Controllers publish NaN for what they do not measure.
        let mine = |at: &usize| wanted.is_empty() || wanted.contains(&first.name[*at]);
        let present =
            arrays.map(|array| !array.is_empty() && (0..array.len()).filter(mine).all(|at| array[at].is_finite()));
        if present == [false; 3] {
            return Err("expected positions, velocities or efforts, found none".into());
        }
        if wanted.is_empty() {
            return Ok(Self {
                names: first.name.clone(),
                present,
                partial: 0,
                strange: Vec::new(),
                others: Vec::new(),
            });
        }
        let missing: Vec<&str> = wanted.iter().filter(|name| !first.name.contains(name)).map(String::as_str).collect();
        if !missing.is_empty() {
            let found = list(first.name.iter().map(String::as_str), usize::MAX);
            let missing = list(missing, usize::MAX);
            return Err(format!("expected the joints of the URDF, found no {missing} among {found}"));
        }
        let others = first.name.iter().filter(|name| !wanted.contains(name)).cloned().collect();
        Ok(Self { names: wanted.to_vec(), present, partial: 0, strange: Vec::new(), others })
    }

    /// The channels `q1`…, `dq1`…, `tau1`… of the quantities that are there.
    pub fn channels(&self) -> Vec<Channel> {
        let families: [Family; 3] = [Quantity::Angle, Quantity::Speed, Quantity::Torque];
        let joints = u16::try_from(self.names.len()).unwrap_or(u16::MAX);
        let present = families.into_iter().zip(self.present).filter(|(_, present)| *present);
        present.flat_map(|(family, _)| (1..=joints).map(move |joint| family(joint).channel())).collect()
    }

    /// Appends a message's values in the order of the channels; a message that lacks one is counted and left out.
    pub fn row(&mut self, message: &JointMessage, values: &mut Vec<f64>) -> bool {
        let start = values.len();
        // Publishers rarely change the order, so the common case is one comparison of the lists.
        let order: Option<Vec<usize>> = if self.names == message.name {
            Some((0..self.names.len()).collect())
        } else {
            self.names.iter().map(|name| message.name.iter().position(|other| other == name)).collect()
        };
        if let Some(order) = order {
            for (array, _) in arrays(message).into_iter().zip(self.present).filter(|(_, present)| *present) {
                values.extend(order.iter().filter_map(|at| array.get(*at)));
            }
        }
        let wanted = self.names.len() * self.present.iter().filter(|present| **present).count();
        if values.len() - start == wanted {
            return true;
        }
        values.truncate(start);
        self.partial += 1;
        for name in &message.name {
            let known = self.names.contains(name) || self.strange.contains(name) || self.others.contains(name);
            if self.strange.len() < MOST_NAMED && !known {
                self.strange.push(name.clone());
            }
        }
        false
    }

    /// Who the joints are, what is not there and what was left out.
    pub fn notes(&self) -> Vec<Note> {
        let mut notes = Vec::new();
        let names = list(self.names.iter().map(String::as_str), usize::MAX);
        notes.push(Note::new(findings::JOINTS_ORDER, format!("joints 1 to {} are {names}", self.names.len()), ""));
        let absent: Vec<&str> = ["position", "velocity", "effort"]
            .into_iter()
            .zip(self.present)
            .filter(|(_, p)| !p)
            .map(|(w, _)| w)
            .collect();
        if !absent.is_empty() {
            let text = format!("the messages carry no {}", absent.join(" and no "));
            notes.push(Note::new(findings::JOINTS_ABSENT, text, "record them where the driver measures them"));
        }
        if !self.others.is_empty() {
            let others = list(self.others.iter().map(String::as_str), usize::MAX);
            let text = format!("not read, since they move nothing between base and payload: {others}");
            notes.push(Note::new(findings::JOINTS_OTHERS, text, ""));
        }
        if self.partial > 0 {
            let messages = counted(self.partial, "message");
            let strange = list(self.strange.iter().map(String::as_str), MOST_NAMED);
            let strange = if self.strange.is_empty() { String::new() } else { format!("; they have {strange}") };
            let text = format!("{messages} left out for lack of one of these joints or quantities{strange}");
            notes.push(Note::new(findings::JOINTS_PARTIAL, text, ""));
        }
        notes
    }
}

fn arrays(message: &JointMessage) -> [&[f64]; 3] {
    [&message.position, &message.velocity, &message.effort]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(names: &[&str], position: &[f64], effort: &[f64]) -> JointMessage {
        JointMessage {
            name: names.iter().map(|name| (*name).to_owned()).collect(),
            position: position.into(),
            velocity: Vec::new(),
            effort: effort.into(),
        }
    }

    #[test]
    fn a_changed_order_is_matched_by_name() {
        let mut joints = Joints::new(&message(&["a", "b"], &[1.0, 2.0], &[3.0, 4.0]), &[]).unwrap();
        assert_eq!(joints.channels().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["q1", "q2", "tau1", "tau2"]);
        let mut values = Vec::new();
        assert!(joints.row(&message(&["b", "finger", "a"], &[2.5, 9.0, 1.5], &[4.5, 9.0, 3.5]), &mut values));
        assert_eq!(values, [1.5, 2.5, 3.5, 4.5]);
        assert!(!joints.row(&message(&["finger"], &[9.0], &[9.0]), &mut values));
        assert_eq!(values.len(), 4);
        let notes = joints.notes();
        assert_eq!(notes[0].text, "joints 1 to 2 are `a`, `b`");
        assert_eq!(notes[1].text, "the messages carry no velocity");
        assert_eq!(
            notes[2].text,
            "1 message left out for lack of one of these joints or quantities; they have `finger`"
        );
    }

    #[test]
    fn joints_asked_for_come_in_their_own_order() {
        let wanted = ["b".to_owned(), "a".to_owned()];
        let first = message(&["a", "grip", "b"], &[1.0, 9.0, 2.0], &[3.0, f64::NAN, 4.0]);
        let mut joints = Joints::new(&first, &wanted).unwrap();
        let mut values = Vec::new();
        assert!(joints.row(&first, &mut values));
        assert_eq!(values, [2.0, 1.0, 4.0, 3.0]);
        assert!(joints.notes().iter().any(|n| n.kind == findings::JOINTS_OTHERS && n.text.contains("`grip`")));
        let unknown = Joints::new(&first, &["c".to_owned()]).unwrap_err();
        assert_eq!(unknown, "expected the joints of the URDF, found no `c` among `a`, `grip`, `b`");
    }

    #[test]
    fn a_missing_or_unknown_effort_is_noted() {
        for effort in [&[][..], &[f64::NAN, 0.0]] {
            let joints = Joints::new(&message(&["a", "b"], &[1.0, 2.0], effort), &[]).unwrap();
            assert_eq!(joints.channels().len(), 2);
            assert_eq!(joints.notes()[1].text, "the messages carry no velocity and no effort");
        }
    }

    #[test]
    fn unusable_joints_say_why() {
        let why = |m| Joints::new(&m, &[]).unwrap_err();
        assert_eq!(why(message(&[], &[], &[])), "expected joint names, found none");
        assert_eq!(why(message(&["a", "a"], &[1.0, 2.0], &[])), "expected each joint once, found `a` twice");
        assert_eq!(why(message(&["a"], &[1.0, 2.0], &[])), "expected 1 values of `position`, found 2");
        assert_eq!(why(message(&["a"], &[], &[])), "expected positions, velocities or efforts, found none");
    }
}
