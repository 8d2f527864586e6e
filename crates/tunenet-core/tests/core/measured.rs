//! Every effect of the measurement against its formula, on a motion that is known in closed form.

use tunenet_core::Result;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{
    Measured, Parameter, Preparation, RolloutResult, Simulator, measurement_effects, rollout as run,
};

/// A body on an endless parabola: x = 1 + 2 t, y = −½ + t, z = 3 t − p t²/2. Its clock must rise.
struct Parabola(Vec<Parameter>, Vec<Channel>, Kind);

fn point(p: f64, t: f64) -> [f64; 3] {
    [1.0 + 2.0 * t, t - 0.5, 3.0 * t - 0.5 * p * t * t]
}

impl Simulator for Parabola {
    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn channels(&self) -> &[Channel] {
        &self.1
    }

    fn kind(&self) -> Kind {
        self.2
    }

    fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
        if !clock.is_sorted() {
            return Err("the clock has to rise".into());
        }
        for (t, row) in clock.iter().zip(out.chunks_exact_mut(self.1.len())) {
            row.copy_from_slice(&point(p[0], *t)[..row.len()]);
        }
        Ok(())
    }
}

const PULL: f64 = 9.0;

fn parabola() -> Parabola {
    Parabola(vec![Parameter::new("pull", "m/s²", PULL, 0.0, 20.0).unwrap()], Channel::positions(), Kind::Positions)
}

fn clock() -> Vec<f64> {
    (0..40).map(|i| 0.3 + 0.02 * f64::from(i)).collect()
}

/// What is seen with these effects, `[name, values]`, as free ones; as fixed ones it has to be the same.
fn seen(effects: &[(&str, &[f64])]) -> Result<Vec<f64>> {
    let parabola = parabola();
    let names: Vec<&str> = effects.iter().map(|e| e.0).collect();
    let free = Measured::new(&parabola, &names)?;
    let mut parameters = vec![PULL];
    parameters.extend(effects.iter().flat_map(|e| e.1));
    let seen = run(&free, &parameters, &[], &clock())?;
    let mut fixed = Measured::new(&parabola, &[])?;
    for (name, values) in effects {
        fixed = fixed.fixed(name, values)?;
    }
    assert_eq!(fixed.parameters().len(), 1);
    assert_eq!(run(&fixed, &[PULL], &[], &clock())?, seen);
    Ok(seen)
}

/// Holds what is seen against a formula of the stamp.
fn follows(effects: &[(&str, &[f64])], tolerance: f64, formula: impl Fn(f64) -> [f64; 3]) {
    for (t, row) in clock().iter().zip(seen(effects).unwrap().chunks(3)) {
        let truth = formula(*t);
        let worst = row.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < tolerance, "{effects:?} at {t}: {row:?}, not {truth:?}");
    }
}

fn at(t: f64) -> [f64; 3] {
    point(PULL, t)
}

#[test]
fn places_follow_their_formulas() {
    follows(&[("length_scale", &[1.07])], 1e-14, |t| at(t).map(|v| 1.07 * v));
    follows(&[("aspect_ratio", &[0.9])], 1e-14, |t| {
        let [x, y, z] = at(t);
        [x, y, 0.9 * z]
    });
    follows(&[("perspective", &[0.08])], 1e-14, |t| at(t).map(|v| v / (1.0 + 0.08 * at(t)[2])));
    follows(&[("lens_distortion", &[-0.03])], 1e-14, |t| {
        let [x, y, z] = at(t);
        let r2 = x.powi(2) + z.powi(2);
        [x - 0.03 * r2 * x, y, z - 0.03 * r2 * z]
    });
    // About x alone y turns into z; about y alone z into x; both keep every length.
    follows(&[("camera_tilt", &[0.2, 0.0])], 1e-14, |t| {
        let [x, y, z] = at(t);
        [x, y * 0.2_f64.cos() - z * 0.2_f64.sin(), y * 0.2_f64.sin() + z * 0.2_f64.cos()]
    });
    follows(&[("camera_tilt", &[0.0, 0.1])], 1e-14, |t| {
        let [x, y, z] = at(t);
        [x * 0.1_f64.cos() + z * 0.1_f64.sin(), y, z * 0.1_f64.cos() - x * 0.1_f64.sin()]
    });
    let length = |row: &[f64]| row.iter().map(|v| v * v).sum::<f64>();
    for (t, row) in clock().iter().zip(seen(&[("camera_tilt", &[0.2, -0.3])]).unwrap().chunks(3)) {
        assert!((length(row) - length(&at(*t))).abs() < 1e-13);
    }
}

#[test]
fn clocks_follow_their_formulas() {
    follows(&[("time_scale", &[1.25])], 1e-14, |t| at(t / 1.25));
    follows(&[("time_offset", &[0.04])], 1e-14, |t| at(t - 0.04));
    // True time is scaled first and shifted then, in whatever order the two are named.
    follows(&[("time_scale", &[1.25]), ("time_offset", &[0.04])], 1e-14, |t| at((t - 0.04) / 1.25));
    follows(&[("time_offset", &[0.04])], 1e-14, |t| at(t - 0.04));
    // The mean of t² over an exposure T is larger by T²/12.
    follows(&[("observation_blur", &[0.06])], 1e-14, |t| {
        let [x, y, z] = at(t);
        [x, y, z - 0.5 * PULL * 0.06_f64.powi(2) / 12.0]
    });
}

#[test]
fn a_rolling_shutter_reads_what_has_moved_meanwhile() {
    let delay = 0.004;
    // t' = t + delay z(t'), a quadratic of t'.
    // Four rounds leave (delay · 7 m/s)⁴ = 6e-7 of the 6 cm that a height of 2 m moves the body.
    follows(&[("rolling_shutter", &[delay])], 4e-8, |t| {
        let (a, b) = (0.5 * PULL * delay, 1.0 - 3.0 * delay);
        at((-b + (b * b + 4.0 * a * t).sqrt()) / (2.0 * a))
    });
}

#[test]
fn effects_act_in_the_order_of_the_light() {
    let both: [(&str, &[f64]); 2] = [("length_scale", &[2.0]), ("perspective", &[0.1])];
    // What is projected is a true length; the scale of the picture comes after.
    follows(&both, 1e-13, |t| at(t).map(|v| 2.0 * v / (1.0 + 0.1 * at(t)[2])));
    assert_eq!(seen(&both).unwrap(), seen(&[both[1], both[0]]).unwrap());
    follows(&[("rolling_shutter", &[1e-3]), ("time_scale", &[1.1]), ("observation_blur", &[0.01])], 1e-4, |t| {
        let t = t / 1.1;
        at(t + 1e-3 * at(t)[2])
    });
}

#[test]
fn absent_effects_change_no_bit() {
    let parabola = parabola();
    let plain = run(&parabola, &[PULL], &[], &clock()).unwrap();
    let all = measurement_effects(Kind::Positions);
    assert_eq!(all.len(), 9);
    let names: Vec<&str> = all.iter().map(|e| e.name.as_ref()).collect();
    let measured = Measured::new(&parabola, &names).unwrap();
    let absent: Vec<f64> = measured.parameters().iter().map(|p| p.value).collect();
    assert_eq!(run(&measured, &absent, &[], &clock()).unwrap(), plain);
}

#[test]
fn derivatives_are_smooth() {
    let parabola = parabola();
    for effect in measurement_effects(Kind::Positions) {
        let measured = Measured::new(&parabola, &[&effect.name]).unwrap();
        let absent: Vec<f64> = measured.parameters().iter().map(|p| p.value).collect();
        for (i, c) in effect.coefficients.iter().enumerate() {
            for away in [0.0, 1.0] {
                let mut point = absent.clone();
                point[1 + i] += away * c.typical;
                let from = run(&measured, &point, &[], &clock()).unwrap();
                let slope = |share: f64| -> Vec<f64> {
                    let mut moved = point.clone();
                    moved[1 + i] += share * c.typical;
                    let to = run(&measured, &moved, &[], &clock()).unwrap();
                    to.iter().zip(&from).map(|(a, b)| (a - b) / (share * c.typical)).collect()
                };
                let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
                let (coarse, fine) = (slope(1e-2), slope(1e-3));
                let apart: Vec<f64> = coarse.iter().zip(&fine).map(|(a, b)| a - b).collect();
                // A mean over an exposure T differs by T²/24 times a curvature: its slope vanishes where it is absent.
                let least = 1e-6 + if effect.name == "observation_blur" { 1e-3 } else { 0.0 };
                assert!(norm(&apart) < 2e-2 * norm(&fine) + least, "{}.{} at {away}", effect.name, c.key);
            }
        }
    }
}

#[test]
fn other_kinds_show_what_they_can() {
    let names = |kind| measurement_effects(kind).into_iter().map(|e| e.name).collect::<Vec<_>>();
    assert_eq!(names(Kind::EventTimes), ["time_scale", "time_offset"]);
    assert_eq!(names(Kind::Joints), Vec::<&str>::new());
    // On a series of no kind, lengths are the channels in m.
    let channels = vec![Channel::new("way", "m"), Channel::new("share", "1")];
    let other = Parabola(parabola().0, channels, Kind::Other);
    let measured = Measured::new(&other, &["length_scale", "time_scale"]).unwrap();
    let seen = run(&measured, &[PULL, 2.0, 2.0], &[], &clock()).unwrap();
    for (t, row) in clock().iter().zip(seen.chunks(2)) {
        assert_eq!(*row, [2.0 * at(t / 2.0)[0], at(t / 2.0)[1]]);
    }
    let said = Measured::new(&other, &["perspective"]).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("`perspective`") && said.contains("length_scale"), "{said}");
}

#[test]
fn a_recording_is_made_ready_as_the_inner_simulator_does() {
    let (parabola, clock) = (parabola(), clock());
    let values = run(&parabola, &[PULL], &[], &clock).unwrap();
    let seen = Observation::new(Kind::Positions, Channel::positions(), clock, values).unwrap();
    let measured = Measured::new(&parabola, &["camera_tilt"]).unwrap();
    let Preparation::Usable(prepared) = measured.prepare(&seen).unwrap() else { panic!("nothing is wrong with it") };
    assert_eq!((prepared.local.len(), prepared.silent.len()), (3, 3));
    assert_eq!(prepared.seen, seen);
}

#[test]
fn what_cannot_be_is_refused_with_a_sentence() {
    let said = |effects: &[(&str, &[f64])]| seen(effects).unwrap_err().to_string();
    assert!(said(&[("time_scale", &[0.0])]).contains("`time_scale.factor` is 0"));
    assert!(said(&[("observation_blur", &[f64::NAN])]).contains("`observation_blur.exposure_s` is NaN"));
    assert!(said(&[("tide", &[0.0])]).contains("`tide`"));
    assert!(said(&[("time_scale", &[1.1]), ("time_scale", &[1.1])]).contains("once"));
    let parabola = parabola();
    assert!(Measured::new(&parabola, &[]).unwrap().fixed("length_scale", &[-1.0]).is_err());
    // 3 t − 4.5 t² is −16.5 m after 2.3 s: behind a camera whose scale doubles in 10 m.
    let behind = Measured::new(&parabola, &["perspective"]).unwrap();
    let said = run(&behind, &[PULL, 0.1], &[], &[2.3]).unwrap_err().to_string();
    assert!(said.contains("behind the camera"), "{said}");
    // A pendulum or anything else that knows no effects of its own says so.
    assert!(behind.with_effects(&["quadratic_drag"]).is_err());
}
