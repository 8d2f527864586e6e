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

use self::set::{Hidden, PAYLOAD_COM_M, draw};
use super::blind::stream;
use crate::args::{BenchDiagnose, Measured};
use crate::resume::Store;
use crate::resume::program;
use tunenet_cli::failure::Exit;
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
const PIECE: usize = 8;
const RATIOS: [f64; 3] = [0.3, 1.0, 3.0];
/// Goals: exact names at or above the noise, unknown where it is in no catalogue, any name where nothing is hidden.
const EXACT: f64 = 0.95;
const UNKNOWN: f64 = 0.95;
const FALSE: f64 = 0.01;

/// The answer to one log.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Trial {
    truth: String,
    ratio: f64,
    outside: bool,
    verdict: Verdict,
    names: Vec<String>,
}

impl Trial {
    fn exact(&self) -> bool {
        self.verdict == Verdict::Named && self.names == [self.truth.as_str()]
    }

    fn in_set(&self) -> bool {
        self.exact() || self.verdict == Verdict::OneOf && self.names.contains(&self.truth)
    }
}

/// One line of the results.
#[derive(Debug, Clone, Serialize)]
struct Line {
    what: String,
    sets: usize,
    exact: f64,
    in_set: f64,
    unknown: f64,
    none: f64,
}

impl Line {
    fn of(what: String, trials: &[&Trial]) -> Self {
        let share =
            |is: &dyn Fn(&Trial) -> bool| trials.iter().filter(|t| is(t)).count() as f64 / trials.len().max(1) as f64;
        Self {
            what,
            sets: trials.len(),
            exact: share(&Trial::exact),
            in_set: share(&Trial::in_set),
            unknown: share(&|t| t.verdict == Verdict::Unknown),
            none: share(&|t| t.verdict == Verdict::None),
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
    let mut cells: Vec<(Hidden, f64, u64)> = vec![(Hidden::Nothing, 0.0, count(CLEAN))];
    for ratio in RATIOS {
        cells.extend(ALL.iter().map(|e| (Hidden::Effect(e.name), ratio, count(WHOLE))));
    }
    cells.extend([Hidden::Ripple, Hidden::Play, Hidden::Drift].map(|h| (h, 1.0, count(OUTSIDE))));
    let sets: Vec<(Hidden, f64, u64)> =
        cells.iter().flat_map(|&(h, ratio, n)| (0..n).map(move |i| (h, ratio, i))).collect();
    let bar = progress(sets.len() as u64, "logs");
    let seed = options.common.seed;
    let one = |&(hidden, ratio, number): &(Hidden, f64, u64)| {
        let trial = trial(&model, &frame, hidden, ratio, seed, number);
        bar.inc(1);
        trial
    };
    // The version alone would not tell a rebuilt program from the one that made a piece.
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let threads = tunenet_cli::pool(options.jobs)?;
    let mut trials: Vec<Trial> = Vec::with_capacity(sets.len());
    for (number, piece) in sets.chunks(PIECE).enumerate() {
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
    rows.extend(lines.iter().map(Line::cells));
    let at_least = |ratio: f64| trials.iter().filter(move |t| !t.outside && t.ratio >= ratio).collect::<Vec<_>>();
    let (large, outside): (Vec<&Trial>, Vec<&Trial>) = (at_least(1.0), trials.iter().filter(|t| t.outside).collect());
    let clean: Vec<&Trial> = trials.iter().filter(|t| t.ratio == 0.0).collect();
    let named = |t: &&&Trial| matches!(t.verdict, Verdict::Named | Verdict::OneOf);
    let measured = [
        ("exact at the noise or above", "at least", EXACT, Line::of(String::new(), &large).exact),
        ("unknown where it is in no catalogue", "at least", UNKNOWN, Line::of(String::new(), &outside).unknown),
        (
            "any name where nothing is hidden",
            "at most",
            FALSE,
            clean.iter().filter(named).count() as f64 / clean.len() as f64,
        ),
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
    let text = include_str!("../../../../../assets/jaco_robotiq.urdf");
    let model = urdf::parse("jaco_robotiq.urdf".as_ref(), text)?.chain_to("grip")?;
    let frame = model.frame("grip")?.clone();
    Ok((model, frame))
}

fn trial(model: &Model, frame: &Frame, hidden: Hidden, ratio: f64, seed: u64, number: u64) -> Result<Trial> {
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
    let arm = ReplayedArm::new(model.clone(), frame.clone(), 9.81, parameters)?;
    let subject = Subject { name: "arm".into(), simulator: &arm };
    let recording = Recording { name: "log".into(), object: 0, held_out: false, seen: &seen };
    let found = diagnose(&[subject], &[recording], &Settings::default(), &|_| {})?;
    let outside = matches!(hidden, Hidden::Ripple | Hidden::Play | Hidden::Drift);
    let names = if found.verdict == Verdict::OneOf {
        found.names
    } else {
        found.effects.iter().map(|e| e.effect.name).collect()
    };
    let names = names.into_iter().map(str::to_owned).collect();
    Ok(Trial { truth: hidden.name().into(), ratio, outside, verdict: found.verdict, names })
}

fn lines(trials: &[Trial]) -> Vec<Line> {
    let mut keys: Vec<(&str, f64)> = Vec::new();
    for trial in trials {
        if !keys.contains(&(trial.truth.as_str(), trial.ratio)) {
            keys.push((&trial.truth, trial.ratio));
        }
    }
    let line = |(truth, ratio): (&str, f64)| {
        let those: Vec<&Trial> = trials.iter().filter(|t| t.truth == truth && t.ratio == ratio).collect();
        Line::of(format!("{truth}, {ratio} σ"), &those)
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
        let clean = ask(Hidden::Nothing, 0.0);
        assert_eq!(clean.verdict, Verdict::None, "{clean:?}");
        for effect in ALL {
            let found = ask(Hidden::Effect(effect.name), 1.0);
            assert!(found.exact(), "{found:?}");
        }
        for outside in [Hidden::Ripple, Hidden::Play, Hidden::Drift] {
            let found = ask(outside, 1.0);
            assert_eq!(found.verdict, Verdict::Unknown, "{found:?}");
        }
    }
}
