//! What was noticed in the recordings that drive a simulation.

use tunenet_core::observation::Note;
use tunenet_formats::Recording;

/// Each note once: of several recordings, with how many of them it concerns, or with the name of the only one.
pub fn of_all(recordings: &[(String, Recording)]) -> Vec<Note> {
    let mut all: Vec<(&Note, usize, &str)> = Vec::new();
    for (name, recording) in recordings {
        for note in &recording.notes {
            match all.iter_mut().find(|(known, ..)| *known == note) {
                Some((_, count, _)) => *count += 1,
                None => all.push((note, 1, name)),
            }
        }
    }
    let text = |text: &str, count: usize, name: &str| match (recordings.len(), count) {
        (1, _) => text.to_owned(),
        (_, 1) => format!("{name}: {text}"),
        (whole, count) => format!("{text} ({count} of {whole} recordings)"),
    };
    all.into_iter().map(|(note, count, name)| Note { text: text(&note.text, count, name), ..note.clone() }).collect()
}

#[cfg(test)]
mod tests {
    use tunenet_core::observation::{Channel, Kind, Observation};
    use tunenet_formats::findings;

    use super::*;

    #[test]
    fn a_note_of_many_recordings_is_said_once() {
        let note = |text: &str| Note::new(findings::COLUMNS_IGNORED, text, "");
        let clock = vec![0.0, 1.0, 2.0];
        let seen = Observation::new(Kind::Other, vec![Channel::new("a", "m")], clock, vec![0.0; 3]).unwrap();
        let recording = |name: &str, notes: &[&str]| {
            let notes = notes.iter().map(|text| note(text)).collect();
            (name.to_owned(), Recording { observation: seen.clone(), notes })
        };
        let several = [recording("r1", &["x"]), recording("r2", &["x", "y"])];
        let texts =
            |recordings: &[(String, Recording)]| of_all(recordings).into_iter().map(|n| n.text).collect::<Vec<_>>();
        assert_eq!(texts(&several), ["x (2 of 2 recordings)", "r2: y"]);
        assert_eq!(texts(&several[1..]), ["x", "y"]);
    }
}
