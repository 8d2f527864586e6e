//! What can be said of a file before its XML is read.

use std::path::Path;

use tunenet_formats::{Error, Result};

/// Longest text, bytes: large URDFs have a few hundred thousand.
const LONGEST: usize = 8 << 20;
/// Deepest nesting: a URDF needs 6, what Gazebo puts into one a few more. The XML readers recurse.
const DEEPEST: usize = 100;

/// Refuses what is no plain URDF.
pub(super) fn check(path: &Path, text: &str) -> Result<()> {
    let refuse = |message: String, hint: &str| Err(Error::file(path, message, hint));
    if text.len() > LONGEST {
        return refuse(
            format!("expected a URDF of at most {} MB, found {} MB", LONGEST >> 20, text.len() >> 20),
            "is this the URDF? meshes stand in files of their own",
        );
    }
    let bare = without_comments(text);
    if bare.contains("<xacro:") || bare.contains("${") {
        return refuse(
            "expected a URDF, found xacro, from which one is made".into(),
            "expand it: `xacro FILE.urdf.xacro > arm.urdf`",
        );
    }
    if bare.contains("<sdf") {
        return refuse(
            "expected a URDF, found an SDF".into(),
            "convert it: `gz sdf` cannot; `sdf2urdf` and others can",
        );
    }
    if !bare.contains("<robot") {
        return refuse(
            "expected a model with <robot> (URDF) or <mujoco> (MJCF), found neither".into(),
            "is this the model of the arm?",
        );
    }
    if depth(&bare) > DEEPEST {
        return refuse(
            format!("expected at most {DEEPEST} nested elements, found more"),
            "is this the URDF of the arm?",
        );
    }
    Ok(())
}

/// The text without `<!-- … -->`.
fn without_comments(text: &str) -> String {
    let mut bare = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!--") {
        bare.push_str(before);
        rest = after.split_once("-->").map_or("", |(_, after)| after);
    }
    bare + rest
}

/// How deeply elements are nested at most, or deeper where the XML is broken.
fn depth(bare: &str) -> usize {
    let (mut depth, mut deepest) = (0_usize, 0);
    for tag in bare.split('<').skip(1) {
        let end = tag.split('>').next().unwrap_or(tag);
        match end.as_bytes().first() {
            Some(b'/') => depth = depth.saturating_sub(1),
            Some(b'!' | b'?') => {}
            _ if end.ends_with('/') => deepest = deepest.max(depth + 1),
            _ => {
                depth += 1;
                deepest = deepest.max(depth);
            }
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nesting_is_counted_without_comments() {
        assert_eq!(depth("<?xml?><a><b/><c><d/></c></a>"), 3);
        assert_eq!(without_comments("a<!-- <xacro:b> -->c<!-- d"), "ac");
    }
}
