//! URDFs: what others publish is read, and what no arm can be is refused in one sentence.

use std::path::{Path, PathBuf};

use tunenet_sim::arm::{Model, urdf};

const GOOD: &str = r#"<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.5"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/></inertial></link>
  <link name="lower"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="5" velocity="2"/><dynamics damping="0.1" friction="0.2"/></joint>
  <joint name="elbow" type="prismatic"><parent link="upper"/><child link="lower"/><axis xyz="0 0 2"/><limit lower="0" upper="0.4" effort="5" velocity="2"/></joint>
</robot>"#;

fn parse(text: &str) -> Result<Model, String> {
    urdf::parse(Path::new("arm.urdf"), text).map_err(|e| {
        let hint = e.hint().unwrap_or_default().to_string();
        format!("{e} [{hint}]")
    })
}

#[test]
fn a_plain_file_is_read() {
    let arm = parse(GOOD).unwrap();
    assert_eq!(arm.joints().iter().map(|j| j.name.as_str()).collect::<Vec<_>>(), ["shoulder", "elbow"]);
    let shoulder = arm.joints()[0];
    assert_eq!((shoulder.damping, shoulder.friction, shoulder.limits.upper), (0.1, 0.2, 1.0));
    assert_eq!(arm.joints()[1].axis.z, 1.0);
    assert_eq!(arm.bodies[0].inertia.com_m.z, 0.5);
}

#[test]
fn what_no_arm_can_be_is_refused() {
    let cases = [
        ("", "", "expected a model with <robot> (URDF) or <mujoco> (MJCF), found neither"),
        ("<mass value=\"2\"/>", "<mass value=\"-2\"/>", "link `upper`: expected a mass of 0 kg or more, found -2 kg"),
        ("<mass value=\"2\"/>", "<mass value=\"NaN\"/>", "link `upper`: expected finite numbers, found NaN"),
        ("ixx=\"0.1\"", "ixx=\"-0.1\"", "link `upper`: expected inertia above 0 about every axis"),
        ("ixx=\"0.1\"", "ixx=\"1.1\"", "at most the sum of the others, found 1.100e0 kg·m² and 1.200e-1 kg·m²"),
        ("<parent link=\"base\"/>", "<parent link=\"ground\"/>", "expected a link as its parent, found `ground`"),
        ("<parent link=\"base\"/>", "<parent link=\"lower\"/>", "expected a tree, found a cycle"),
        ("name=\"lower\"", "name=\"upper\"", "expected each link once, found `upper` twice"),
        ("name=\"elbow\"", "name=\"shoulder\"", "expected each joint once, found `shoulder` twice"),
        ("<link name=\"base\"/>", "<link name=\"base\"/><link name=\"b\"/>", "found `base` and `b`"),
        ("<child link=\"lower\"/>", "<child link=\"upper\"/>", "link `upper`: expected one joint to carry it"),
        ("xyz=\"0 1 0\"", "xyz=\"0 0 0\"", "joint `shoulder`: expected an axis with a direction"),
        ("lower=\"-1\"", "lower=\"4\"", "expected limits with lower below upper"),
        ("damping=\"0.1\"", "damping=\"-0.1\"", "expected damping of 0 or more, found -0.1"),
        ("prismatic", "floating", "found floating"),
        ("prismatic", "fixd", "expected a URDF, found what cannot be read as one"),
        ("xyz=\"0 0 0.5\"", "xyz=\"${height} 0 0.5\"", "found xacro"),
        ("</robot>", "", "expected a URDF, found what is no XML: `<robot>` is not closed"),
        ("xyz=\"0 0 0.5\"", "xyz=\"0 0 inf\"", "expected finite numbers in <origin>, found inf"),
    ];
    for (from, to, expected) in cases {
        let text = if from.is_empty() { String::new() } else { GOOD.replacen(from, to, 1) };
        let refused = parse(&text).expect_err(&format!("{from} → {to}"));
        assert!(refused.contains(expected) && refused.starts_with("arm.urdf:"), "{from} → {to}: {refused}");
    }
    let begin = GOOD.find("<inertial>").unwrap();
    let end = GOOD.find("</inertial>").unwrap() + "</inertial>".len();
    let without = format!("{}{}", &GOOD[..begin], &GOOD[end..]);
    let arm = parse(&without).unwrap();
    assert!(arm.notes.iter().any(|n| n.text.starts_with("no <inertial> of `upper`, which move")));
    let refused = arm.weighed().unwrap_err().to_string();
    assert!(refused.contains("an <inertial> of link `upper`, which moves, found none"), "{refused}");
}

#[test]
fn mimics_are_followed_and_refused_where_they_lead_nowhere() {
    let mimic = |joint: &str| {
        GOOD.replacen(
            "<axis xyz=\"0 0 2\"/>",
            &format!("<axis xyz=\"0 0 2\"/><mimic joint=\"{joint}\" multiplier=\"-2\" offset=\"0.1\"/>"),
            1,
        )
    };
    let arm = parse(&mimic("shoulder")).unwrap();
    assert_eq!(arm.degrees(), 1);
    assert!((arm.bodies[1].coordinate.position(&[0.2]) + 0.3).abs() < 1e-15);
    assert!(parse(&mimic("wrist")).unwrap_err().contains("expected a joint to mimic, found `wrist`"));
    assert!(parse(&mimic("elbow")).unwrap_err().contains("expected to mimic a joint that moves by itself"));
}

#[test]
fn text_that_would_exhaust_a_reader_is_refused() {
    let deep = format!("<robot name=\"a\">{}", "<gazebo>".repeat(200_000));
    assert!(parse(&deep).unwrap_err().contains("nested elements"));
    let long = format!("<robot name=\"a\">{}", " ".repeat(9 << 20));
    assert!(parse(&long).unwrap_err().contains("at most 8 MB"));
    for cut in (0..GOOD.len()).step_by(37) {
        let _ = parse(&GOOD[..cut]);
    }
}

#[test]
fn a_child_may_stand_before_its_parent() {
    let (head, joints) = GOOD.split_at(GOOD.find("  <joint").unwrap());
    let (one, two) = joints.split_at(joints.find("  <joint name=\"elbow\"").unwrap());
    let swapped = format!("{head}{}{one}</robot>", two.replace("</robot>", ""));
    let arm = parse(&swapped).unwrap();
    assert_eq!(arm.bodies.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["upper", "lower"]);
    // Coordinates follow the file.
    assert_eq!(arm.joints()[0].name, "elbow");
}

/// Arms that others publish; skipped where no folder with them is named.
#[test]
fn published_arms_are_read() {
    let Some(measured) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) else {
        eprintln!("skipped: TUNENET_MEASURED names no folder with published URDFs");
        return;
    };
    let read = |name: &str| urdf::read(&measured.join(name));
    // File, moving joints without mimics, total moving mass.
    let published = [
        ("urdf-kinova/j2s7s300_standalone_expanded.urdf", 13, 5.557 - 0.46784),
        // Its fingers weigh nothing: their inertias are commented out. So are its mimics.
        ("urdf-robotiq/robotiq_2f_85.urdf", 6, 0.0),
        ("ur10e-payload/ur10e.urdf", 6, f64::NAN),
        ("pendulum-dfki/dfki_simple_pendulum.urdf", 1, 0.67531),
    ];
    for (name, degrees, mass) in published {
        let arm = read(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(arm.degrees(), degrees, "{name}");
        let found: f64 = arm.bodies.iter().map(|b| b.inertia.mass_kg).sum();
        assert!(mass.is_nan() || (found - mass).abs() < 2e-3, "{name}: {found} kg");
        assert!(arm.notes.iter().any(|n| n.text.contains("meshes are not opened")), "{name}");
    }
    // The same arm without any inertia: it can be moved, not weighed.
    let bare = read("urdf-kinova/j2s7s300_orsula_expanded.urdf").unwrap().weighed().unwrap_err().to_string();
    assert!(bare.contains("expected a URDF with an <inertial> of link"), "{bare}");
}
