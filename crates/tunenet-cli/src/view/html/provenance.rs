//! Where a page comes from: enough to make it again.

use crate::files::{hash, names};
use std::path::Path;

use maud::{Markup, html};
use tunenet_formats::shell_word;

/// What made a page.
pub struct Provenance {
    command: String,
    seed: u64,
    /// Name and SHA-256 of every input; none where it could not be read.
    inputs: Vec<(String, Option<String>)>,
}

impl Provenance {
    /// Of this process, which read `inputs`.
    pub fn new(seed: u64, inputs: &[&Path]) -> Self {
        let hashed = inputs.iter().map(|path| (names::file_name(path), hash::sha256(path).ok()));
        Self { command: command(std::env::args_os().skip(1)), seed, inputs: hashed.collect() }
    }

    /// The section; `rollouts` says what was rolled out, and what for.
    pub fn section(&self, rollouts: &str) -> Markup {
        html! {
            table {
                tbody {
                    tr { th scope="row" { "command" } td { pre.code { (self.command) } } }
                    tr { th scope="row" { "version" } td { "tunenet " (env!("CARGO_PKG_VERSION")) } }
                    tr { th scope="row" { "seed" } td { (self.seed) } }
                    tr { th scope="row" { "rollouts" } td { (rollouts) } }
                    @for (name, hash) in &self.inputs {
                        tr {
                            th.file scope="row" { (name) }
                            td { @if let Some(hash) = hash { "SHA-256 " span.code { (hash) } } @else { "could not be read" } }
                        }
                    }
                }
            }
            p.how { "The same command on the same files gives the same page, byte for byte. "
                "With " code { "--json" } " it prints all numbers for programs." }
        }
    }
}

/// The arguments as they would be typed into a shell.
fn command(arguments: impl Iterator<Item = std::ffi::OsString>) -> String {
    let quoted = arguments.map(|argument| shell_word(&argument.to_string_lossy()));
    std::iter::once("tunenet".to_string()).chain(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::command;

    #[test]
    fn arguments_are_quoted_where_a_shell_would_read_them_otherwise() {
        let typed = ["tune", "--sim", "my ball.toml", "it's"].map(std::ffi::OsString::from);
        assert_eq!(command(typed.into_iter()), r#"tunenet tune --sim 'my ball.toml' "it's""#);
    }
}
