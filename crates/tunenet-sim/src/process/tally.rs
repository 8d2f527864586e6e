//! Rollouts that a program did not simulate, counted across threads.

use std::sync::{Mutex, PoisonError};

use tunenet_core::observation::{GREATEST, Note};
use tunenet_core::simulator::Parameter;

use crate::findings;

/// Rollouts that a program was asked for, and those of them that cannot be used. A fit then tries other values, so the user has
/// to be warned.
///
/// Which rollouts are asked for follows from the work alone, and so do these counts, for any order of the threads.
#[derive(Debug, Default)]
pub(super) struct Tally(Mutex<Counted>);

#[derive(Debug, Default)]
struct Counted {
    asked: u64,
    refused: Option<Lacking>,
    beyond: Option<Lacking>,
}

/// Rollouts that cannot be used, and the one among them that is nearest to the values of the file.
#[derive(Debug)]
struct Lacking {
    rollouts: u64,
    nearest: Place,
}

#[derive(Debug)]
struct Place {
    /// From the file's values, in spans of the parameters.
    distance: f64,
    values: Vec<f64>,
    /// `length=0.2 damping=0.1`.
    at: String,
    /// What the program said or answered.
    what: String,
    /// The table of the number that is farthest from the file's value, in spans.
    farthest: String,
}

impl Place {
    fn of(parameters: &[Parameter], values: &[f64], what: &str) -> Self {
        let each = || parameters.iter().zip(values);
        let distance = each().map(|(p, v)| ((v - p.value) / p.span()).powi(2)).sum::<f64>().sqrt();
        // Coefficients have both names, and matter where their effect is there.
        let shown = each().filter(|(p, v)| !p.name.contains('.') || p.value != **v);
        let at = shown.map(|(p, v)| format!("{}={v}", p.name)).collect::<Vec<_>>().join(" ");
        let far = |(p, v): &(&Parameter, &f64)| ((*v - p.value) / p.span()).abs();
        let moved = each().filter(|one| far(one) > 0.0).max_by(|a, b| far(a).total_cmp(&far(b)));
        let farthest = moved.map_or_else(|| "[parameters.NAME]".to_owned(), |(p, _)| table(&p.name));
        Self { distance, values: values.to_vec(), at, what: what.to_owned(), farthest }
    }

    /// Whether this one is to be reported rather than `other`; of two at one distance always the same one.
    fn comes_before(&self, other: &Self) -> bool {
        let values = || self.values.iter().zip(&other.values).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne());
        let order = self.distance.total_cmp(&other.distance);
        order
            .then_with(|| values().unwrap_or(std::cmp::Ordering::Equal))
            .then_with(|| self.what.cmp(&other.what))
            .is_lt()
    }
}

/// The table of a simulation file that bounds a parameter, or a coefficient, whose name is `effect.key`.
fn table(name: &str) -> String {
    name.split_once('.').map_or_else(
        || format!("[parameters.{name}]"),
        |(effect, key)| format!("[candidates.{effect}.coefficients.{key}]"),
    )
}

/// Why a rollout cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Why {
    /// The program said that it cannot simulate these values.
    Refused,
    /// It answered an unusable number.
    Beyond,
}

impl Tally {
    /// One more rollout that was asked for.
    pub fn asked(&self) {
        self.counted(|counted| counted.asked += 1);
    }

    /// So many that an earlier run asked for.
    pub fn recalled(&self, rollouts: u64) {
        self.counted(|counted| counted.asked += rollouts);
    }

    /// That one cannot be used, and `what` was said or answered.
    pub fn lacks(&self, why: Why, parameters: &[Parameter], values: &[f64], what: &str) {
        let place = Place::of(parameters, values, what);
        self.counted(|counted| {
            let kept = match why {
                Why::Refused => &mut counted.refused,
                Why::Beyond => &mut counted.beyond,
            };
            match kept {
                None => *kept = Some(Lacking { rollouts: 1, nearest: place }),
                Some(lacking) => {
                    lacking.rollouts += 1;
                    if place.comes_before(&lacking.nearest) {
                        lacking.nearest = place;
                    }
                }
            }
        });
    }

    /// How many rollouts were asked for.
    pub fn rollouts(&self) -> u64 {
        self.counted(|counted| counted.asked)
    }

    /// What a user should know of it.
    pub fn notes(&self) -> Vec<Note> {
        let remedy = |table: &str| {
            format!(
                "narrow `min` and `max` of `{table}` to what the program can simulate, where the answer lies near that"
            )
        };
        self.counted(|counted| {
            let all = counted.asked;
            let refused = counted.refused.iter().map(|Lacking { rollouts, nearest: Place { at, what, farthest, .. } }| {
                let text = format!(
                    "the program refused {rollouts} of {all} rollouts, of these nearest to the file's values {at}: {what}"
                );
                Note::new(findings::PROGRAM_REFUSED, text, remedy(farthest))
            });
            let beyond = counted.beyond.iter().map(|Lacking { rollouts, nearest: Place { at, what, farthest, .. } }| {
                let text = format!(
                    "the program answered numbers beyond {GREATEST:e} in {rollouts} of {all} rollouts, of these nearest to the \
                     file's values {at}: {what}"
                );
                Note::new(findings::PROGRAM_BEYOND, text, remedy(farthest))
            });
            refused.chain(beyond).collect()
        })
    }

    fn counted<T>(&self, of: impl FnOnce(&mut Counted) -> T) -> T {
        of(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_do_not_depend_on_the_order_of_rollouts() {
        let parameters = ["a", "b"].map(|name| Parameter::new(name, "m", 1.0, 0.0, 4.0).unwrap());
        // The second and third lie equally far from (1, 1).
        let lacking = [([4.0, 1.0], "far"), ([0.5, 1.0], "left"), ([1.5, 1.0], "right"), ([1.0, 3.0], "far as well")];
        let notes_in = |order: [usize; 4]| {
            let tally = Tally::default();
            for i in order {
                tally.asked();
                tally.lacks(Why::Refused, &parameters, &lacking[i].0, lacking[i].1);
            }
            tally.asked();
            tally.notes()
        };
        let first = notes_in([0, 1, 2, 3]);
        assert_eq!(first.len(), 1);
        assert_eq!(
            first[0].text,
            "the program refused 4 of 5 rollouts, of these nearest to the file's values a=0.5 b=1: left"
        );
        assert!(first[0].remedy.contains("`[parameters.a]`"), "{}", first[0].remedy);
        assert!([[3, 2, 1, 0], [2, 0, 3, 1], [1, 3, 0, 2]].into_iter().all(|order| notes_in(order) == first));
        let tally = Tally::default();
        tally.asked();
        assert!(tally.notes().is_empty() && tally.rollouts() == 1);
        tally.lacks(Why::Beyond, &parameters, &[1.0, 1.0], "1e160 for `z_m` in row 1");
        assert!(
            tally.notes()[0].text.contains(
                "numbers beyond 1e100 in 1 of 1 rollouts, of these nearest to the file's values a=1 b=1: 1e160"
            )
        );
    }

    #[test]
    fn the_remedy_names_the_number_that_was_moved_farthest() {
        assert_eq!(table("gain"), "[parameters.gain]");
        assert_eq!(table("dead_zone.v"), "[candidates.dead_zone.coefficients.v]");
        let parameters = ["a", "e.k"].map(|name| Parameter::new(name, "m", 1.0, 0.0, 4.0).unwrap());
        let place = Place::of(&parameters, &[1.5, 3.0], "no");
        assert_eq!((place.farthest.as_str(), place.at.as_str()), ("[candidates.e.coefficients.k]", "a=1.5 e.k=3"));
    }
}
