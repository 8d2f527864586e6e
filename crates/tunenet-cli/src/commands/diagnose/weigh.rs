//! What a search for a law says of the names that the diagnosis gave.

use tunenet_core::diagnose::{Diagnosis, Doubt};
use tunenet_core::findings::NOISE_AUTOCORRELATED;
use tunenet_core::law::{self, MOST_HELD_OUT_FORCE_NATS, Settings};

use crate::answers::law::Law;

/// The diagnosis with what a search says of it: names that leave nothing but noise are in doubt where a force that decays explains more. Of a
/// search without a law, a name is in doubt where held-out recordings refuse the law that it is, and something is missing where a force is
/// left as certainly as a law may not leave one on held-out recordings.
pub fn weighed(diagnosis: Diagnosis, law: Option<&Law>) -> Diagnosis {
    let Some(found) = law.and_then(|law| law.found.as_ref().ok()) else { return diagnosis };
    let gains = found.answer.decay_bic_gain.zip(found.answer.rival_bic_gain);
    if gains.is_some_and(|(decays, named)| decays > named + Settings::default().margin) {
        return diagnosis.doubted(Doubt::DecayingForce);
    }
    if found.answer.verdict != law::Verdict::Unknown {
        return diagnosis;
    }
    let nats = found.answer.base_force_nats;
    // Residual tests know the noise better where nothing else is left.
    let is_white = diagnosis.notes.iter().all(|note| note.kind != NOISE_AUTOCORRELATED);
    if found.answer.rival_refused {
        diagnosis.doubted(Doubt::HeldOutUnexplained)
    } else if is_white && nats > MOST_HELD_OUT_FORCE_NATS {
        diagnosis
            .reopened(format!("a smooth force is left (evidence {nats:.0} nats), and no law that passes explains it"))
    } else {
        diagnosis
    }
}

/// Whether what the diagnosis leaves looks like noise.
pub fn adequate(diagnosis: &Diagnosis) -> bool {
    diagnosis.adequacy.iter().all(|test| test.passed)
}
