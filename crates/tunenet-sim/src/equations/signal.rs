//! What drives equations, cut into pieces without a jump or a bend: a step of the integration ends where a piece does.

use tunenet_core::observation::{Hold, Input};

/// An input on the clock of the rollout (s since its start), possibly delayed, at a piece between two of its breaks.
#[derive(Debug, Clone)]
pub(super) struct Signal<'a> {
    input: &'a Input,
    start_s: f64,
    delay_s: f64,
    /// The sample at which the piece ends.
    next: usize,
}

/// A straight piece of a signal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Piece {
    pub value: f64,
    pub slope: f64,
    /// Where it has that value, s.
    pub from: f64,
}

impl Piece {
    pub fn at(&self, t: f64) -> f64 {
        self.value + self.slope * (t - self.from)
    }
}

impl<'a> Signal<'a> {
    /// An input from the start of a rollout on, `delay_s` later than it was recorded.
    pub fn new(input: &'a Input, start_s: f64, delay_s: f64) -> Self {
        let mut signal = Self { input, start_s, delay_s, next: 0 };
        signal.next = input.series().clock().partition_point(|t| (t - start_s) + delay_s <= 0.0);
        signal.skip();
        signal
    }

    fn count(&self) -> usize {
        self.input.series().clock().len()
    }

    /// When a sample acts, s.
    fn time(&self, i: usize) -> f64 {
        (self.input.series().clock()[i] - self.start_s) + self.delay_s
    }

    fn value(&self, i: usize) -> f64 {
        self.input.series().row(i)[0]
    }

    /// How fast it changes before a sample, for linear signals.
    fn slope(&self, i: usize) -> f64 {
        if i == 0 || i >= self.count() {
            return 0.0;
        }
        (self.value(i) - self.value(i - 1)) / (self.time(i) - self.time(i - 1))
    }

    /// Goes on to the sample at which it jumps or bends.
    fn skip(&mut self) {
        let before = self.next.max(1) - 1;
        let slope = self.slope(self.next);
        while self.next < self.count()
            && match self.input.hold() {
                Hold::Previous => self.value(self.next) == self.value(before),
                Hold::Linear => self.slope(self.next + 1) == slope,
            }
        {
            self.next += 1;
        }
    }

    /// Where the piece ends, s; infinity where it never does.
    pub fn ends(&self) -> f64 {
        if self.next < self.count() { self.time(self.next) } else { f64::INFINITY }
    }

    /// The present piece.
    pub fn piece(&self) -> Piece {
        let before = self.next.max(1) - 1;
        match self.input.hold() {
            Hold::Previous => Piece { value: self.value(before), slope: 0.0, from: 0.0 },
            Hold::Linear => {
                let slope = self.slope(self.next);
                Piece { value: self.value(before), slope, from: self.time(before) }
            }
        }
    }

    /// Goes on to the piece that holds from `t` on; how many breaks lie between.
    pub fn pass(&mut self, t: f64) -> usize {
        let mut passed = 0;
        while self.ends() <= t {
            self.next += 1;
            self.skip();
            passed += 1;
        }
        passed
    }
}

#[cfg(test)]
mod tests {
    use tunenet_core::observation::Channel;

    use super::*;

    fn input(hold: Hold) -> Input {
        let (clock, values) = (vec![1.0, 2.0, 3.0, 4.0, 6.0], vec![5.0, 5.0, 7.0, 9.0, 9.0]);
        Input::sampled(Channel::new("u", "V"), hold, clock, values).unwrap()
    }

    #[test]
    fn pieces_meet_the_signal_wherever_they_hold() {
        for (hold, wanted) in [(Hold::Previous, vec![3.0, 4.0]), (Hold::Linear, vec![2.0, 4.0])] {
            let input = input(hold);
            let (mut signal, mut breaks) = (Signal::new(&input, 0.5, 0.25), Vec::new());
            let mut t = 0.0;
            loop {
                let end = signal.ends().min(9.0);
                for share in [0.0, 0.3, 0.99] {
                    let at = t + share * (end - t);
                    let known = input.at(0, at + 0.5 - 0.25);
                    assert!((signal.piece().at(at) - known).abs() < 1e-12, "{hold:?} at {at}");
                }
                if end == 9.0 {
                    break;
                }
                breaks.push(end - 0.25 + 0.5);
                t = end;
                signal.pass(t);
            }
            assert_eq!(breaks, wanted, "{hold:?}");
        }
    }
}
