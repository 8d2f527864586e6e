//! URDF, the model format of ROS: the reader and the list of what it leaves out.
//!
//! Source of the rules: the URDF specification (wiki.ros.org/urdf/XML) and what exporters write in practice: a limit of 0 for
//! effort or velocity stands for "not said".

mod commands;
mod left_out;
mod link;
mod tree;

pub use self::commands::{Commanded, Commands, Interface};
use self::commands::{is_reduction, transmissions};
use self::tree::Tree;
use crate::Result;
use crate::given::Given;
use crate::robot::{Actuator, Contacts, Coupling, Filter, Law, Robot, Target};
use crate::unused::Collector;
use crate::xml::{Document, Element, shown};

/// Most links of a file: a humanoid with hands has about a hundred.
const MOST_LINKS: usize = 1000;

/// A URDF: what it describes, and its text for edits.
#[derive(Debug, Clone)]
pub struct Urdf {
    robot: Robot,
    commands: Commands,
    pub(crate) document: Document,
    /// The `<joint>` of each joint of the robot, with its children.
    pub(crate) joints: Vec<Element>,
}

impl Urdf {
    /// What the file describes.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// What it says of the commands to the joints.
    #[must_use]
    pub fn commands(&self) -> &Commands {
        &self.commands
    }
}

/// The model that a document describes.
pub(crate) fn read(document: Document) -> Result<Urdf> {
    refuse_templates(&document, &document.root)?;
    let count = document.root.named("link").count();
    if count > MOST_LINKS {
        let message = format!("expected at most {MOST_LINKS} links, found {count}");
        return Err(document.error_at(&document.root, message, "cut the file down to the robot"));
    }
    let mut unused = Collector::default();
    left_out::note(&document, &mut unused);
    let tree = Tree::read(&document)?;
    let couplings = couplings(&document, &tree)?;
    let name = document.root.value("name").unwrap_or_default().to_owned();
    let (links, joints) = (tree.links, tree.joints);
    let mut robot = Robot {
        name,
        links,
        joints,
        couplings,
        tendons: Vec::new(),
        actuators: Vec::new(),
        gravity_m_s2: None,
        step_s: None,
        contacts: Contacts::None,
        unused: unused.finish(&document.files),
    };
    robot.actuators = actuators(&document, &robot)?;
    let joints = tree.joint_elements.into_iter().cloned().collect();
    let commands = commands::read(&document, &robot)?;
    Ok(Urdf { robot, commands, document, joints })
}

/// Refuses xacro, from which a URDF is made.
fn refuse_templates(document: &Document, element: &Element) -> Result<()> {
    let braced = element.attributes.iter().find(|attribute| attribute.value.contains("${"));
    if element.tag.starts_with("xacro:") || braced.is_some() {
        let message = "expected a URDF, found xacro, from which one is made";
        return Err(document.error_at(element, message, "expand it: `xacro FILE.urdf.xacro > robot.urdf`"));
    }
    element.children.iter().try_for_each(|child| refuse_templates(document, child))
}

/// The joints with a `<mimic>`.
fn couplings(document: &Document, tree: &Tree) -> Result<Vec<Coupling>> {
    let mut all = Vec::new();
    for (joint, element) in tree.joint_elements.iter().enumerate() {
        let Some(mimic) = element.named("mimic").next() else { continue };
        let given = Given::own(document, mimic);
        let name = given.text("joint").unwrap_or_default();
        let other = tree.joints.iter().position(|other| other.name == name).ok_or_else(|| {
            let message = format!(
                "joint `{}`: expected to mimic a joint that moves, found `{}`",
                shown(&tree.joints[joint].name),
                shown(name)
            );
            given.error("joint", message, "let <mimic> name the joint that is driven")
        })?;
        let offset = given.number("offset")?.unwrap_or(0.0);
        let multiplier = given.number("multiplier")?.unwrap_or(1.0);
        all.push(Coupling { joint, other: Some(other), coefficients: [offset, multiplier, 0.0, 0.0, 0.0] });
    }
    Ok(all)
}

/// What `<transmission>` and `<ros2_control>` say of drives. What couples several motors or joints, such as a differential gear, is no
/// motor of a joint: its force is left open.
fn actuators(document: &Document, robot: &Robot) -> Result<Vec<Actuator>> {
    let mut all = Vec::new();
    for transmission in transmissions(document) {
        let name = transmission.value("name").unwrap_or("transmission");
        let (joints, motors) = (transmission.named("joint").count(), transmission.named("actuator").count());
        for joint in transmission.named("joint") {
            let Some(target) = joint.value("name").and_then(|name| robot.joint(name)) else { continue };
            let of = |element: &Element| {
                let own = element.children.iter().find(|child| is_reduction(child));
                own.map(|own| number_within(document, own)).transpose()
            };
            // A simple transmission states its ratio once: at the actuator in ROS, at the joint in ROS 2.
            let simple = joints == 1 && motors <= 1;
            let motor = transmission.named("actuator").next().filter(|_| simple);
            let gear = of(joint)?.or(motor.map(of).transpose()?.flatten()).unwrap_or(1.0);
            let law = if simple { Law::Affine { gain: 1.0, bias: [0.0; 3] } } else { Law::Other };
            let target = Target::Joint(target);
            all.push(Actuator { gear, ..drive(shown(name), target, law, None) });
        }
    }
    for joint in document.root.named("ros2_control").flat_map(|control| control.named("joint")) {
        let Some(target) = joint.value("name").and_then(|name| robot.joint(name)) else { continue };
        for command in joint.named("command_interface") {
            let kind = command.value("name").unwrap_or_default();
            let law = if kind == "effort" { Law::Affine { gain: 1.0, bias: [0.0; 3] } } else { Law::Other };
            let bound = |key: &str| command.named("param").find(|param| param.value("name") == Some(key));
            let range = match (bound("min"), bound("max")) {
                (Some(min), Some(max)) => Some([number_within(document, min)?, number_within(document, max)?]),
                _ => None,
            };
            let name = format!("{}/{}", robot.joints[target].name, shown(kind));
            all.push(drive(name, Target::Joint(target), law, range.filter(|[min, max]| min < max)));
        }
    }
    Ok(all)
}

fn drive(name: String, target: Target, law: Law, command_range: Option<[f64; 2]>) -> Actuator {
    Actuator { name, target, gear: 1.0, law, filter: Filter::None, command_range, force_range: None, delay_s: 0.0 }
}

/// The text between the tags of an element.
fn within<'a>(document: &'a Document, element: &Element) -> &'a str {
    document.files[element.file].text.get(element.open.end..element.close).unwrap_or_default().trim()
}

/// The number between the tags of an element.
fn number_within(document: &Document, element: &Element) -> Result<f64> {
    let within = within(document, element);
    within.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| {
        let message = format!("<{}>: expected a finite number, found `{}`", shown(&element.tag), shown(within));
        document.error_at(element, message, "mend the number")
    })
}
