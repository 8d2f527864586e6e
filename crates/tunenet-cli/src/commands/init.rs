//! `tunenet init`.

use anyhow::Result;
use serde_json::json;
use tunenet_core::observation::recording::write_atomically;
use tunenet_sim::simulation_file::{Domain, template};

use super::destination::{self, Output, Product};
use super::{load, print_json};
use crate::cli::{Init, Scene};
use crate::failure::Exit;
use crate::terminal::stage;

pub fn run(options: &Init) -> Result<Exit> {
    let (domain, name, first) = match options.scene {
        Scene::Ball => (Domain::Ball, "ball.toml", "write your ball's radius into it"),
        Scene::Arm => (
            Domain::Arm,
            "arm.toml",
            "name your arm's URDF and the payload's link in it, and for logs of a real arm `motion.kind = \"replay\"`",
        ),
    };
    let out = options.out.clone().unwrap_or_else(|| name.into());
    load::ending(&out, &["toml"])?;
    destination::check(&[Output::new(&out, "--out", Product::Unmarked)], &[], options.writing.overwrite)?;
    write_atomically(&out, |file| file.write_all(template(domain).as_bytes()))?;
    let path = out.display();
    stage("wrote", &format!("{path}"));
    stage("next", &format!("{first}, then `tunenet tune --sim {path} --observation FILE`"));
    if options.common.json {
        print_json(&json!({ "schema": "tunenet.init/1", "file": load::name(&out), "warnings": [] }));
    }
    Ok(Exit::Done)
}
