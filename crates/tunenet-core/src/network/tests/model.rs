//! Model files, whole and foreign.

use super::*;

#[test]
fn a_model_file_comes_back() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 5 }, ..Preset::paper() }] {
        let model = train(&out, &options(preset, None), &mut |_| true).unwrap();
        let path = folder.path().join("model.safetensors");
        model.save(&path).unwrap();
        let loaded = Model::load(&path).unwrap();
        assert_eq!(loaded.to_bytes().unwrap(), std::fs::read(&path).unwrap());
        let (one, two, scale) = (seen(0.3, 4.2, 60), seen(0.6, 4.2, 60), scale(4.2));
        let estimate = |model: &Model| model.estimate(&one, Some(&scale), &two, Some(&scale)).unwrap();
        assert_eq!(estimate(&loaded), estimate(&model));
        assert_eq!(loaded.parameters(), model.parameters());
    }
}

#[test]
fn what_is_no_model_is_refused_in_one_sentence() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    let model = train(&out, &options(short(20), None), &mut |_| true).unwrap();
    let path = folder.path().join("model.safetensors");
    assert!(matches!(Model::load(&path), Err(Error::Io { .. })));
    std::fs::write(&path, "no tensors here").unwrap();
    assert!(Model::load(&path).unwrap_err().to_string().contains("not safetensors"));

    let good = model.to_bytes().unwrap();
    let with = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len(), "the header's length must stay");
        let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        let mut bytes = good.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        std::fs::write(&path, bytes).unwrap();
        Model::load(&path).unwrap_err().to_string()
    };
    assert!(with("\\\"version\\\":1", "\\\"version\\\":9").contains("expected a model of version 1, found version 9"));
    let text = with("\\\"hidden\\\":32", "\\\"hidden\\\":31");
    let rows = 2 * Preset::default().features;
    assert!(text.contains(&format!("[{rows}, 31]")) && text.contains(&format!("[{rows}, 32]")), "{text}");
}

#[test]
fn an_observation_of_something_else_is_refused() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    let model = train(&out, &options(short(20), None), &mut |_| true).unwrap();
    let good = seen(0.4, 4.5, 60);
    assert!(model.estimate(&good, None, &good, None).unwrap_err().to_string().contains("scale"));
    let other =
        Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], vec![0.0, 0.1, 0.2], vec![0.0; 3]).unwrap();
    let refused = model.estimate(&other, Some(&scale(4.5)), &good, Some(&scale(4.5))).unwrap_err().to_string();
    assert!(refused.contains("angle (rad)") && refused.contains("z (m)"), "{refused}");
}
