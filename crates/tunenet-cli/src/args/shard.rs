//! `--shard` and `tunenet merge`.

use std::path::PathBuf;

use clap::Args;
use tunenet_core::network::Shard;

use super::{Common, Writing};

pub const MERGE_EXAMPLES: &str = "\
Examples:
  tunenet gen ball --preset easy --pairs 800 --out pairs.mcap --shard 0/2
  tunenet gen ball --preset easy --pairs 800 --out pairs.mcap --shard 1/2
  tunenet merge 'pairs.shard-*-of-2.mcap' --out pairs.mcap
  tunenet merge 'target/bench-diagnose.shard-*-of-8' --out target/bench-diagnose
  tunenet merge 'results.shard-*-of-8' --out results --json > results.json
The result is identical to a run without --shard, except for timings.";

/// `--shard`, wherever work can be cut.
#[derive(Debug, Clone, Default, PartialEq, Eq, Args)]
pub struct Sharing {
    /// Process shard I of N, I from 0 to N - 1 (`auto` in a Slurm array, `auto/N` on Kubernetes); combine the shards with
    /// `tunenet merge`
    #[arg(long, value_name = "I/N", value_parser = read)]
    pub shard: Option<Shard>,
}

/// `tunenet merge`.
#[derive(Debug, Args)]
pub struct Merge {
    /// Shards: all files of one dataset, or all folders of one benchmark or of one `--each`; quoted patterns are expanded
    #[arg(value_name = "SHARD", required = true)]
    pub shards: Vec<PathBuf>,
    /// File or folder to write
    #[arg(short, long, value_name = "FILE|FOLDER")]
    pub out: PathBuf,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

/// From the command line and, for `auto`, from the environment.
fn read(text: &str) -> Result<Shard, String> {
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let shard = match text.split_once('/') {
        _ if text == "auto" => of_environment(&variable, None),
        Some(("auto", count)) => match count.parse() {
            Ok(count) => of_environment(&variable, Some(count)),
            Err(_) => Err(format!("expected `auto` or `auto/N`, such as `auto/8`, found `{text}`")),
        },
        _ => text.parse().map_err(|error| without_name(&error)),
    };
    shard.map_err(|text| text.trim_start_matches("`shard`: ").to_owned())
}

const TASK: &str = "SLURM_ARRAY_TASK_ID";
const FIRST: &str = "SLURM_ARRAY_TASK_MIN";
const LAST: &str = "SLURM_ARRAY_TASK_MAX";
const TASKS: &str = "SLURM_ARRAY_TASK_COUNT";
const STEP: &str = "SLURM_ARRAY_TASK_STEP";
const COMPLETION: &str = "JOB_COMPLETION_INDEX";

/// Which share an engine gave this process: of `count`, or of as many as the engine says.
///
/// Where the count is given, a Slurm task is the share of its own number, so that one that failed can be sent off alone;
/// otherwise the first task of the array is share 0.
fn of_environment(variable: &dyn Fn(&str) -> Option<String>, count: Option<u32>) -> Result<Shard, String> {
    let number = |name: &str, text: &str| -> Result<u32, String> {
        text.parse().map_err(|_| format!("expected a whole number in {name}, found `{text}`"))
    };
    let of_slurm = |name: &str| -> Result<u32, String> {
        let text =
            variable(name).ok_or_else(|| format!("expected {name} in addition to {TASK}, as in every Slurm array"))?;
        number(name, &text)
    };
    match (variable(TASK), variable(COMPLETION), count) {
        (Some(_), Some(_), _) => Err(format!(
            "expected {TASK} (Slurm) or {COMPLETION} (Kubernetes), found both: give the shard, such as `0/8`"
        )),
        (Some(task), None, None) => {
            let (task, first, tasks, step) =
                (number(TASK, &task)?, of_slurm(FIRST)?, of_slurm(TASKS)?, of_slurm(STEP)?);
            if step != 1 {
                return Err(format!(
                    "expected an array in steps of 1, found {STEP}={step}: use `--array=0-{}`",
                    tasks.saturating_sub(1)
                ));
            }
            let last = variable(LAST).map(|text| number(LAST, &text)).transpose()?;
            let gaps = last.is_some_and(|last| last.checked_sub(first).and_then(|n| n.checked_add(1)) != Some(tasks));
            match task.checked_sub(first) {
                Some(index) if !gaps => Shard::new(index, tasks).map_err(|error| without_name(&error)),
                _ => Err(format!(
                    "expected an array without gaps, found task {task} of {tasks} from {first}: give the number of shards with `auto/N`"
                )),
            }
        }
        (Some(task), None, Some(count)) => {
            Shard::new(number(TASK, &task)?, count).map_err(|error| without_name(&error))
        }
        (None, Some(index), Some(count)) => {
            Shard::new(number(COMPLETION, &index)?, count).map_err(|error| without_name(&error))
        }
        (None, Some(_), None) => Err(format!(
            "expected `auto/N` with {COMPLETION}, since Kubernetes does not report the number of shards, found `auto`"
        )),
        (None, None, _) => Err(format!(
            "expected {TASK} (Slurm) or {COMPLETION} (Kubernetes) in the environment, found neither: give the shard, such as `0/8`"
        )),
    }
}

/// Without the flag's name, which clap says itself.
fn without_name(error: &tunenet_core::Error) -> String {
    let text = error.to_string();
    text.strip_prefix("`shard`: ").map(str::to_owned).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)], count: Option<u32>) -> Result<String, String> {
        let variable =
            |name: &str| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned());
        of_environment(&variable, count).map(|shard| shard.to_string())
    }

    fn array<'a>(
        task: &'a str,
        first: &'a str,
        last: &'a str,
        count: &'a str,
        step: &'a str,
    ) -> [(&'a str, &'a str); 5] {
        [(TASK, task), (FIRST, first), (LAST, last), (TASKS, count), (STEP, step)]
    }

    #[test]
    fn slurm_says_which() {
        assert_eq!(with(&array("0", "0", "3", "4", "1"), None).unwrap(), "0/4");
        assert_eq!(with(&array("7", "5", "8", "4", "1"), None).unwrap(), "2/4");
        // A task that is sent off alone.
        assert_eq!(with(&array("2", "2", "2", "1", "1"), Some(4)).unwrap(), "2/4");
        for (variables, wanted) in [
            (array("4", "0", "6", "4", "2"), "steps of 1, found SLURM_ARRAY_TASK_STEP=2"),
            (array("6", "0", "9", "4", "1"), "without gaps, found task 6 of 4"),
            (array("1", "0", "9", "4", "1"), "without gaps"),
            (array("x", "0", "3", "4", "1"), "a whole number in SLURM_ARRAY_TASK_ID, found `x`"),
            (array("4", "5", "8", "4", "1"), "without gaps"),
        ] {
            let refused = with(&variables, None).unwrap_err();
            assert!(refused.contains(wanted), "{refused}");
        }
        assert!(with(&[(TASK, "1")], None).unwrap_err().contains("expected SLURM_ARRAY_TASK_MIN in addition to"));
        assert!(with(&array("4", "0", "4", "5", "1"), Some(4)).unwrap_err().contains("from 0/4 to 3/4"));
    }

    #[test]
    fn kubernetes_says_which_of_a_given_number() {
        assert_eq!(with(&[(COMPLETION, "3")], Some(8)).unwrap(), "3/8");
        assert!(with(&[(COMPLETION, "3")], None).unwrap_err().contains("`auto/N`"));
        assert!(with(&[(COMPLETION, "8")], Some(8)).unwrap_err().contains("from 0/8 to 7/8"));
        assert!(with(&[(COMPLETION, "3"), (TASK, "3")], Some(8)).unwrap_err().contains("found both"));
        assert!(with(&[], Some(8)).unwrap_err().contains("found neither"));
    }

    #[test]
    fn numbers_are_read_as_they_stand() {
        assert_eq!(read("1/4").unwrap().to_string(), "1/4");
        for text in ["4/4", "1/0", "one", "auto/x", "auto/"] {
            assert!(read(text).unwrap_err().starts_with("expected"), "{text}");
        }
    }
}
