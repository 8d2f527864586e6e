//! What ties joints: `<equality><joint/>` and `<tendon><fixed/>`.

use std::collections::HashMap;

use super::defaults::Classes;
use crate::given::Given;
use crate::robot::{Coupling, Tendon};
use crate::xml::{Document, Element, shown};
use crate::{Error, Result};

/// Places of joints by their names.
pub(super) type Names<'a> = HashMap<&'a str, usize>;

/// The joint that an attribute names; `None` where it is absent.
pub(super) fn named(document: &Document, element: &Element, key: &str, names: &Names) -> Result<Option<usize>> {
    let Some(attribute) = element.attribute(key) else { return Ok(None) };
    let found = names.get(attribute.value.as_str()).copied();
    found.map(Some).ok_or_else(|| {
        let message = format!("`{key}`: expected a {} of the model, found `{}`", kind(key), shown(&attribute.value));
        document.error(attribute, message, "correct the name")
    })
}

fn kind(key: &str) -> &str {
    if key == "tendon" { "fixed tendon" } else { "joint" }
}

fn missing(document: &Document, element: &Element, key: &str) -> Error {
    let message = format!("expected <{}> to name a joint, found no `{key}`", element.tag);
    document.error_at(element, message, "add the attribute")
}

/// The joints that follow others.
pub(super) fn couplings(document: &Document, classes: &Classes, joints: &Names) -> Result<Vec<Coupling>> {
    let mut all = Vec::new();
    for element in document.root.named("equality").flat_map(|section| section.named("joint")) {
        let class = classes.of(document, element, None)?;
        let given = Given { document, own: element, class: Some(&class.equality) };
        if given.flag("active")? == Some(false) {
            continue;
        }
        let joint = named(document, element, "joint1", joints)?.ok_or_else(|| missing(document, element, "joint1"))?;
        let other = named(document, element, "joint2", joints)?;
        let mut coefficients = [0.0, 1.0, 0.0, 0.0, 0.0];
        Given::own(document, element).fill("polycoef", &mut coefficients)?;
        all.push(Coupling { joint, other, coefficients });
    }
    Ok(all)
}

/// The tendons that are sums of joints.
pub(super) fn tendons(document: &Document, joints: &Names) -> Result<Vec<Tendon>> {
    let mut all = Vec::new();
    for element in document.root.named("tendon").flat_map(|section| section.named("fixed")) {
        let mut terms = Vec::new();
        for term in element.named("joint") {
            let joint = named(document, term, "joint", joints)?.ok_or_else(|| missing(document, term, "joint"))?;
            terms.push((joint, Given::own(document, term).number("coef")?.unwrap_or(1.0)));
        }
        let name = element.value("name").map_or_else(|| format!("tendon_{}", all.len()), str::to_owned);
        all.push(Tendon { name, terms });
    }
    Ok(all)
}
