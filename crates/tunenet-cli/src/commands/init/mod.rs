//! `tunenet init`.

mod asked;
mod columns;
mod flags;
mod joint_notes;
mod limits;
mod messages;
mod place;
mod robot;
mod switch;
mod topics;
mod typed;
mod typed_clock;
mod typed_units;

use std::path::Path;

use anyhow::Result;
use serde_json::json;
use tunenet_core::Origin;
use tunenet_formats::{shell_word, shown_path, write_atomically};
use tunenet_sim::simulation_file::{Domain, template};

use self::columns::Columns;
use self::robot::Started;
use crate::args::{Init, Scene};
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::json::warning;
use crate::view::text::stage;

/// The program that the simulation file of a program names.
const PROGRAM: (&str, &str) = ("pendulum.py", include_str!("../../../../../assets/process/driven_pendulum.py"));

/// What is written: of a robot whose model is given, its own joints.
fn started(options: &Init, domain: Domain, out: &Path) -> Result<Started> {
    let Some(urdf) = &options.urdf else {
        return Ok(Started {
            text: template(domain),
            recording: None,
            columns: Vec::new(),
            switch: None,
            notes: Vec::new(),
        });
    };
    if domain != Domain::Robot {
        let (expected, found) = ("`--urdf` with `init robot` only".into(), format!("`init {}`", domain.name()));
        return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "--urdf", expected, found }.into());
    }
    robot::started(options, urdf, out)
}

pub fn run(options: &Init) -> Result<Exit> {
    let (domain, name, first) = match options.scene {
        Scene::Ball => (Domain::Ball, "ball.toml", "write your ball's radius into it"),
        Scene::Arm => (
            Domain::Arm,
            "arm.toml",
            "name your arm's URDF and the payload's link in it, and for logs of a real arm `motion.kind = \"replay\"`",
        ),
        Scene::Process => (Domain::Process, "process.toml", "put your simulator into the program"),
        Scene::Equations => (Domain::Equations, "equations.toml", "write your equations into it"),
        Scene::Robot => (Domain::Robot, "robot.toml", "check the gains of your joints and your loads in it"),
    };
    let out = options.out.clone().unwrap_or_else(|| name.into());
    names::require_ending(&out, "--out", &["toml"])?;
    let program = (domain == Domain::Process).then(|| out.with_file_name(PROGRAM.0));
    let same = |path: &&Path| std::fs::read(path).is_ok_and(|there| there == PROGRAM.1.as_bytes());
    let program = program.as_deref().filter(|path| !same(path));
    let outputs =
        std::iter::once(out.as_path()).chain(program).map(|path| Output::new(path, "--out", Product::Unmarked));
    destination::check(&outputs.collect::<Vec<_>>(), &[], options.writing.overwrite)?;
    let Started { text, recording, columns, switch, notes } = started(options, domain, &out)?;
    write_atomically(&out, |file| file.write_all(text.as_bytes()))?;
    stage("wrote", &shown_path(&out));
    if let Some(program) = program {
        write_atomically(program, |file| file.write_all(PROGRAM.1.as_bytes()))?;
        stage("wrote", &shown_path(program));
    }
    for columns in &columns {
        stage("joint", &columns.described());
    }
    switch::show(switch.as_ref());
    let leave = if domain == Domain::Process { " --allow-process" } else { "" };
    let path = shell_word(&out.to_string_lossy());
    match &recording {
        Some(recording) => {
            // A model finds what it includes, and its meshes, from its own folder.
            let model = options.urdf.as_deref().unwrap_or(Path::new("robot.urdf"));
            let ending = model.extension().map_or("urdf".into(), |e| e.to_string_lossy());
            let copy = shell_word(&model.with_file_name(format!("improved.{ending}")).to_string_lossy());
            stage(
                "next",
                &format!(
                    "check the units against the robot's documents, then `tunenet diagnose --sim {path} {recording} \
                     --out improved.toml --out-model {copy}`"
                ),
            );
        }
        None => stage("next", &format!("{first}, then `tunenet tune --sim {path}{leave} FILE`")),
    }
    let mut shown = Printout::default();
    shown.warn_all(&notes);
    shown.show(options.common.json, || {
        let mut object = json!({ "schema": "tunenet.init/1", "file": names::file_name(&out),
            "warnings": notes.iter().map(warning).collect::<Vec<_>>() });
        if options.from.is_some() {
            object["joints"] = columns.iter().map(Columns::object).collect();
            object["switch"] = switch::object(switch.as_ref());
        }
        if domain == Domain::Process {
            object["program"] = PROGRAM.0.into();
        }
        object
    })?;
    Ok(Exit::Done)
}
