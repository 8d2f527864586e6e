//! `tunenet plan`.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use tunenet_sim::shot::reach::Anywhere;
use tunenet_sim::shot::{self, ArmReach, Belief, NoPlan, Reach, Rule, Settings, ShotScene, Task};

use super::load;
use crate::answers::plan::{Answer, notice};
use crate::args::{Plan, PlanRule};
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::names;
use crate::view::html;
use crate::view::json::plan::object as plan_json;
use crate::view::text::plan::printout;
use crate::view::text::stage;

pub fn run(options: &Plan) -> Result<Exit> {
    let out = options.out.iter().map(|out| Output::new(out, "--out", Product::Unmarked));
    let report = options.report.iter().map(|report| Output::new(report, "--report", Product::Page));
    let outputs: Vec<Output> = out.chain(report).collect();
    let inputs = [options.simulation.sim.as_path(), options.task.as_path()];
    options.out.iter().try_for_each(|out| names::require_ending(out, "--out", &["mcap"]))?;
    destination::check(&outputs, &inputs, options.writing.overwrite)?;
    let file = load::simulation(&options.simulation)?;
    if file.domain() != Domain::Ball {
        let other = match file.domain() {
            Domain::Arm => "an arm",
            Domain::Equations => "equations",
            Domain::Robot => "robot joints",
            _ => "a program",
        };
        let message = format!("expected the tuned simulation of a ball (`kind = \"ball\"`), found that of {other}");
        let hint = "give the ball's file with --sim; an arm that lets the ball go stands in the task file, under [arm]";
        return Err(Error::file(file.path(), message, hint).into());
    }
    let task = Task::read(&options.task)?;
    let answer = answer(options, &file, &task)?;
    if let Some(out) = &options.out {
        if answer.plan.reachable {
            write_approach(&answer, &options.task, out)?;
        } else {
            // Nobody may send an arm to a release that is known to miss.
            stage("kept", &format!("{} is not written: no height brings the ball through", out.display()));
        }
    }
    if let Some(report) = &options.report {
        let read = [options.simulation.sim.as_path(), options.task.as_path()];
        let provenance = html::Provenance::new(options.common.seed, &read);
        html::shot::write(report, &names::file_name(&options.task), &answer, &provenance)?;
        stage("report", &report.display().to_string());
    }
    printout(&answer).show(options.common.json, || plan_json(&answer))?;
    let count = answer.plan.candidates.len();
    stage("planned", &format!("{count} heights, {:.1} s, seed {}", answer.seconds, answer.settings.seed));
    Ok(if answer.plan.reachable { Exit::Done } else { Exit::Inconclusive })
}

fn answer(options: &Plan, file: &SimulationFile, task: &Task) -> Result<Answer> {
    let began = Instant::now();
    let refused = |message: String, remedy: &str| Error::file(&options.task, message, remedy);
    let radius_m = file.ball()?.ball.radius_m;
    let scene = ShotScene::new(task, radius_m).map_err(|e| refused(e.message, e.remedy))?;
    let belief = Belief::new(file, task)?;
    let settings = Settings {
        heights: options.heights as usize,
        rule: if options.rule == PlanRule::Nearest { Rule::Nearest } else { Rule::Probability },
        draws: options.draws as usize,
        seed: options.common.seed,
    };
    let arm = task.arm.as_ref().map(ArmReach::new).transpose()?;
    let reach: &dyn Reach = arm.as_ref().map_or(&Anywhere, |arm| arm);
    let plan = shot::plan(&scene, &belief, task.release.heights_m, reach, &settings).map_err(|error| match error {
        NoPlan::OutOfReach { .. } => refused(
            error.to_string(),
            "move `arm.base_position_m`, or let `release.heights_m` be heights that it reaches",
        ),
        NoPlan::NotFollowed { .. } => refused(error.to_string(), "correct the task file"),
        NoPlan::Other(other) => other.into(),
    })?;
    let mut notes = belief.notes().to_vec();
    notes.extend(notice(&plan, task));
    let seconds = began.elapsed().as_secs_f64();
    Ok(Answer { scene, belief, arm, plan, settings, notes, seconds })
}

/// Writes the arm's way to the release.
fn write_approach(answer: &Answer, task: &Path, out: &Path) -> Result<()> {
    let Some(arm) = &answer.arm else {
        let message = "expected a robot for --out, found no [arm]";
        return Err(Error::file(task, message, "add [arm] with its `urdf`, or leave `--out` out").into());
    };
    let best = answer.plan.best();
    let way = arm.approach([0.0, 0.0, best.height_m], best.joints_rad.as_deref().unwrap_or_default());
    tunenet_formats::write_approach(arm.base_name(), &arm.joint_names(), &way, out)?;
    stage("wrote", &format!("{}, {} points", out.display(), way.len()));
    Ok(())
}
