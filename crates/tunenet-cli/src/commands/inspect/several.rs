//! Several files: each on its own, then what all of them say of gravity.

use anyhow::Result;
use serde_json::json;
use tunenet_ball::preflight::{ApparentGravity, Expected};

use super::{Standing, look};
use crate::args::Inspect;
use crate::failure::{Exit, sentence};
use crate::files::{hash, names};
use crate::view::answer::Printout;
use crate::view::inspect::motion::{gravity_json, render_gravity, row};

/// Several files: each on its own, then what all of them say of gravity.
pub fn run(options: &Inspect) -> Result<Exit> {
    hash::refuse_copies(options.files.iter().map(AsRef::as_ref))?;
    let (mut objects, mut gravities, mut worst, mut rate_hz) = (Vec::new(), Vec::new(), Exit::Done, 0.0);
    let head = ["file", "bounces", "gravity", "noticed"];
    let mut rows: Vec<Vec<String>> = vec![head.map(String::from).to_vec()];
    let mut shown = Printout::default();
    for path in &options.files {
        let name = names::file_name(path);
        shown.row("file", &name);
        match look(path, options, &mut shown) {
            Ok(found) => {
                worst = match (worst, found.standing) {
                    (Exit::Refused, _) | (_, Standing::Refused) => Exit::Refused,
                    (Exit::Done, standing) => standing.exit(),
                    (worst, _) => worst,
                };
                if let Some(motion) = &found.motion {
                    gravities.extend(motion.gravity());
                    rate_hz = motion.rate_hz;
                    rows.push([vec![name], row(motion)].concat());
                }
                objects.push(found.object);
            }
            Err(error) => {
                worst = Exit::Refused;
                let text = sentence(&error);
                shown.row("refused", &text);
                objects.push(json!({ "schema": "tunenet.inspect/1", "file": name, "usable": false, "error": text }));
            }
        }
        shown.line("");
    }
    shown.table(&rows);
    let pooled = ApparentGravity::pooled(&gravities);
    let mut causes = Vec::new();
    if let Some(gravity) = &pooled {
        let expected = Expected::default().gravity_m_s2;
        render_gravity(
            gravity,
            &match gravities.len() {
                1 => " from 1 recording".into(),
                several => format!(" from {several} recordings together"),
            },
            &mut shown,
        );
        if gravity.differs(expected) {
            causes = gravity.causes(expected, rate_hz);
            for cause in &causes {
                shown.row("perhaps", cause);
            }
        }
    }
    shown.show(options.common.json, || {
        json!({
            "schema": "tunenet.inspect.files/1", "files": objects, "gravity": pooled.as_ref().map(gravity_json),
            "causes": causes, "warnings": [],
        })
    })?;
    Ok(worst)
}
