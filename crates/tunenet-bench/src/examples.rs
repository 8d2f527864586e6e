//! The examples in the help of each benchmark.

pub const ALL: &str = "\
Examples:
  tunenet bench speed
  tunenet bench speed --json
  tunenet bench tuning --quick --only easy-0 easy-2cm
  tunenet bench diagnose --quick --only clean ratio-10
  tunenet bench diagnose --shard 0/8        one of eight shards; `tunenet merge` combines them
All but `speed`, `rollouts`, `recorded` and `grow` resume an interrupted run when the same command is given again.";

pub const SPEED: &str = "\
Example:
  tunenet bench speed --json";
pub const TUNING: &str = "\
Example:
  tunenet bench tuning --quick --only easy-0 easy-2cm";
pub const DIAGNOSE: &str = "\
Examples:
  tunenet bench diagnose --quick --only clean ratio-10
  tunenet bench diagnose --arm --quick";
pub const LAW: &str = "\
Examples:
  tunenet bench law --quick                    one set of each law, some minutes
  tunenet bench law --sets 6 --seed 7
  tunenet bench law --only clean drag-2";
pub const JOINTS: &str = "\
Examples:
  tunenet bench joints --quick                 one set of each effect, some minutes
  tunenet bench joints --sets 6 --seed 7
  tunenet bench joints --only ratio-10 backlash";
pub const RECORDED: &str = "\
Example:
  tunenet bench recorded --measured recordings";
pub const INTERVALS: &str = "\
Example:
  tunenet bench intervals --quick";
pub const REGIONS: &str = "\
Example:
  tunenet bench regions --quick";
pub const ROLLOUTS: &str = "\
Example:
  tunenet bench rollouts";
pub const PREFLIGHT: &str = "\
Example:
  tunenet bench preflight --quick";
pub const PAPER: &str = "\
Example:
  tunenet bench paper --quick --only table2";
pub const SHOT: &str = "\
Example:
  tunenet bench shot --quick";
pub const GROW: &str = "\
Example:
  tunenet bench grow --pairs 1000 10000";

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use crate::args::Arguments;

    #[test]
    fn every_example_in_the_help_is_accepted() {
        let mut tool = Arguments::command();
        tool.build();
        let seen: Vec<_> = tool.get_subcommands().filter(|command| !command.is_hide_set()).collect();
        for command in &seen {
            assert!(command.get_name() == "help" || command.get_after_help().is_some(), "{}", command.get_name());
        }
        let texts = seen.into_iter().chain([&tool]).filter_map(|command| command.get_after_help());
        let texts: Vec<String> = texts.map(ToString::to_string).collect();
        let lines = texts.iter().flat_map(|text| text.lines()).map(str::trim);
        let examples: Vec<&str> = lines.filter_map(|line| line.strip_prefix("tunenet ")).collect();
        assert!(examples.len() > 15, "{}", examples.len());
        for example in examples {
            let command = example.split("   ").next().unwrap_or_default();
            let parsed = Arguments::try_parse_from(command.split_whitespace());
            assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
        }
    }
}
