//! What the fuzz target of robot models runs: the readers of MJCF and URDF, the edits and the exports, on text of any kind.
//!
//! A reader may refuse; it may not panic. What it accepts has to hold what it promises.

use std::path::Path;

use tunenet_models::edit::edit;
use tunenet_models::export::{isaac_lab, ranges, sidecar};
use tunenet_models::{Change, Model, Quantity};

/// What a change asks for, one after another.
const QUANTITIES: [Quantity; 10] = [
    Quantity::ViscousFriction,
    Quantity::CoulombFriction,
    Quantity::Armature,
    Quantity::PositionGain,
    Quantity::VelocityGain,
    Quantity::TorqueLimit,
    Quantity::CommandDelay,
    Quantity::Gear,
    Quantity::SpringReference,
    Quantity::DeadBand,
];

/// A robot model: MJCF or URDF.
pub fn robot(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let path = Path::new("a.xml");
    let Ok(model) = Model::parse_alone(path, text) else { return };
    let robot = model.robot();
    for link in &robot.links {
        assert!(link.inertia.is_finite(), "an inertia that is not finite was accepted");
        assert!(link.parent.is_none_or(|parent| parent < robot.links.len()), "a parent that is not there");
    }
    for joint in &robot.joints {
        let numbers = [joint.armature, joint.damping, joint.friction, joint.stiffness, joint.reference];
        assert!(
            numbers.iter().chain(joint.axis.iter()).all(|n| n.is_finite()),
            "a number that is not finite was accepted"
        );
    }
    let changes: Vec<Change> = robot
        .joints
        .iter()
        .take(20)
        .zip(0_u32..)
        .map(|(joint, i)| {
            let quantity = QUANTITIES[i as usize % QUANTITIES.len()];
            Change {
                joint: joint.name.clone(),
                motion: joint.motion,
                quantity,
                value: 0.25 + f64::from(i),
                interval: Some([0.1, 0.25 + f64::from(i)]),
            }
        })
        .collect();
    let edited = edit(&model, &changes).expect("numbers of joints that are there");
    assert_eq!(edited.done.len() + edited.left.len(), changes.len(), "a change was lost");
    if let Err(error) = Model::parse_alone(path, &edited.files[0].text) {
        panic!("an edited model is no model: {error}\n{}", edited.files[0].text);
    }
    let _ = (sidecar(path, &edited.left, &[]), ranges("a.xml", &changes), isaac_lab(&changes, &[], 0.005));
}
