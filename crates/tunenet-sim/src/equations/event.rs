//! Events, and impacts that pile up (Zeno behaviour; Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988):
//! where the next hop would be too short, the impact keeps nothing and a support holds the surface as long as it is pressed.

use super::motion::{Constraint, MOST_CONSTRAINTS, Motion};

/// A hop shorter than this (s) ends the bouncing: that of our ball's slowest rebound, 1e-4 m/s, under gravity.
const SHORTEST_HOP_S: f64 = 2e-5;
/// An event's formula is at zero below this share of the greatest that it was.
const AT_ZERO: f64 = 1e-9;

impl Motion<'_> {
    /// Whether impacts of an event have come to rest.
    pub fn rests_on(&self, event: usize) -> bool {
        self.constraints.contains(&Constraint::Rests(event))
    }

    /// What happens at the start of a rollout to an event whose formula is at zero there: it happens where the motion falls or presses.
    pub fn begins(&mut self, event: usize, state: &mut [f64]) {
        let (height, speed) = self.height(event, 0.0, state);
        let mut field = vec![0.0; state.len()];
        self.field(0.0, state, &mut field);
        let presses = self.lift(event, 0.0, state, &field) < 0.0;
        if height.abs() <= f64::EPSILON && (speed < 0.0 || speed == 0.0 && presses) {
            self.happens(event, 0.0, state, 0.0);
        } else {
            self.armed[event] = height > 0.0 || height == 0.0 && speed > 0.0;
        }
    }

    /// Changes the state as the event says; `greatest` is the greatest magnitude of its formula so far.
    pub fn happens(&mut self, event: usize, t: f64, state: &mut [f64], greatest: f64) {
        let (_, before) = self.height(event, t, state);
        let old = state.to_vec();
        let system = self.system;
        self.load(t, &old);
        for then in &system.events[event].then {
            state[then.state] = then.program.value(&self.values);
            if !state[then.state].is_finite() {
                let part = then.written.undefined(&self.values);
                self.unusable = part.map(|part| format!("`{}` in `{}` {}", part.text, then.path, part.what));
            }
        }
        self.settle(t, state, None);
        let (height, speed) = self.height(event, t, state);
        if height.abs() > AT_ZERO * greatest.max(f64::EPSILON) {
            self.armed[event] = height > 0.0;
            return;
        }
        let mut field = vec![0.0; state.len()];
        self.field(t, state, &mut field);
        let bend = self.lift(event, t, state, &field);
        let hop = -2.0 * speed.max(0.0) / bend;
        self.armed[event] = speed > 0.0;
        if bend < 0.0 && hop < SHORTEST_HOP_S && speed >= -AT_ZERO * before.abs() {
            let jump: Vec<f64> = state.iter().zip(&old).map(|(new, old)| new - old).collect();
            self.rests(event, t, state, &jump);
        }
    }

    /// Holds the state on the surface of an event from now on.
    fn rests(&mut self, event: usize, t: f64, state: &mut [f64], jump: &[f64]) {
        let system = self.system;
        let mut gradient = vec![0.0; state.len()];
        for i in system.events[event].then.iter().map(|then| then.state) {
            let (now, by) = (state[i], 1e-6 * (1.0 + state[i].abs()));
            state[i] = now + by;
            let above = self.height(event, t, state).1;
            state[i] = now - by;
            let below = self.height(event, t, state).1;
            state[i] = now;
            gradient[i] = (above - below) / (2.0 * by);
        }
        // An impact acts in the direction in which it changed what the speed of approach depends on.
        let along = |direction: &[f64]| -> (Vec<f64>, f64) {
            let one = |(d, g): (&f64, &f64)| if *g == 0.0 { 0.0 } else { *d };
            let own: Vec<f64> = direction.iter().zip(&gradient).map(one).collect();
            let gain = own.iter().zip(&gradient).map(|(d, g)| d * g).sum();
            (own, gain)
        };
        let (mut support, mut gain) = along(jump);
        if gain.abs() <= 1e-12 * gradient.iter().map(|g| g * g).sum::<f64>().sqrt() {
            (support, gain) = along(&gradient);
        }
        if gain == 0.0 || self.constraints.len() == MOST_CONSTRAINTS {
            return;
        }
        for one in &mut support {
            *one /= gain;
        }
        let speed = self.height(event, t, state).1;
        state.iter_mut().zip(&support).for_each(|(value, one)| *value -= speed * one);
        self.supports[event] = support;
        self.armed[event] = false;
        self.constraints.push(Constraint::Rests(event));
        self.settle(t, state, None);
    }
}
