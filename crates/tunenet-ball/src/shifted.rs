//! An outlier by the range of the others: the one recording whose surface was estimated far from where all others have it.

use tunenet_core::diagnose::{Diagnosis, Explained};
use tunenet_core::observation::Note;
use tunenet_core::statistics::median;

use crate::findings;

/// The nuisance parameter that is the height of the surface where no file states it.
const HEIGHT: &str = "surface.height";
/// Of fewer other recordings, two levels are as likely as one that is shifted.
const LEAST_OTHERS: usize = 3;
/// A shifted level lies farther from the median of the others than so many times their range, and than so many times the noise.
const RANGES: f64 = 10.0;
const NOISES: f64 = 3.0;

/// A warning for each object of which one recording is shifted in height; nothing of surfaces whose height is known.
pub(crate) fn shifted(diagnosis: &Diagnosis) -> Vec<Note> {
    let objects = diagnosis.explained.iter().map(|one| one.object + 1).max().unwrap_or(0);
    let of =
        |object: usize| diagnosis.explained.iter().filter(move |one| one.object == object && one.segment.is_none());
    (0..objects).filter_map(|object| of_object(&of(object).collect::<Vec<_>>())).collect()
}

fn of_object(recordings: &[&Explained]) -> Option<Note> {
    let level = |one: &&Explained| one.nuisances.iter().find(|(name, ..)| name == HEIGHT).map(|(_, m, _)| *m);
    let levels_m: Vec<f64> = recordings.iter().map(level).collect::<Option<_>>()?;
    let (odd, off_m) = outlier(&levels_m)?;
    let odd = recordings[odd];
    let noise_m = odd.noise.iter().copied().fold(0.0, f64::max);
    if off_m.abs() <= NOISES * noise_m {
        return None;
    }
    let (name, others, way) = (&odd.name, recordings.len() - 1, if off_m > 0.0 { "above" } else { "below" });
    let text = format!(
        "{name}: the surface lies {:.1} mm {way} that of the other {others} recordings; every recording was fitted with a height of its own",
        1e3 * off_m.abs()
    );
    Some(Note::new(findings::SURFACE_SHIFTED, text, "check the origin and the calibration of z in this recording"))
}

/// The position of the one level (m) that lies far outside the range of all others, and how far it is from their median.
fn outlier(levels_m: &[f64]) -> Option<(usize, f64)> {
    let middle_m = median(levels_m.iter().copied())?;
    let off = |m: f64| (m - middle_m).abs();
    let odd = (0..levels_m.len()).max_by(|&a, &b| off(levels_m[a]).total_cmp(&off(levels_m[b])))?;
    let others = || levels_m.iter().enumerate().filter(|(at, _)| *at != odd).map(|(_, m)| *m);
    let range_m = others().fold(f64::NEG_INFINITY, f64::max) - others().fold(f64::INFINITY, f64::min);
    let off_m = levels_m[odd] - median(others())?;
    (others().count() >= LEAST_OTHERS && off_m.abs() > RANGES * range_m).then_some((odd, off_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_level_far_from_the_others_is_an_outlier() {
        let (odd, off_m) = outlier(&[0.0, 0.001, 0.04, 0.0005]).unwrap();
        assert_eq!(odd, 2);
        assert!((off_m - 0.0395).abs() < 1e-12, "{off_m}");
        let (odd, off_m) = outlier(&[-0.03, 0.0, 0.001, 0.0005]).unwrap();
        assert!(odd == 0 && (off_m + 0.0305).abs() < 1e-12, "{off_m}");
    }

    #[test]
    fn levels_that_all_differ_and_two_of_each_have_no_outlier() {
        for levels_m in [&[0.0, 0.01, 0.02, 0.04][..], &[0.0, 0.0, 0.04, 0.04], &[0.0, 0.0, 0.04], &[0.0], &[]] {
            assert_eq!(outlier(levels_m), None, "{levels_m:?}");
        }
    }
}
