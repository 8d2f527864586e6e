//! Whether a model says which of its shapes touch.
//!
//! Every geom touches others by default, also in models that are made for joints alone; who sets `contype` or `conaffinity` to
//! another number than 0, or lists pairs in `<contact>`, means contacts.

use crate::xml::{Document, Element};

/// Whether the document states contacts, and does not switch all of them off.
pub(super) fn stated(document: &Document) -> bool {
    let root = &document.root;
    let flags = root.named("option").flat_map(|option| option.named("flag"));
    let off = flags.filter_map(|flag| flag.value("contact")).last() == Some("disable");
    let pairs = root.named("contact").any(|section| !section.children.is_empty());
    !off && (pairs || root.children.iter().any(enables))
}

/// Whether a shape in this element has a mask that is not 0. Masks are whole numbers.
fn enables(element: &Element) -> bool {
    let mask = |name: &str| element.value(name).is_some_and(|value| value.trim().parse::<i64>().is_ok_and(|n| n != 0));
    let own = element.tag == "geom" && (mask("contype") || mask("conaffinity"));
    own || element.children.iter().any(enables)
}

#[cfg(test)]
mod tests {
    use crate::Model;

    fn contacts(geom: &str, sections: &str) -> bool {
        let text = format!(
            "<mujoco>{sections}<worldbody><body name='a'><joint/><geom size='0.1' {geom}/>\
             <body name='b'><geom size='0.1' pos='1 0 0'/></body></body></worldbody></mujoco>"
        );
        Model::parse("m.xml".as_ref(), &text).unwrap().robot().contacts
    }

    #[test]
    fn masks_and_pairs_state_contacts_and_defaults_do_not() {
        assert!(!contacts("", ""));
        assert!(!contacts("contype='0' conaffinity='0'", ""));
        assert!(contacts("contype='1' conaffinity='0'", ""));
        assert!(contacts("", "<default><geom conaffinity='2'/></default>"));
        assert!(contacts("", "<contact><exclude body1='a' body2='b'/></contact>"));
        assert!(!contacts("", "<contact/>"));
        assert!(!contacts("contype='1'", "<option><flag contact='disable'/></option>"));
    }
}
