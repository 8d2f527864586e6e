//! Training on a GPU against training on the CPU.

use super::*;
use crate::network::two_branch::{TwoBranch, Widths};

fn trained(device: TrainDevice, out: &Set, preset: &Preset) -> Model {
    train(out, &TrainOptions { device, ..options(preset.clone()) }, Keeping::default(), &mut |_| true).unwrap()
}

/// One after the other.
fn weights(model: &Model) -> Vec<f64> {
    let weights = model.weights().unwrap();
    let numbers = |name: &&str| match &weights.arrays[*name].numbers {
        Numbers::F32(numbers) => numbers.iter().map(|v| f64::from(*v)).collect(),
        Numbers::F64(numbers) => numbers.clone(),
    };
    TwoBranch::NAMES.iter().flat_map(numbers).collect()
}

/// How far the weights of two short trainings are apart, over how far one of them went.
fn apart(device: TrainDevice, out: &Set, preset: &Preset) -> f64 {
    let ours = trained(TrainDevice::Cpu, out, preset);
    let (end, theirs) = (weights(&ours), weights(&trained(device, out, preset)));
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
fn a_checkpoint_is_resumed_on_its_own_device_only() {
    let (out, kept) = (dataset(60, 60), Kept::default());
    let stopped = train(&out, &options(short(100)), kept.here(), &mut |at| at.step < 40);
    assert!(matches!(stopped, Err(Error::Stopped)));
    let mut on_device = kept.0.borrow_mut();
    let about = on_device.as_mut().map(|weights| &mut weights.about).unwrap();
    assert!(about.contains(r#""device":"cpu""#), "{about}");
    *about = about.replace(r#""device":"cpu""#, r#""device":"cuda""#);
    drop(on_device);
    let refused = train(&out, &options(short(100)), kept.here(), &mut |_| true).unwrap_err();
    let Error::Weights { fault, .. } = refused else { panic!("{refused}") };
    assert_eq!(fault, WeightsFault::OtherDevice("cuda".into()));
}

#[test]
fn a_build_without_gpus_says_so() {
    if candle_core::utils::cuda_is_available() {
        return println!("skipped: this build has support for GPUs");
    }
    assert_eq!(TrainDevice::at_hand(), TrainDevice::Cpu);
    let cuda = TrainOptions { device: TrainDevice::Cuda, ..options(short(20)) };
    let refused = train(&dataset(20, 30), &cuda, Keeping::default(), &mut |_| true).unwrap_err();
    assert!(matches!(refused, Error::DeviceUnsupported { device: TrainDevice::Cuda }), "{refused}");
}

/// The one test that wants a GPU.
#[test]
fn a_gpu_does_the_same() {
    if let Err(why) = TrainDevice::Cuda.check() {
        return println!("skipped: {why}");
    }
    let out = dataset(100, 120);
    for preset in presets() {
        let apart = apart(TrainDevice::Cuda, &out, &preset);
        assert!(apart < ROUNDED, "{}: {apart:.1e}", preset.name);
        let bytes = [0, 1].map(|_| trained(TrainDevice::Cuda, &out, &preset).weights().unwrap());
        assert!(bytes[0] == bytes[1], "{}: not the same bits twice", preset.name);
    }
}
