//! `tunenet bench diagnose --arm`: logs of a seven-joint arm with an effect hidden in them, by a dynamics of the bench's own.

mod set;
mod world;

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tunenet_core::diagnose::{Recording, Settings, Subject, Verdict, diagnose};
use tunenet_core::simulator::Parameter;
use tunenet_formats::write_atomically;
use tunenet_sim::ReplayedArm;
use tunenet_sim::arm::effects::ALL;
use tunenet_sim::arm::{Frame, Model, urdf};

use self::set::{ArmEffect, PAYLOAD_COM_M, draw};
use super::blind::stream;
use crate::args::{BenchDiagnose, Measured};
use crate::goals::{ARM_EXACT, ARM_FALSE_NAMES, ARM_UNKNOWN};
use crate::output::share;
use crate::resume::{Store, program};
use crate::scene::{GRAVITY_M_S2, URDF};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage, table};

const PURPOSE: &str = "tunenet bench diagnose --arm";
/// Sets of each kind.
const WHOLE: u64 = 10;
const CLEAN: u64 = 200;
const OUTSIDE: u64 = 20;
const QUICK: u64 = 1;
/// Logs that are kept in one piece.
const LOGS_PER_PIECE: usize = 8;
const NOISE_RATIOS: [f64; 3] = [0.3, 1.0, 3.0];

/// The answer to one log.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct ArmTrial {
    truth: String,
    ratio: f64,
    outside: bool,
    verdict: Verdict,
    names: Vec<String>,
}

impl ArmTrial {
    fn exact(&self) -> bool {
        self.verdict == Verdict::Named && self.names == [self.truth.as_str()]
    }

    fn in_set(&self) -> bool {
        self.exact() || self.verdict == Verdict::OneOf && self.names.contains(&self.truth)
    }
}

/// One line of the results.
#[derive(Debug, Clone, Serialize)]
struct ArmLine {
    what: String,
    sets: usize,
    exact: f64,
    in_set: f64,
    unknown: f64,
    none: f64,
}

impl ArmLine {
    fn new(what: String, trials: &[&ArmTrial]) -> Self {
        Self {
            what,
            sets: trials.len(),
            exact: share(trials, |t| t.exact()),
            in_set: share(trials, |t| t.in_set()),
            unknown: share(trials, |t| t.verdict == Verdict::Unknown),
            none: share(trials, |t| t.verdict == Verdict::None),
        }
    }

    fn cells(&self) -> Vec<String> {
        let percent = |v: f64| format!("{:.0} %", 100.0 * v);
        vec![
            self.what.clone(),
            self.sets.to_string(),
            percent(self.exact),
            percent(self.in_set),
            percent(self.unknown),
            percent(self.none),
        ]
    }
}

pub fn run(options: &BenchDiagnose) -> Result<Exit> {
    let (model, frame) = arm()?;
    let count = |whole: u64| if options.quick { QUICK } else { whole };
    let mut cells: Vec<(ArmEffect, f64, u64)> = vec![(ArmEffect::Nothing, 0.0, count(CLEAN))];
    for ratio in NOISE_RATIOS {
        cells.extend(ALL.iter().map(|e| (ArmEffect::Effect(e.name), ratio, count(WHOLE))));
    }
    cells.extend([ArmEffect::Ripple, ArmEffect::Play, ArmEffect::Drift].map(|h| (h, 1.0, count(OUTSIDE))));
    let sets: Vec<(ArmEffect, f64, u64)> =
        cells.iter().flat_map(|&(h, ratio, n)| (0..n).map(move |i| (h, ratio, i))).collect();
    let bar = progress(sets.len() as u64, "logs");
    let seed = options.common.seed;
    let one = |&(hidden, ratio, number): &(ArmEffect, f64, u64)| {
        let trial = trial(&model, &frame, hidden, ratio, seed, number);
        bar.inc(1);
        trial
    };
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let threads = tunenet_cli::pool(options.jobs)?;
    let mut trials: Vec<ArmTrial> = Vec::with_capacity(sets.len());
    for (number, piece) in sets.chunks(LOGS_PER_PIECE).enumerate() {
        let quick = if options.quick { "quick-" } else { "" };
        let make = || threads.install(|| piece.par_iter().map(one).collect::<Result<Vec<_>>>());
        trials.extend(store.piece(&format!("arm-{quick}{number}"), make)?.into_iter().flatten());
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Diagnose(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let lines = lines(&trials);
    let mut rows = vec![["hidden", "logs", "exact", "in the set", "unknown", "none"].map(String::from).to_vec()];
    rows.extend(lines.iter().map(ArmLine::cells));
    let at_least = |ratio: f64| trials.iter().filter(move |t| !t.outside && t.ratio >= ratio).collect::<Vec<_>>();
    let (large, outside): (Vec<&ArmTrial>, Vec<&ArmTrial>) =
        (at_least(1.0), trials.iter().filter(|t| t.outside).collect());
    let clean: Vec<&ArmTrial> = trials.iter().filter(|t| t.ratio == 0.0).collect();
    let named = |t: &&ArmTrial| matches!(t.verdict, Verdict::Named | Verdict::OneOf);
    let measured = [
        ("exact at the noise or above", "at least", ARM_EXACT, ArmLine::new(String::new(), &large).exact),
        ("unknown where it is in no catalogue", "at least", ARM_UNKNOWN, ArmLine::new(String::new(), &outside).unknown),
        ("any name where nothing is hidden", "at most", ARM_FALSE_NAMES, share(&clean, named)),
    ];
    let goals: Vec<_> = measured
        .iter()
        .map(|(what, relation, limit, value)| {
            let met = if *relation == "at least" { value >= limit } else { value <= limit };
            serde_json::json!({ "what": what, "relation": relation, "limit": limit, "measured": value, "met": met })
        })
        .collect();
    let quick = if options.quick { " --quick" } else { "" };
    let results = serde_json::json!({
        "schema": "tunenet.bench.diagnose.arm/1",
        "command": format!("tunenet bench diagnose --arm{quick} --seed {seed}"),
        "version": env!("CARGO_PKG_VERSION"),
        "seed": seed,
        "quick": options.quick,
        "lines": lines,
        "goals": goals,
        "trials": trials,
        "warnings": [],
    });
    std::fs::create_dir_all(&options.out)?;
    let path = options.out.join("diagnose-arm.json");
    let text = serde_json::to_string_pretty(&results)?;
    write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
    answer::text(options.common.json, &table(&rows))?;
    for (what, relation, limit, value) in measured {
        answer::text(
            options.common.json,
            &format!("  {what}: {:.1} % ({relation} {:.0} %)", 100.0 * value, 100.0 * limit),
        )?;
    }
    stage("wrote", &path.display().to_string());
    if options.common.json {
        print_json(&results)?;
    }
    Ok(Exit::Done)
}

/// The arm that comes with the tool.
fn arm() -> Result<(Model, Frame)> {
    let model = urdf::parse("jaco_robotiq.urdf".as_ref(), URDF)?.chain_to("grip")?;
    let frame = model.frame("grip")?.clone();
    Ok((model, frame))
}

fn trial(model: &Model, frame: &Frame, hidden: ArmEffect, ratio: f64, seed: u64, number: u64) -> Result<ArmTrial> {
    let mut random = stream(PURPOSE, seed, &format!("{} {ratio}", hidden.name()), number);
    let seen = draw(model, frame, hidden, ratio, &mut random);
    let fixed = |name: &str, value: f64| -> Result<Parameter> {
        Ok(Parameter { tune: false, ..Parameter::new(name, "m", value, -1.0, 1.0)? })
    };
    let [x, y, z] = PAYLOAD_COM_M;
    let parameters = vec![
        Parameter::new("payload_mass", "kg", 0.5, 0.0, 10.0)?,
        fixed("payload_com_x", x)?,
        fixed("payload_com_y", y)?,
        fixed("payload_com_z", z)?,
    ];
    let arm = ReplayedArm::new(model.clone(), frame.clone(), GRAVITY_M_S2, parameters)?;
    let subject = Subject { name: "arm".into(), simulator: &arm };
    let recording = Recording { name: "log".into(), object: 0, held_out: false, seen: &seen };
    let found = diagnose(&[subject], &[recording], &Settings::default(), &|_| {})?;
    let outside = matches!(hidden, ArmEffect::Ripple | ArmEffect::Play | ArmEffect::Drift);
    let names = if found.verdict() == Verdict::OneOf {
        found.names()
    } else {
        found.effects().iter().map(|e| e.effect.name.as_ref()).collect()
    };
    let names = names.into_iter().map(str::to_owned).collect();
    Ok(ArmTrial { truth: hidden.name().into(), ratio, outside, verdict: found.verdict(), names })
}

fn lines(trials: &[ArmTrial]) -> Vec<ArmLine> {
    let mut keys: Vec<(&str, f64)> = Vec::new();
    for trial in trials {
        if !keys.contains(&(trial.truth.as_str(), trial.ratio)) {
            keys.push((&trial.truth, trial.ratio));
        }
    }
    let line = |(truth, ratio): (&str, f64)| {
        let those: Vec<&ArmTrial> = trials.iter().filter(|t| t.truth == truth && t.ratio == ratio).collect();
        ArmLine::new(format!("{truth}, {ratio} σ"), &those)
    };
    keys.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One log of each kind that is neither weak nor rare; the bench itself draws hundreds.
    #[test]
    fn hidden_effects_are_named() {
        let (model, frame) = arm().unwrap();
        let ask = |hidden, ratio| trial(&model, &frame, hidden, ratio, 7, 0).unwrap();
        let clean = ask(ArmEffect::Nothing, 0.0);
        assert_eq!(clean.verdict, Verdict::None, "{clean:?}");
        for effect in ALL {
            let found = ask(ArmEffect::Effect(effect.name), 1.0);
            assert!(found.exact(), "{found:?}");
        }
        for outside in [ArmEffect::Ripple, ArmEffect::Play, ArmEffect::Drift] {
            let found = ask(outside, 1.0);
            assert_eq!(found.verdict, Verdict::Unknown, "{found:?}");
        }
    }
}
