//! What was measured, and how it is written down.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use serde_json::{Map, Value, json};

use super::ball::ShotBall;
use super::estimate::FEWEST_BOUNCES;
use super::figure;
use super::lacking::{Lacking, LackingCost, SHOTS};
use super::share::{Difference, Share};
use super::trial::{ShotTrial, Way};
use crate::goals::{SHOT_DIAGNOSED, SHOT_FLAGS, SHOT_OF_KNOWN, SHOT_TUNED};
use crate::output::{file_of, write_all};

/// The ways that are drawn.
const DRAWN: [Way; figure::WAYS] = [Way::Apex, Way::Nearest, Way::Tuned, Way::Diagnosed, Way::Known];

/// All trials of one ball.
pub struct Series {
    pub ball: ShotBall,
    pub rich: bool,
    pub trials: Vec<ShotTrial>,
    /// What each thing costs that is not known of it.
    pub lacking: Vec<LackingCost>,
}

pub struct ShotResults {
    pub seed: u64,
    pub quick: bool,
    pub trials: u64,
    pub series: Vec<Series>,
}

impl ShotTrial {
    /// Whether the drop corrupts the estimate, by the truth: too little happened, or what is planned from it misses.
    fn uninformative(&self) -> bool {
        self.impacts < FEWEST_BOUNCES || self.misplanned
    }

    fn hit(&self, way: Way, repeated: bool) -> bool {
        let shots = if repeated { &self.repeated } else { &self.shots };
        shots.iter().any(|shot| shot.way == way && shot.goes_in)
    }
}

/// Success of one way over some trials.
struct Success {
    all: Share,
    accepted: Share,
    after_repeat: Share,
}

impl Success {
    fn new(way: Way, trials: &[&ShotTrial]) -> Self {
        Self {
            all: Share::from_hits(trials.iter().map(|t| t.hit(way, false))),
            accepted: Share::from_hits(trials.iter().filter(|t| !t.flagged).map(|t| t.hit(way, false))),
            after_repeat: Share::from_hits(trials.iter().map(|t| t.hit(way, true))),
        }
    }

    fn json(&self) -> Value {
        json!({
            "success_all": self.all.json(), "success_all_se": self.all.error(),
            "success_accepted": self.accepted.json(), "success_after_repeat": self.after_repeat.json(),
        })
    }
}

impl ShotResults {
    fn trials(&self, rich: bool) -> Vec<&ShotTrial> {
        self.series.iter().filter(|s| s.rich == rich).flat_map(|s| &s.trials).collect()
    }

    /// Shares of corrupted drops that are flagged, of those that bounced often enough and mislead all the same, and of good
    /// drops that are.
    fn flags(&self) -> [Share; 3] {
        let trials = self.trials(false);
        let flagged = |which: &dyn Fn(&ShotTrial) -> bool| {
            Share::from_hits(trials.iter().filter(|t| which(t)).map(|t| t.flagged))
        };
        let misled = |t: &ShotTrial| t.impacts >= FEWEST_BOUNCES && t.misplanned;
        [flagged(&ShotTrial::uninformative), flagged(&misled), flagged(&|t| !t.uninformative())]
    }

    pub fn as_json(&self) -> Value {
        let trials = self.trials(false);
        let way = |way: &Way| (key(*way), Success::new(*way, &trials).json());
        let tuned = Success::new(Way::Tuned, &trials);
        let [rightly, misled, wrongly] = self.flags();
        let ball = |series: &Series| {
            let trials_of_ball: Vec<&ShotTrial> = series.trials.iter().collect();
            let ways: Map<String, Value> =
                Way::ALL.iter().map(|way| (key(*way), Success::new(*way, &trials_of_ball).json())).collect();
            let named: Vec<&String> = trials_of_ball.iter().flat_map(|t| &t.named).collect();
            json!({
                "ball": series.ball.name, "richer": series.rich, "trials": trials_of_ball.len(), "ways": ways,
                "restitution": series.ball.restitution, "friction": series.ball.friction,
                "drag_1_m": series.ball.drag_1_m, "scatter_rad": series.ball.scatter_rad,
                "worth_of_naming": difference(&trials_of_ball, Way::Pooled, Way::Diagnosed).json(),
                "worth_of_diagnosis": difference(&trials_of_ball, Way::Tuned, Way::Diagnosed).json(),
                "named": counted(&named),
                "lacking": series.lacking,
            })
        };
        json!({
            "schema": "tunenet.bench.shot/1",
            "seed": self.seed, "trials": self.trials, "quick": self.quick,
            "success_all": tuned.all.json(), "success_accepted": tuned.accepted.json(),
            "success_after_repeat": tuned.after_repeat.json(),
            "flagged_rightly": rightly.json(), "flagged_wrongly": wrongly.json(),
            "spoilt": rightly.count, "misled": misled.count, "left": trials.iter().filter(|t| t.left).count(),
            "success_left": left(&trials).json(),
            "all_known": Success::new(Way::Known, &trials).json(),
            "ways": Way::ALL.iter().map(way).collect::<Map<String, Value>>(),
            "worth_of_naming": difference(&trials, Way::Pooled, Way::Diagnosed).json(),
            "worth_of_diagnosis": difference(&trials, Way::Tuned, Way::Diagnosed).json(),
            "per_ball": self.series.iter().map(ball).collect::<Vec<_>>(),
        })
    }

    /// The tables for users. Writing to a string cannot fail, so its results are dropped.
    pub fn markdown(&self) -> String {
        let mut out = String::new();
        let quick = if self.quick { " --quick" } else { "" };
        let _ = writeln!(
            out,
            "# The bounce shot\n\n    tunenet bench shot{quick} --trials {} --seed {}\n",
            self.trials, self.seed
        );
        let _ = writeln!(
            out,
            "Six balls, {} trials each. A ball is dropped once in front of an uncalibrated camera; then it is let go above \
             a plane so that it bounces through a hoop. Success with standard error.\n",
            self.trials
        );
        let trials = self.trials(false);
        table(&mut out, &trials);
        let _ = writeln!(out);
        for (way, (all, accepted)) in [(Way::Tuned, SHOT_TUNED), (Way::Diagnosed, SHOT_DIAGNOSED)] {
            let found = Success::new(way, &trials);
            goal(&mut out, &format!("{}: all", way.words()), found.all.value, all, true);
            goal(&mut out, &format!("{}: accepted drops", way.words()), found.accepted.value, accepted, true);
        }
        let ratio = Success::new(Way::Diagnosed, &trials).all.value / Success::new(Way::Known, &trials).all.value;
        goal(&mut out, "with named effects, of everything known", ratio, SHOT_OF_KNOWN, true);
        let [rightly, misled, wrongly] = self.flags();
        goal(&mut out, "flagged of uninformative drops", rightly.value, SHOT_FLAGS.0, true);
        goal(&mut out, "flagged of all other drops", wrongly.value, SHOT_FLAGS.1, false);
        let _ = writeln!(
            out,
            "\n{} of {} drops are uninformative: {} hit the table less than {FEWEST_BOUNCES} times; for {} more, the shot planned with \
             only the restitution misses even without random deflection of the rebound, while the shot of a planner that knows \
             every parameter goes in. In {} drops the ball fell off the table during the recording; of the shots planned from \
             these, {} go in with only the restitution.\n",
            rightly.count,
            trials.len(),
            rightly.count - misled.count,
            misled.count,
            left(&trials).count,
            left(&trials).words(),
        );
        let _ = writeln!(
            out,
            "| ball | restitution alone | from three drops | named effects | worth of naming | known | effects named |"
        );
        let _ = writeln!(out, "|---|---|---|---|---|---|---|");
        for series in &self.series {
            let trials_of_ball: Vec<&ShotTrial> = series.trials.iter().collect();
            let of = |way: Way| Success::new(way, &trials_of_ball).all;
            let named: Vec<&String> = trials_of_ball.iter().flat_map(|t| &t.named).collect();
            let words: Vec<String> = counted(&named).into_iter().map(|(name, n)| format!("{name} {n}")).collect();
            let _ = writeln!(
                out,
                "| {}{} | {} | {} | {} | {} | {} | {} |",
                series.ball.name,
                if series.rich { ", richer" } else { "" },
                of(Way::Tuned).words(),
                of(Way::Pooled).words(),
                of(Way::Diagnosed).words(),
                difference(&trials_of_ball, Way::Pooled, Way::Diagnosed).words(),
                of(Way::Known).words(),
                if words.is_empty() { "none".into() } else { words.join(", ") }
            );
        }
        let _ = writeln!(
            out,
            "| all | {} | {} | {} | {} | {} | |\n\n\
             What three drops are worth without naming: {}; with naming: {}.",
            Success::new(Way::Tuned, &trials).all.words(),
            Success::new(Way::Pooled, &trials).all.words(),
            Success::new(Way::Diagnosed, &trials).all.words(),
            difference(&trials, Way::Pooled, Way::Diagnosed).words(),
            Success::new(Way::Known, &trials).all.words(),
            difference(&trials, Way::Tuned, Way::Pooled).words(),
            difference(&trials, Way::Tuned, Way::Diagnosed).words(),
        );
        if self.series.iter().any(|s| !s.lacking.is_empty()) {
            lacking(&mut out, &self.series);
        }
        let richer = self.trials(true);
        if !richer.is_empty() {
            let _ = writeln!(out, "\nIn richer worlds (spin, restitution that falls with speed):\n");
            table(&mut out, &richer);
        }
        out
    }

    /// Success ball by ball, as an SVG file.
    pub fn figure(&self) -> String {
        let mut groups: Vec<figure::Group> = Vec::new();
        for series in self.series.iter().filter(|s| !s.rich) {
            let trials_of_ball: Vec<&ShotTrial> = series.trials.iter().collect();
            groups.push(figure::Group {
                name: series.ball.name,
                shares: DRAWN.map(|way| Success::new(way, &trials_of_ball).all),
            });
        }
        let all = self.trials(false);
        groups.push(figure::Group { name: "all", shares: DRAWN.map(|way| Success::new(way, &all).all) });
        figure::draw(&groups, &DRAWN.map(Way::words))
    }

    /// Success ball by ball: the figure as a table.
    pub fn by_ball(&self) -> String {
        let mut out =
            format!("| ball | {} |\n|---{}|\n", DRAWN.map(Way::words).join(" | "), "|---".repeat(DRAWN.len()));
        for series in self.series.iter().filter(|s| !s.rich) {
            let trials_of_ball: Vec<&ShotTrial> = series.trials.iter().collect();
            let cells = DRAWN.map(|way| Success::new(way, &trials_of_ball).all.words());
            let _ = writeln!(out, "| {} | {} |", series.ball.name, cells.join(" | "));
        }
        let all = self.trials(false);
        for (name, of) in [("all", 0), ("all, accepted drops", 1)] {
            let cells = DRAWN.map(|way| {
                let found = Success::new(way, &all);
                [found.all, found.accepted][of].words()
            });
            let _ = writeln!(out, "| {name} | {} |", cells.join(" | "));
        }
        out
    }

    pub fn write(&self, folder: &Path) -> Result<()> {
        write_all(
            folder,
            [("shot.md", self.markdown()), ("shot.json", file_of(&self.as_json())), ("shot.svg", self.figure())],
        )
    }
}

fn table(out: &mut String, trials: &[&ShotTrial]) {
    let _ = writeln!(out, "| who plans | all | accepted drops | after one repeat |");
    let _ = writeln!(out, "|---|---|---|---|");
    for way in Way::ALL {
        let found = Success::new(way, trials);
        let cells = [found.all, found.accepted, found.after_repeat].map(Share::words);
        let _ = writeln!(out, "| {} | {} |", way.words(), cells.join(" | "));
    }
}

/// What each thing costs that is not known of a ball.
fn lacking(out: &mut String, series: &[Series]) {
    let _ = writeln!(
        out,
        "\nCost of each parameter that a drop may not determine: success rate over {SHOTS} shots of a planner that knows every parameter \
         except that one, and its release height.\n"
    );
    let _ = writeln!(out, "| ball | unknown: {} |", Lacking::EACH.map(Lacking::words).join(" | "));
    let _ = writeln!(out, "|---{}|", "|---".repeat(Lacking::EACH.len()));
    for one in series {
        let cell = |cost: &LackingCost| format!("{} ({:.2} m)", cost.share().words(), cost.height_m);
        let cells: Vec<String> = one.lacking.iter().map(cell).collect();
        let rich = if one.rich { ", richer" } else { "" };
        let _ = writeln!(out, "| {}{rich} | {} |", one.ball.name, cells.join(" | "));
    }
}

fn goal(out: &mut String, what: &str, found: f64, goal: f64, least: bool) {
    let met = if least { found >= goal } else { found <= goal };
    let sign = if least { "at least" } else { "at most" };
    let _ = if found.is_nan() {
        writeln!(out, "- {what}: none there, goal {sign} {goal}")
    } else {
        writeln!(out, "- {what}: {found:.3}, goal {sign} {goal}: {}", if met { "met" } else { "missed" })
    };
}

/// How much more often one way goes in than another over the same trials.
fn difference(trials: &[&ShotTrial], without: Way, with: Way) -> Difference {
    let hit = |t: &ShotTrial, way: Way| f64::from(u8::from(t.hit(way, false)));
    Difference::from_differences(&trials.iter().map(|t| hit(t, with) - hit(t, without)).collect::<Vec<_>>())
}

/// Success with the restitution alone after drops in which the ball fell off the table.
fn left(trials: &[&ShotTrial]) -> Share {
    Share::from_hits(trials.iter().filter(|t| t.left).map(|t| t.hit(Way::Tuned, false)))
}

/// How often each name stands there.
fn counted(names: &[&String]) -> std::collections::BTreeMap<String, usize> {
    let mut all = std::collections::BTreeMap::new();
    for name in names {
        *all.entry((*name).clone()).or_insert(0) += 1;
    }
    all
}

fn key(way: Way) -> String {
    serde_json::to_value(way).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::super::trial::Shot;
    use super::*;

    fn trial(impacts: usize, misplanned: bool, flagged: bool) -> ShotTrial {
        let shot = |way: Way| Shot { way, height_m: 0.5, miss_m: 0.0, goes_in: way != Way::Tuned || !misplanned };
        let shots: Vec<Shot> = Way::ALL.into_iter().map(shot).collect();
        let repeated = shots.clone();
        let bounces = impacts;
        ShotTrial { left: true, impacts, bounces, misplanned, off: 0.0, flagged, shots, repeated, named: Vec::new() }
    }

    /// One that hit the table once is uninformative for every plan; one that left after that only where it misleads.
    #[test]
    fn whether_a_drop_is_uninformative_depends_on_the_truth_only() {
        let trials = vec![
            trial(1, false, true),
            trial(1, true, false),
            trial(2, false, true),
            trial(5, false, false),
            trial(5, true, false),
        ];
        let uninformative: Vec<bool> = trials.iter().map(ShotTrial::uninformative).collect();
        assert_eq!(uninformative, [true, true, false, false, true]);
        let series =
            vec![Series { ball: super::super::ball::FIXED[0].clone(), rich: false, trials, lacking: Vec::new() }];
        let results = ShotResults { seed: 0, quick: true, trials: 5, series };
        let [rightly, misled, wrongly] = results.flags();
        assert_eq!((rightly.value, rightly.count), (1.0 / 3.0, 3));
        assert_eq!((misled.value, misled.count), (0.0, 1));
        assert_eq!((wrongly.value, wrongly.count), (0.5, 2));
        let worth = difference(&results.trials(false), Way::Tuned, Way::Known);
        assert!((worth.mean - 0.4).abs() < 1e-12 && (worth.error - (0.24_f64 / 5.0).sqrt()).abs() < 1e-12);
    }
}
