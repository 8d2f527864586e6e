//! The configuration for Isaac Lab is Python that gives the numbers back.

use std::process::Command;

use tunenet_models::export::{Whole, WholeNumber, isaac_lab};
use tunenet_models::{Change, Motion, Quantity};

/// Stand-ins for Isaac Lab, which needs a GPU: they keep what they are given, and patterns must fit one name each.
const STUB: &str = r#"
import re, sys, types
module = types.ModuleType("isaaclab.actuators")
class Cfg:
    def __init__(self, **given):
        self.__dict__.update(given)
module.ImplicitActuatorCfg = type("ImplicitActuatorCfg", (Cfg,), {})
module.DelayedPDActuatorCfg = type("DelayedPDActuatorCfg", (Cfg,), {})
sys.modules["isaaclab"] = types.ModuleType("isaaclab")
sys.modules["isaaclab.actuators"] = module
space = {}
exec(compile(sys.stdin.read(), "actuators.py", "exec"), space)
found = space["ACTUATORS"]
assert sorted(found) == ["delay_6_8", "tuned"], found
slow, quick = found["delay_6_8"], found["tuned"]
assert type(slow).__name__ == "DelayedPDActuatorCfg" and (slow.min_delay, slow.max_delay) == (6, 8)
assert [n for n in ("arm.1", "armx1", 'a"b\\') if re.fullmatch(slow.joint_names_expr[0], n)] == ["arm.1"]
assert list(slow.stiffness.values()) == [12.5] and list(slow.damping.values()) == [0.0]
assert list(quick.damping.values()) == [0.0] and list(quick.stiffness.values()) == [0.0]
(pattern, friction), = quick.friction.items()
assert re.fullmatch(pattern, 'a"b\\') and friction == 0.5 and quick.dynamic_friction == quick.friction
assert not hasattr(quick, "min_delay") and quick.effort_limit_sim[pattern] == 3.0
assert quick.viscous_friction == {pattern: 0.75}
print("same")
"#;

#[test]
fn isaac_lab_gets_the_numbers() {
    let change = |joint: &str, quantity, value, interval| Change {
        joint: joint.into(),
        motion: Motion::Revolute,
        quantity,
        value,
        interval,
    };
    let changes = [
        change("arm.1", Quantity::PositionGain, 12.5, None),
        change("arm.1", Quantity::CommandDelay, 0.034, Some([0.031, 0.038])),
        change("a\"b\\", Quantity::CoulombFriction, 0.5, None),
        change("a\"b\\", Quantity::TorqueLimit, 3.0, None),
        change("a\"b\\", Quantity::ViscousFriction, 0.25, None),
        change("a\"b\\", Quantity::BackEmf, 0.5, None),
        change("arm.1", Quantity::DeadBand, 0.01, None),
    ];
    let delay = WholeNumber { key: "s".into(), value: 0.02, interval: None };
    let whole = [Whole { effect: "time_delay".into(), numbers: vec![delay], why: String::new() }];
    let text = isaac_lab(&changes, &whole, 0.005);
    assert!(text.contains("# not in Isaac Lab: dead_band of \"arm.1\" = 0.01 rad"), "{text}");
    assert!(text.ends_with("# not in Isaac Lab: time_delay of the robot, s = 0.02\n"), "{text}");
    let mut python = match Command::new("python3")
        .args(["-c", STUB])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
    {
        Ok(python) => python,
        Err(error) => {
            println!("skipped: no python3: {error}");
            return;
        }
    };
    std::io::Write::write_all(&mut python.stdin.take().unwrap(), text.as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "same", "{text}");
}
