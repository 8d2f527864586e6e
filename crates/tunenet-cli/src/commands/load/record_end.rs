//! Where the clock of `[record]` and the inputs that drive it do not end together.

use tunenet_core::observation::{Note, Observation, with_decimals};
use tunenet_formats::{Recording, findings};
use tunenet_sim::SimulationFile;

/// `driven`, which has no more samples than its inputs last: what is too long is `[record]`, `whole`, and no recording.
pub fn ended(mut driven: Recording, whole: &Observation) -> Recording {
    let before = driven.notes.len();
    driven.notes.retain(|note| note.kind != findings::INPUT_SHORT);
    if driven.notes.len() < before {
        let (clock, used) = (whole.clock(), driven.observation.len());
        let [last_s, end_s] =
            [clock[used - 1] - clock[0], clock[clock.len() - 1] - clock[0]].map(|t| with_decimals(t, 2));
        let text = format!(
            "the inputs end after {last_s} s, and [record] at {end_s} s (`record.frames` over `record.rate_hz`): {used} of {} \
             samples are simulated",
            clock.len()
        );
        let remedy = format!("to end with the inputs: `--set record.frames={used}`");
        driven.notes.push(Note::new(findings::INPUT_SHORT, text, remedy));
    }
    driven
}

/// That inputs go on after the last sample of `[record]`, both counted from its first one.
pub fn goes_on(file: &SimulationFile, longest_s: f64, end_s: f64) -> Option<Note> {
    let record = file.record();
    if longest_s <= end_s + 1.5 / record.rate_hz {
        return None;
    }
    let (last, end) = (with_decimals(longest_s, 2), with_decimals(end_s, 2));
    let text = format!("the inputs go on to {last} s, and [record] ends at {end} s: what comes later is not simulated");
    let frames = (longest_s * record.rate_hz).floor() + 1.0;
    let remedy = format!("to simulate all of them: `--set record.frames={frames}`");
    Some(Note::new(findings::INPUT_LONG, text, remedy))
}

#[cfg(test)]
mod tests {
    use tunenet_core::observation::{Channel, Kind};

    use super::*;

    #[test]
    fn what_is_longer_than_the_inputs_is_the_record() {
        let clock: Vec<f64> = (0..5).map(f64::from).collect();
        let whole = Observation::new(Kind::Other, vec![Channel::new("a", "m")], clock, vec![0.0; 5]).unwrap();
        let short =
            Note::new(findings::INPUT_SHORT, "`u` ends 2.000 s before the recording", "record the input to the end");
        let driven = Recording { observation: whole.slice(0..3).unwrap(), notes: vec![short] };
        let noted = ended(driven, &whole).notes;
        let text = "the inputs end after 2 s, and [record] at 4 s (`record.frames` over `record.rate_hz`): 3 of 5 samples are simulated";
        assert_eq!((noted.len(), noted[0].text.replace(".00", "").as_str()), (1, text));
        assert_eq!(noted[0].remedy, "to end with the inputs: `--set record.frames=3`");
        assert!(ended(Recording { observation: whole.clone(), notes: Vec::new() }, &whole).notes.is_empty());
    }
}
