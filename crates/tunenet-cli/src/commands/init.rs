//! `tunenet init`.

use anyhow::Result;
use serde_json::json;
use tunenet_core::Error;
use tunenet_core::observation::recording::write_atomically;
use tunenet_sim::simulation_file::template;

use super::{load, print_json};
use crate::cli::{Init, Scene};
use crate::failure::Exit;
use crate::terminal::stage;

pub fn run(options: &Init) -> Result<Exit> {
    let Scene::Ball = options.scene;
    load::ending(&options.out, &["toml"])?;
    load::writable(&options.out, &[])?;
    // A link that leads nowhere is something of the person's as well.
    if options.out.symlink_metadata().is_ok() && !options.force {
        let message = "expected a new name, found a file that is there already";
        return Err(Error::file(&options.out, message, "choose another --out, or overwrite it with --force").into());
    }
    write_atomically(&options.out, |out| out.write_all(template().as_bytes()))?;
    let path = options.out.display();
    stage("wrote", &format!("{path}"));
    stage("next", &format!("write your ball's radius into it, then `tunenet tune --sim {path} --observation FILE`"));
    if options.common.json {
        print_json(&json!({ "schema": "tunenet.init/1", "file": load::name(&options.out), "warnings": [] }));
    }
    Ok(Exit::Done)
}
