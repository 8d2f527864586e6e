//! The drive of EMPS as equations: mass, viscous and Coulomb friction, and an offset of the voltage.

use std::path::Path;

use anyhow::{Context, Result};

use super::drive::open_loop;
use super::table::column;
use super::{Row, asked};
use crate::goals::DRIVE_RMS_MM;
use crate::process;

/// The model that others fit to these data, in at most 20 lines.
const FILE: &str = r#"kind = "equations"
states.q_m = {}
states.v_m_s = {}
start.q_m.value = "first"
start.v_m_s.value = 0.0
outputs.q_m = "q_m"
inputs.voltage_v = {}
constants.n_v = 35.1507
[record]
rate_hz = 1000.0
frames = FRAMES
[derivatives]
q_m = "v_m_s"
v_m_s = "(n_v*voltage_v - viscous*v_m_s - coulomb*sign(v_m_s) - offset)/mass"
[parameters]
mass = { value = 95.0, min = 50.0, max = 200.0 }
viscous = { value = 200.0, min = 0.0, max = 500.0 }
coulomb = { value = 20.0, min = 0.0, max = 60.0 }
offset = { value = 0.0, min = -10.0, max = 10.0 }
"#;

/// The error of the tuned equations, simulated without feedback.
///
/// # Errors
/// Where the recording cannot be read, or `tunenet` refuses it.
pub fn row(recording: &Path, folder: &Path) -> Result<Row> {
    let path = |name: &str| folder.join(name).display().to_string();
    let (from, tuned, open) = (path("equations.toml"), path("tuned.toml"), path("equations.csv"));
    let count = column(recording, "t_s")?.len();
    let text = FILE.replace("FRAMES", &count.to_string());
    std::fs::write(&from, &text).with_context(|| format!("writing {from}"))?;
    let seen = recording.display().to_string();
    let answer = asked(&["tune", "--json", "--quick", "--sim", &from, &seen, "--out", &tuned], folder)?;
    process::run(&["simulate", "--quiet", "--sim", &tuned, "--inputs", &seen, "--out", &open])?;
    let rms_mm = 1e3 * open_loop(recording, Path::new(&open))?;
    let rollouts = answer["rollouts"].as_u64().context("expected `rollouts`")?;
    Ok(Row {
        what: format!(
            "drive, {} lines of equations, tuned, simulated without feedback: root mean square error",
            text.lines().count()
        ),
        aim: format!("at most {DRIVE_RMS_MM} mm"),
        measured: format!("{rms_mm:.2} mm ({rollouts} rollouts)"),
        others: "5.27 as published, 2.81 to 3.50 fitted again".into(),
        met: Some(rms_mm <= DRIVE_RMS_MM),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_read_by_the_simulator() {
        let file = tunenet_sim::SimulationFile::parse(Path::new("drive.toml"), &FILE.replace("FRAMES", "10")).unwrap();
        assert!(tunenet_sim::observed_equations::equations(&[&file]).is_ok());
        assert!(FILE.lines().count() <= 20);
    }
}
