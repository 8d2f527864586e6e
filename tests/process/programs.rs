//! What the tests of programs as simulators share: programs, scenes, a swing that others reckoned, and which processes are alive.

use std::fmt::Write as _;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::common::{Folder, Noise};

pub const DRIVEN: &str = include_str!("../../assets/process/driven_pendulum.py");
pub const DRIVEN_SCENE: &str = include_str!("../../assets/process/driven_pendulum.toml");
pub const MUJOCO_CART: &str = include_str!("../../assets/process/mujoco_cart.py");
pub const MUJOCO_CART_SCENE: &str = include_str!("../../assets/process/mujoco_cart.toml");
pub const PENDULUM: &str = include_str!("../../assets/process/pendulum.py");
pub const MUJOCO: &str = include_str!("../../assets/process/mujoco_pendulum.py");
pub const PENDULUM_SCENE: &str = include_str!("../../assets/process/pendulum.toml");
pub const MUJOCO_SCENE: &str = include_str!("../../assets/process/mujoco_pendulum.toml");

/// Whether Python can do `import NAME`; says where it cannot.
pub fn python(import: &str) -> bool {
    let there =
        Command::new("python3").args(["-c", &format!("import {import}")]).output().is_ok_and(|o| o.status.success());
    if !there {
        eprintln!("skipped: no python3 that can `import {import}`");
    }
    there
}

/// A swing by the classical Runge–Kutta method, which the programs do not use: length and damping of θ'' = -g/l sin θ - d θ',
/// with `stretch` times the length for the mass that is not in one point.
pub struct Swing {
    pub length_m: f64,
    pub damping_1_s: f64,
    pub stretch: f64,
    pub noise_rad: f64,
    /// How much later than true the stamps are.
    pub late_s: f64,
    /// A torque beside the law, which no program knows: this times sin(7 t), rad/s².
    pub shaken: f64,
    pub start_rad: f64,
    /// What the sensor adds to every angle.
    pub bias_rad: f64,
    pub seed: u64,
}

impl Default for Swing {
    fn default() -> Self {
        Self {
            length_m: 0.62,
            damping_1_s: 0.24,
            stretch: 1.0,
            noise_rad: 2e-3,
            late_s: 0.0,
            shaken: 0.0,
            start_rad: 0.5,
            bias_rad: 0.0,
            seed: 7,
        }
    }
}

/// Steps of the integration from sample to sample.
pub const STEPS: u32 = 40;

impl Swing {
    pub fn csv(&self, header: &str) -> String {
        let slope = |t: f64, [angle, rate]: [f64; 2]| {
            let pull = -9.81 / (self.length_m * self.stretch) * angle.sin();
            [rate, pull - self.damping_1_s * rate + self.shaken * (7.0 * t).sin()]
        };
        let (mut state, mut noise, mut text) = ([self.start_rad, 0.0], Noise(self.seed), format!("{header}\n"));
        let h = 1.0 / (72.0 * f64::from(STEPS));
        for sample in 0..216_u32 {
            let time = f64::from(sample) / 72.0;
            writeln!(text, "{},{}", time + self.late_s, state[0] + self.bias_rad + self.noise_rad * noise.normal())
                .unwrap();
            for step in 0..STEPS {
                let t = time + f64::from(step) * h;
                let ahead = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
                let a = slope(t, state);
                let b = slope(t + h / 2.0, ahead(a, h / 2.0));
                let c = slope(t + h / 2.0, ahead(b, h / 2.0));
                let d = slope(t + h, ahead(c, h));
                state = [0, 1].map(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            }
        }
        text
    }
}

/// A folder with the pendulum's program, its scene and a swing that others reckoned.
pub fn pendulum() -> Folder {
    let folder = Folder::new();
    folder.write("pendulum.py", PENDULUM);
    folder.write("pendulum.toml", PENDULUM_SCENE);
    folder.write("swing.csv", Swing::default().csv("t_s,angle_rad"));
    folder
}

/// Beginning of a program that greets and answers with `answer`, a piece of Python with `request` and `id`.
pub fn program(answer: &str) -> String {
    format!(
        "import json, math, os, sys, time\nprint('{{\"tunenet\":1}}', flush=True)\nsys.stdin.readline()\n\
         for line in sys.stdin:\n    request = json.loads(line)\n    id, n = request['id'], len(request['times_s'])\n    \
         good = json.dumps({{'id': id, 'values': [[math.exp(-t)] for t in request['times_s']]}})\n{}",
        answer.lines().map(|line| format!("    {line}")).collect::<Vec<_>>().join("\n")
    )
}

pub const GOOD: &str = "print(good, flush=True)";

/// Whether any process still has `mark` among its arguments.
pub fn alive(mark: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<u32>() else { continue };
        let words = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        if String::from_utf8_lossy(&words).contains(mark) && pid != std::process::id() {
            found.push(String::from_utf8_lossy(&words).replace('\0', " "));
        }
    }
    found
}

/// Waits until no process has `mark` among its arguments.
#[track_caller]
pub fn gone(mark: &str) {
    let until = Instant::now() + Duration::from_secs(5);
    while !alive(mark).is_empty() {
        assert!(Instant::now() < until, "left behind: {:?}", alive(mark));
        std::thread::sleep(Duration::from_millis(20));
    }
}

pub fn scene(command: &str) -> String {
    format!(
        "kind = \"process\"\n[process]\ncommand = {command}\nchannels = [\"angle_rad\"]\ntimeout_s = 30\nstart_timeout_s = 30\n\
         [record]\nrate_hz = 20\nframes = 40\n[parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n"
    )
}
