//! Whether the shapes of a model touch, and whether it says so.
//!
//! Every geom touches others by default, also in models that are made for joints alone; who sets `contype` or `conaffinity` to
//! another number than 0, or lists pairs in `<contact>`, means contacts.

use crate::Contacts;
use crate::xml::{Document, Element};

/// Whether shapes touch in the simulation of the document, in which those of so many links or the world may by their masks.
pub(super) fn of(document: &Document, touching: usize) -> Contacts {
    let root = &document.root;
    let flags = root.named("option").flat_map(|option| option.named("flag"));
    let off = flags.filter_map(|flag| flag.value("contact")).last() == Some("disable");
    let pairs = root.named("contact").any(|section| !section.children.is_empty());
    match pairs || root.children.iter().any(enables) {
        _ if off => Contacts::None,
        true => Contacts::Stated,
        false if touching > 1 => Contacts::ByDefault,
        false => Contacts::None,
    }
}

/// Whether a shape in this element has a mask that is not 0. Masks are whole numbers.
fn enables(element: &Element) -> bool {
    let mask = |name: &str| element.value(name).is_some_and(|value| value.trim().parse::<i64>().is_ok_and(|n| n != 0));
    let own = element.tag == "geom" && (mask("contype") || mask("conaffinity"));
    own || element.children.iter().any(enables)
}

#[cfg(test)]
mod tests {
    use crate::Contacts::{ByDefault, None, Stated};
    use crate::{Contacts, Model};

    fn contacts(geom: &str, sections: &str) -> Contacts {
        let text = format!(
            "<mujoco>{sections}<worldbody><body name='a'><joint/><geom size='0.1' {geom}/>\
             <body name='b'><geom size='0.1' pos='1 0 0'/></body></body></worldbody></mujoco>"
        );
        Model::parse("m.xml".as_ref(), &text).unwrap().robot().contacts
    }

    #[test]
    fn masks_and_pairs_state_contacts_and_defaults_do_not() {
        assert_eq!(contacts("", ""), ByDefault);
        assert_eq!(contacts("contype='0' conaffinity='0'", ""), None);
        assert_eq!(contacts("", "<default><geom contype='0' conaffinity='0'/></default>"), None);
        assert_eq!(contacts("contype='1' conaffinity='0'", ""), Stated);
        assert_eq!(contacts("", "<default><geom conaffinity='2'/></default>"), Stated);
        assert_eq!(contacts("", "<contact><exclude body1='a' body2='b'/></contact>"), Stated);
        assert_eq!(contacts("", "<contact/>"), ByDefault);
        for geom in ["", "contype='1'"] {
            assert_eq!(contacts(geom, "<option><flag contact='disable'/></option>"), None);
        }
    }
}
