//! Writing friction back: a URDF's text with other `<dynamics>`, everything else as it stands.

use tunenet_core::{Error, Origin, Result};

/// Friction of one joint, as `<dynamics>` has it.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFriction {
    /// Name of the joint.
    pub joint: String,
    /// Viscous friction, N·m·s/rad.
    pub damping: f64,
    /// Coulomb friction, N·m.
    pub friction: f64,
}

/// `text` with this friction in the `<dynamics>` of its joints.
///
/// ```
/// use tunenet_sim::arm::urdf::{JointFriction, with_friction};
/// let text = "<robot name=\"r\"><joint name=\"a\" type=\"revolute\"><axis xyz=\"0 0 1\"/></joint></robot>";
/// let found = [JointFriction { joint: "a".into(), damping: 0.5, friction: 1.25 }];
/// let written = with_friction(text, &found)?;
/// assert!(written.contains("<dynamics damping=\"0.5\" friction=\"1.25\"/></joint>"));
/// # Ok::<(), tunenet_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Setting`] where a joint does not stand there.
pub fn with_friction(text: &str, joints: &[JointFriction]) -> Result<String> {
    let mut text = text.to_owned();
    for one in joints {
        let Some((inside, end)) = place(&text, &one.joint) else {
            let (expected, found) = ("a joint of the URDF".into(), format!("`{}`", one.joint));
            return Err(Error::Setting { origin: Origin::Caller, name: "arm.urdf", expected, found });
        };
        let tag = format!("<dynamics damping=\"{}\" friction=\"{}\"/>", one.damping, one.friction);
        let body = &text[inside..end];
        let (from, to) = match body.find("<dynamics") {
            Some(at) => {
                let rest = &body[at..];
                let closed = rest.find("</dynamics>").map(|i| i + "</dynamics>".len());
                let short = rest.find('>').map_or(rest.len(), |i| i + 1);
                let whole = if rest[..short].ends_with("/>") { short } else { closed.unwrap_or(short) };
                (inside + at, inside + at + whole)
            }
            None => (end, end),
        };
        text.replace_range(from..to, &tag);
    }
    Ok(text)
}

/// Where the inside of a joint's element begins and ends. Transmissions name joints too, without a type.
fn place(text: &str, name: &str) -> Option<(usize, usize)> {
    let mut from = 0;
    while let Some(at) = text[from..].find("<joint").map(|i| from + i) {
        let head = at + text[at..].find('>')?;
        let tag = text[at..head].split_whitespace().collect::<Vec<_>>().join(" ").replace(" = ", "=");
        let named = [format!("name=\"{name}\""), format!("name='{name}'")].iter().any(|n| tag.contains(n.as_str()));
        if named && tag.contains("type=") && !tag.ends_with('/') {
            return Some((head + 1, head + text[head..].find("</joint>")?));
        }
        from = head;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_there_is_replaced_and_transmissions_are_left_alone() {
        let text = "<transmission><joint name=\"a\"/></transmission>\n<joint\n  name=\"a\"\n  type=\"revolute\">\n  \
                    <dynamics damping=\"9\"></dynamics>\n</joint>";
        let found = [JointFriction { joint: "a".into(), damping: 1.0, friction: 2.0 }];
        let written = with_friction(text, &found).unwrap();
        assert_eq!(written.matches("<dynamics").count(), 1);
        assert!(written.contains("<dynamics damping=\"1\" friction=\"2\"/>\n</joint>"), "{written}");
        assert!(with_friction(text, &[JointFriction { joint: "b".into(), damping: 1.0, friction: 2.0 }]).is_err());
    }
}
