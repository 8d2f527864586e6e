//! `tunenet bench rollouts`: how many rollouts a tuning takes, and how many scipy and `mujoco.sysid` take for the same.
//!
//! ```text
//! runge_kutta → cart, arm; cosines; drop → problem (tune, python) → results (table)
//! ```

mod arm;
mod cart;
mod cosines;
mod drop;
mod problem;
mod python;
mod results;

use anyhow::Result;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

use self::problem::Problem;
use self::results::markdown;
use crate::args::BenchRollouts;
use crate::goals;
use crate::output::{file_of, write_all};
use crate::scene::seeds;

pub fn run(options: &BenchRollouts) -> Result<Exit> {
    let seed = options.common.seed;
    let problems = problems(seed)?;
    let bar = progress(problems.len() as u64, "problems");
    let mut rows = Vec::with_capacity(problems.len());
    for problem in problems {
        rows.push(problem.compare()?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let text = markdown(&format!("tunenet bench rollouts --seed {seed}"), &rows);
    let object = json!({ "schema": "tunenet.bench.rollouts/1", "seed": seed, "problems": rows, "warnings": [] });
    std::fs::create_dir_all(&options.out)?;
    write_all(&options.out, [("rollouts.md", text.clone()), ("rollouts.json", file_of(&object))])?;
    answer::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("rollouts.md").display().to_string());
    if options.common.json {
        print_json(&object)?;
    }
    Ok(Exit::Done)
}

fn problems(seed: u64) -> Result<Vec<Problem>> {
    let seed = seed.wrapping_add(seeds::ROLLOUTS);
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    Ok(vec![
        cart::problem(1, goals::CART_ROLLOUTS, &mut draw, seed)?,
        cart::problem(6, goals::CARTS_ROLLOUTS, &mut draw, seed)?,
        arm::problem(goals::TWO_LINK_ROLLOUTS, &mut draw)?,
        cosines::problem(goals::COSINES_ROLLOUTS, &mut draw)?,
        drop::problem(goals::BALL_ROLLOUTS)?,
    ])
}
