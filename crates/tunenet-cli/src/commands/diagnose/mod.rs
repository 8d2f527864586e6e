//! `tunenet diagnose`: where simulation and measurement disagree, which effect is missing, and the file with it.
//!
//! ```text
//! sources → load → ask (tunenet_ball::diagnose), law, weigh → improve, crate::view::{json, text, html}
//! ```

mod ask;
mod improve;
mod law;
mod law_start;
mod load;
mod outputs;
mod sources;
mod weigh;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use serde_json::json;
use tunenet_core::diagnose::{Diagnosis, Verdict};
use tunenet_core::findings::RECORDINGS_ODD;
use tunenet_core::observation::Note;
use tunenet_sim::SimulationFile;

use super::each::{Answered, Work};
use super::models;
use super::odd_units::odd_units;
use crate::answers::diagnose::{Answer, Loaded};
use crate::answers::improved::edits;
use crate::args::{Diagnose, pool};
use crate::exit_status::Exit;
use crate::files::hash;
use crate::files::manifest::Source;
use crate::view::html;
use crate::view::json::diagnose as json;
use crate::view::text::diagnose as text;
use crate::view::text::stage;
use ask::ask;

pub fn run(options: &Diagnose) -> Result<Exit> {
    options.apart.check(options.each)?;
    if options.each {
        return each(options);
    }
    let sources = sources::sources(options)?;
    outputs::writable(options, &sources)?;
    let loaded = load::load(options, &sources)?;
    models::check(&options.models, &loaded.objects[0].file, loaded.objects.len())?;
    text::read(&loaded);
    let began = Instant::now();
    let mut diagnosis = pool(options.jobs)?.install(|| ask(&loaded, &options.settings()))?;
    diagnosis.notes.extend(units(&loaded, &diagnosis));
    diagnosis.notes.extend(super::load::left_out(&loaded.objects[0].file)?);
    let (seconds, re_asks) = (began.elapsed().as_secs_f64(), loaded.re_asks());
    let law = law::search_law(options, &loaded, &diagnosis)?;
    let diagnosis = weigh::weighed(diagnosis, law.as_ref());
    let answer = Answer { loaded: &loaded, diagnosis: &diagnosis, seconds, re_asks, law: law.as_ref() };
    let wrote = improve::write(options, &answer)?;
    improve::write_models(options, &answer)?;
    if let Some(path) = improve::write_ranges(options, &answer)? {
        stage("ranges", &path.display().to_string());
    }
    text::answer(&answer).show(options.common.json, || json::object(&answer))?;
    text::end(options.out.as_deref(), options.common.seed, &answer, &wrote);
    if let Some(path) = &options.report {
        let edits = edits(&SimulationFile::read(&options.simulation.sim)?, &answer)?;
        html::diagnose::write(path, &answer, &edits, &outputs::provenance(options, &sources))?;
        stage("report", &path.display().to_string());
    }
    Ok(answer.verdict().into())
}

/// What is said of units where the answer is open, or a recording disagrees with the others.
fn units(loaded: &Loaded, diagnosis: &Diagnosis) -> Vec<Note> {
    let open = matches!(diagnosis.verdict(), Verdict::Unknown | Verdict::OneOf);
    if !open && diagnosis.notes.iter().all(|note| note.kind != RECORDINGS_ODD) {
        return Vec::new();
    }
    let of = |object: usize| {
        // What a ball does along an axis may differ from throw to throw by any factor, and its units are checked by its fall.
        let declares = loaded.objects[object].file.domain().declares();
        let own = loaded.recorded.iter().filter(|one| declares && one.object == object);
        odd_units(&own.map(|one| (one.name.as_str(), &one.seen)).collect::<Vec<_>>())
    };
    (0..loaded.objects.len()).flat_map(of).collect()
}

/// Each recording on its own.
fn each(options: &Diagnose) -> Result<Exit> {
    // Refused once and as in `tune`, not once for every recording.
    let (file, _) = super::load::simulation_with(&options.simulation, options.permission)?;
    let reference = options.reference.as_deref().map(hash::sha256).transpose()?;
    let run = json!({
        "simulation": file.text(), "urdf": super::load::urdf_hash(&options.simulation)?,
        "reading": format!("{:?}", options.reading), "reference": reference, "seed": options.common.seed,
        "quick": options.quick, "max_rollouts": options.max_rollouts,
    });
    let (observation, jobs, json) = (&options.observation, options.jobs, options.common.json);
    let (apart, overwrite) = (&options.apart, options.writing.overwrite);
    let alone = |path: &Path| [Source::alone(path, file.domain().name(), options.reference.clone())];
    let inputs = observation.iter().map(|path| outputs::input_files(options, &alone(path))).collect();
    let work = Work { tool: "diagnose", observation, inputs, apart, jobs, json, overwrite, run };
    let (exit, _) = work.run::<()>(&|path, _| {
        let sources = alone(path);
        let loaded = load::load(options, &sources)?;
        let began = Instant::now();
        let diagnosis = ask(&loaded, &options.settings())?;
        let (seconds, re_asks) = (began.elapsed().as_secs_f64(), loaded.re_asks());
        let law = law::search_law(options, &loaded, &diagnosis)?;
        let diagnosis = weigh::weighed(diagnosis, law.as_ref());
        let answer = Answer { loaded: &loaded, diagnosis: &diagnosis, seconds, re_asks, law: law.as_ref() };
        Ok(Answered { object: json::object(&answer), line: text::sentence(&answer), case: None })
    })?;
    Ok(exit)
}
