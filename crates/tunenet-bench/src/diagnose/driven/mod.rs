//! `tunenet bench diagnose --driven`: recordings of driven mechanisms with an effect hidden in them, each mechanism with nine
//! candidates of its user's own.
//!
//! ```text
//! plant ← cart_pole, dc_motor, two_link; plant → set → trial → results
//! ```

mod cart_pole;
mod dc_motor;
mod plant;
mod results;
mod set;
mod trial;
mod two_link;

use anyhow::Result;
use rayon::prelude::*;
use serde_json::json;

use self::plant::{CANDIDATES, Plant, Undeclared};
use self::results::DrivenResults;
use self::set::Hidden;
use self::trial::{DrivenTrial, trial};
use crate::args::{BenchDiagnose, Measured};
use crate::output::{file_of, write_all};
use crate::resume::{Store, program};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

const PURPOSE: &str = "tunenet bench diagnose --driven";
static PLANTS: [&Plant; 3] = [&cart_pole::CART_POLE, &dc_motor::DC_MOTOR, &two_link::TWO_LINK];
/// RMS of what is hidden over the noise.
const RATIOS: [f64; 3] = [3.0, 10.0, 30.0];
/// Sets of each mechanism with nothing hidden, with each candidate at each ratio, and with each undeclared effect at each ratio.
const WHOLE: Counts = Counts { clean: 100, declared: 8, undeclared: 6 };
const QUICK: Counts = Counts { clean: 6, declared: 1, undeclared: 1 };
/// Sets that are kept in one piece.
const SETS_PER_PIECE: usize = 16;

struct Counts {
    clean: u64,
    declared: u64,
    undeclared: u64,
}

/// One set to draw.
#[derive(Clone, Copy)]
struct Asked {
    plant: &'static Plant,
    hidden: Hidden,
    ratio: f64,
    number: u64,
}

pub fn run(options: &BenchDiagnose) -> Result<Exit> {
    let sets = sets(if options.quick { &QUICK } else { &WHOLE });
    let bar = progress(sets.len() as u64, "sets");
    let seed = options.common.seed;
    let one = |asked: &Asked| {
        let trial = trial(asked, PURPOSE, seed);
        bar.inc(1);
        trial
    };
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let threads = tunenet_cli::pool(options.jobs)?;
    let mut trials: Vec<DrivenTrial> = Vec::with_capacity(sets.len());
    for (number, piece) in sets.chunks(SETS_PER_PIECE).enumerate() {
        let quick = if options.quick { "quick-" } else { "" };
        let make = || threads.install(|| piece.par_iter().map(one).collect::<Result<Vec<_>>>());
        trials.extend(store.piece(&format!("driven-{quick}{number}"), make)?.into_iter().flatten());
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Diagnose(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let quick = if options.quick { " --quick" } else { "" };
    let command = format!("tunenet bench diagnose --driven{quick} --seed {seed}");
    let results = DrivenResults::new(command, seed, options.quick, trials);
    let (text, value) = (results.markdown(), serde_json::to_value(&results)?);
    write_all(
        &options.out,
        [("driven.md", text.clone()), ("goals.md", results.goals()), ("driven.json", file_of(&value))],
    )?;
    answer::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("driven.md").display().to_string());
    if options.common.json {
        print_json(&value)?;
    }
    Ok(Exit::Done)
}

/// Every set of the bench, those of one mechanism after the other.
fn sets(counts: &Counts) -> Vec<Asked> {
    let mut all = Vec::new();
    for plant in PLANTS {
        let mut ask = |hidden, ratio, count| {
            all.extend((0..count).map(|number| Asked { plant, hidden, ratio, number }));
        };
        ask(Hidden::Nothing, 0.0, counts.clean);
        for ratio in RATIOS {
            (0..CANDIDATES).for_each(|number| ask(Hidden::Declared(number), ratio, counts.declared));
            for kind in Undeclared::ALL {
                ask(Hidden::Undeclared(kind), ratio, counts.undeclared);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::diagnose::Verdict;

    /// A delay of each mechanism is named and nothing where there is nothing; the bench itself draws a thousand sets.
    #[test]
    fn a_delay_is_named_and_nothing_where_there_is_nothing() {
        for plant in PLANTS {
            let ask = |hidden, ratio| trial(&Asked { plant, hidden, ratio, number: 0 }, "test", 5).unwrap();
            let found = ask(Hidden::Declared(0), 10.0);
            assert!(found.exact(), "{found:?}");
            let clean = ask(Hidden::Nothing, 0.0);
            assert_eq!(clean.answer.as_ref().unwrap().verdict, Verdict::None, "{clean:?}");
        }
    }

    #[test]
    fn whole_runs_hold_enough_sets_for_a_share_of_one_percent() {
        let all = sets(&WHOLE);
        let count = |is: &dyn Fn(&Hidden) -> bool| all.iter().filter(|asked| is(&asked.hidden)).count();
        assert_eq!(count(&|hidden| *hidden == Hidden::Nothing), 300);
        assert_eq!(count(&|hidden| matches!(hidden, Hidden::Undeclared(_))), 324);
        assert_eq!(count(&|hidden| matches!(hidden, Hidden::Declared(_))), 648);
    }
}
