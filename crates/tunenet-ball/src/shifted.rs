//! An outlying level: the one recording whose surface was estimated far from where all others have it.

use tunenet_core::diagnose::{Diagnosis, Explained};
use tunenet_core::observation::Note;
use tunenet_core::statistics::median;

use crate::findings;

/// The nuisance parameter that is the height of the surface where no file states it.
const HEIGHT: &str = "surface.height";
/// Of fewer other recordings, two levels are as likely as one that is shifted.
const LEAST_OTHERS: usize = 3;
/// A level is shifted that lies so many times the range of the others, and so many times the noise, from their median.
const RANGES: f64 = 10.0;
const NOISES: f64 = 3.0;

/// A warning for each object of which one recording is shifted in height; nothing of surfaces whose height is known.
pub(crate) fn shifted(diagnosis: &Diagnosis) -> Vec<Note> {
    let objects = diagnosis.explained.iter().map(|one| one.object + 1).max().unwrap_or(0);
    (0..objects).filter_map(|object| of_object(diagnosis.explained.iter().filter(|one| one.object == object))).collect()
}

fn of_object<'a>(explained: impl Iterator<Item = &'a Explained>) -> Option<Note> {
    let level = |one: &'a Explained| one.nuisances.iter().find(|(name, ..)| name == HEIGHT).map(|(_, m, _)| (one, *m));
    let mut levels: Vec<(&Explained, f64)> =
        explained.filter(|one| one.segment.is_none()).map(level).collect::<Option<_>>()?;
    levels.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (lowest, highest) = (levels.first()?, levels.last()?);
    let middle_m = median(levels.iter().map(|(_, m)| *m))?;
    let (odd, others) = if highest.1 - middle_m > middle_m - lowest.1 {
        (highest, &levels[..levels.len() - 1])
    } else {
        (lowest, &levels[1..])
    };
    if others.len() < LEAST_OTHERS {
        return None;
    }
    let (range_m, others_m) = (others[others.len() - 1].1 - others[0].1, median(others.iter().map(|(_, m)| *m))?);
    let noise_m = odd.0.noise.iter().copied().fold(0.0, f64::max);
    let off_m = odd.1 - others_m;
    if off_m.abs() <= (RANGES * range_m).max(NOISES * noise_m) {
        return None;
    }
    let (name, count, way) = (&odd.0.name, others.len(), if off_m > 0.0 { "above" } else { "below" });
    let text = format!(
        "{name}: the surface lies {:.1} mm {way} that of the other {count} recordings; every recording was fitted with a height of its own",
        1e3 * off_m.abs()
    );
    Some(Note::new(findings::SURFACE_SHIFTED, text, "check the origin and the calibration of z in this recording"))
}
