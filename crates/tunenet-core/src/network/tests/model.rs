//! Models out of stored weights, whole and foreign.

use super::*;

#[test]
fn a_model_comes_back_from_its_weights() {
    let out = dataset(30, 60);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 5 }, ..Preset::paper() }] {
        let model = learned(&out, preset);
        let loaded = Model::from_weights(model.weights().unwrap()).unwrap();
        assert_eq!(loaded.weights().unwrap(), model.weights().unwrap());
        let (one, two, scale) = (seen(0.3, 4.2, 60), seen(0.6, 4.2, 60), scale(4.2));
        let estimate = |model: &Model| model.estimate(&one, Some(&scale), &two, Some(&scale)).unwrap();
        assert_eq!(estimate(&loaded), estimate(&model));
        assert_eq!(loaded.parameters(), model.parameters());
    }
}

#[test]
fn weights_of_something_else_are_refused() {
    let good = learned(&dataset(30, 60), short(20)).weights().unwrap();
    let with = |from: &str, to: &str| {
        assert!(good.about.contains(from));
        let weights = Weights { about: good.about.replace(from, to), ..good.clone() };
        Model::from_weights(weights).unwrap_err().to_string()
    };
    assert!(with("\"version\":1", "\"version\":9").contains("expected a model of version 1, found version 9"));
    let text = with("\"hidden\":32", "\"hidden\":31");
    let rows = 2 * Preset::default().features;
    assert!(text.contains(&format!("[{rows}, 31]")) && text.contains(&format!("[{rows}, 32]")), "{text}");
}

#[test]
fn an_observation_of_something_else_is_refused() {
    let out = dataset(30, 60);
    let model = learned(&out, short(20));
    let good = seen(0.4, 4.5, 60);
    assert!(model.estimate(&good, None, &good, None).unwrap_err().to_string().contains("scale"));
    let other =
        Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], vec![0.0, 0.1, 0.2], vec![0.0; 3]).unwrap();
    let refused = model.estimate(&other, Some(&scale(4.5)), &good, Some(&scale(4.5))).unwrap_err().to_string();
    assert!(refused.contains("angle (rad)") && refused.contains("z (m)"), "{refused}");
}
