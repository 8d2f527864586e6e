//! What the process tests share: a folder that goes away, the binary run in it, and a ball's drop from formulas alone.

pub mod recorded;

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A scene that leaves release and floor to the data.
pub const SCENE: &str = "\
kind = \"ball\"

[ball]
radius_m = 0.02

[parameters.restitution]
value = 0.5
min = 0.0
max = 1.0
";

/// A complete scene with few frames.
pub const DROP: &str = "\
kind = \"ball\"

[ball]
radius_m = 0.02

[surface]
height_m = 0.0

[release]
height_m = 1.0
velocity_m_s = [0.0, 0.0, 0.0]
time_s = 0.0

[record]
rate_hz = 100.0
frames = 200

[parameters.restitution]
value = 0.7
min = 0.0
max = 1.0
";

/// The scene of the sets of other engines.
pub const PEERS_BALL: &str = "\
kind = \"ball\"
ball.radius_m = 0.5
surface.height_m = 0.0

[parameters.restitution]
value = 0.5
min = 0.0
max = 1.0
";

/// A ball's scene without a word about its start.
pub fn ball(radius_m: f64, mass_kg: Option<f64>) -> String {
    let mass = mass_kg.map(|m| format!("ball.mass_kg = {m}\n")).unwrap_or_default();
    format!(
        "kind = \"ball\"\nball.radius_m = {radius_m}\n{mass}\n[parameters.restitution]\nvalue = 0.8\nmin = 0.0\nmax = 1.0\n"
    )
}

/// A manifest in which every file is an object of its own.
pub fn each_its_own(files: &[PathBuf]) -> String {
    let one =
        |(i, path): (usize, &PathBuf)| format!("[[observation]]\nfile = '{}'\nobject = \"ball {i}\"\n", path.display());
    files.iter().enumerate().map(one).collect()
}

/// Writes a script that can be run.
#[cfg(unix)]
pub fn executable(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::write(path, script).expect("a script");
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).expect("permissions");
}

/// How a process ended.
pub struct Ran {
    /// Its exit status; `None` where a signal ended it.
    pub code: Option<i32>,
    /// Its standard output.
    pub stdout: String,
    /// Its standard error.
    pub stderr: String,
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        let ran = Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("standard output is UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("standard error is UTF-8"),
        };
        assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
        ran
    }
}

impl Ran {
    /// Checks the exit status.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// The one JSON object on standard output.
    #[track_caller]
    pub fn json(&self) -> Value {
        let value: Value =
            serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e} in:\n{}\n{}", self.stdout, self.stderr));
        assert!(value.is_object(), "{value}");
        value
    }
}

/// The codes of an answer's warnings.
pub fn codes(json: &Value) -> Vec<&str> {
    json["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

/// A JSON text without what differs from run to run: how long it took, and how often programs were tested.
pub fn timeless(text: &[u8]) -> Vec<u8> {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(object) => {
                object.retain(|key, _| !key.contains("seconds") && !key.ends_with("_s_spent") && key != "re_asks");
                object.values_mut().for_each(strip);
            }
            Value::Array(all) => all.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value: Value = serde_json::from_slice(text).expect("JSON");
    strip(&mut value);
    value.to_string().into_bytes()
}

/// A temporary folder that commands run in, so that every path in their output is a bare name.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// With [`SCENE`] as `scene.toml`.
    pub fn with_scene() -> Self {
        let folder = Self::new();
        folder.write("scene.toml", SCENE);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("a file in a temporary folder");
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Everything in it, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a readable folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The binary, to be run here.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tunenet"));
        command.current_dir(self.0.path()).env_remove("CLICOLOR_FORCE").env("NO_COLOR", "1").env("COLUMNS", "100");
        // Nothing of a person's own cache is read or written.
        command.env("TUNENET_CACHE", self.path("cache"));
        command
    }

    /// Runs the binary with these arguments, split at spaces.
    pub fn run(&self, arguments: &str) -> Ran {
        self.call(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs the binary with arguments that may hold spaces.
    pub fn call(&self, arguments: &[impl AsRef<OsStr>]) -> Ran {
        self.command().args(arguments).output().expect("the binary starts").into()
    }

    /// Runs a line of shell with the binary as `$TUNENET`.
    pub fn shell(&self, line: &str) -> Ran {
        let mut command = Command::new("sh");
        command.args(["-c", line]).current_dir(self.0.path()).env("TUNENET", env!("CARGO_BIN_EXE_tunenet"));
        command.env("TUNENET_CACHE", self.path("cache"));
        command.env("NO_COLOR", "1").output().expect("a shell").into()
    }
}

/// Refused with status 1: nothing on standard output, `wanted` on standard error, no new files.
#[track_caller]
pub fn refused(folder: &Folder, line: &str, wanted: &[&str]) {
    let before = folder.names();
    let ran = folder.run(line).ends(1);
    assert!(ran.stdout.is_empty(), "{line}: {}", ran.stdout);
    assert_eq!(ran.stderr.lines().filter(|l| l.starts_with("error")).count(), 1, "{line}: {}", ran.stderr);
    for text in wanted {
        assert!(ran.stderr.contains(text), "{line}: no `{text}` in:\n{}", ran.stderr);
    }
    assert!(ran.stderr.contains("help: "), "{line}: no hint in:\n{}", ran.stderr);
    assert_eq!(folder.names(), before, "{line}");
}

/// A ball let go from rest, in SI units.
#[derive(Debug, Clone, Copy)]
pub struct Drop {
    pub restitution: f64,
    /// From its lowest point to the floor.
    pub height_m: f64,
    pub radius_m: f64,
    pub floor_m: f64,
    pub rate_hz: f64,
    pub frames: usize,
    /// How long the record holds it before it is let go.
    pub held_s: f64,
    /// Standard deviation of the noise on every axis.
    pub noise_m: f64,
    pub seed: u64,
}

impl Default for Drop {
    fn default() -> Self {
        Self {
            restitution: 0.7,
            height_m: 1.0,
            radius_m: 0.02,
            floor_m: 0.0,
            rate_hz: 120.0,
            frames: 240,
            held_s: 0.0,
            noise_m: 0.001,
            seed: 1,
        }
    }
}

const GRAVITY_M_S2: f64 = 9.81;

impl Drop {
    /// When it hits the floor for the `n`th time, from 0, counted from the start of the record: the fall, then flights of
    /// 2·eᵏ·v/g, whose sum is geometric.
    pub fn impact_s(&self, n: u32) -> f64 {
        let fall = (2.0 * self.height_m / GRAVITY_M_S2).sqrt();
        let e = self.restitution;
        self.held_s + fall + (1..=n).map(|k| 2.0 * fall * e.powi(k.cast_signed())).sum::<f64>()
    }

    /// The height of its centre without noise.
    pub fn height_at(&self, time_s: f64) -> f64 {
        let rest = self.floor_m + self.radius_m;
        let since = (time_s - self.held_s).max(0.0);
        let fall = (2.0 * self.height_m / GRAVITY_M_S2).sqrt();
        if since <= fall {
            return rest + self.height_m - 0.5 * GRAVITY_M_S2 * since * since;
        }
        let (mut left, mut speed) = (since - fall, self.restitution * GRAVITY_M_S2 * fall);
        while speed > 1e-9 {
            let flight = 2.0 * speed / GRAVITY_M_S2;
            if left <= flight {
                return rest + left * (speed - 0.5 * GRAVITY_M_S2 * left);
            }
            left -= flight;
            speed *= self.restitution;
        }
        rest
    }

    /// Time and measured centre of every frame.
    pub fn frames(&self) -> Vec<(f64, [f64; 3])> {
        let mut noise = Noise(self.seed);
        (0..self.frames)
            .map(|i| {
                let t = i as f64 / self.rate_hz;
                let seen = [0.0, 0.0, self.height_at(t)].map(|v| v + self.noise_m * noise.normal());
                (t, seen)
            })
            .collect()
    }

    /// The record as a CSV file.
    pub fn csv(&self) -> String {
        table(&self.frames())
    }
}

/// A CSV file of positions.
pub fn table(frames: &[(f64, [f64; 3])]) -> String {
    let mut text = String::from("t_s,x_m,y_m,z_m\n");
    for (t, [x, y, z]) in frames {
        writeln!(text, "{t},{x},{y},{z}").expect("a string takes all");
    }
    text
}

/// Small, seeded draws (`SplitMix64`).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Even from 0 to 1.
    pub fn even(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.even()
    }

    /// Standard normal, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.even()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.even()).cos()
    }
}
