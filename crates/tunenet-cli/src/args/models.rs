//! Models that `tune` and `diagnose` write for other programs.

use std::path::PathBuf;

use clap::Args;

use super::track::positive;

/// Models with the tuned numbers of a robot.
#[derive(Debug, Default, Args)]
pub struct Models {
    /// Write a copy of the robot's model (MJCF or URDF) with the tuned numbers; FILE.effects.toml gets those that the format
    /// cannot express. For an arm with replayed logs: its joint friction
    #[arg(long, visible_alias = "out-urdf", value_name = "FILE")]
    pub out_model: Option<PathBuf>,
    /// Write the parameters of the joints' servos for BAM (JSON)
    #[arg(long, value_name = "FILE.json", requires = "bam_actuator")]
    pub out_bam: Option<PathBuf>,
    /// Kind of the servos as BAM names it, such as sts3215
    #[arg(long, value_name = "NAME", requires = "out_bam")]
    pub bam_actuator: Option<String>,
    /// Write an actuator configuration for Isaac Lab (Python)
    #[arg(long, value_name = "FILE.py")]
    pub out_isaac: Option<PathBuf>,
    /// Physics step of Isaac Lab in seconds, in which it counts delays
    #[arg(long, value_name = "S", default_value_t = 0.005, value_parser = positive, requires = "out_isaac")]
    pub isaac_step: f64,
}

impl Models {
    /// Whether any is asked for.
    pub fn asked(&self) -> bool {
        self.out_model.is_some() || self.of_robots().is_some()
    }

    /// The first option that only a robot's file has, by its name.
    pub fn of_robots(&self) -> Option<&'static str> {
        let bam = self.out_bam.as_ref().map(|_| "--out-bam");
        bam.or(self.out_isaac.as_ref().map(|_| "--out-isaac"))
    }

    /// Where numbers go that the model file cannot express.
    pub fn sidecar(&self) -> Option<PathBuf> {
        self.out_model.as_ref().map(|out| out.with_extension("effects.toml"))
    }
}
