//! A set as a user has it: a simulation file that lacks the law, and a CSV file for each recording.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::json;

use super::arena::{Arena, RADIUS_M, SOFT_M};
use super::set::{BlindSet, Recorded};
use crate::output::file_of;

/// The files of a set.
pub struct Files {
    pub folder: PathBuf,
    pub simulation: PathBuf,
    pub fitted: Vec<PathBuf>,
    pub held_out: Vec<PathBuf>,
}

impl Files {
    /// Writes a set to `folder`; `truth.json` in it is for people, no part of what the tool gets.
    pub fn write(folder: &Path, set: &BlindSet) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("creating {}", folder.display()))?;
        let keep = |name: &str, text: String| -> Result<PathBuf> {
            let path = folder.join(name);
            std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
            Ok(path)
        };
        let arena = set.world.base.arena;
        let simulation = keep("simulation.toml", simulation(arena, set.noise))?;
        let all = |kind: &str, recorded: &[Recorded]| -> Result<Vec<PathBuf>> {
            let one = |(i, one): (usize, &Recorded)| keep(&format!("{kind}_{}.csv", i + 1), table(set, one));
            recorded.iter().enumerate().map(one).collect()
        };
        let (fitted, held_out) = (all("fitted", &set.fitted)?, all("held_out", &set.held_out)?);
        all("faster", &set.faster)?;
        keep("truth.json", file_of(&json!({ "world": set.world, "noise": set.noise })))?;
        Ok(Self { folder: folder.into(), simulation, fitted, held_out })
    }
}

/// The columns of a recording, with those of its input.
fn columns(arena: Arena) -> &'static str {
    match arena {
        Arena::Flight => "time_s,x_m,y_m,z_m",
        Arena::Plane | Arena::Centre => "time_s,x_m,y_m",
        Arena::Pendulum => "time_s,q_rad,u_rad_s2",
    }
}

fn table(set: &BlindSet, recorded: &Recorded) -> String {
    let channels = set.world.base.arena.channels();
    let mut out = format!("{}\n", columns(set.world.base.arena));
    for (i, (t, row)) in set.clock.iter().zip(recorded.values.chunks_exact(channels)).enumerate() {
        let _ = write!(out, "{t}");
        row.iter().chain(recorded.run.input.get(i)).for_each(|value| {
            let _ = write!(out, ",{value}");
        });
        out.push('\n');
    }
    out
}

/// What a user knows: the base model without the values of its parameters.
fn simulation(arena: Arena, noise: f64) -> String {
    let plane = |derivatives: &str, parameters: &str| {
        format!(
            "kind = \"equations\"\n\n[states.x_m]\n[states.y_m]\n[states.vx_m_s]\n[states.vy_m_s]\n\n\
             [derivatives]\nx_m = \"vx_m_s\"\ny_m = \"vy_m_s\"\n{derivatives}\n\
             [outputs]\nx_m = \"x_m\"\ny_m = \"y_m\"\n\n\
             [start.x_m]\nvalue = \"first\"\nsd = {noise}\n[start.y_m]\nvalue = \"first\"\nsd = {noise}\n\
             [start.vx_m_s]\nvalue = 0.0\nmin = -10.0\nmax = 10.0\n[start.vy_m_s]\nvalue = 0.0\nmin = -10.0\nmax = 10.0\n\
             {parameters}"
        )
    };
    match arena {
        Arena::Flight => format!(
            "kind = \"ball\"\nworld.gravity_m_s2 = {}\nball.radius_m = {RADIUS_M}\nsurface.height_m = 0.0\n\
             release.time_s = 0.0\n\n\
             [parameters.restitution]\nvalue = 0.5\nmin = 0.0\nmax = 1.0\n\n\
             [parameters.friction]\nvalue = 0.0\nmin = 0.0\nmax = 2.0\ntune = false\n",
            crate::scene::GRAVITY_M_S2
        ),
        Arena::Plane => plane(
            "vx_m_s = \"-damping*vx_m_s\"\nvy_m_s = \"-damping*vy_m_s\"\n",
            "\n[parameters.damping]\nvalue = 0.1\nmin = -1.0\nmax = 5.0\nunit = \"1/s\"\n",
        ),
        Arena::Centre => {
            let central = |axis: &str| format!("v{axis}_m_s = \"-strength*{axis}_m/(x_m^2 + y_m^2 + soft_m^2)\"\n");
            plane(
                &format!("{}{}", central("x"), central("y")),
                &format!(
                    "\n[constants]\nsoft_m = {SOFT_M}\n\n\
                     [parameters.strength]\nvalue = 1.0\nmin = 0.1\nmax = 5.0\nunit = \"m2/s2\"\n"
                ),
            )
        }
        Arena::Pendulum => format!(
            "kind = \"equations\"\n\n[states.q_rad]\n[states.dq_rad_s]\n\n\
             [derivatives]\nq_rad = \"dq_rad_s\"\ndq_rad_s = \"u_rad_s2 - stiffness*sin(q_rad) - damping*dq_rad_s\"\n\n\
             [outputs]\nq_rad = \"q_rad\"\n\n[inputs.u_rad_s2]\nhold = \"linear\"\n\n\
             [start.q_rad]\nvalue = \"first\"\nsd = {noise}\n[start.dq_rad_s]\nvalue = 0.0\nmin = -20.0\nmax = 20.0\n\n\
             [parameters.stiffness]\nvalue = 20.0\nmin = 5.0\nmax = 60.0\nunit = \"1/s2\"\n\
             [parameters.damping]\nvalue = 0.2\nmin = 0.0\nmax = 5.0\nunit = \"1/s\"\n"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::predict::Improved;
    use crate::law::set::{Hidden, Recipe, stream};

    /// The simulation file of each arena is the base model of the bench: two integrators that share nothing agree.
    #[test]
    fn the_simulation_file_is_the_base_model() {
        for arena in [Arena::Flight, Arena::Plane, Arena::Centre, Arena::Pendulum] {
            let recipe = Recipe { hidden: Hidden::Nothing(arena), ratio: 0.0, colour: 0.0, outliers: 0.0 };
            let set = BlindSet::draw(&recipe, &mut stream("test", 1, recipe.hidden.name(), 0)).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let files = Files::write(folder.path(), &set).unwrap();
            assert_eq!((files.fitted.len(), files.held_out.len()), (3, 2));
            let mut improved = Improved::open(&files.simulation).unwrap();
            improved.set(&set.world.base);
            for one in set.fitted.iter().chain(&set.faster) {
                let found = improved.seen(&set, one, &one.run.start).unwrap();
                let worst = found.iter().zip(set.world.seen(&one.run, &set.clock)).map(|(a, b)| (a - b).abs());
                let worst = worst.fold(0.0, f64::max);
                assert!(worst < 2e-6, "{arena:?}: {worst}");
            }
        }
    }

    #[test]
    fn a_table_has_a_row_for_each_stamp() {
        let hidden = Hidden::Nothing(Arena::Pendulum);
        let recipe = Recipe { hidden, ratio: 0.0, colour: 0.0, outliers: 0.0 };
        let set = BlindSet::draw(&recipe, &mut stream("test", 1, "table", 0)).unwrap();
        let text = table(&set, &set.fitted[0]);
        assert!(text.starts_with("time_s,q_rad,u_rad_s2\n0,") && text.lines().count() == 201, "{text}");
        assert!(text.lines().all(|line| line.split(',').count() == 3));
    }
}
