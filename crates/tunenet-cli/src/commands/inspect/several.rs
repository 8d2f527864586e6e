//! Several files: each on its own, then what all of them say of gravity.

use anyhow::Result;
use serde_json::json;
use tunenet_ball::preflight::{ApparentGravity, Expected};

use super::listing::Listing;
use super::look;
use crate::args::Inspect;
use crate::exit_status::Exit;
use crate::files::{hash, names};
use crate::view::inspect::motion::{gravity_json, render_gravity, row};

/// Several files: each on its own, then what all of them say of gravity.
pub fn run(options: &Inspect) -> Result<Exit> {
    hash::refuse_copies(options.files.iter().map(AsRef::as_ref))?;
    let (mut listing, mut gravities, mut rate_hz) = (Listing::new(), Vec::new(), 0.0);
    let head = ["file", "bounces", "gravity", "noticed"];
    let mut rows: Vec<Vec<String>> = vec![head.map(String::from).to_vec()];
    for path in &options.files {
        let Some(motion) = listing.add(path, |shown| look(path, options, shown)) else { continue };
        gravities.extend(motion.gravity());
        rate_hz = motion.rate_hz;
        rows.push([vec![names::file_name(path)], row(&motion)].concat());
    }
    let Listing { mut shown, objects, worst } = listing;
    // Of other things than balls there is nothing to put together.
    if rows.len() > 1 {
        shown.table(&rows);
    }
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
            expected,
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
