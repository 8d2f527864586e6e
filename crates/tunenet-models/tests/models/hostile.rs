//! Files that are no models, or worse: one sentence with its place, and never a panic.

use std::path::Path;

use tunenet_models::{Error, Model};

use super::support::generator::{Draw, mjcf};

#[path = "../../../../fuzz/src/robots.rs"]
mod robots;

/// A body with one joint around these pieces.
fn model(attributes: &str, inside: &str, sections: &str) -> String {
    format!(
        "<mujoco>\n{sections}\n<worldbody>\n<body name=\"b\">\n<joint name=\"j\" {attributes}/>\n{inside}\n</body>\n</worldbody>\n</mujoco>"
    )
}

#[test]
fn each_mistake_has_one_sentence_at_its_line() {
    let solid = "<geom size=\"0.1\"/>";
    let joints = "<joint/>".repeat(6000);
    let deep = format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", "<body>".repeat(5000), "</body>".repeat(5000));
    let many = (0..1000).map(|i| format!(" a{i}=\"\"")).collect::<Vec<_>>().concat();
    let cases: &[(&str, &str, usize)] = &[
        (&model("damping=\"nan\"", solid, ""), "`damping`: expected finite numbers, found `nan`", 5),
        (&model("damping=\"1e999\"", solid, ""), "expected finite numbers, found `1e999`", 5),
        (&model("axis=\"0 0\"", solid, ""), "`axis`: expected 3 numbers, found 2", 5),
        (&model("axis=\"0 0 0\"", solid, ""), "expected a direction", 5),
        (&model("type=\"hing\"", solid, ""), "expected `hinge`, `slide`, `ball`, `free`, found `hing`", 5),
        (&model("class=\"none\"", solid, ""), "expected a class of <default> (`main`), found `none`", 5),
        (&model("limited=\"true\" range=\"1 0\"", solid, ""), "expected the smaller number first", 5),
        (&model("", "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 3\"/>", ""), "greatest moment of inertia", 6),
        (&model("", "<inertial pos=\"0 0 0\" mass=\"-1\" diaginertia=\"1 1 1\"/>", ""), "a mass of 0 kg or more", 6),
        (&model("", "<inertial pos=\"0 0 0\" diaginertia=\"1 1 1\"/>", ""), "expected <inertial> to state `mass`", 6),
        (
            &model(
                "",
                "<inertial pos=\"0 0 0\" mass=\"1e300\" diaginertia=\"1e308 1e308 1e308\" quat=\"0 0 0 0\"/>",
                "",
            ),
            "quaternion",
            6,
        ),
        (&model("", "<geom type=\"cube\" size=\"1\"/>", ""), "expected a shape of MJCF, found `cube`", 6),
        (&model("", solid, "<actuator><motor joint=\"k\"/></actuator>"), "expected a joint of the model, found `k`", 2),
        (&model("", solid, "<actuator><position joint=\"j\" kv=\"1\" dampratio=\"1\"/></actuator>"), "found both", 2),
        (&model("", solid, "<compiler angle=\"turns\"/>"), "expected `degree`, `radian`", 2),
        (
            &model("", solid, "<compiler settotalmass=\"1e308\" boundmass=\"1e300\" boundinertia=\"1e308\"/>"),
            "expected finite masses",
            2,
        ),
        (&model("", &joints, ""), "expected at most 5000 bodies and as many joints", 6),
        (&model("", solid, "<compiler eulerseq=\"xy\"/>"), "expected three of", 2),
        (&model("", solid, "<default><default><joint/></default></default>"), "nested <default> to have a class", 2),
        (&model("", solid, "<include file=\"../x.xml\"/>"), "lies outside it", 2),
        (&model("", solid, "<include file=\"x.xml\"/>"), "not there", 2),
        (&model("", &format!("{solid}<joint name=\"j\"/>"), ""), "expected each name once", 6),
        (&model("", solid, "")[..60], "not closed", 6),
        (&deep, "nested elements", 1),
        (&format!("<mujoco><worldbody{many}/></mujoco>"), "attributes", 1),
        ("<!DOCTYPE a [<!ENTITY l \"lol\"><!ENTITY m \"&l;&l;\">]>\n<mujoco model=\"&m;\"/>", "expected text", 2),
        ("<mujoco/>", "expected bodies", 1),
        (
            "<mujoco><worldbody><frame>\n<replicate count='3'><body/></replicate></frame></worldbody></mujoco>",
            "expected bodies in <worldbody>, found none without <replicate>, which is not read",
            2,
        ),
        ("<sdf/>", "found an SDF", 1),
        ("<html/>", "expected an MJCF (<mujoco>) or a URDF (<robot>), found <html>", 1),
        ("<mujocoinclude/>", "found a part of an MJCF", 1),
        ("", "no element at all", 1),
        ("<robot name='r'>\n<link name='a'/><link name='a'/></robot>", "name of its own", 2),
        ("<robot name='r'>\n<link name='a'/>\n<link name='b'/></robot>", "expected one link that hangs on nothing", 3),
        (
            "<robot>\n<link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='x'/></joint></robot>",
            "found `x`, which is none",
            2,
        ),
        (
            "<robot>\n<link name='a'/><link name='b'/><joint name='j' type='planar'><parent link='a'/><child link='b'/></joint></robot>",
            "found `planar`",
            2,
        ),
        ("<robot>\n<link name='${prefix}a'/></robot>", "found xacro", 2),
        ("<robot/>", "expected links, found none", 1),
    ];
    for (text, expected, line) in cases {
        let error = Model::parse_alone(Path::new("m.xml"), text).unwrap_err();
        let sentence = error.to_string();
        assert!(sentence.contains(expected), "{sentence}\nexpected: {expected}");
        assert!(!error.hint().is_empty(), "{sentence}: no hint");
        assert!(!sentence.contains('\n') && sentence.chars().count() < 600, "{sentence}");
        let Error::Text { line: found, .. } = error else { panic!("{sentence}: no place") };
        assert_eq!(found, *line, "{sentence}");
    }
}

/// Loads that grow with the square of a file would take minutes here.
#[test]
fn large_files_take_time_in_proportion() {
    let classes = (0..20_000)
        .map(|i| format!("<default class=\"c{i}\"><joint damping=\"{i}\"/></default>"))
        .collect::<Vec<_>>()
        .concat();
    let joints = (0..4000)
        .map(|i| format!("<body><joint name=\"j{i}\"/><geom size=\"0.1\"/></body>"))
        .collect::<Vec<_>>()
        .concat();
    let servos = (0..4000).map(|i| format!("<position joint=\"j{i}\" dampratio=\"1\"/>")).collect::<Vec<_>>().concat();
    let text = format!(
        "<mujoco><default>{classes}</default><worldbody>{joints}</worldbody><actuator>{servos}</actuator></mujoco>"
    );
    let robot = Model::parse_alone(Path::new("m.xml"), &text).unwrap();
    assert_eq!(robot.robot().actuators.len(), 4000);
    let unknown = (0..50_000).map(|i| format!("<e{i}/>")).collect::<Vec<_>>().concat();
    let text = model("", &format!("<geom size=\"0.1\"/>{unknown}"), "");
    let unused = &Model::parse_alone(Path::new("m.xml"), &text).unwrap().robot().unused.len();
    assert!(*unused <= 1100, "{unused}");
}

/// Changes a text somewhere.
fn corrupted(text: &str, draw: &mut Draw) -> Vec<u8> {
    const WORDS: [&str; 16] = [
        "nan",
        "1e308",
        "-1",
        "0",
        "1e999",
        "<",
        ">",
        "\"",
        "/>",
        "<body>",
        "</body>",
        "class=\"x\"",
        "&amp;",
        "&x;",
        "<include file=\"a.xml\"/>",
        "\u{fffd}",
    ];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=draw.below(3) {
        let at = draw.below(bytes.len().max(1)).min(bytes.len());
        match draw.below(6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..(at + draw.below(20)).min(bytes.len()))),
            2 => drop(bytes.splice(at..at, WORDS[draw.below(WORDS.len())].bytes())),
            3 if at < bytes.len() => bytes[at] = u8::try_from(draw.below(256)).unwrap(),
            4 => {
                let end = (at + draw.below(200)).min(bytes.len());
                let again = bytes[at..end].to_vec();
                bytes.splice(at..at, again);
            }
            // A number becomes another one.
            _ => {
                let digit = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i);
                if let Some(from) = digit {
                    let end = bytes[from..]
                        .iter()
                        .position(|b| !b"0123456789.e-+".contains(b))
                        .map_or(bytes.len(), |i| from + i);
                    bytes.splice(from..end, WORDS[draw.below(5)].bytes());
                }
            }
        }
    }
    bytes
}

#[test]
fn corrupted_models_are_refused_or_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/robot");
    let mut seeds: Vec<String> = (0..20).map(mjcf).collect();
    for entry in std::fs::read_dir(folder).unwrap() {
        seeds.push(std::fs::read_to_string(entry.unwrap().path()).unwrap());
    }
    let mut draw = Draw(24);
    for seed in &seeds {
        robots::robot(seed.as_bytes());
        assert!(Model::parse_alone(Path::new("m.xml"), seed).is_ok(), "{seed}");
        for _ in 0..400 {
            robots::robot(&corrupted(seed, &mut draw));
        }
    }
}

/// Names that are made up for joints without one do not try the same numbers again and again.
#[test]
fn names_are_made_up_in_linear_time() {
    let named = (2400..4800).map(|i| format!("<joint name=\"joint_{i}\"/>")).collect::<Vec<_>>().concat();
    let text = model("", &format!("<geom size=\"0.1\"/>{named}{}", "<joint/>".repeat(2400)), "");
    let robot = Model::parse_alone(Path::new("m.xml"), &text).unwrap();
    let names: std::collections::HashSet<_> = robot.robot().joints.iter().map(|joint| &joint.name).collect();
    assert_eq!(names.len(), 4801);
}

#[cfg(unix)]
#[test]
fn an_include_of_a_pipe_is_refused_without_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.xml");
    if !std::process::Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo");
        return;
    }
    let path = folder.path().join("m.xml");
    std::fs::write(&path, "<mujoco><include file='pipe.xml'/></mujoco>").unwrap();
    let error = Model::read(&path).unwrap_err();
    assert!(error.to_string().contains("found a pipe or a device"), "{error}");
}
