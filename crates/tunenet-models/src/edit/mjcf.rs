//! Numbers in an MJCF.
//!
//! Source: the XML reference of MuJoCo 4.0.0. Braking by the motor's own voltage belongs into the joint's `damping`: `kv` lies
//! within `forcerange`, the braking does not.

use super::patch::{Patches, listed, number};
use super::{Done, Edited, Left, NO_OFFSET_OF_READINGS};
use crate::mjcf::Mjcf;
use crate::robot::{Joint, Law, Motion, Target};
use crate::xml::{Element, SourceFile, shown};
use crate::{Change, Quantity};

/// How exactly dry friction holds, and how fast it catches what slips.
const IMPEDANCE: &str = "solimpfriction";
const REFERENCE: &str = "solreffriction";
/// It gives way by a ten-thousandth, and catches as fast as MuJoCo allows: within two steps.
const HOLDS: &str = "0.9999 0.9999 0.001 0.5 2";
const CATCHES_STEPS: f64 = 2.0;

/// What can become of a change.
enum Outcome<'a> {
    /// Attributes of an element.
    Written(&'a Element, Vec<(&'static str, String)>),
    /// An element behind that of the joint.
    Added(&'a Element, String),
    /// It cannot be written, and why.
    Left(String),
}

pub(super) fn edit(mjcf: &Mjcf, changes: &[(usize, &Change)]) -> Edited {
    let mut editor = Editor { mjcf, changes, patches: Patches::default(), notes: Vec::new() };
    let (mut done, mut left) = (Vec::new(), Vec::new());
    for (joint, change) in changes {
        match editor.outcome(*joint, change) {
            Outcome::Written(element, attributes) => {
                let source = &mjcf.document.files[element.file];
                let mut written = format!("<{}", element.tag);
                for (name, value) in &attributes {
                    editor.patches.set(element, source, name, value);
                }
                written += &listed(&attributes);
                let (path, line) = (source.path.clone(), source.line(element.open.start));
                done.push(Done { change: (*change).clone(), path, line, written: written + ">" });
            }
            Outcome::Added(element, written) => {
                let source = &mjcf.document.files[element.file];
                let (path, line) = (source.path.clone(), source.line(element.open.start));
                done.push(Done { change: (*change).clone(), path, line, written });
            }
            Outcome::Left(why) => left.push(Left { change: (*change).clone(), why }),
        }
    }
    Edited { files: editor.patches.apply(&mjcf.document.files), done, left, notes: editor.notes }
}

struct Editor<'a> {
    mjcf: &'a Mjcf,
    changes: &'a [(usize, &'a Change)],
    patches: Patches,
    notes: Vec<String>,
}

impl<'a> Editor<'a> {
    fn outcome(&mut self, joint: usize, change: &Change) -> Outcome<'a> {
        let value = change.value;
        self.clear_followers(joint, change.quantity);
        match change.quantity {
            Quantity::Armature => self.on_joint(joint, "armature", value),
            Quantity::CoulombFriction => self.dry_friction(joint, value),
            Quantity::Stiffness => self.on_joint(joint, "stiffness", value),
            Quantity::SpringReference if !self.has_one_axis(joint) => {
                Outcome::Left("only a hinge or a slide has a spring with a reference".into())
            }
            Quantity::SpringReference => {
                let turns = self.mjcf.robot().joints[joint].motion == Motion::Revolute && self.mjcf.degrees;
                self.on_joint(joint, "springref", if turns { value.to_degrees() } else { value })
            }
            Quantity::ViscousFriction | Quantity::BackEmf | Quantity::QuadraticFriction => self.damping(joint),
            Quantity::PositionGain | Quantity::VelocityGain => self.gain(joint, change),
            Quantity::TorqueLimit => self.torque_limit(joint, value),
            Quantity::Gear => match self.actuator(joint, |_| true) {
                Err(why) => Outcome::Left(why),
                Ok(at) => {
                    let element = &self.mjcf.heads.actuators[at];
                    Outcome::Written(element, vec![("gear", with(element, "gear", &[Some(value)]))])
                }
            },
            Quantity::CommandDelay => self.delay(joint, value),
            Quantity::CommandLag => self.lag(joint, value),
            Quantity::ExtraLoad => self.extra_load(joint, value),
            other => Outcome::Left(why_not(other).into()),
        }
    }

    /// What is written of a joint holds for those that follow it as well: the same numbers of theirs become 0.
    fn clear_followers(&mut self, joint: usize, quantity: Quantity) {
        let (name, own): (&str, fn(&Joint) -> f64) = match quantity {
            Quantity::Armature => ("armature", |joint| joint.armature),
            Quantity::CoulombFriction => ("frictionloss", |joint| joint.friction),
            Quantity::ViscousFriction => ("damping", |joint| joint.damping),
            _ => return,
        };
        let robot = self.mjcf.robot();
        for (follower, _) in robot.followers(joint) {
            if own(&robot.joints[follower]) == 0.0 {
                continue;
            }
            let element = &self.mjcf.heads.joints[follower];
            self.patches.set(element, self.source(element), name, "0");
            let (follower, joint) = (shown(&robot.joints[follower].name), shown(&robot.joints[joint].name));
            self.note(&format!(
                "`{name}` of `{follower}` is 0 in the copy: what is written of `{joint}` holds for both"
            ));
        }
    }

    fn has_one_axis(&self, joint: usize) -> bool {
        matches!(self.mjcf.robot().joints[joint].motion, Motion::Revolute | Motion::Prismatic)
    }

    /// Why an attribute of the joint would not count. `spring`: it is stiffness or damping.
    fn without_effect(&self, joint: usize, spring: bool) -> Option<&'static str> {
        if self.mjcf.heads.joints[joint].tag == "freejoint" {
            return Some("a free joint has no such number: name a hinge or a slide");
        }
        (spring && self.mjcf.heads.spring_dampers[joint])
            .then_some("`springdamper` of the joint or its class sets stiffness and damping: take it out first")
    }

    /// The transmission ratio of an actuator of the joint: the one that it gets, if it gets another.
    fn gear(&self, joint: usize, actuator: usize) -> f64 {
        self.wanted(joint, Quantity::Gear).unwrap_or(self.mjcf.robot().actuators[actuator].gear)
    }

    /// The value that a number of the joint is to have, if it is among the changes.
    fn wanted(&self, joint: usize, quantity: Quantity) -> Option<f64> {
        let same = |(place, change): &&(usize, &Change)| *place == joint && change.quantity == quantity;
        self.changes.iter().find(same).map(|(_, change)| change.value)
    }

    fn source(&self, element: &Element) -> &'a SourceFile {
        &self.mjcf.document.files[element.file]
    }

    fn on_joint(&self, joint: usize, name: &'static str, value: f64) -> Outcome<'a> {
        let element = &self.mjcf.heads.joints[joint];
        if let Some(why) = self.without_effect(joint, matches!(name, "stiffness" | "damping")) {
            return Outcome::Left(why.into());
        }
        Outcome::Written(element, vec![(name, with(element, name, &[Some(value)]))])
    }

    /// Dry friction that holds what stands still: by MuJoCo's own numbers, it gives way by a tenth of the acceleration that it stops.
    fn dry_friction(&mut self, joint: usize, value: f64) -> Outcome<'a> {
        let mut outcome = self.on_joint(joint, "frictionloss", value);
        if let Outcome::Written(element, attributes) = &mut outcome
            && value > 0.0
            && [IMPEDANCE, REFERENCE].iter().all(|name| element.value(name).is_none())
        {
            attributes.push((REFERENCE, format!("{} 1", number(CATCHES_STEPS * self.mjcf.timestep_s))));
            attributes.push((IMPEDANCE, HOLDS.into()));
            self.note("`solreffriction` and `solimpfriction` make dry friction hold a joint that stands still, as in the simulation that was tuned");
        }
        outcome
    }

    /// All that brakes with the speed stands in one attribute.
    fn damping(&mut self, joint: usize) -> Outcome<'a> {
        let of = |quantity: Quantity| self.wanted(joint, quantity);
        let (viscous, braking, quadratic) =
            (of(Quantity::ViscousFriction), of(Quantity::BackEmf), of(Quantity::QuadraticFriction));
        if braking.is_some() && viscous.is_none() {
            return Outcome::Left("it belongs into the joint's damping: give viscous_friction as well".into());
        }
        let element = &self.mjcf.heads.joints[joint];
        if let Some(why) = self.without_effect(joint, true) {
            return Outcome::Left(why.into());
        }
        if quadratic.is_some() {
            self.note("a second number in `damping` is read by MuJoCo 4 or later");
        }
        let first = viscous.map(|viscous| viscous + braking.unwrap_or(0.0));
        let first = first.or(quadratic.map(|_| self.mjcf.robot().joints[joint].damping));
        let numbers = if quadratic.is_some() { vec![first, quadratic] } else { vec![first] };
        Outcome::Written(element, vec![("damping", with(element, "damping", &numbers))])
    }

    fn gain(&mut self, joint: usize, change: &Change) -> Outcome<'a> {
        let proportional = change.quantity == Quantity::PositionGain;
        let servo = |at: usize| {
            let tag = self.mjcf.heads.actuators[at].tag.as_str();
            let affine = self.mjcf.robot().actuators[at].position_gains().is_some();
            matches!(tag, "position" | "intvelocity")
                || tag == "velocity" && !proportional
                || tag == "general" && affine
        };
        let at = match self.actuator(joint, servo) {
            Ok(at) => at,
            Err(why) => return Outcome::Left(why),
        };
        let element = &self.mjcf.heads.actuators[at];
        let actuator = &self.mjcf.robot().actuators[at];
        // Torque is gear times force, and the servo's length is gear times position.
        let gear = self.gear(joint, at);
        let value = change.value / (gear * gear);
        if !value.is_finite() {
            return Outcome::Left("the actuator has a gear of 0, or one too small for this number".into());
        }
        if element.tag == "general" {
            let Law::Affine { bias, .. } = actuator.law else { return Outcome::Left("its force is not affine".into()) };
            // Both gains stand in one attribute, so that each is written with the other.
            let of = |quantity: Quantity, old: f64| {
                self.wanted(joint, quantity).map_or(Some(old), |gain| Some(-gain / (gear * gear)))
            };
            let bias = [Some(bias[0]), of(Quantity::PositionGain, bias[1]), of(Quantity::VelocityGain, bias[2])];
            let mut attributes = vec![("biasprm", with(element, "biasprm", &bias))];
            if proportional {
                attributes.insert(0, ("gainprm", with(element, "gainprm", &[Some(value)])));
            }
            return Outcome::Written(element, attributes);
        }
        if proportional {
            if self.mjcf.servos[at].ratio {
                self.note("the damping of an actuator with `dampratio` changes with its `kp`");
            }
            return Outcome::Written(element, vec![("kp", number(value))]);
        }
        if element.attribute("dampratio").is_some() {
            let source = self.source(element);
            self.patches.remove(element, source, "dampratio");
            self.note("`kv` took the place of `dampratio`: an actuator has one of them");
        }
        Outcome::Written(element, vec![("kv", number(value))])
    }

    fn torque_limit(&self, joint: usize, value: f64) -> Outcome<'a> {
        let at = match self.actuator(joint, |_| true) {
            Ok(at) => at,
            Err(why) => return Outcome::Left(why),
        };
        let element = &self.mjcf.heads.actuators[at];
        let force = value / self.gear(joint, at).abs();
        if !(force > 0.0 && force.is_finite()) {
            return Outcome::Left("an actuator without force is none: remove it from the model".into());
        }
        let mut attributes = vec![("forcerange", format!("{} {}", number(-force), number(force)))];
        let off = self.mjcf.servos[at].unlimited || !self.mjcf.auto_limits;
        if off || element.attribute("forcelimited").is_some() {
            attributes.push(("forcelimited", "true".into()));
        }
        Outcome::Written(element, attributes)
    }

    fn delay(&mut self, joint: usize, value: f64) -> Outcome<'a> {
        let at = match self.actuator(joint, |_| true) {
            Ok(at) => at,
            Err(why) => return Outcome::Left(why),
        };
        let element = &self.mjcf.heads.actuators[at];
        if value == 0.0 {
            return Outcome::Written(element, vec![("delay", "0".into())]);
        }
        let step = self.mjcf.timestep_s;
        let samples = (value / step).ceil() + 2.0;
        if samples > 1e5 {
            return Outcome::Left(format!("{value} s are too many steps of {step} s"));
        }
        self.note(&format!("`delay` is read by MuJoCo 4 or later; `nsample` holds for steps of {step} s or longer"));
        let attributes =
            vec![("delay", number(value)), ("nsample", format!("{samples}")), ("interp", "linear".to_owned())];
        Outcome::Written(element, attributes)
    }

    /// A first-order filter between command and force, which only these elements have.
    fn lag(&self, joint: usize, value: f64) -> Outcome<'a> {
        let at = match self.actuator(joint, |_| true) {
            Ok(at) => at,
            Err(why) => return Outcome::Left(why),
        };
        let element = &self.mjcf.heads.actuators[at];
        match element.tag.as_str() {
            "position" => Outcome::Written(element, vec![("timeconst", number(value))]),
            "general" if value == 0.0 => Outcome::Written(element, vec![("dyntype", "none".into())]),
            "general" => {
                let filter =
                    vec![("dyntype", "filterexact".to_owned()), ("dynprm", with(element, "dynprm", &[Some(value)]))];
                Outcome::Written(element, filter)
            }
            tag => {
                Outcome::Left(format!("`<{tag}>` has no filter: write it as <general> with dyntype=\"filterexact\""))
            }
        }
    }

    /// A body of its own, fixed to that of the joint.
    fn extra_load(&mut self, joint: usize, value: f64) -> Outcome<'a> {
        let robot = self.mjcf.robot();
        let element = &self.mjcf.heads.joints[joint];
        let Some(link) = robot.links.iter().position(|link| link.joints.contains(&joint)) else {
            return Outcome::Left("no body of the model has the joint".into());
        };
        if value < 0.0 {
            let name = shown(&robot.links[link].name);
            return Outcome::Left(format!("a body has no mass below 0: take it from the mass of `{name}`"));
        }
        let [x, y, z] = robot.fixed_together(link).com_m.into();
        let place = [x, y, z].map(number).join(" ");
        let end = if element.empty {
            element.open.end
        } else {
            let text = &self.source(element).text;
            text[element.close..].find('>').map_or(element.close, |i| element.close + i + 1)
        };
        let name = if robot.links.iter().any(|link| link.name == "extra_load") { "" } else { " name=\"extra_load\"" };
        // A point of mass; MuJoCo asks for an inertia above 0.
        let inertial = format!("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"1e-9 1e-9 1e-9\"/>", number(value));
        let body = format!("<body{name} pos=\"{place}\">{inertial}</body>");
        self.patches.replace(element.file, end..end, body.clone());
        self.note("the extra load is a body of its own, fixed at the centre of mass of the last link");
        Outcome::Added(element, body)
    }

    /// The only actuator of a joint that fits.
    fn actuator(&self, joint: usize, fits: impl Fn(usize) -> bool) -> std::result::Result<usize, String> {
        let all = &self.mjcf.robot().actuators;
        let own: Vec<usize> = (0..all.len()).filter(|i| all[*i].target == Target::Joint(joint) && fits(*i)).collect();
        match own.as_slice() {
            [one] => Ok(*one),
            [] => Err(match self.tendon_of(joint) {
                Some(name) => format!(
                    "the tendon `{name}`, which the simulation does not have, moves the joint: the number is of a servo in its place"
                ),
                None => "no actuator of the joint has such a number: add one to <actuator>".into(),
            }),
            several => {
                let names: Vec<_> = several.iter().map(|i| format!("`{}`", shown(&all[*i].name))).collect();
                Err(format!(
                    "several actuators of the joint have such a number ({}): edit one by hand",
                    names.join(", ")
                ))
            }
        }
    }

    /// The tendon with an actuator of its own that moves the joint.
    fn tendon_of(&self, joint: usize) -> Option<String> {
        let robot = self.mjcf.robot();
        let all = robot.actuators.iter().filter_map(|one| match one.target {
            Target::Tendon(tendon) => robot.tendons.get(tendon),
            _ => None,
        });
        let mut own = all.filter(|tendon| tendon.terms.iter().any(|(of, _)| *of == joint));
        own.next().map(|tendon| shown(&tendon.name))
    }

    fn note(&mut self, text: &str) {
        if !self.notes.iter().any(|old| old == text) {
            self.notes.push(text.to_owned());
        }
    }
}

/// The attribute with other first numbers; those that follow stay.
fn with(element: &Element, name: &str, first: &[Option<f64>]) -> String {
    let old: Vec<&str> = element.value(name).map(|value| value.split_ascii_whitespace().collect()).unwrap_or_default();
    let mut words: Vec<String> = old.iter().map(|word| (*word).to_owned()).collect();
    for (i, value) in first.iter().enumerate() {
        let word = value.map_or_else(|| "0".to_owned(), number);
        if i < words.len() {
            words[i] = word;
        } else {
            words.push(word);
        }
    }
    words.join(" ")
}

/// Why MJCF cannot express it, and what to do.
fn why_not(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::GoalSpeedLimit => {
            "MJCF has no speed limit of a goal: limit the command before it reaches the simulation"
        }
        Quantity::ReadingDelay => "it belongs to sensors: give them `delay` (MuJoCo 4 or later), or delay the readings",
        Quantity::PositionLatch => "it belongs to sensors: give them `interval` (MuJoCo 4 or later)",
        Quantity::ReleaseDelay | Quantity::ReleaseBraking => "MJCF cannot release a motor: switch its gains outside",
        Quantity::StallTorque => "MJCF knows the torque of a motor as `forcerange`: give it as torque_limit",
        Quantity::Backlash => "MJCF has it only as a second joint between motor and link",
        Quantity::Compliance => "MJCF has it only as a second joint with a spring between motor and link",
        Quantity::ZeroOffset => NO_OFFSET_OF_READINGS,
        Quantity::CommandOffset => "MJCF has no offset of a command: add it to the command before the simulation",
        Quantity::DeadBand => {
            "MJCF has no dead band: leave out errors within it before the command reaches the simulation"
        }
        Quantity::TorqueBias | Quantity::TorqueFactor => "it belongs to the command: change it before the simulation",
        _ => "MJCF has no attribute for it: add it as a force in the simulation loop",
    }
}
