//! A joint as a first-order lag of its delayed commands with a gain, an offset and a limit of its speed, fitted by least squares: the
//! model that came with the recordings of the arm.

use std::path::Path;

use anyhow::{Context, Result};
use tunenet_core::observation::Channel;
use tunenet_core::statistics::mean;
use tunenet_formats::{ReadOptions, UnitRule, read};

use super::asked;
use super::table::{column, paired};
use crate::process;

/// Delays, s, and limits of the speed, rad/s, at which searches start; the best of them counts.
const DELAYS_S: [f64; 3] = [0.03, 0.05, 0.08];
const FASTEST_RAD_S: [f64; 3] = [2.0, 4.0, 20.0];

/// One joint of a data set.
pub struct LaggedJoint<'a> {
    pub name: &'a str,
    /// The data set, in which its commands are called `action.NAME`.
    pub data: &'a Path,
    /// `--units` of all joints.
    pub units: &'a str,
}

impl LaggedJoint<'_> {
    /// The root mean square in rad that the model leaves of an episode of so many frames, fitted to the `others`, such as `0,2-3`; what the
    /// tool is given and says stays in `folder`.
    ///
    /// # Errors
    /// Where the tool gives no answer.
    pub fn held_out_rad(&self, others: &str, held_out: &str, frames: u64, folder: &Path) -> Result<f64> {
        let file = folder.join("lagged.toml");
        std::fs::write(&file, self.file())?;
        let file = file.display().to_string();
        let (data, units) = (self.data.display().to_string(), self.own_units());
        let mut best: Option<(f64, Vec<String>)> = None;
        for delay in DELAYS_S {
            for fastest in FASTEST_RAD_S {
                let late = format!("parameters.late.value={delay}");
                let fastest = format!("parameters.fastest.value={fastest}");
                let words =
                    ["tune", "--json", "--quiet", "--sim", &file, "--set", &late, "--set", &fastest, "--units", &units];
                let answer = asked(&[&words[..], &["--episodes", others, &data]].concat(), folder)?;
                let left = answer["iterations"].as_array().and_then(|all| all.last()?["rmse"].as_f64());
                let left = left.context("expected `iterations` with `rmse`")?;
                if best.as_ref().is_none_or(|(least, _)| left < *least) {
                    let values = answer["parameters"].as_object().context("expected `parameters`")?;
                    let set = |(name, one): (&String, &serde_json::Value)| {
                        Some(format!("parameters.{name}.value={}", one["value"].as_f64()?))
                    };
                    best = Some((left, values.iter().filter_map(set).collect()));
                }
            }
        }
        let (_, values) = best.context("expected an answer")?;
        let (episode, out) = (self.data.join(held_out), folder.join("lagged.csv"));
        let (inputs, written) = (episode.display().to_string(), out.display().to_string());
        let count = format!("record.frames={frames}");
        let mut words =
            vec!["simulate", "--quiet", "--overwrite", "--sim", &file, "--inputs", &inputs, "--units", &units];
        words.extend(["--out", &written, "--set", &count]);
        words.extend(values.iter().flat_map(|value| ["--set", value]));
        process::run(&words)?;
        let channel = format!("{}_rad", self.name);
        let (clock, seen) = self.measured(&episode)?;
        let pairs = paired((&clock, &seen), (&column(&out, "t_s")?, &column(&out, &channel)?));
        Ok(mean(pairs.iter().map(|(seen, simulated)| (seen - simulated).powi(2))).sqrt())
    }

    /// The stamps, s, and the positions, rad, of an episode.
    fn measured(&self, episode: &Path) -> Result<(Vec<f64>, Vec<f64>)> {
        let rule = UnitRule::parse(&self.own_units()).map_err(anyhow::Error::msg)?;
        let channels = vec![Channel::new(self.name, "rad")];
        let seen = read(episode, &ReadOptions { units: vec![rule], channels, ..ReadOptions::default() })?.observation;
        Ok((seen.clock().to_vec(), seen.column(0).collect()))
    }

    /// The one of `--units` that is about it.
    fn own_units(&self) -> String {
        let start = format!("{}=", self.name);
        self.units.split(',').find(|one| one.starts_with(&start)).unwrap_or(&start).to_owned()
    }

    /// The simulation file.
    fn file(&self) -> String {
        let name = self.name;
        let number = |name: &str, value: f64, [min, max]: [f64; 2], unit: &str| {
            format!("[parameters.{name}]\nvalue = {value:?}\nmin = {min:?}\nmax = {max:?}\nunit = \"{unit}\"\n")
        };
        [
            format!("kind = \"equations\"\n[states.{name}_rad]\n[derivatives]\n"),
            format!(
                "{name}_rad = \"clamp((gain*delay({name}_goal_rad, late) + offset - {name}_rad)/lag, -fastest, fastest)\"\n"
            ),
            format!("[inputs.{name}_goal_rad]\ncolumn = \"action.{name}\"\nhold = \"linear\"\n"),
            format!("[start.{name}_rad]\nvalue = \"first\"\n[record]\nrate_hz = 30.0\nframes = 300\n"),
            number("gain", 1.0, [0.5, 1.5], "1"),
            number("offset", 0.0, [-0.5, 0.5], "rad"),
            number("lag", 0.09, [0.01, 0.5], "s"),
            number("late", 0.05, [0.0, 0.3], "s"),
            number("fastest", 4.0, [0.2, 20.0], "rad/s"),
        ]
        .concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_a_joint_is_one_and_its_unit_is_its_own() {
        let joint = LaggedJoint { name: "elbow", data: Path::new("data"), units: "pan=2deg,elbow=0.5deg" };
        assert_eq!(joint.own_units(), "elbow=0.5deg");
        let file = tunenet_sim::SimulationFile::parse(Path::new("lagged.toml"), &joint.file());
        assert!(file.is_ok(), "{file:?}");
    }
}
