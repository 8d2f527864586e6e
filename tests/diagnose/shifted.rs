//! A recording whose heights are shifted.

use crate::common::{Drop, Folder};

/// Four drops of one ball, the second one on a surface at this height.
fn codes(floor_m: f64) -> Vec<(String, String)> {
    let folder = Folder::new();
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
    for (k, height_m) in (0u64..).zip([0.8, 1.0, 1.2, 0.9]) {
        let floor_m = if k == 1 { floor_m } else { 0.0 };
        folder.write(&format!("{k}.csv"), Drop { height_m, floor_m, seed: 20 + k, ..Drop::default() }.csv());
    }
    let json = folder.run("diagnose 0.csv 1.csv 2.csv --held-out 3.csv --sim ball.toml --json").ends(0).json();
    assert_eq!(json["verdict"], "none", "{json:#}");
    let warnings = json["warnings"].as_array().unwrap().iter();
    let text = |warning: &serde_json::Value, key: &str| warning[key].as_str().unwrap().to_owned();
    warnings.map(|warning| (text(warning, "code"), text(warning, "text"))).collect()
}

#[test]
fn a_surface_at_another_height_in_one_recording_is_noticed() {
    let is_shifted = |(code, _): &&(String, String)| code == "surface.shifted";
    assert_eq!(codes(0.0).iter().find(is_shifted), None);
    for (floor_m, way) in [(0.04, "40.0 mm above"), (-0.025, "25.0 mm below")] {
        let all = codes(floor_m);
        let (_, text) = all.iter().find(is_shifted).unwrap_or_else(|| panic!("{all:?}"));
        let (name, rest) = text.split_once(": ").unwrap();
        assert_eq!(name, "1.csv");
        let expected: f64 = way[..4].parse().unwrap();
        let found: f64 = rest.split_whitespace().nth(3).unwrap().parse().unwrap();
        assert!((found - expected).abs() < 0.5 && rest.contains(&way[5..]), "{text}");
    }
}
