//! The built-in network: its size, what it reaches, and that it is made the same way every time.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::network::{Course, Model, Preset, Side, TrainOptions, stream, train_on};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Preparation, Simulator};
use tunenet_formats::{model_from_bytes, model_to_bytes};
use tunenet_sim::drawn::{Drawn, Ranges};
use tunenet_sim::{ObservedBall, SimulationFile, built_in};

const BALL: &str = include_str!("../../../../assets/ball.toml");

fn file() -> SimulationFile {
    SimulationFile::parse("ball.toml".as_ref(), BALL).unwrap()
}

#[test]
fn it_is_small_and_starts_near() {
    let size = include_bytes!("../../../../assets/networks/ball.safetensors").len();
    assert!(size <= 500_000, "{size} bytes");
    let (file, model) = (file(), built_in::ball().unwrap());
    let ball = ObservedBall::new(&file, Kind::Positions).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(0x51de_0001);
    let mut errors = Vec::new();
    for _ in 0..150 {
        let (e, fall): (f64, f64) = (random.random_range(0.3..0.9), random.random_range(0.5..5.0));
        let rate: f64 = random.random_range(50.0..240.0);
        let first = (2.0 * fall / 9.81).sqrt();
        let clock: Vec<f64> = (0..1_000_000).map(|i| f64::from(i) / rate).take_while(|t| *t < 5.0 * first).collect();
        let mut noise = || 0.003 * fall * random.sample::<f64, _>(StandardNormal);
        let rows: Vec<[f64; 3]> = clock
            .iter()
            .map(|t| [noise(), noise(), 7.0 + crate::closed_form::drop(fall, 9.81, e, *t) + noise()])
            .collect();
        let seen = Observation::positions(clock, &rows).unwrap();
        let Preparation::Usable(prepared) = ball.prepare(&seen).unwrap() else { continue };
        if built_in::serves(&file, &prepared).is_err() {
            continue;
        }
        let start = model.start(Side { observation: &prepared.seen, scale: prepared.scale.as_ref() }).unwrap();
        errors.push((start.unwrap()[0] - e).abs());
    }
    assert!(errors.len() > 130, "{} of 150", errors.len());
    errors.sort_by(f64::total_cmp);
    // Without a single rollout; half of the untuned range would be 0.2.
    assert!(errors[errors.len() / 2] < 0.01, "median {}", errors[errors.len() / 2]);
    assert!(errors[errors.len() * 9 / 10] < 0.05, "nine of ten {}", errors[errors.len() * 9 / 10]);
}

/// What `make model` does, with fewer recordings and steps.
fn short() -> Model {
    let drawn = Drawn::new(&file(), Ranges::general()).unwrap();
    let pairs: Vec<_> = (0..150).map(|i| drawn.pair(&mut stream(0, i)).unwrap()).collect();
    let preset = Preset { course: Course::Remixed { steps: 60, noise: 0.02, cut: 0.0 }, ..Preset::general() };
    let options = TrainOptions::new(preset, 0);
    train_on(&drawn.header("ball/general", 0, 150), &pairs, &options, &mut |_| true).unwrap()
}

#[test]
fn it_is_made_the_same_every_time() {
    let bytes = [short(), short()].map(|model| model_to_bytes(&model).unwrap());
    assert!(bytes[0] == bytes[1]);
    let loaded = model_from_bytes("short", &bytes[0]).unwrap();
    assert!(loaded.from_recordings() && model_to_bytes(&loaded).unwrap() == bytes[0]);
}

#[test]
fn it_says_where_it_serves() {
    let ball = |file: &SimulationFile, fall: f64, rate: f64| {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) / rate).collect();
        let rows: Vec<[f64; 3]> =
            clock.iter().map(|t| [0.0, 0.0, 0.02 + crate::closed_form::drop(fall, 9.81, 0.7, *t)]).collect();
        let seen = Observation::positions(clock, &rows).unwrap();
        let ball = ObservedBall::new(file, Kind::Positions).unwrap();
        let Preparation::Usable(prepared) = ball.prepare(&seen).unwrap() else { panic!("{fall} m at {rate} Hz") };
        built_in::serves(file, &prepared)
    };
    let plain = file();
    assert_eq!(ball(&plain, 1.0, 100.0), Ok(()));
    assert!(ball(&plain, 20.0, 60.0).unwrap_err().contains("20.000 m"));
    assert!(ball(&plain, 4.0, 20.0).unwrap_err().contains("20.0 samples"));
    let mut other = file();
    other.set("parameters.friction.tune=true").unwrap();
    assert!(ball(&other, 1.0, 100.0).unwrap_err().contains("friction"));
    let mut tilted = file();
    tilted.set("surface.tilt_about_x_rad=0.1").unwrap();
    assert!(ball(&tilted, 1.0, 100.0).unwrap_err().contains("tilted"));
}
