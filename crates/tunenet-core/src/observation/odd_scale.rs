//! Recordings whose channel varies by another order of magnitude than in the others, by the ratio of its standard deviation to their
//! median: degrees among radians, millivolts among volts.

use super::Observation;
use crate::statistics::median;

/// A ratio of at least this or its reciprocal is odd: degrees are 57 times as many as radians.
const ODD: f64 = 20.0;
/// The others have to agree to within this factor.
const ALIKE: f64 = 5.0;

/// A channel or an input of one recording on another scale than in the others.
#[derive(Debug, Clone, PartialEq)]
pub struct OddScale {
    /// The recording's position.
    pub recording: usize,
    /// The name of the channel or input, with its unit.
    pub header: String,
    /// Its standard deviation over the median of the others.
    pub ratio: f64,
}

/// Channels and inputs whose standard deviation is at least 20 times that of all other recordings, or at most a twentieth of it. Of two
/// recordings, the one that varies more is named.
#[must_use]
pub fn odd_scales(recordings: &[&Observation]) -> Vec<OddScale> {
    let all: Vec<Vec<(String, f64)>> = recordings.iter().map(|seen| deviations(seen)).collect();
    let mut found = Vec::new();
    for (recording, own) in all.iter().enumerate() {
        for (header, deviation) in own {
            let others = all.iter().enumerate().filter(|(i, _)| *i != recording);
            let others = others.filter_map(|(_, other)| Some(other.iter().find(|(name, _)| name == header)?.1));
            let others: Vec<f64> = others.filter(|other| *other > 0.0).collect();
            let Some(middle) = median(others.iter().copied()).filter(|_| *deviation > 0.0) else { continue };
            let alike = others.iter().all(|other| (ALIKE.recip()..=ALIKE).contains(&(other / middle)));
            let ratio = deviation / middle;
            let odd = ratio >= ODD || ratio <= ODD.recip() && others.len() > 1;
            if odd && alike {
                found.push(OddScale { recording, header: header.clone(), ratio });
            }
        }
    }
    found
}

/// The standard deviation of every channel and input of a recording.
fn deviations(seen: &Observation) -> Vec<(String, f64)> {
    let of = |series: &Observation| {
        let one = |c: usize| (series.channels()[c].header(), deviation(&series.column(c).collect::<Vec<_>>()));
        (0..series.channels().len()).map(one).collect::<Vec<_>>()
    };
    let inputs = seen.circumstances().map_or(&[][..], |known| &known.inputs);
    of(seen).into_iter().chain(inputs.iter().flat_map(|input| of(input.series()))).collect()
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Circumstances, Hold, Input, Kind};

    fn recording(scale: f64, volts: f64) -> Observation {
        let clock: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let angle = clock.iter().map(|t| scale * t.sin()).collect();
        let drive = clock.iter().map(|t| volts * (2.0 * t).cos()).collect();
        let input = Input::sampled(Channel::new("volt", "V"), Hold::Linear, clock.clone(), drive).unwrap();
        let seen = Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], clock, angle).unwrap();
        seen.under(Circumstances::driven_by(vec![input]))
    }

    fn found(all: &[Observation]) -> Vec<(usize, String)> {
        let all: Vec<&Observation> = all.iter().collect();
        odd_scales(&all).into_iter().map(|one| (one.recording, one.header)).collect()
    }

    #[test]
    fn degrees_among_radians_and_millivolts_among_volts_are_found() {
        let all = [recording(0.3, 5.0), recording(0.5f64.to_degrees(), 5.0), recording(0.4, 4000.0)];
        assert_eq!(found(&all), [(1, "angle_rad".to_owned()), (2, "volt_v".to_owned())]);
        // Of two, the larger; radians among degrees are too few.
        assert_eq!(found(&all[..2]), [(1, "angle_rad".to_owned())]);
        let few = [recording(20.0, 5.0), recording(30.0, 5.0), recording(0.4, 4.0)];
        assert_eq!(found(&few), [(2, "angle_rad".to_owned())]);
    }

    #[test]
    fn motions_of_several_sizes_are_not_odd() {
        let sizes = [0.1, 1.0, 3.0, 0.5];
        assert_eq!(found(&sizes.map(|size| recording(size, 5.0 * size))), []);
        // Where the others do not agree either, none is the odd one.
        assert_eq!(found(&[recording(0.01, 1.0), recording(1.0, 1.0), recording(50.0, 1.0)]), []);
        assert_eq!(found(&[recording(0.0, 1.0), recording(1.0, 1.0)]), []);
    }
}
