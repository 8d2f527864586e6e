//! In what shards of different commands differ.

use serde_json::Value;

use crate::shard::differing::{differing, sides};
use crate::shard::{Job, Mark};

/// The first thing in which a shard differs from the others, as it should be and as it is.
pub fn foreign(like: &Mark, mark: &Mark) -> Option<(String, String)> {
    if like.program != mark.program {
        return Some(("one build of tunenet".into(), "another build".into()));
    }
    let count = |mark: &Mark| format!("{} shards", mark.shard.count());
    if like.job == mark.job {
        return (like.shard.count() != mark.shard.count()).then(|| (count(like), count(mark)));
    }
    Some(match (&like.job, &mark.job) {
        (Job::Bench(like), Job::Bench(found)) => of_benches(like, found),
        (Job::Each { tool, run, recordings }, Job::Each { tool: other, run: ran, recordings: treated }) => {
            if tool != other {
                (format!("`{tool} --each`"), format!("`{other} --each`"))
            } else if recordings != treated {
                (format!("{} recordings", recordings.len()), format!("{} others", treated.len()))
            } else {
                debug_assert_ne!(run, ran);
                ("the same simulation, seed and settings".into(), "another simulation, seed or setting".into())
            }
        }
        (Job::Bench(like), Job::Each { tool, .. }) => (named(like).0, format!("`{tool} --each`")),
        (Job::Each { tool, .. }, Job::Bench(found)) => (format!("`{tool} --each`"), named(found).0),
    })
}

/// The options in which two benches differ, or their names where they are not the same.
fn of_benches(like: &Value, found: &Value) -> (String, String) {
    let ((name, options), (other, others)) = (named(like), named(found));
    if name == other { sides(&differing(&options, &others)) } else { (name, other) }
}

/// A bench's name, and everything on its command line that decides its result.
fn named(bench: &Value) -> (String, Value) {
    let only = bench.as_object().and_then(|object| object.iter().next());
    only.map_or_else(Default::default, |(name, options)| (format!("`bench {name}`"), options.clone()))
}
