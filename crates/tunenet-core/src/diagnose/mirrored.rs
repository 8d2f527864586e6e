//! Unknowns that turn a motion out of the plane that was measured, to either side alike.
//!
//! Of a ball seen along x and z alone, spin about an axis within the picture pushes it across, and then pushes what has become
//! of that back along x: a braking of second order, which drag would have to share with a spin that nobody saw. To first
//! order nothing is known of such an unknown, and it stays at its guess.

use super::joint::Point;
use super::sets::Set;
use super::study::Study;
use crate::Result;

/// How far from its guess an unknown is tried, as a share of its range.
const TRIED: f64 = 0.05;
/// Two sides are alike where they differ by less than this share of what either does.
const ALIKE: f64 = 1e-6;

impl Study<'_> {
    /// Holds such unknowns at their guesses, before anything is fitted.
    pub fn hold_mirrored(&mut self, held_out: &mut [Set]) -> Result<()> {
        let mirrored = self.mirrored(&self.sets)?;
        hold(&mut self.sets, &mirrored);
        let mirrored = self.mirrored(held_out)?;
        hold(held_out, &mirrored);
        Ok(())
    }

    /// For each recording: which of its own unknowns are such.
    fn mirrored(&self, sets: &[Set]) -> Result<Vec<Vec<bool>>> {
        let none = |set: &Set| vec![false; set.prepared.own.len()];
        let mut found: Vec<Vec<bool>> = sets.iter().map(none).collect();
        if sets.iter().all(|set| set.unmeasured().is_empty()) {
            return Ok(found);
        }
        let structure = self.structure(&[])?;
        let joint = super::joint::Joint { structure: &structure, sets, rollouts: &self.rollouts };
        let guess = Point {
            globals: structure.globals.iter().map(|g| g.parameter.value).collect(),
            own: sets.iter().map(|s| s.prepared.own_values()).collect(),
        };
        // What cannot be simulated from the guesses is left to the fit.
        let Ok(still) = joint.residuals(&guess, 1.0) else { return Ok(found) };
        for i in 0..found.iter().map(Vec::len).max().unwrap_or(0) {
            let moved = |direction: f64| {
                let mut point = guess.clone();
                for (own, set) in point.own.iter_mut().zip(sets) {
                    let Some(unknown) = set.prepared.own.get(i) else { continue };
                    let room = (unknown.max - own[i]).min(own[i] - unknown.min);
                    own[i] += direction * room.min(TRIED * unknown.span());
                }
                joint.residuals(&point, 1.0)
            };
            let (Ok(more), Ok(less)) = (moved(1.0), moved(-1.0)) else { continue };
            for (d, set) in sets.iter().enumerate().filter(|(_, set)| i < set.prepared.own.len()) {
                let differ = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                let (one, sides) = (differ(&more[d], &still[d]), differ(&more[d], &less[d]));
                found[d][i] = !set.unmeasured().is_empty() && one > 0.0 && sides < ALIKE * one;
            }
        }
        Ok(found)
    }
}

fn hold(sets: &mut [Set], mirrored: &[Vec<bool>]) {
    for (set, mirrored) in sets.iter_mut().zip(mirrored) {
        for i in (0..mirrored.len()).filter(|&i| mirrored[i]) {
            set.hold(i);
        }
    }
}
