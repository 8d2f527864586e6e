//! `tunenet bench paper` as a process.

use std::process::Command;

/// Torques are all but a straight line in the mass: without noise a linear fit finds it, and nothing beats the bound by much with it.
#[test]
#[ignore = "takes some minutes in the profile of tests; `cargo test --release -- --ignored bench_table` runs it"]
fn bench_table_1_runs_and_holds_its_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
    command.args(["paper", "--only", "table1", "--quick", "--json", "--out"]).arg(folder.path());
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(results["schema"], "tunenet.bench.paper/1");
    assert!(results.get("table2").is_none(), "only what was asked for");
    let table = &results["table1"];
    for tuner in ["mean", "max", "direct", "paper", "linear", "gauss_newton", "default"] {
        for key in ["validation_mae_kg", "test_mae_kg", "published_test_kg", "goal_met"] {
            assert!(table[tuner].get(key).is_some(), "{tuner}.{key} is missing");
        }
    }
    let number = |tuner: &str, key: &str| table[tuner][key].as_f64().unwrap_or_else(|| panic!("{tuner}.{key}"));
    assert!(number("linear", "test_mae_kg") < 1e-6 && number("gauss_newton", "test_mae_kg") < 1e-6);
    // Thirty targets: their mean error strays from the bound's by a fifth at most, three times out of four.
    assert!(number("gauss_newton", "noisy_validation_mae_kg") > 0.5 * number("cramer_rao", "validation_mae_kg"));
    for file in ["table1.md", "table1.csv", "table1.json"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
}

/// Every rival has an error after every budget, and those that nobody has to measure are what they must be.
#[test]
fn bench_table_2_and_its_figure_agree() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet-bench"));
        command.args(["paper", "--only", "table2", "figure2", "--quick", "--seed", "3", "--json", "--out"]);
        let output = command.arg(folder.path()).output().expect("the program starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("JSON")
    };
    let results = run();
    let methods = [
        "default",
        "paper",
        "mean",
        "direct",
        "entropy_search",
        "cma_es",
        "cma_es_2d",
        "brent",
        "gauss_newton",
        "apex",
        "nearest",
    ];
    let error = |method: &str, set: &str, k: &str| {
        results["table2"][method][set][k].as_f64().unwrap_or_else(|| panic!("{method}.{set}.{k}"))
    };
    for method in methods {
        for set in ["easy", "hard", "easy_2cm", "hard_2cm"] {
            for k in ["k1", "k5", "k10", "k100"] {
                assert!((0.0..1.0).contains(&error(method, set, k)), "{method}.{set}.{k}");
            }
            let points = results["figure2"][method][set].as_array().unwrap_or_else(|| panic!("{method}.{set}"));
            let drawn = points.iter().find(|p| p[0] == 5).and_then(|p| p[1].as_f64());
            assert_eq!(drawn, Some(error(method, set, "k5")), "{method}.{set}");
        }
    }
    // Restitutions are even over a range of .4 and of 1: their mean distance to the middle is a quarter of it, and forty of
    // them stray from that by .009 and .023 (one standard deviation).
    assert!((error("mean", "easy", "k1") - 0.1).abs() < 0.04 && (error("mean", "hard", "k1") - 0.25).abs() < 0.1);
    // Without noise the least of the squares is the truth: whoever searches for long enough finds it.
    assert!(error("brent", "easy", "k100") < 1e-6 && error("default", "easy", "k5") < 1e-9);
    // More rollouts leave a search that keeps its best no worse on the average.
    assert!(error("cma_es", "hard", "k100") < error("cma_es", "hard", "k10"));
    for file in ["table2.md", "table2.csv", "table2.json", "figure2.md", "figure2.json", "figure2.svg"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
    assert_eq!(run(), results, "again, from what is kept");
}
