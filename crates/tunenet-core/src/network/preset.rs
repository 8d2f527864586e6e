//! Every hyper-parameter of a training, as one value.

use serde::{Deserialize, Serialize};

use crate::observation::Channel;
use crate::{Error, Origin, Result};

/// A training in full: what the network sees, its shape, and how it learns.
///
/// [`Preset::paper`] is as published in the appendix of `TuneNet` (arXiv 1907.11200); [`Preset::default`] is recommended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Its name, for users and for the model file.
    pub name: String,
    /// What the network sees.
    pub input: InputChoice,
    /// How the two branches become a difference.
    pub head: Head,
    /// Width of each branch. The paper: 32.
    pub features: usize,
    /// Width of the layer behind both branches. The paper: 32.
    pub hidden: usize,
    /// What is made small.
    pub loss: Loss,
    /// How it is made small.
    pub optimiser: Optimiser,
    /// Pairs in a step. At least 1.
    pub batch: usize,
    /// Which pairs are shown, and how often.
    pub course: Course,
    /// Share of the dataset's pairs that are kept for validation, in `[0, 0.5]`.
    pub held_back: f64,
    /// How many of the training's rollouts are kept with the weights, for a start without a rollout; 0 for none.
    #[serde(default)]
    pub library: usize,
}

/// What the network is to see; [`Input`](super::Input) is the same, fitted to a training set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum InputChoice {
    /// One channel as recorded, min-max normalised over the training set.
    Raw {
        /// The channel's name; without one, the last channel (a body's height).
        #[serde(default)]
        channel: Option<String>,
    },
    /// One channel in units of each recording's own scale; where a dataset has no scales, all channels standardised over
    /// the same number of intervals.
    Dimensionless {
        /// The channel's name; without one, the last channel (a body's height).
        #[serde(default)]
        channel: Option<String>,
        /// How many intervals, at least 2.
        bins: usize,
        /// The end of the last interval in units of the recording's time.
        tau_max: f64,
    },
    /// All channels in units of each recording's own scale.
    Scaled {
        /// How many intervals of each channel, at least 2.
        bins: usize,
        /// The end of the last interval in units of the recording's time.
        tau_max: f64,
    },
    /// All channels, standardised.
    Standardised {
        /// How many intervals of each channel, at least 2.
        bins: usize,
    },
    /// All channels as recorded, min-max normalised together over the training set: a channel that hardly changes is not
    /// blown up to noise.
    Recorded,
    /// All channels less their means, divided by one standard deviation for all of them.
    Balanced {
        /// How many intervals of each channel, at least 2.
        bins: usize,
    },
}

/// How the two branches become a difference of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Head {
    /// `tanh h(a, b)`: the appendix.
    Tanh,
    /// `½ [h(a, b) − h(b, a)]`: equal observations give exactly no change, for any weights.
    Antisymmetric,
}

/// What is made small, a mean over the batch and the parameters, each in units of its training span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// The squared error: the appendix.
    Squared,
    /// The absolute error.
    Absolute,
}

/// How the loss is made small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Optimiser {
    /// Plain gradient descent, the rate decayed stepwise.
    Sgd {
        /// The first rate.
        rate: f64,
        /// Factor on the rate after every `decay_every` epochs.
        decay: f64,
        /// Epochs between two decays, at least 1.
        decay_every: u64,
        /// L2 regularisation: this times the weight is added to the gradient.
        l2: f64,
    },
    /// `AdamW` (arXiv 1711.05101), the rate falling to 0 along half a cosine.
    AdamW {
        /// The first rate.
        rate: f64,
        /// Decoupled weight decay.
        decay: f64,
        /// Memory of the mean gradient, in `[0, 1)`.
        beta1: f64,
        /// Memory of the mean squared gradient, in `[0, 1)`.
        beta2: f64,
        /// Added to the root of the mean squared gradient.
        epsilon: f64,
    },
}

/// Which pairs are shown, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Course {
    /// The dataset's own pairs, all of them in a new order each epoch.
    Epochs {
        /// How many.
        epochs: u64,
    },
    /// Pairs drawn afresh at every step. Where a rollout can be paired with any other (dimensionless inputs, or a dataset
    /// without nuisance parameters) any two rollouts make a pair; otherwise the dataset's pairs, either way round.
    Remixed {
        /// How many steps.
        steps: u64,
        /// White noise on the second branch, in units of the input: each pair's standard deviation is `noise · U²` with U
        /// uniform in `[0, 1]`, so that nearly clean and very noisy targets both occur.
        noise: f64,
        /// Share of the pairs whose record is cut at a random place, in `[0, 1]`, so that short records are known too.
        cut: f64,
    },
}

impl Preset {
    /// The appendix of the paper: one channel, min-max normalised; residual over training span; SGD at 1e-2, times 0.99
    /// every 5 epochs; L2 1e-2; batches of 50; 200 epochs; mean squared error.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            name: "paper".into(),
            input: InputChoice::Raw { channel: None },
            head: Head::Tanh,
            features: 32,
            hidden: 32,
            loss: Loss::Squared,
            optimiser: Optimiser::Sgd { rate: 1e-2, decay: 0.99, decay_every: 5, l2: 1e-2 },
            batch: 50,
            course: Course::Epochs { epochs: 200 },
            held_back: 0.0,
            library: 0,
        }
    }

    /// For recordings of any body that falls and rebounds, as they come out of their preparation: start and surface are guesses, records
    /// end anywhere.
    #[must_use]
    pub fn general() -> Self {
        Self {
            name: "general".into(),
            // What the rows lack on purpose is there already: noise, wrong guesses, short records.
            course: Course::Remixed { steps: 8000, noise: 0.02, cut: 0.0 },
            ..Self::default()
        }
    }

    /// The appendix of the paper for joint torques: all torques, min-max normalised; residual over training span; SGD at 1e-2, times
    /// 0.99 every 50 epochs; L2 1e-3; batches of 50; 1000 epochs; mean squared error.
    #[must_use]
    pub fn paper_arm() -> Self {
        Self {
            input: InputChoice::Recorded,
            optimiser: Optimiser::Sgd { rate: 1e-2, decay: 0.99, decay_every: 50, l2: 1e-3 },
            course: Course::Epochs { epochs: 1000 },
            ..Self::paper()
        }
    }

    /// For joint torques: recommended.
    #[must_use]
    pub fn arm() -> Self {
        Self {
            input: InputChoice::Balanced { bins: 50 },
            features: 32,
            // In standard deviations of all torques; those of a mechanism are several N·m.
            course: Course::Remixed { steps: 4000, noise: 0.1, cut: 0.0 },
            library: 101,
            ..Self::default()
        }
    }

    /// As [`named`](Self::named), for observations of these channels: joint torques have presets of their own.
    ///
    /// # Errors
    /// [`Error::Setting`] for any other name, and for `general`, which is for falling bodies, with torques.
    pub fn named_for(name: &str, channels: &[Channel]) -> Result<Self> {
        let torques = !channels.is_empty() && channels.iter().all(|c| c.unit == "N·m");
        match name {
            "paper" if torques => Ok(Self::paper_arm()),
            "default" if torques => Ok(Self::arm()),
            other if torques => Err(setting("preset", "`paper` or `default` for joint torques", other)),
            other => Self::named(other),
        }
    }

    /// For one scene, on the spot: a small network, few steps, all parameters and channels, looking as far as `tau_max`
    /// recording's times.
    #[must_use]
    pub fn scene(tau_max: f64) -> Self {
        Self {
            name: "scene".into(),
            input: InputChoice::Scaled { bins: 48, tau_max },
            features: 64,
            batch: 128,
            course: Course::Remixed { steps: 1500, noise: 0.01, cut: 0.0 },
            library: 128,
            ..Self::default()
        }
    }

    /// `paper`, `default` or `general`.
    ///
    /// # Errors
    /// [`Error::Setting`] for any other name.
    pub fn named(name: &str) -> Result<Self> {
        match name {
            "paper" => Ok(Self::paper()),
            "default" => Ok(Self::default()),
            "general" => Ok(Self::general()),
            other => Err(setting("preset", "`paper`, `default` or `general`", other)),
        }
    }

    /// Whether every number is in its range.
    ///
    /// # Errors
    /// [`Error::Setting`] for the first that is not.
    pub fn check(&self) -> Result<()> {
        if self.features == 0 || self.hidden == 0 {
            return Err(setting("features", "at least 1", "0"));
        }
        if self.batch == 0 {
            return Err(setting("batch", "at least 1", "0"));
        }
        if !(0.0..=0.5).contains(&self.held_back) {
            return Err(setting("held_back", "0 to 0.5", self.held_back));
        }
        match &self.input {
            InputChoice::Dimensionless { bins, .. }
            | InputChoice::Standardised { bins }
            | InputChoice::Balanced { bins }
                if *bins < 2 =>
            {
                return Err(setting("bins", "at least 2", bins));
            }
            InputChoice::Dimensionless { tau_max, .. } if !(tau_max.is_finite() && *tau_max > 0.0) => {
                return Err(setting("tau_max", "above 0", tau_max));
            }
            _ => {}
        }
        match self.optimiser {
            Optimiser::Sgd { decay_every: 0, .. } => return Err(setting("decay_every", "at least 1", 0)),
            Optimiser::Sgd { rate, .. } | Optimiser::AdamW { rate, .. } if !(rate.is_finite() && rate > 0.0) => {
                return Err(setting("rate", "above 0", rate));
            }
            _ => {}
        }
        if let Course::Remixed { noise, cut, .. } = self.course {
            if !(noise.is_finite() && noise >= 0.0) {
                return Err(setting("noise", "0 or more", noise));
            }
            if !(0.0..=1.0).contains(&cut) {
                return Err(setting("cut", "0 to 1", cut));
            }
        }
        Ok(())
    }
}

impl Default for Preset {
    /// This project's own: dimensionless, antisymmetric, absolute error, heavy noise on the target, `AdamW`.
    fn default() -> Self {
        Self {
            name: "default".into(),
            // τ = 9.8 is the end of 400 frames at 60 Hz after a fall of 4.5 m, the paper's window.
            input: InputChoice::Dimensionless { channel: None, bins: 128, tau_max: 9.8 },
            head: Head::Antisymmetric,
            // Three times the paper's branches halve the error of the first step; a wider layer behind them does not help.
            features: 96,
            hidden: 32,
            loss: Loss::Absolute,
            optimiser: Optimiser::AdamW { rate: 3e-3, decay: 0.0, beta1: 0.9, beta2: 0.99, epsilon: 1e-8 },
            batch: 256,
            // An order of magnitude above the noise expected on a fall of 4.5 m, which makes the network nearly efficient.
            course: Course::Remixed { steps: 5000, noise: 0.06, cut: 0.05 },
            held_back: 0.1,
            library: 201,
        }
    }
}

fn setting(name: &'static str, expected: &str, found: impl std::fmt::Display) -> Error {
    Error::Setting { origin: Origin::Caller, name, expected: expected.into(), found: found.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_survive_their_file_form() {
        for preset in [Preset::paper(), Preset::default(), Preset::paper_arm(), Preset::arm()] {
            preset.check().unwrap();
            let text = serde_json::to_string(&preset).unwrap();
            assert_eq!(serde_json::from_str::<Preset>(&text).unwrap(), preset);
        }
    }

    #[test]
    fn unknown_keys_and_numbers_out_of_range_are_refused() {
        let text = serde_json::to_string(&Preset::paper()).unwrap();
        let typo = text.replace("\"batch\"", "\"bacth\"");
        assert!(serde_json::from_str::<Preset>(&typo).unwrap_err().to_string().contains("bacth"));
        assert!(Preset { batch: 0, ..Preset::paper() }.check().is_err());
        assert!(Preset::named("papre").unwrap_err().to_string().contains("papre"));
    }
}
