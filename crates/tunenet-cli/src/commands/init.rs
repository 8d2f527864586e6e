//! `tunenet init`.

use anyhow::Result;
use serde_json::json;
use tunenet_core::observation::recording::write_atomically;
use tunenet_sim::simulation_file::template;

use super::destination::{self, Output, Product};
use super::{load, print_json};
use crate::cli::{Init, Scene};
use crate::failure::Exit;
use crate::terminal::stage;

pub fn run(options: &Init) -> Result<Exit> {
    let Scene::Ball = options.scene;
    load::ending(&options.out, &["toml"])?;
    destination::check(&[Output::new(&options.out, "--out", Product::Unmarked)], &[], options.writing.overwrite)?;
    write_atomically(&options.out, |out| out.write_all(template().as_bytes()))?;
    let path = options.out.display();
    stage("wrote", &format!("{path}"));
    stage("next", &format!("write your ball's radius into it, then `tunenet tune --sim {path} --observation FILE`"));
    if options.common.json {
        print_json(&json!({ "schema": "tunenet.init/1", "file": load::name(&options.out), "warnings": [] }));
    }
    Ok(Exit::Done)
}
