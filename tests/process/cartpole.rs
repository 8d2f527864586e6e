//! The recorded carts with one hidden effect each, where `TUNENET_CASES` names a folder that holds them: through a program that
//! drives the folder's own model, each is named by name.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

use crate::common::Folder;

/// The interpreter that can import mujoco and numpy.
const PYTHON: &str = "TUNENET_PYTHON";
/// Rollouts that a diagnosis may take, a recording simulated once counted as one.
const MOST_ROLLOUTS: u64 = 3_000;

/// Speaks protocol 2 and asks the model of the folder.
const PROGRAM: &str = r#"import json, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
import cart
known = {}
def one(asked):
    p = asked["parameters"] | {name: c["k"] for name, c in asked["effects"].items()}
    force = np.array(known[asked["recording"]]["inputs"]["force_n"]["values"])
    start = asked["start"]["x_m"], asked["start"]["theta_rad"]
    return {"values": cart.sim(p, force, start, asked["times_s"]).tolist()}
for line in sys.stdin:
    asked = json.loads(line)
    if "tunenet" in asked:
        answer = {"tunenet": 2}
    elif "batch" in asked:
        answer = {"id": asked["id"], "answers": [one(each) for each in asked["batch"]]}
    else:
        if "inputs" in asked:
            known[asked["recording"]] = asked
        answer = {"id": asked["id"]} | (one(asked) if "times_s" in asked else {})
    print(json.dumps(answer), flush=True)
"#;

/// Prints the parameters and the candidates of the folder's model as tables of a simulation file.
const TABLES: &str = r#"import sys
sys.path.insert(0, sys.argv[1])
import cart
for name in cart.NAMES:
    print(f"[parameters.{name}]\nvalue = {cart.START[name]}\nmin = {cart.LO[name]}\nmax = {cart.HI[name]}")
for name, (absent, low, high, unit) in cart.CAND.items():
    print(f"[candidates.{name}]\nsentence = \"the cart has {name}\"\nacts = \"mechanism\"\n[candidates.{name}.coefficients.k]")
    print(f"unit = \"{unit}\"\nabsent = {absent}\nmin = {low}\nmax = {high}\ntypical = {(high - low) / 20}")
"#;

#[test]
fn the_hidden_effect_of_every_cart_is_named() {
    let Some(cases) = std::env::var_os("TUNENET_CASES").map(|path| PathBuf::from(path).join("cartpole")) else {
        eprintln!("skipped: TUNENET_CASES names no folder");
        return;
    };
    let python = std::env::var(PYTHON).unwrap_or_else(|_| "python3".into());
    let imports = Command::new(&python).args(["-c", "import mujoco, numpy"]).output();
    if !imports.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {python} cannot import mujoco and numpy; {PYTHON} may name another");
        return;
    }
    let cases = cases.display().to_string();
    let folder = Folder::new();
    folder.write("cart_program.py", PROGRAM);
    let tables = Command::new(&python).args(["-c", TABLES, &cases]).output().expect("tables");
    assert!(tables.status.success(), "{}", String::from_utf8_lossy(&tables.stderr));
    let head = format!(
        "kind = \"process\"\n[process]\ncommand = ['{python}', 'cart_program.py', '{cases}']\nchannels = [\"x_m\", \"theta_rad\"]\n\
         [inputs.force_n]\n[start.x_m]\nvalue = 0.0\n[start.theta_rad]\nvalue = \"first\"\n"
    );
    folder.write("cart.toml", format!("{head}{}", String::from_utf8_lossy(&tables.stdout)));
    let starts = std::fs::read_to_string(format!("{cases}/starts.txt")).expect("the starts");
    for (case, hidden) in [
        ("none", None),
        ("delay", Some(("delay", 0.025))),
        ("hfric", Some(("hinge_friction", 0.03))),
        ("offset", Some(("encoder_offset", 0.04))),
        ("backlash", Some(("backlash", 0.03))),
        ("dead", Some(("deadzone", 0.6))),
    ] {
        let mut manifest = String::new();
        for (i, start) in starts.split_whitespace().enumerate() {
            let held_out = i > 3;
            writeln!(manifest, "[[observation]]\nfile = '{cases}/{case}/rec{i}.csv'\nobject = \"cart\"").unwrap();
            writeln!(manifest, "start.theta_rad = {start}\nheld_out = {held_out}\n").unwrap();
        }
        folder.write("runs.toml", manifest);
        let ran = folder.run("diagnose --sim cart.toml --allow-process --manifest runs.toml --json").ends(0);
        let json = ran.json();
        match hidden {
            None => assert_eq!(json["verdict"], "none", "{case}"),
            Some((name, truth)) => {
                assert_eq!(
                    (json["verdict"].as_str(), json["effects"].as_array().map(Vec::len)),
                    (Some("named"), Some(1))
                );
                assert_eq!(json["effects"][0]["name"], name, "{case}");
                let found = json["effects"][0]["coefficients"]["k"]["value"].as_f64().unwrap();
                assert!((found / truth - 1.0).abs() < 0.02, "{case}: {found}");
            }
        }
        let rollouts = json["rollouts"].as_u64().unwrap();
        assert!(rollouts <= MOST_ROLLOUTS, "{case}: {rollouts} rollouts");
        eprintln!("{case}: {} in {rollouts} rollouts", json["verdict"]);
    }
}
