//! What drives equations: holds and delays.

use tunenet_core::observation::Hold;

use super::{Given, clock, input, run, system};

/// The integral of an input.
const TANK: &str = "states.x_m = {}\nstart.x_m.value = 0\nderivatives.x_m = \"gain*u_v\"\ninputs.u_v = {}\n";

fn given(hold: Hold, parameters: Vec<f64>) -> Given {
    let inputs = vec![input(hold, &[0.0, 1.0, 2.0, 4.0], &[1.0, 3.0, -1.0, -1.0])];
    Given { parameters, start: vec![0.0], inputs, ..Given::default() }
}

#[test]
fn an_input_is_held_or_joined() {
    let system = system(TANK, &["gain"]);
    for (hold, wanted) in [(Hold::Previous, [0.5, 1.0, 4.0, 3.0, 1.0]), (Hold::Linear, [0.75, 2.0, 3.0, 2.0, 0.0])] {
        let found = run(&system, &given(hold, vec![1.0]), &[0.5, 1.0, 2.0, 3.0, 5.0]);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{hold:?}: {found:?}");
    }
}

#[test]
fn a_delayed_input_acts_later_and_exactly() {
    let text = TANK.replace("gain*u_v", "gain*delay(u_v, late_s)");
    let (late, plain) = (system(&text, &["gain", "late_s"]), system(TANK, &["gain"]));
    for hold in [Hold::Previous, Hold::Linear] {
        let times = clock(30, 0.13);
        let found = run(&late, &given(hold, vec![1.0, 0.37]), &times);
        let sooner: Vec<f64> = times.iter().map(|t| t - 0.37).collect();
        let known = run(&plain, &given(hold, vec![1.0]), &sooner);
        for (i, t) in times.iter().enumerate() {
            // Before its first sample the first value holds, which is 1.
            let wanted = if *t < 0.37 { *t } else { 0.37 + known[i] };
            assert!((found[i] - wanted).abs() < 1e-12, "{hold:?} {t}: {} {wanted}", found[i]);
        }
    }
}

#[test]
fn an_output_shows_the_input_of_its_instant() {
    let text = format!("{TANK}outputs.x_m = \"x_m\"\noutputs.u_v = \"u_v\"\n");
    let found = run(&system(&text, &["gain"]), &given(Hold::Previous, vec![1.0]), &[-1.0, 0.0, 0.5, 1.0, 2.0, 9.0]);
    assert_eq!(found.iter().skip(1).step_by(2).copied().collect::<Vec<_>>(), [1.0, 1.0, 1.0, 3.0, -1.0, -1.0]);
}
