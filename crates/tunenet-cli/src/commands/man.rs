//! `tunenet man`.

use anyhow::Result;
use clap::CommandFactory;
use tunenet_core::{Error, Origin};

use super::bench;
use crate::args::Arguments;
use crate::exit_status::Exit;
use crate::view::json;

pub fn run(command: Option<&str>) -> Result<Exit> {
    if command == Some("bench") {
        return bench::run(&["man"], []);
    }
    let mut tool = Arguments::command();
    tool.build();
    let page = match command {
        None => tool,
        Some(name) => tool.find_subcommand(name).cloned().ok_or_else(|| {
            let known: Vec<&str> =
                tool.get_subcommands().map(clap::Command::get_name).filter(|name| *name != "help").collect();
            Error::Setting {
                origin: Origin::Flag,
                name: "man",
                expected: format!("a command ({})", known.join(", ")),
                found: format!("`{name}`"),
            }
        })?,
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text)?;
    json::print(&text)?;
    Ok(Exit::Done)
}
