//! `tunenet bench shot` as a process: films, estimates, plans and shots of every ball, and an interrupted run that goes on.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn bench(folder: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
    command.args(["shot", "--quick", "--trials", "1", "--seed", "11", "--json", "--out"]).arg(folder);
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("JSON is Unicode")
}

#[test]
fn a_few_trials_run_and_resume() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = bench(folder.path());
    let found: Value = serde_json::from_str(&first).expect("JSON");
    assert_eq!((&found["schema"], &found["trials"]), (&"tunenet.bench.shot/1".into(), &1.into()));
    for key in ["success_all", "success_accepted", "success_after_repeat", "flagged_rightly", "flagged_wrongly"] {
        assert!(
            found.get(key).is_some_and(|v| v.is_null() || (0.0..=1.0).contains(&v.as_f64().unwrap())),
            "{key}: {found}"
        );
    }
    // With a restitution of .5 no ball goes in; of those that are known, nearly all do.
    let success = |way: &str| found["ways"][way]["success_all"].as_f64().expect(way);
    assert_eq!(success("untuned"), 0.0);
    assert!(success("known") >= 0.5 && found["all_known"]["success_all"] == success("known"), "{found}");
    for way in ["apex", "nearest", "tuned", "pooled", "diagnosed"] {
        assert!((0.0..=1.0).contains(&success(way)), "{way}");
    }
    let balls = found["per_ball"].as_array().expect("balls");
    assert!(balls.len() == 6 && balls.iter().all(|ball| ball["trials"] == 1 && ball["richer"] == false), "{found}");
    let page = std::fs::read_to_string(folder.path().join("shot.md")).expect("a page");
    assert!(page.contains("with named effects") && !page.contains("NaN"), "{page}");
    // Two of six pieces are lost, as where a run was killed: they alone are made again, with the same digits.
    let pieces = || std::fs::read_dir(folder.path().join("cells")).expect("pieces").map(|e| e.expect("a piece").path());
    assert_eq!(pieces().count(), 6);
    let kept = pieces().find(|p| p.to_string_lossy().contains("ball0")).expect("a piece of the first ball");
    let made = kept.metadata().and_then(|m| m.modified()).expect("a time");
    for piece in pieces().filter(|p| ["ball2", "ball5"].iter().any(|ball| p.to_string_lossy().contains(ball))) {
        std::fs::remove_file(piece).expect("a piece that goes");
    }
    assert_eq!(bench(folder.path()), first);
    assert_eq!(kept.metadata().and_then(|m| m.modified()).expect("a time"), made);
}
