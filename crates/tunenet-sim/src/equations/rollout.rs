//! A rollout: from the start to the last instant, in steps that end where an input breaks, a surface is reached or an event happens.
//! How it steps does not depend on the instants that are asked for: these are read from the dense output.

use tunenet_core::observation::Input;
use tunenet_core::simulator::{RolloutResult, Run};

use super::crossing::{ARMED, Found, Watch, first, watched};
use super::motion::Motion;
use super::runge_kutta::Stepper;
use super::signal::Signal;
use super::smoothness::tolerance;
use super::system::System;

/// Most evaluations of all derivatives in a rollout, and further ones for each instant that is asked for and each break of an input.
const MOST_EVALUATIONS: usize = 200_000;
const EVALUATIONS_PER_INSTANT: usize = 20;
const EVALUATIONS_PER_BREAK: usize = 40;
/// How often a step is shortened for what is watched within it, and how much longer the one after it may be: what is watched may change
/// fast where the states do not.
const MOST_SHORTENED: u32 = 8;
const GROWTH: f64 = 2.0;
/// A state beyond this explodes.
const GREATEST: f64 = 1e30;

/// Simulates `run` and writes its outputs, row-major `[instant, output]`.
///
/// # Errors
/// A sentence that names a state and a time where the equations explode, are not finite, or take too many steps.
pub fn rollout(system: &System, run: &Run, values: &mut [f64]) -> RolloutResult {
    let numbers = [run.parameters, run.coefficients, run.start, run.times_s];
    if !numbers.into_iter().flatten().all(|number| number.is_finite()) {
        return Err("parameters, initial states and times have to be finite".into());
    }
    let (inputs, known) = (&run.recording.inputs, system.slots.inputs.len());
    if inputs.len() != known {
        return Err(format!("the equations need {known} inputs of a recording, and it has {}", inputs.len()).into());
    }
    let answer = Answer { start_s: run.recording.start_s, times_s: run.times_s, values, next: 0 };
    Rollout::new(system, run)?.all(answer)
}

struct Rollout<'a> {
    motion: Motion<'a>,
    stepper: Stepper,
    /// Inputs and delayed inputs, in the order of the pieces of the motion.
    signals: Vec<Signal<'a>>,
    inputs: Vec<(&'a Input, f64)>,
    /// When windows of a law's terms begin and end, s; those ahead.
    windows: std::collections::VecDeque<f64>,
    watches: Vec<Watch>,
    /// The greatest magnitudes of the events' formulas.
    heights: Vec<f64>,
    scratch: (Vec<f64>, Vec<f64>),
    most_evaluations: usize,
}

impl<'a> Rollout<'a> {
    fn new(system: &'a System, run: &Run<'a>) -> Result<Self, String> {
        let start_s = run.recording.start_s;
        let start: Vec<f64> = system.starts.iter().filter_map(|i| run.start.get(*i).copied()).collect();
        if start.len() != system.states.len() {
            return Err(format!("the equations need the initial values of {} states", system.states.len()));
        }
        let mut motion = Motion::new(system, run.parameters, run.coefficients, start_s);
        let plain =
            run.recording.inputs.iter().enumerate().map(|(i, input)| (system.slots.inputs.start + i, input, 0.0));
        let mut all: Vec<(usize, &Input, f64)> = plain.collect();
        for delayed in &system.delayed {
            let by_s = delayed.by.value(&motion.values);
            if !by_s.is_finite() {
                return Err("a delay is not finite".into());
            }
            all.push((delayed.slot, &run.recording.inputs[delayed.input], by_s));
        }
        let signals: Vec<Signal> = all.iter().map(|(_, input, by_s)| Signal::new(input, start_s, *by_s)).collect();
        motion.pieces = all.iter().zip(&signals).map(|((slot, ..), signal)| (*slot, signal.piece())).collect();
        let n = start.len();
        let windows: std::collections::VecDeque<f64> = motion.window_ends().into();
        motion.window_s = start_s + windows.front().map_or(0.0, |end| 0.5 * end);
        Ok(Self {
            windows,
            stepper: Stepper::new(&start, tolerance(motion.bends())),
            signals,
            inputs: all.iter().map(|(_, input, by_s)| (*input, *by_s)).collect(),
            watches: Vec::new(),
            heights: vec![0.0; system.events.len()],
            scratch: (vec![0.0; n], vec![0.0; n]),
            most_evaluations: MOST_EVALUATIONS + EVALUATIONS_PER_INSTANT * run.times_s.len(),
            motion,
        })
    }

    /// Everything up to the last instant.
    fn all(mut self, mut answer: Answer) -> RolloutResult {
        self.start();
        while answer.next_s() < 0.0 {
            self.before(&mut answer);
        }
        let (motion, stepper) = (&mut self.motion, &mut self.stepper);
        stepper.begin(|t, y, f| motion.field(t, y, f));
        stepper.propose(|t, y, f| motion.field(t, y, f));
        while answer.next_s() < f64::INFINITY {
            self.step(&mut answer)?;
        }
        Ok(())
    }

    /// Sides and events where the motion starts.
    fn start(&mut self) {
        let mut state = self.stepper.y.clone();
        self.motion.settle(0.0, &state, None);
        for event in 0..self.motion.armed.len() {
            self.motion.begins(event, &mut state);
        }
        self.stepper.restart(0.0, &state);
        watched(&self.motion, &mut self.watches);
    }

    /// An instant before the start: the state does not move, and inputs do.
    fn before(&mut self, answer: &mut Answer) {
        let t = answer.next_s();
        self.motion.load(t, &self.stepper.y);
        for ((slot, _), (input, by_s)) in self.motion.pieces.iter().zip(&self.inputs) {
            self.motion.values[*slot] = input.at(0, self.motion.start_s + t - by_s);
        }
        answer.write(&self.motion);
    }

    /// One step that is exact enough, up to where it is interrupted.
    fn step(&mut self, answer: &mut Answer) -> Result<(), String> {
        let wish = self.stepper.proposed;
        let mut h = wish;
        let ends = self.signals.iter().map(Signal::ends).fold(f64::INFINITY, f64::min);
        let ends = self.windows.front().map_or(ends, |end| end.min(ends));
        let mut shortened = 0;
        loop {
            let t = self.stepper.t;
            let until = if t + h >= ends { ends } else { t + h };
            if until <= t {
                return Err(self.stuck("cannot be followed: it changes too fast"));
            }
            let motion = &mut self.motion;
            let exact = self.stepper.attempt(until - t, until, |t, y, f| motion.field(t, y, f));
            if motion.evaluations > self.most_evaluations {
                return Err(self.stuck("takes too many steps: the equations are stiff or change too often"));
            }
            if !exact {
                h = self.stepper.proposed;
                continue;
            }
            if !self.watches.is_empty() || answer.next_s() < until {
                self.stepper.interpolate();
            }
            let watches = (self.watches.as_slice(), shortened < MOST_SHORTENED);
            match first(motion, &self.stepper, watches, &mut self.heights, &mut self.scratch) {
                Found::TooLong => {
                    h = 0.25 * (until - t);
                    shortened += 1;
                }
                Found::Nothing => {
                    self.read(until, answer);
                    self.stepper.advance(until);
                    if !self.watches.is_empty() {
                        self.stepper.proposed = self.stepper.proposed.min(GROWTH * (until - t));
                    }
                    self.bounded()?;
                    if until == ends {
                        self.pass(until, wish);
                    } else {
                        self.arm();
                    }
                    return Ok(());
                }
                Found::Pole(event, share) => {
                    let path = &motion.system.events[event].path;
                    let at_s = motion.start_s + t + share * self.stepper.h;
                    return Err(format!("`{path}` changes its sign at {} s without being zero there", shown(at_s)));
                }
                Found::Crossing(watch, share) => {
                    let at = t + share * self.stepper.h;
                    self.read(at, answer);
                    self.cross(watch, at, share);
                    return self.bounded();
                }
            }
        }
    }

    /// Writes the instants before `until`.
    fn read(&mut self, until: f64, answer: &mut Answer) {
        let switches = self.motion.system.outputs_switch && !self.motion.constraints.is_empty();
        while answer.next_s() < until {
            let t = answer.next_s();
            let (state, field) = (&mut self.scratch.0, &mut self.scratch.1);
            self.stepper.within((t - self.stepper.t) / self.stepper.h, state);
            if switches {
                self.motion.field(t, state, field);
            }
            self.motion.load(t, state);
            answer.write(&self.motion);
        }
    }

    /// Goes on from where something crossed zero.
    fn cross(&mut self, watch: Watch, at: f64, share: f64) {
        let mut state = self.stepper.y.clone();
        self.stepper.within(share, &mut state);
        match watch {
            Watch::Surface(surface) => self.motion.settle(at, &state, Some(surface)),
            Watch::Hold(k) => {
                self.motion.field(at, &state, &mut self.scratch.0);
                self.motion.let_go(k);
                self.motion.settle(at, &state, None);
            }
            Watch::Unarmed(_) => {}
            Watch::Event(event) => {
                self.motion.armed[event] = false;
                self.motion.happens(event, at, &mut state, self.heights[event]);
            }
        }
        self.stepper.proposed = self.stepper.proposed.min(self.stepper.h);
        self.stepper.restart(at, &state);
        self.begin();
    }

    /// Goes on with the next piece of every input that ends here. Steps may be as long as before it.
    fn pass(&mut self, t: f64, wish: f64) {
        for (signal, (_, piece)) in self.signals.iter_mut().zip(&mut self.motion.pieces) {
            if signal.ends() <= t {
                self.most_evaluations += EVALUATIONS_PER_BREAK * signal.pass(t);
                *piece = signal.piece();
            }
        }
        while self.windows.front().is_some_and(|end| *end <= t) {
            self.windows.pop_front();
            self.most_evaluations += EVALUATIONS_PER_BREAK;
            self.motion.window_s = self.motion.start_s + self.windows.front().map_or(t + 1.0, |end| 0.5 * (t + end));
        }
        self.stepper.proposed = self.stepper.proposed.max(wish);
        if !self.watches.is_empty() {
            self.motion.settle(t, &self.stepper.y, None);
        }
        self.begin();
    }

    fn begin(&mut self) {
        let (motion, stepper) = (&mut self.motion, &mut self.stepper);
        stepper.begin(|t, y, f| motion.field(t, y, f));
        self.arm();
        watched(&self.motion, &mut self.watches);
    }

    /// Arms events whose formula is above zero again.
    fn arm(&mut self) {
        let events = &self.motion.system.events;
        if self.motion.armed.iter().all(|armed| *armed) {
            return;
        }
        let mut is_armed = false;
        self.motion.load(self.stepper.t, &self.stepper.y);
        for (event, of) in events.iter().enumerate() {
            let rests = self.motion.rests_on(event);
            if !self.motion.armed[event]
                && !rests
                && of.when.program.value(&self.motion.values) > ARMED * self.heights[event]
            {
                self.motion.armed[event] = true;
                is_armed = true;
            }
        }
        if is_armed {
            watched(&self.motion, &mut self.watches);
        }
    }

    /// Refuses a state that is not finite or explodes.
    fn bounded(&self) -> Result<(), String> {
        let Some(i) = self.stepper.y.iter().position(|value| value.is_nan() || value.abs() > GREATEST) else {
            return Ok(());
        };
        let name = &self.motion.system.states[i];
        Err(self.at_part().unwrap_or_else(|| format!("`{name}` grows beyond all bounds at {} s", self.time())))
    }

    /// The part of an event or of a derivative that has no finite value here or where the next step leads, where there is one.
    fn at_part(&self) -> Option<String> {
        if let Some(part) = &self.motion.unusable {
            return Some(format!("{part} at {} s", self.time()));
        }
        let system = self.motion.system;
        let (ahead, later) = self.stepper.ahead();
        [(self.stepper.y.as_slice(), 0.0), (&ahead, later)].into_iter().find_map(|(state, later)| {
            let mut values = self.motion.values.clone();
            values[..state.len()].copy_from_slice(state);
            values[system.slots.clock] += later;
            // A trial step may have been of no length that is a number.
            if !values[system.slots.clock].is_finite() {
                values = self.motion.loaded(self.stepper.t + later, state);
            }
            let mut named = system.states.iter().zip(system.written.iter());
            let (state, part) = named.find_map(|(state, formula)| Some((state, formula.undefined(&values)?)))?;
            Some(format!("`{}` in `derivatives.{state}` {} at {} s", part.text, part.what, self.time()))
        })
    }

    fn stuck(&self, why: &str) -> String {
        if let Some(sentence) = self.at_part() {
            return sentence;
        }
        format!("`{}` {why} at {} s", self.motion.system.states[self.stepper.fastest()], self.time())
    }

    /// The present instant on the recording's clock, for a message.
    fn time(&self) -> String {
        shown(self.motion.start_s + self.stepper.t)
    }
}

fn shown(seconds: f64) -> String {
    let shown = format!("{seconds:.6}");
    shown.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Instants that are asked for, and what has been written of them.
struct Answer<'a> {
    start_s: f64,
    times_s: &'a [f64],
    values: &'a mut [f64],
    next: usize,
}

impl Answer<'_> {
    /// The next instant, s since the start; infinity after the last one.
    fn next_s(&self) -> f64 {
        self.times_s.get(self.next).map_or(f64::INFINITY, |t| t - self.start_s)
    }

    /// Writes what the loaded state shows at the next instant.
    fn write(&mut self, motion: &Motion) {
        let outputs = &motion.system.outputs;
        let row = self.values[self.next * outputs.len()..].iter_mut();
        row.zip(outputs).for_each(|(value, program)| *value = program.value(&motion.values));
        self.next += 1;
    }
}
