//! `tunenet man`.

use anyhow::Result;
use clap::CommandFactory;
use tunenet_core::Error;

use crate::cli::Arguments;
use crate::failure::Exit;

pub fn run(command: Option<&str>) -> Result<Exit> {
    let mut tool = Arguments::command();
    tool.build();
    let page = match command {
        None => tool,
        Some(name) => tool.find_subcommand(name).cloned().ok_or_else(|| {
            let known: Vec<&str> =
                tool.get_subcommands().map(clap::Command::get_name).filter(|name| *name != "help").collect();
            Error::Setting {
                name: "man",
                expected: format!("a command ({})", known.join(", ")),
                found: format!("`{name}`"),
            }
        })?,
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text)?;
    super::print(&text)?;
    Ok(Exit::Done)
}
