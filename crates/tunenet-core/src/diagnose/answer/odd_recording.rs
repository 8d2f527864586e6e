//! Leave one out: the one recording that disagrees with all others is named, and the answer is that of the others.

use crate::Result;
use crate::diagnose::answer::Verdict;
use crate::diagnose::pipeline::{Explanation, Problem, Strategy};
use crate::findings;
use crate::observation::Note;

/// Leaves out the one recording that disagrees with all others, where these are explained without it.
pub struct OddRecording;

impl Strategy for OddRecording {
    fn applies(&self, _: &Problem, so_far: &Explanation) -> bool {
        so_far.odd.is_some() && so_far.diagnosis.verdict() == Verdict::Unknown
    }

    fn attempt(&self, problem: &Problem, so_far: &Explanation) -> Result<Option<Explanation>> {
        let Some(odd) = so_far.odd else { return Ok(None) };
        let mut explained = problem.without(odd)?;
        let answer = &mut explained.diagnosis;
        if matches!(answer.verdict(), Verdict::Unknown | Verdict::Insufficient) {
            return Ok(None);
        }
        let fitted = problem.recordings().iter().filter(|one| !one.held_out()).count();
        let name = answer.uses[odd].name.clone();
        let text =
            format!("{name} disagrees with the other {} recordings that were fitted, and is left out", fitted - 1);
        let note = Note::new(findings::RECORDINGS_ODD, text, "check its object, units and frame rate");
        answer.uses[odd].used = false;
        answer.uses[odd].notes.push(note.clone());
        answer.notes.push(note);
        Ok(Some(explained))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::swing;
    use crate::diagnose::{Recording, Settings, Subject, diagnose_with};
    use crate::testing::{Exact, Pendulum};

    /// Where the odd one is held out, those that were fitted show nothing missing, and the answer is not that nothing is.
    #[test]
    fn a_swing_of_another_pendulum_that_is_held_out_is_named() {
        let pendulum = Exact::new(Pendulum);
        let subjects = [Subject { name: "it".into(), simulator: &pendulum }];
        for (last, verdict) in [(0.8, Verdict::None), (0.9, Verdict::Unknown)] {
            let seen: Vec<_> =
                (0u32..).zip([0.8, 0.8, 0.8, last]).map(|(k, length)| swing(&[("length", length)], k)).collect();
            let one = |(i, seen)| Recording { name: format!("swing {i}"), object: 0, held_out: i == 3, seen };
            let recordings: Vec<Recording> = seen.iter().enumerate().map(one).collect();
            let found = diagnose_with(&[], &subjects, &recordings, &Settings::default(), &|_| {}).unwrap();
            let said = found.notes.iter().any(|note| note.text.starts_with("swing 3, which is held out, disagrees"));
            assert_eq!((found.verdict(), said), (verdict, verdict == Verdict::Unknown), "{:?}", found.notes);
        }
    }

    #[test]
    fn the_swing_of_another_pendulum_is_named_and_left_out() {
        let pendulum = Exact::new(Pendulum);
        let lengths = [0.8, 0.8, 0.9, 0.8, 0.8];
        let seen: Vec<_> = (0u32..).zip(lengths).map(|(k, length)| swing(&[("length", length)], k)).collect();
        let subjects = [Subject { name: "it".into(), simulator: &pendulum }];
        let one = |(i, seen)| Recording { name: format!("swing {i}"), object: 0, held_out: false, seen };
        let recordings: Vec<Recording> = seen.iter().enumerate().map(one).collect();
        let settings = Settings { set_aside: false, ..Settings::default() };
        let answer = |list: &[&dyn Strategy]| diagnose_with(list, &subjects, &recordings, &settings, &|_| {}).unwrap();
        assert_eq!(answer(&[]).verdict(), Verdict::Unknown);
        let found = answer(&[&OddRecording]);
        assert_eq!(found.verdict(), Verdict::None);
        assert!(found.uses.iter().enumerate().all(|(i, one)| one.used == (i != 2)));
        assert!(found.notes.iter().any(|note| note.text.starts_with("swing 2 disagrees with the other 4")));
        assert!((found.parameters[0].value - 0.8).abs() < 1e-3);
    }
}
