//! MJCF, the model format of MuJoCo: the reader and the list of what it leaves out.
//!
//! Source of the rules: the XML reference of MuJoCo 4.0.0 and its compiler's answers; tests compare with MuJoCo itself.
//!
//! Read are bodies and frames, hinge, slide, ball and free joints, stated inertias and those of solid shapes, default
//! classes, includes, affine actuators with their filters, joint equalities and fixed tendons.
//! [`Robot::unused`](crate::Robot::unused) lists the rest.

mod actuator;
mod body;
mod compiler;
mod contacts;
mod defaults;
mod effective_inertia;
mod joint;
mod known;
mod left_out;
mod pose;
mod shape;
mod ties;

use std::collections::{HashMap, HashSet};

use self::actuator::Servo;
use self::body::Tree;
use self::compiler::Compiler;
use self::defaults::Classes;
use self::effective_inertia::EffectiveInertias;
use self::ties::Names;
use crate::given::Given;
use crate::robot::{Actuator, Link, Robot, Target};
use crate::unused::{Changes, Collector};
use crate::xml::{Document, Element, shown};
use crate::{Error, Result};

/// Where things of the robot stand: elements without their children, in the order of the robot's lists.
#[derive(Debug, Clone, Default)]
pub(crate) struct Heads {
    pub joints: Vec<Element>,
    /// Whether a `springdamper` sets stiffness and damping of each joint.
    pub spring_dampers: Vec<bool>,
    pub actuators: Vec<Element>,
}

/// What an actuator has from its class or itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ServoFacts {
    /// A damping ratio instead of a damping.
    pub ratio: bool,
    /// Its range of forces is switched off.
    pub unlimited: bool,
}

/// An MJCF model: what it describes, and its text for edits.
#[derive(Debug, Clone)]
pub struct Mjcf {
    robot: Robot,
    pub(crate) document: Document,
    pub(crate) heads: Heads,
    /// Whether angles of the file are degrees.
    pub(crate) degrees: bool,
    /// Whether a range limits where the file does not say.
    pub(crate) auto_limits: bool,
    pub(crate) timestep_s: f64,
    /// What edits need of each actuator.
    pub(crate) servos: Vec<ServoFacts>,
}

impl Mjcf {
    /// What the file describes.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }
}

/// The model that a document describes.
pub(crate) fn read(document: Document) -> Result<Mjcf> {
    let compiler = Compiler::read(&document)?;
    let classes = Classes::read(&document)?;
    let mut unused = Collector::default();
    left_out::note(&document, &mut unused);
    let mut tree = Tree::new(&document, &compiler, &classes, &mut unused);
    tree.read()?;
    let contacts = contacts::of(&document, tree.touching.len());
    let (mut links, joints, mut heads) = (tree.links, tree.joints, tree.heads);
    finish_inertias(&document, &mut links, &compiler)?;
    if links.is_empty() {
        return Err(without_bodies(&document));
    }
    let names: Names = joints.iter().enumerate().map(|(i, joint)| (joint.name.as_str(), i)).collect();
    let couplings = ties::couplings(&document, &classes, &names)?;
    let tendons = ties::tendons(&document, &names)?;
    let mut option = ([0.0, 0.0, -9.81], 0.002);
    for element in document.root.named("option") {
        let given = Given::own(&document, element);
        option.0 = given.numbers("gravity")?.unwrap_or(option.0);
        option.1 = given.number("timestep")?.filter(|step| *step > 0.0).unwrap_or(option.1);
    }
    let name = document.root.value("model").unwrap_or_default().to_owned();
    let gravity_m_s2 = Some(option.0);
    let mut robot = Robot {
        name,
        links,
        joints,
        couplings,
        tendons,
        actuators: Vec::new(),
        gravity_m_s2,
        step_s: Some(option.1),
        contacts,
        unused: Vec::new(),
    };
    let servos = read_actuators((&document, &compiler, &classes), &mut robot, &mut heads, &mut unused)?;
    robot.unused = unused.finish(&document.files);
    let (degrees, auto_limits) = (compiler.degrees, compiler.auto_limits);
    Ok(Mjcf { robot, document, heads, degrees, auto_limits, timestep_s: option.1, servos })
}

/// Elements that make bodies, and that the reader leaves out.
pub const MAKERS: [&str; 4] = ["replicate", "composite", "flexcomp", "attach"];

/// That there are no bodies, and which element would make some.
fn without_bodies(document: &Document) -> Error {
    fn maker(element: &Element) -> Option<&Element> {
        let own = Some(element).filter(|element| MAKERS.contains(&element.tag.as_str()));
        own.or_else(|| element.children.iter().find_map(maker))
    }
    let Some(element) = document.root.named("worldbody").find_map(maker) else {
        let message = "expected bodies in <worldbody>, found none";
        return document.error_at(&document.root, message, "is this the model of a robot, or only a part of one?");
    };
    let message =
        format!("expected bodies in <worldbody>, found none without <{}>, which is not read", shown(&element.tag));
    document.error_at(element, message, "write the bodies themselves: MuJoCo saves a model with them")
}

/// Bounds, balance and the total mass that `<compiler>` asks for.
fn finish_inertias(document: &Document, links: &mut [Link], compiler: &Compiler) -> Result<()> {
    for link in links.iter_mut() {
        let inertia = &mut link.inertia;
        inertia.mass_kg = inertia.mass_kg.max(compiler.bound_mass_kg);
        let least = compiler.bound_inertia_kg_m2;
        if least > 0.0 {
            *inertia = inertia.with_moments(|moments| moments.map(|moment| moment.max(least)));
        }
        if compiler.balance_inertia {
            *inertia = inertia.with_moments(|moments| {
                let (sum, greatest) = (moments.sum(), moments.max());
                if 2.0 * greatest > sum { nalgebra::Vector3::repeat(sum / 3.0) } else { moments }
            });
        }
    }
    let total: f64 = links.iter().map(|link| link.inertia.mass_kg).sum();
    if compiler.total_mass_kg > 0.0 && total > 0.0 {
        let factor = compiler.total_mass_kg / total;
        for link in links.iter_mut() {
            link.inertia.mass_kg *= factor;
            link.inertia.about_com_kg_m2 *= factor;
        }
    }
    if links.iter().all(|link| link.inertia.is_finite()) {
        return Ok(());
    }
    let at = document.root.named("compiler").last().unwrap_or(&document.root);
    let message =
        "expected finite masses and inertias, found others after `settotalmass`, `boundmass` and `boundinertia`";
    Err(document.error_at(at, message, "correct these attributes of <compiler>, or the masses"))
}

/// Reads the actuators into the robot.
fn read_actuators(
    (document, compiler, classes): (&Document, &Compiler, &Classes),
    robot: &mut Robot,
    heads: &mut Heads,
    unused: &mut Collector,
) -> Result<Vec<ServoFacts>> {
    let names: Names = robot.joints.iter().enumerate().map(|(i, joint)| (joint.name.as_str(), i)).collect();
    let tendons: HashMap<&str, usize> = robot.tendons.iter().enumerate().map(|(i, t)| (t.name.as_str(), i)).collect();
    let of_space = document.root.named("tendon").flat_map(|section| section.named("spatial"));
    let of_space: HashSet<&str> = of_space.filter_map(|tendon| tendon.value("name")).collect();
    let (mut all, mut facts) = (Vec::new(), Vec::new());
    let mut inertias = EffectiveInertias::new(robot);
    for element in document.root.named("actuator").flat_map(|section| &section.children) {
        let tag = element.tag.as_str();
        if !known::ACTUATORS.contains(&tag) && !known::OTHER_ACTUATORS.contains(&tag) {
            continue;
        }
        let mut servo: Servo = classes.of(document, element, None)?.actuator.clone();
        let given = Given::own(document, element);
        servo.update(&given)?;
        if let Some(what) = servo.left_out() {
            unused.add(element.file, element.open.start, (tag, None), Changes::Dynamics, what);
        }
        let joint = ties::named(document, element, "joint", &names)?;
        // A fixed tendon of the same name comes first.
        let spatial =
            element.value("tendon").is_some_and(|name| !tendons.contains_key(name) && of_space.contains(name));
        let tendon = if spatial { None } else { ties::named(document, element, "tendon", &tendons)? };
        let target = joint.map(Target::Joint).or(tendon.map(Target::Tendon)).unwrap_or(Target::Other);
        let gear = servo.gear[0];
        let inertia = || joint.and_then(|j| inertias.of(j)).map(|m| m / (gear * gear));
        let law = servo.law(inertia);
        if servo.ratio().is_some() && law == crate::Law::Other {
            let what = "a damping ratio of something else than a hinge or a slide with mass and gear";
            unused.add(element.file, element.open.start, (tag, Some("dampratio")), Changes::Dynamics, what);
        }
        facts.push(ServoFacts { ratio: servo.ratio().is_some(), unlimited: servo.unlimited() });
        let range = joint.and_then(|j| robot.joints[j].range);
        all.push(Actuator {
            name: element.value("name").map_or_else(|| format!("actuator_{}", all.len()), str::to_owned),
            target,
            gear,
            law,
            filter: servo.filter(),
            command_range: servo.command_range(range, &given, compiler.auto_limits)?,
            force_range: servo.force_range(&given, compiler.auto_limits)?,
            delay_s: servo.delay_s,
        });
        heads.actuators.push(element.head());
    }
    robot.actuators = all;
    Ok(facts)
}
