//! The script that maps shards over Ray, on a stand-in for Ray that runs one task after the other: what its exit status is, and that
//! what a shard says reaches whoever started the script.

use std::path::Path;
use std::process::Command;

use crate::common::{DROP, Folder, Ran};
use crate::process::programs::python;

const RAY: &str = "\
def init(**_):
    pass

def get(all):
    return all

def remote(**_):
    class Task:
        def __init__(self, run):
            self.remote = run
    return Task
";

#[test]
fn the_ray_script_says_what_a_shard_says() {
    if !python("json") {
        return;
    }
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    std::fs::create_dir(folder.path("stand_in")).unwrap();
    folder.write("stand_in/ray.py", RAY);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/cluster/ray_shards.py");
    let run = |line: &str| {
        let tunenet = folder.command();
        let mut command = Command::new("python3");
        command.arg(&script).args(line.split(' ')).current_dir(folder.path("."));
        command.env("PYTHONPATH", folder.path("stand_in")).env("TUNENET", tunenet.get_program());
        Ran::from(command.output().unwrap())
    };
    run("3 pairs.mcap gen ball --sim drop.toml --pairs 12 --seed 7").ends(0);
    folder.run("gen ball --sim drop.toml --pairs 12 --seed 7 --out whole.mcap").ends(0);
    assert!(folder.read("pairs.mcap") == folder.read("whole.mcap"));
    let refused = run("2 other.mcap gen ball --sim none.toml --pairs 12").ends(1).stderr;
    assert!(
        refused.contains("shard 0/2 ended with status 1: ") && refused.contains("none.toml: no such file"),
        "{refused}"
    );
    assert!(!folder.path("other.mcap").exists());
    // A merge that is refused is no success either.
    folder.write("taken.mcap", "mine");
    run("2 taken.mcap gen ball --sim drop.toml --pairs 12").ends(1);
}
