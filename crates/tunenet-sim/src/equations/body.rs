//! What is known of the states of equations by their units and derivatives: which are positions, and which the coordinates of one body.

use tunenet_core::observation::Channel;

use super::law::Quantity;
use crate::scene::{EquationsScene, State};

/// The clock of the recording, s.
pub(crate) const CLOCK: &str = "t_s";
/// The distance of a body from the origin, and its speed, where no state has such a name.
const DISTANCE: &str = "r_m";
const SPEED: &str = "speed_m_s";

/// What is found of the states of a file.
pub(crate) struct States<'a> {
    pub names: Vec<&'a str>,
    pub units: Vec<String>,
    /// Positions of positions and of their rates.
    pub pairs: Vec<(usize, usize)>,
}

impl<'a> States<'a> {
    pub fn of(scene: &'a EquationsScene) -> Self {
        let names: Vec<&str> = scene.states.keys().map(String::as_str).collect();
        let unit = |(name, state): (&String, &State)| {
            let ending = || Channel::from_header(name).map(|channel| channel.unit);
            state.unit.clone().or_else(ending).unwrap_or_else(|| "1".into())
        };
        let rate = |name: &&str| {
            let text = scene.derivatives.get(*name)?.trim();
            names.iter().position(|other| *other == text)
        };
        let pairs = names.iter().enumerate().filter_map(|(i, name)| Some((i, rate(name)?))).collect();
        Self { units: scene.states.iter().map(unit).collect(), names, pairs }
    }

    /// Positions whose unit is a length and their rates: coordinates of one body, where there are two or three.
    pub fn body(&self) -> Option<Vec<(usize, usize)>> {
        let lengths: Vec<(usize, usize)> = self.pairs.iter().copied().filter(|(q, _)| self.units[*q] == "m").collect();
        (2..=3).contains(&lengths.len()).then_some(lengths)
    }

    /// What ranges of validity may be stated of, by name: states, the clock, and a body's distance from the origin and speed.
    pub fn quantities(&self) -> Vec<(&'a str, Quantity)> {
        let states = self.names.iter().enumerate().map(|(i, name)| (*name, Quantity::Slot(i)));
        let mut all: Vec<(&str, Quantity)> = states.chain([(CLOCK, Quantity::Slot(self.names.len()))]).collect();
        if let Some(body) = self.body() {
            let (places, speeds) = body.into_iter().unzip();
            let lengths = [(DISTANCE, Quantity::Length(places)), (SPEED, Quantity::Length(speeds))];
            all.extend(lengths.into_iter().filter(|(name, _)| !self.names.contains(name)));
        }
        all
    }
}

/// The length of a vector of states as a formula.
pub(crate) fn written_length(of: &[usize], names: &[&str]) -> String {
    let squares: Vec<String> = of.iter().map(|i| format!("{}^2", names[*i])).collect();
    format!("sqrt({})", squares.join(" + "))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::SimulationFile;

    fn quantities(states: &str) -> Vec<(String, Quantity)> {
        let mut text = String::from("kind = \"equations\"\n[parameters.k]\nvalue = 1.0\nmin = 0.0\nmax = 2.0\n");
        for name in states.split(' ') {
            writeln!(text, "[states.{name}]\n[start.{name}]\nvalue = 0.5").unwrap();
        }
        text.push_str("[derivatives]\nx_m = \"u_m_s\"\ny_m = \"w_m_s\"\nu_m_s = \"0*k\"\nw_m_s = \"0\"\n");
        let file = SimulationFile::parse("body.toml".as_ref(), &text).expect("equations");
        let scene = file.equations().expect("equations").clone();
        States::of(&scene).quantities().into_iter().map(|(name, of)| (name.to_owned(), of)).collect()
    }

    /// Of two positions in m, distance and speed are known by name as well.
    #[test]
    fn a_body_in_the_plane_has_a_distance_and_a_speed() {
        let found = quantities("x_m y_m u_m_s w_m_s");
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["x_m", "y_m", "u_m_s", "w_m_s", "t_s", "r_m", "speed_m_s"]);
        assert_eq!(found[4].1, Quantity::Slot(4));
        assert_eq!((&found[5].1, &found[6].1), (&Quantity::Length(vec![0, 1]), &Quantity::Length(vec![2, 3])));
    }
}
