//! How recordings are read.

use std::path::PathBuf;

use clap::Args;
use tunenet_formats::{Selection, UnitRule};

use super::{pair, track};

/// How recordings are read, wherever a command takes observations.
#[derive(Debug, Default, Args)]
pub struct Reading {
    #[command(flatten)]
    pub numbers: Numbers,
    /// Episodes of a data set, such as 0-7 or 0,2,5 [default: all]
    #[arg(long, value_name = "NUMBERS")]
    pub episodes: Option<Selection>,
    /// True capture rate in frames per second, for slow-motion video or folders of images
    #[arg(long, value_name = "HZ", value_parser = track::positive)]
    pub camera_rate: Option<f64>,
}

/// How files of numbers are read, wherever a command takes some.
#[derive(Debug, Default, Args)]
pub struct Numbers {
    /// Map columns, such as `t_s=time,z_m=height`; use numbers from 1 for files without a header, and a minus for an axis
    /// that points the other way: `z_m=-depth`
    #[arg(long, value_name = "OURS=THEIRS,…", value_parser = pair, value_delimiter = ',')]
    pub columns: Vec<(String, String)>,
    /// Topic of a log to read [default: the only suitable one]
    #[arg(long)]
    pub topic: Option<String>,
    /// Definition of a ROS message that a log names and does not define (may be repeated)
    #[arg(long = "msg", value_name = "TYPE.msg")]
    pub definitions: Vec<PathBuf>,
    /// Units of columns whose file states none, such as `elbow=deg` or `wrist=1.0122deg`; `inspect` proposes them
    #[arg(long, value_name = "COLUMN=UNIT,…", value_parser = UnitRule::parse, value_delimiter = ',')]
    pub units: Vec<UnitRule>,
    /// Calibration file of LeRobot, which states the units of joints that a data set normalises to -100..100
    #[arg(long, value_name = "FILE.json")]
    pub calibration: Option<PathBuf>,
    /// Rows per second of a file without a time base
    #[arg(long = "rate", value_name = "HZ", value_parser = track::positive)]
    pub rate_hz: Option<f64>,
    /// Skip malformed lines of a CSV file (at most 5 %) and list them
    #[arg(long)]
    pub skip_broken: bool,
}

impl Numbers {
    /// The first of its flags that is given.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            (!self.columns.is_empty(), "--columns"),
            (self.topic.is_some(), "--topic"),
            (!self.definitions.is_empty(), "--msg"),
            (!self.units.is_empty(), "--units"),
            (self.calibration.is_some(), "--calibration"),
            (self.rate_hz.is_some(), "--rate"),
            (self.skip_broken, "--skip-broken"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }
}
