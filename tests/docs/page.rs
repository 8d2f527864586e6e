//! A page of the documentation: its commands, what is shown below them, and what stands in running text.

use std::path::{Path, PathBuf};

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// A file of the repository.
pub fn text(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A command that a page shows.
pub struct Shown {
    /// As it is typed, its lines joined.
    pub command: String,
    /// The lines of output below it.
    pub output: Vec<String>,
    /// Whether the page marks it as long.
    pub long: bool,
}

/// One page, by its name from the root.
pub struct Page {
    pub name: String,
    pub text: String,
}

/// Everything that people read, apart from the code's own documentation.
pub fn pages() -> Vec<Page> {
    let mut names = vec!["README.md".to_owned(), "CONTRIBUTING.md".into(), "assets/README.md".into()];
    for entry in std::fs::read_dir(root().join("docs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if Path::new(&name).extension().is_some_and(|e| e == "md") {
            names.push(format!("docs/{name}"));
        }
    }
    names.sort();
    names.into_iter().map(|name| Page { text: text(&name), name }).collect()
}

impl Page {
    /// Its lines, each with the info string of the fence around it; those of fences themselves are left out.
    fn lines(&self) -> Vec<(Option<&str>, &str)> {
        let (mut fence, mut found) = (None, Vec::new());
        for line in self.text.lines() {
            match (fence, line.trim_start().strip_prefix("```")) {
                (None, Some(info)) => fence = Some(info),
                (Some(_), Some(_)) => fence = None,
                _ => found.push((fence, line)),
            }
        }
        assert!(fence.is_none(), "{}: a fence is not closed", self.name);
        found
    }

    /// The commands of its `sh` blocks, in their order. A block in which a line begins with `$ ` shows output as well; in any other
    /// every line is a command.
    pub fn commands(&self) -> Vec<Shown> {
        let mut found: Vec<Shown> = Vec::new();
        let (mut console, mut within, mut continued) = (false, None, false);
        for (fence, line) in self.lines() {
            if fence != within || fence.is_none() {
                (console, within, continued) = (false, fence, false);
            }
            let Some(info) = fence.filter(|info| info.split(',').next() == Some("sh")) else { continue };
            console |= line.starts_with("$ ");
            let (part, last) = match line.strip_suffix('\\') {
                Some(part) => (part, false),
                None => (line, true),
            };
            if continued {
                found.last_mut().unwrap().command.push_str(part.trim_start());
            } else if let Some(typed) = if console { part.strip_prefix("$ ") } else { Some(part) } {
                let command = typed.split(" # ").next().unwrap().trim_end_matches(' ');
                if !command.is_empty() {
                    let command = format!("{command}{}", if last { "" } else { " " });
                    found.push(Shown { command, output: Vec::new(), long: info.split(',').any(|word| word == "long") });
                }
            } else if !line.trim().is_empty() {
                found.last_mut().expect("output follows a command").output.push(line.into());
            }
            continued = !last && (continued || !console || line.starts_with("$ "));
        }
        found
    }

    /// Its assignments to variables of the shell, for the commands that use them.
    pub fn variables(&self) -> String {
        let assigns = |command: &str| {
            let name = command.split('=').next().unwrap_or_default();
            command.contains('=') && !command.contains(' ') && name.chars().all(|c| c.is_ascii_uppercase())
        };
        let commands = self.commands().into_iter().map(|shown| shown.command);
        commands.filter(|c| assigns(c)).flat_map(|c| [c, "; ".to_owned()]).collect()
    }

    /// Lines in blocks of other kinds that look like commands: they would never be run.
    pub fn hidden_commands(&self) -> Vec<String> {
        let other = |info: &str| info.split(',').next() != Some("sh");
        let typed =
            |line: &str| ["tunenet ", "cargo ", "make ", "$ "].iter().any(|start| line.trim().starts_with(start));
        let lines = self.lines().into_iter().filter(|(fence, line)| fence.is_some_and(other) && typed(line));
        lines.map(|(_, line)| line.to_owned()).collect()
    }

    /// What stands between backquotes in running text; a span may go on in the next line.
    pub fn spans(&self) -> Vec<String> {
        let running: Vec<&str> =
            self.lines().into_iter().filter(|(fence, _)| fence.is_none()).map(|(_, l)| l).collect();
        let text = running.join("\n");
        let paragraphs = text.split("\n\n");
        paragraphs
            .flat_map(|p| p.split('`').skip(1).step_by(2).map(|s| s.replace('\n', " ")).collect::<Vec<_>>())
            .collect()
    }

    /// The targets of its links.
    pub fn links(&self) -> Vec<String> {
        let running = self.lines().into_iter().filter(|(fence, _)| fence.is_none());
        running
            .flat_map(|(_, line)| {
                let parts = line.split("](").skip(1);
                parts.filter_map(|p| Some(p.split_once(')')?.0.to_owned())).collect::<Vec<_>>()
            })
            .collect()
    }

    /// The anchors of its headings, as GitHub and mdBook make them.
    pub fn anchors(&self) -> Vec<String> {
        let running = self.lines().into_iter().filter(|(fence, line)| fence.is_none() && line.starts_with('#'));
        let mut found: Vec<String> = Vec::new();
        for (_, line) in running {
            let words = line.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
            let plain: String = words.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect();
            let again = found.iter().filter(|a| **a == plain).count();
            found.push(if again == 0 { plain } else { format!("{plain}-{again}") });
        }
        found
    }
}
