//! The tree of bodies, frames, joints and shapes.

use std::collections::HashSet;

use nalgebra::Point3;

use super::Heads;
use super::compiler::{Compiler, FromShapes};
use super::defaults::Classes;
use super::joint::joint;
use super::pose::pose;
use super::shape::{ShapeInertia, inertia};
use crate::given::Given;
use crate::robot::{Joint, Link, Weight};
use crate::unused::Collector;
use crate::xml::{Document, Element, shown};
use crate::{Inertia, Pose, Result};

/// Most bodies of a file: a humanoid with hands has about a hundred.
const MOST_LINKS: usize = 5000;

/// What is read of `<worldbody>`.
pub(super) struct Tree<'a> {
    pub document: &'a Document,
    pub compiler: &'a Compiler,
    pub classes: &'a Classes,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    pub heads: Heads,
    pub unused: &'a mut Collector,
    /// The links with a shape that may touch others; `None` for the world.
    pub touching: HashSet<Option<usize>>,
    link_names: HashSet<String>,
    joint_names: HashSet<String>,
    /// The first numbers that names of bodies and of joints without one may have.
    next_numbers: [usize; 2],
}

/// Where an element stands.
#[derive(Clone, Copy)]
struct Around<'a> {
    /// The link that carries it; `None` in the world.
    link: Option<usize>,
    /// The frame around it, in that link.
    frame: Pose,
    childclass: Option<&'a str>,
}

impl<'a> Tree<'a> {
    pub fn new(
        document: &'a Document,
        compiler: &'a Compiler,
        classes: &'a Classes,
        unused: &'a mut Collector,
    ) -> Self {
        let (link_names, joint_names) = (HashSet::from(["world".to_owned()]), HashSet::new());
        let (links, joints, heads) = (Vec::new(), Vec::new(), Heads::default());
        Self {
            document,
            compiler,
            classes,
            links,
            joints,
            heads,
            unused,
            touching: HashSet::new(),
            link_names,
            joint_names,
            next_numbers: [0; 2],
        }
    }

    /// All `<worldbody>` elements.
    pub fn read(&mut self) -> Result<()> {
        let around = Around { link: None, frame: Pose::identity(), childclass: None };
        for world in self.document.root.named("worldbody") {
            let around = Around { childclass: world.value("childclass"), ..around };
            self.children(world, around)?;
        }
        Ok(())
    }

    fn children(&mut self, element: &'a Element, around: Around<'a>) -> Result<()> {
        for child in &element.children {
            match child.tag.as_str() {
                "body" => self.body(child, around)?,
                "frame" => {
                    let own = pose(&Given::own(self.document, child), self.compiler)?;
                    let childclass = child.value("childclass").or(around.childclass);
                    self.children(child, Around { frame: around.frame * own, childclass, ..around })?;
                }
                "geom" => {
                    if self.may_touch(child, around) {
                        self.touching.insert(around.link);
                    }
                    if let Some(link) = around.link {
                        self.shape(child, link, around)?;
                    }
                }
                "joint" | "freejoint" if around.link.is_none() => {
                    let message = format!("expected <{}> as a child of a <body>, found it outside", shown(&child.tag));
                    return Err(self.document.error_at(child, message, "move it into its body"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn body(&mut self, element: &'a Element, around: Around<'a>) -> Result<()> {
        let document = self.document;
        self.bound(element)?;
        let own = pose(&Given::own(document, element), self.compiler)?;
        let name = self.name(element, true)?;
        let childclass = element.value("childclass").or(around.childclass);
        let index = self.links.len();
        self.links.push(Link {
            name,
            parent: around.link,
            placement: around.frame * own,
            joints: Vec::new(),
            inertia: Inertia::zero(),
            weight: Weight::Missing,
        });
        let inside = Around { link: Some(index), frame: Pose::identity(), childclass };
        self.own_joints(element, index, inside)?;
        let stated = element.named("inertial").last().filter(|_| self.compiler.from_shapes != FromShapes::Always);
        if let Some(inertial) = stated {
            self.links[index].inertia = self.inertial(inertial, index)?;
            self.links[index].weight = Weight::Stated;
        }
        self.children(element, inside)?;
        let link = &self.links[index];
        if !link.placement.translation.vector.iter().all(|n| n.is_finite()) {
            return Err(document.error_at(element, "expected a place, found one that is not finite", "correct `pos`"));
        }
        self.check(element, index)
    }

    /// The joints of a link, those within frames included.
    fn own_joints(&mut self, element: &'a Element, link: usize, around: Around<'a>) -> Result<()> {
        let document = self.document;
        for child in &element.children {
            match child.tag.as_str() {
                "joint" | "freejoint" => {
                    self.bound(child)?;
                    let name = self.name(child, false)?;
                    let class = self.classes.of(document, child, around.childclass)?;
                    let class = (child.tag == "joint").then_some(class.joint.as_slice());
                    let given = Given { document, own: child, class };
                    let mut joint = joint(&given, self.compiler, name, self.unused)?;
                    let springs = given.numbers::<2>("springdamper")?;
                    self.heads.spring_dampers.push(springs.is_some_and(|numbers| numbers.iter().all(|n| *n > 0.0)));
                    joint.anchor_m = (around.frame * Point3::from(joint.anchor_m)).coords;
                    joint.axis = around.frame.rotation * joint.axis;
                    self.links[link].joints.push(self.joints.len());
                    self.joints.push(joint);
                    self.heads.joints.push(child.head());
                }
                "frame" => {
                    let own = pose(&Given::own(document, child), self.compiler)?;
                    let childclass = child.value("childclass").or(around.childclass);
                    self.own_joints(child, link, Around { frame: around.frame * own, childclass, ..around })?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Refuses another body or joint where there are too many.
    fn bound(&self, element: &Element) -> Result<()> {
        if self.links.len() < MOST_LINKS && self.joints.len() < MOST_LINKS {
            return Ok(());
        }
        let message = format!("expected at most {MOST_LINKS} bodies and as many joints, found more");
        Err(self.document.error_at(element, message, "cut the file down to the robot"))
    }

    /// Refuses an inertia that no body can have.
    fn check(&self, element: &Element, index: usize) -> Result<()> {
        let balanced = self.compiler.balance_inertia;
        match self.links[index].inertia.impossible() {
            Some((expected, found)) if !(balanced && self.links[index].inertia.is_finite()) => {
                let message = format!("body `{}`: expected {expected}, found {found}", shown(&self.links[index].name));
                let at = element.named("inertial").last().unwrap_or(element);
                Err(self.document.error_at(at, message, "no body has such an inertia: correct <inertial>"))
            }
            _ => Ok(()),
        }
    }

    fn inertial(&self, element: &Element, index: usize) -> Result<Inertia> {
        let given = Given::own(self.document, element);
        let name = || shown(&self.links[index].name);
        let Some(mass_kg) = given.number("mass")? else {
            let message = format!("body `{}`: expected <inertial> to state `mass`, found none", name());
            return Err(self.document.error_at(element, message, "add the mass in kg"));
        };
        let pose = pose(&given, self.compiler)?;
        if let Some([xx, yy, zz, xy, xz, yz]) = given.numbers("fullinertia")? {
            if ["quat", "axisangle", "euler", "xyaxes", "zaxis"].iter().any(|key| given.get(key).is_some()) {
                let message = format!("body `{}`: expected `fullinertia` or an orientation, found both", name());
                return Err(given.error("fullinertia", message, "give `diaginertia` with the orientation"));
            }
            let about_com_kg_m2 = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            return Ok(Inertia { mass_kg, com_m: pose.translation.vector, about_com_kg_m2 });
        }
        let moments = given.numbers::<3>("diaginertia")?.unwrap_or_default().into();
        Ok(Inertia::principal(mass_kg, pose.translation.vector, pose.rotation, moments))
    }

    /// Whether a shape may touch others: both masks are 1 where nothing states them.
    fn may_touch(&self, element: &Element, around: Around) -> bool {
        let Ok(class) = self.classes.of(self.document, element, around.childclass) else { return false };
        let given = Given { document: self.document, own: element, class: Some(&class.geom) };
        ["contype", "conaffinity"].iter().any(|mask| given.text(mask).is_none_or(|mask| mask.trim() != "0"))
    }

    /// Adds the mass of a shape where the body states none.
    fn shape(&mut self, element: &Element, link: usize, around: Around) -> Result<()> {
        let counts = match self.compiler.from_shapes {
            FromShapes::Never => false,
            FromShapes::Always => true,
            FromShapes::Absent => self.links[link].weight != Weight::Stated,
        };
        let class = self.classes.of(self.document, element, around.childclass)?;
        if !counts {
            return Ok(());
        }
        let given = Given { document: self.document, own: element, class: Some(&class.geom) };
        let own = inertia(&given, self.compiler)?;
        let link = &mut self.links[link];
        match own {
            ShapeInertia::None => {}
            ShapeInertia::Mesh(what) => {
                link.inertia = Inertia::zero();
                link.weight = Weight::Mesh(what);
            }
            ShapeInertia::Known(own) => {
                if !matches!(link.weight, Weight::Mesh(_)) {
                    link.inertia = link.inertia.with(&own.seen_from(&around.frame));
                    link.weight = Weight::Shapes;
                }
            }
        }
        Ok(())
    }

    /// The name of a body or a joint, or one for it.
    fn name(&mut self, element: &Element, link: bool) -> Result<String> {
        let (names, next, count) = if link {
            (&mut self.link_names, &mut self.next_numbers[0], self.links.len())
        } else {
            (&mut self.joint_names, &mut self.next_numbers[1], self.joints.len())
        };
        let Some(name) = element.value("name").filter(|name| !name.is_empty()) else {
            let kind = if link { "body" } else { "joint" };
            // Numbers that were tried once are taken.
            *next = count.max(*next);
            loop {
                let made = format!("{kind}_{next}");
                *next += 1;
                if names.insert(made.clone()) {
                    return Ok(made);
                }
            }
        };
        if names.insert(name.to_owned()) {
            return Ok(name.to_owned());
        }
        let message = format!("expected each name once, found <{} name=\"{}\"> again", element.tag, shown(name));
        Err(self.document.error_at(element, message, "rename one of them"))
    }
}
