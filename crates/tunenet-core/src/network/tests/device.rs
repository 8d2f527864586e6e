//! The training that a GPU runs, on candle's CPU: the same as the one written out by hand.

use candle_core::{DType, Device};

use super::*;
use crate::network::learner::Place;
use crate::network::train::train_at;
use crate::network::two_branch::{TwoBranch, Widths};
use crate::network::weights_file;

const CANDLE: Place = Place::Candle(Device::Cpu);

fn trained(place: &Place, out: &Path, preset: &Preset) -> Model {
    train_at(place, out, &options(preset.clone(), None), &mut |_| true).unwrap()
}

/// One after the other.
fn weights(model: &Model) -> Vec<f64> {
    let contents = weights_file::from_bytes(Path::new("model"), &model.to_bytes().unwrap(), "a model").unwrap();
    let numbers = |name: &str| {
        let flat = contents.tensors[name].flatten_all().unwrap();
        flat.to_dtype(DType::F64).unwrap().to_vec1::<f64>().unwrap()
    };
    TwoBranch::NAMES.iter().flat_map(|name| numbers(name)).collect()
}

/// How far the weights of two short trainings are apart, over how far one of them went.
fn apart(place: &Place, out: &Path, preset: &Preset) -> f64 {
    let ours = trained(&Place::ByHand, out, preset);
    let (end, theirs) = (weights(&ours), weights(&trained(place, out, preset)));
    let widths = Widths {
        inputs: ours.input().width(),
        features: preset.features,
        hidden: preset.hidden,
        outputs: ours.parameters().len(),
    };
    let first = TwoBranch::new(widths, preset.head, ours.seed()).unwrap();
    let first = first.weights().map(|w| w.flatten_all().unwrap().to_vec1::<f32>().unwrap()).concat();
    assert_eq!((first.len(), end.len()), (end.len(), theirs.len()));
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    distance(&end, &theirs) / distance(&end, &first.iter().map(|w| f64::from(*w)).collect::<Vec<f64>>())
}

/// Every head, loss, optimiser and way of seeing that a preset has, shortened. The steps of `AdamW` are as long where a gradient is
/// nothing but rounding as anywhere else, and go anywhere there; an ε above the rounding takes that away.
fn presets() -> Vec<Preset> {
    let smooth = |optimiser: Optimiser| match optimiser {
        Optimiser::AdamW { rate, decay, beta1, beta2, .. } => {
            Optimiser::AdamW { rate, decay, beta1, beta2, epsilon: 1e-3 }
        }
        sgd @ Optimiser::Sgd { .. } => sgd,
    };
    let steps = |preset: Preset| match preset.course {
        Course::Epochs { .. } => Preset { course: Course::Epochs { epochs: 6 }, ..preset },
        Course::Remixed { noise, cut, .. } => {
            Preset { course: Course::Remixed { steps: 12, noise, cut }, batch: 64, ..preset }
        }
    };
    [Preset::paper(), Preset::default(), Preset::general(), Preset::paper_arm(), Preset::arm(), Preset::scene(9.8)]
        .map(|preset| Preset { optimiser: smooth(preset.optimiser.clone()), ..steps(preset) })
        .into()
}

/// How far apart, in shares of the way, rounding to 24 bits at a dozen steps puts them.
const ROUNDED: f64 = 1e-5;

#[test]
fn some_steps_of_every_preset_are_the_same() {
    let folder = folder();
    let out = dataset(&folder, 100, 120);
    for preset in presets() {
        let apart = apart(&CANDLE, &out, &preset);
        println!("{}, {:?}: {apart:.1e}", preset.name, preset.input);
        assert!(apart < ROUNDED, "{}: {apart:.1e}", preset.name);
        assert!(apart > 0.0, "{}: they are one", preset.name);
    }
}

#[test]
fn a_whole_training_tunes_as_well() {
    let folder = folder();
    let out = dataset(&folder, 300, 400);
    let preset = Preset { batch: 128, ..short(800) };
    let errors = [Place::ByHand, CANDLE].map(|place| {
        let model = trained(&place, &out, &preset);
        let errors = (0..50).map(|i| {
            let (truth, height) = (0.31 + 0.008 * f64::from(i), 3.0);
            let (one, two) = (seen(0.5, height, 400), seen(truth, height, 400));
            let change = model.estimate(&one, Some(&scale(height)), &two, Some(&scale(height))).unwrap()[0];
            (truth - 0.5 - change).abs() / 50.0
        });
        errors.sum::<f64>()
    });
    println!("mean error by hand {:.2e}, candle {:.2e}", errors[0], errors[1]);
    // Two seeds are as far apart as this.
    assert!(errors.iter().all(|error| *error < 0.005), "{errors:?}");
}

#[test]
fn it_is_resumed_with_the_same_bits_and_never_elsewhere() {
    let folder = folder();
    let out = dataset(&folder, 60, 60);
    for (name, preset) in
        [("default", short(100)), ("paper", Preset { course: Course::Epochs { epochs: 50 }, ..Preset::paper() })]
    {
        let whole = trained(&CANDLE, &out, &preset).to_bytes().unwrap();
        let kept = options(preset, Some(folder.path().join(name)));
        for (here, elsewhere) in [(&Place::ByHand, &CANDLE), (&CANDLE, &Place::ByHand)] {
            let stopped = train_at(here, &out, &kept, &mut |at| at.step < 40);
            assert!(matches!(stopped, Err(Error::Stopped)));
            let refused = train_at(elsewhere, &out, &kept, &mut |_| true).unwrap_err();
            let (expected, found) = (format!("on `{}`,", elsewhere.name()), format!("on `{}`", here.name()));
            assert!(refused.to_string().contains(&expected) && refused.to_string().ends_with(&found), "{refused}");
            assert!(refused.hint().unwrap().contains(&format!("--device {}", here.name())));
            let mut first = u64::MAX;
            let mut progress = |at: &TrainProgress| {
                first = first.min(at.step);
                true
            };
            let resumed = train_at(here, &out, &kept, &mut progress).unwrap().to_bytes().unwrap();
            assert_eq!(first, 60, "{name}");
            assert!((resumed == whole) == matches!(here, Place::Candle(_)), "{name}");
            std::fs::remove_file(kept.checkpoint.as_ref().unwrap()).unwrap();
        }
    }
}

#[test]
fn a_build_without_gpus_says_so() {
    if candle_core::utils::cuda_is_available() {
        return println!("skipped: this build has support for GPUs");
    }
    assert_eq!(TrainDevice::at_hand(), TrainDevice::Cpu);
    let folder = folder();
    let cuda = TrainOptions { device: TrainDevice::Cuda, ..options(short(20), None) };
    let refused = train(&dataset(&folder, 20, 30), &cuda, &mut |_| true).unwrap_err();
    assert!(matches!(refused, Error::Setting { name: "device", .. }), "{refused}");
    assert!(refused.hint().unwrap().contains("--features cuda"));
}

/// The one test that wants a GPU; all that it runs there ran on the CPU above.
#[test]
fn a_gpu_does_the_same() {
    let place = match TrainDevice::Cuda.place() {
        Ok(place) => place,
        Err(why) => return println!("skipped: {why}"),
    };
    let folder = folder();
    let out = dataset(&folder, 100, 120);
    for preset in presets() {
        let apart = apart(&place, &out, &preset);
        assert!(apart < ROUNDED, "{}: {apart:.1e}", preset.name);
        let bytes = [0, 1].map(|_| trained(&place, &out, &preset).to_bytes().unwrap());
        assert!(bytes[0] == bytes[1], "{}: not the same bits twice", preset.name);
    }
}
