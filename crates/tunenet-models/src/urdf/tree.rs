//! From links and joints to one tree with one root, parents first.

use std::collections::{HashMap, HashSet};

use super::link::{inertia, joint, motion, name, origin};
use crate::robot::{Joint, Link};
use crate::xml::{Document, Element, shown};
use crate::{Pose, Result};

/// Links and joints with their elements.
pub(super) struct Tree<'a> {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    pub joint_elements: Vec<&'a Element>,
}

/// A `<joint>` with its two links, as places among the `<link>` elements.
struct Edge<'a> {
    element: &'a Element,
    parent: usize,
    child: usize,
}

impl<'a> Tree<'a> {
    /// The tree of a document.
    pub fn read(document: &'a Document) -> Result<Self> {
        let elements: Vec<&Element> = document.root.named("link").collect();
        let edges = edges(document, &elements)?;
        let root = root(document, &elements, &edges)?;
        let mut tree = Self { links: Vec::new(), joints: Vec::new(), joint_elements: Vec::new() };
        let mut of_joint: Vec<Option<usize>> = Vec::new();
        for edge in &edges {
            let moving = motion(document, edge.element)?;
            of_joint.push(moving.map(|_| tree.joints.len()));
            if let Some(motion) = moving {
                tree.joints.push(joint(document, edge.element, motion)?);
                tree.joint_elements.push(edge.element);
            }
        }
        // Where each element went in the list.
        let mut homes: Vec<Option<usize>> = vec![None; elements.len()];
        tree.add(document, elements[root], (None, Pose::identity()), None)?;
        homes[root] = Some(0);
        let mut waiting: Vec<usize> = (0..edges.len()).collect();
        loop {
            let before = waiting.len();
            let mut still = Vec::new();
            for at in waiting {
                let edge = &edges[at];
                let Some(parent) = homes[edge.parent] else {
                    still.push(at);
                    continue;
                };
                homes[edge.child] = Some(tree.links.len());
                let placement = origin(document, edge.element)?;
                tree.add(document, elements[edge.child], (Some(parent), placement), of_joint[at])?;
            }
            waiting = still;
            if waiting.is_empty() || waiting.len() == before {
                break;
            }
        }
        if let Some(at) = waiting.first() {
            let link = name(elements[edges[*at].parent]);
            let message = format!("expected a tree, found a cycle: nothing carries link `{link}` but itself");
            return Err(document.error_at(
                edges[*at].element,
                message,
                "a link hangs on one joint; close loops by <mimic>",
            ));
        }
        Ok(tree)
    }

    fn add(
        &mut self,
        document: &Document,
        element: &Element,
        (parent, placement): (Option<usize>, Pose),
        joint: Option<usize>,
    ) -> Result<()> {
        let (inertia, weight) = inertia(document, element)?;
        let name = element.value("name").unwrap_or_default().to_owned();
        let joints = joint.into_iter().collect();
        self.links.push(Link { name, parent, placement, joints, inertia, weight });
        Ok(())
    }
}

/// The joints between links; no name twice, no joint between links that are not there.
fn edges<'a>(document: &'a Document, elements: &[&'a Element]) -> Result<Vec<Edge<'a>>> {
    let mut links: HashMap<&str, usize> = HashMap::new();
    for (i, element) in elements.iter().enumerate() {
        let own = element.value("name").unwrap_or_default();
        if own.is_empty() || links.insert(own, i).is_some() {
            let message = format!("expected each link to have a name of its own, found `{}` again", shown(own));
            return Err(document.error_at(element, message, "rename one"));
        }
    }
    let (mut all, mut names) = (Vec::new(), HashSet::new());
    for element in document.root.named("joint") {
        let own = element.value("name").unwrap_or_default();
        if own.is_empty() || !names.insert(own) {
            let message = format!("expected each joint to have a name of its own, found `{}` again", shown(own));
            return Err(document.error_at(element, message, "rename one"));
        }
        let end = |role: &str| {
            let named = element.named(role).next().and_then(|end| end.value("link")).unwrap_or_default();
            links.get(named).copied().ok_or_else(|| {
                let found = shown(named);
                let message =
                    format!("joint `{}`: expected a link as its {role}, found `{found}`, which is none", shown(own));
                document.error_at(element, message, "add the link, or correct its name")
            })
        };
        all.push(Edge { element, parent: end("parent")?, child: end("child")? });
    }
    Ok(all)
}

/// The link that hangs on nothing.
fn root(document: &Document, elements: &[&Element], edges: &[Edge]) -> Result<usize> {
    let mut carried: Vec<Option<&Edge>> = elements.iter().map(|_| None).collect();
    for edge in edges {
        if let Some(other) = carried[edge.child].replace(edge) {
            let (link, one, two) = (name(elements[edge.child]), name(other.element), name(edge.element));
            let message = format!("link `{link}`: expected one joint to carry it, found `{one}` and `{two}`");
            return Err(document.error_at(edge.element, message, "a link hangs on one joint; close loops by <mimic>"));
        }
    }
    let mut roots = (0..elements.len()).filter(|i| carried[*i].is_none());
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(one), Some(other)) => {
            let (one, two) = (name(elements[one]), name(elements[other]));
            let message = format!("expected one link that hangs on nothing, found `{one}` and `{two}`");
            Err(document.error_at(elements[other], message, "join them by a fixed joint"))
        }
        (None, _) if elements.is_empty() => {
            Err(document.error_at(&document.root, "expected links, found none", "is this the URDF of a robot?"))
        }
        (None, _) => {
            let message = "expected a tree, found a cycle: every link hangs on another";
            Err(document.error_at(elements[0], message, "let the base hang on nothing"))
        }
    }
}
