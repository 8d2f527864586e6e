//! Searches a law where it is asked for, or where no known effect explains the recordings.

use std::time::Instant;

use anyhow::Result;
use tunenet_core::diagnose::{Diagnosis, Verdict};
use tunenet_core::law::{Named, Settings, has_noise, search};
use tunenet_core::simulator::{Preparation, Prepared, Simulator, measurement_effects};

use super::law_start::named;
use super::weigh::adequate;
use crate::answers::diagnose::Loaded;
use crate::answers::law::{Found, Law};
use crate::args::Diagnose;

/// The search that these options and this diagnosis ask for; nothing where they ask for none.
pub fn search_law(options: &Diagnose, loaded: &Loaded, diagnosis: &Diagnosis) -> Result<Option<Law>> {
    let open = match diagnosis.verdict() {
        Verdict::Unknown => true,
        Verdict::Named | Verdict::OneOf => !adequate(diagnosis),
        Verdict::None | Verdict::Insufficient => false,
    };
    // Without recordings that agree and others that confirm it, no law is an answer.
    let count = |held_out: bool| diagnosis.uses.iter().filter(|one| one.used && one.held_out == held_out).count();
    let by_itself = open && count(false) > 1 && count(true) > 0;
    if !options.law && !by_itself {
        return Ok(None);
    }
    let began = Instant::now();
    if options.quick || options.max_rollouts.is_some() {
        let found = Err("not searched: `--quick` and `--max-rollouts` leave out the search for a law");
        let unknown = diagnosis.verdict() == Verdict::Unknown;
        return Ok(unknown.then_some(Law { asked: true, seconds: 0.0, found }));
    }
    let found = match searched(options, loaded, diagnosis) {
        Ok(found) => found,
        // A search that nobody asked for does not end a diagnosis.
        Err(_) if !options.law => return Ok(None),
        Err(error) => return Err(error),
    };
    if !options.law && found.is_err() {
        return Ok(None);
    }
    Ok(Some(Law { asked: options.law, seconds: began.elapsed().as_secs_f64(), found }))
}

fn searched(
    options: &Diagnose,
    loaded: &Loaded,
    diagnosis: &Diagnosis,
) -> Result<std::result::Result<Found, &'static str>> {
    let [object] = loaded.objects.as_slice() else {
        return Ok(Err("a law is searched in recordings of one object only"));
    };
    if diagnosis.verdict() == Verdict::Insufficient {
        return Ok(Err("the recordings do not suffice for a law"));
    }
    let present = object.file.effects();
    let present: Vec<&str> = present.iter().map(|effect| effect.name.as_str()).collect();
    let kind = loaded.recorded[0].seen.kind();
    let host = match tunenet_sim::law::host(&object.setups.iter().collect::<Vec<_>>(), kind, &present)? {
        Ok(host) => host,
        Err(why) => return Ok(Err(why)),
    };
    let base = host.carrying(&[])?;
    let (mut fitted, mut held_out): (Vec<Prepared>, Vec<Prepared>) = (Vec::new(), Vec::new());
    let mut names = Vec::new();
    for (recorded, used) in loaded.recorded.iter().zip(&diagnosis.uses) {
        if let (true, Preparation::Usable(prepared)) = (used.used, base.prepare(&recorded.seen)?) {
            if used.held_out {
                held_out.push(*prepared);
            } else {
                fitted.push(*prepared);
                names.push(recorded.name.clone());
            }
        }
    }
    if fitted.is_empty() {
        return Ok(Err("no recording can be used for a law"));
    }
    if !fitted.iter().chain(&held_out).all(has_noise) {
        return Ok(Err("no channel of a recording changes, so nothing shows how large its noise is"));
    }
    let effects = diagnosis.effects();
    let competes = effects.iter().all(|one| base.with_effects(&[one.effect.name.as_ref()]).is_ok());
    let rival_explains = adequate(diagnosis);
    let apart = !competes && rival_explains;
    let mut rival: Vec<Named> = if competes { effects.iter().map(named).collect() } else { Vec::new() };
    // In the order in which a simulator takes their coefficients.
    let of_measurement = measurement_effects(kind);
    rival.sort_by_key(|one| of_measurement.iter().any(|effect| effect.name == one.name));
    let known = tunenet_sim::law::known(diagnosis, base.parameters(), &fitted);
    let settings = Settings { rival, rival_explains, apart, known, ..Settings::default() };
    let working = crate::view::text::working("searching a law");
    let answer = crate::args::pool(options.jobs)?.install(|| search(host.as_ref(), &fitted, &held_out, &settings));
    working.finish_and_clear();
    Ok(Ok(Found { answer: answer?, names, parameters: base.parameters().to_vec() }))
}
