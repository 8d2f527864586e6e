//! Pages: complete in themselves, escaped, the same for equal runs, and readable at every width.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::common::{Drop, Folder, SCENE};

/// A folder with the scene, and with ready observations under their own names.
fn folder() -> Folder {
    let folder = Folder::with_scene();
    let ready = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/observations");
    let light = (1..=5).map(|i| format!("light_{i}.csv"));
    let others = ["drop.csv", "throw.csv", "bounces.csv", "table_tennis.csv"].map(String::from);
    for name in light.chain(others) {
        folder.write(&name, std::fs::read(ready.join(&name)).unwrap());
    }
    // A camera that shakes is in no catalogue.
    for seed in 1..=3 {
        let fall = Drop { noise_m: 0.002, seed, ..Drop::default() };
        let shake = |t: f64| 0.012 * (2.0 * std::f64::consts::PI * 7.0 * t).sin();
        let shaken: Vec<_> = fall.frames().iter().map(|(t, [x, y, z])| (*t, [x + shake(*t), *y, *z])).collect();
        folder.write(&format!("shaken_{seed}.csv"), crate::common::table(&shaken));
    }
    folder
        .write("objects.toml", objects(&[("red", 1, false), ("red", 2, false), ("blue", 3, false), ("blue", 4, true)]));
    let still: Vec<_> = (0..200).map(|i| (f64::from(i) / 100.0, [0.0, 0.0, 0.5])).collect();
    folder.write("still.csv", crate::common::table(&still));
    folder
}

/// A manifest of the light ball's throws: object, number, whether held out.
fn objects(all: &[(&str, u32, bool)]) -> String {
    let entry = |(object, number, held_out): &(&str, u32, bool)| {
        format!("[[observation]]\nfile = \"light_{number}.csv\"\nobject = \"{object}\"\nheld_out = {held_out}\n")
    };
    all.iter().map(entry).collect()
}

const FREE: &str = "--set parameters.friction.value=0 --set parameters.friction.min=0 --set parameters.friction.max=2 --set parameters.friction.tune=true";

/// Every kind of page: its name, the arguments, the exit status, and what it has to say.
fn kinds() -> Vec<(&'static str, String, i32, &'static [&'static str])> {
    let tune = |rest: &str| format!("tune --sim scene.toml --observation {rest}");
    let mut all = diagnoses();
    let tuned: Vec<(&'static str, String, i32, &'static [&'static str])> = vec![
        ("drop", tune("drop.csv"), 0, &["Tuned", "residual / \u{3c3}", "determined", "95 %", "release.late"]),
        ("throw", tune(&format!("throw.csv {FREE}")), 0, &["Tuned", "friction", "50 %", "The closed lines"]),
        ("bounces", tune("bounces.csv"), 0, &["Tuned", "interval before it, s"]),
        ("poor", tune("table_tennis.csv"), 3, &["Poor fit", "fit.poor", "estimated from the contacts only"]),
        ("open", tune(&format!("drop.csv {FREE}")), 3, &["Not identifiable", "no effect", "unknown"]),
        ("rejected", tune("still.csv"), 3, &["Rejected", "does not move", "Recordings"]),
        ("several", tune("drop.csv table_tennis.csv still.csv"), 3, &["3 recordings", "still.csv: "]),
        ("each", tune("drop.csv still.csv none.csv --each"), 1, &["one by one", "Tuned", "Rejected", "Refused"]),
    ];
    all.extend(tuned);
    all
}

/// The pages of `diagnose`.
fn diagnoses() -> Vec<(&'static str, String, i32, &'static [&'static str])> {
    let diagnose = |rest: &str| format!("diagnose --sim scene.toml --set ball.mass_kg=0.0027 {rest}");
    let seen = |rest: &str| diagnose(&format!("--observation {rest}"));
    let named: &[&str] = &[
        "Quadratic drag in flight is missing.",
        "drag coefficient",
        "light_5.csv, held out",
        "dashed before, dots after",
        "before the 1st contact",
        "control: ",
        "held-out residual after over before",
        "+ [effects.quadratic_drag]",
        "\u{2212} value = 0.5",
    ];
    let one_of: &[&str] = &[
        "Quadratic drag or ",
        "the first fits best by far, but a single throw does not",
        "Next experiment",
        "does not identify one effect",
    ];
    let unknown: &[&str] =
        &["Something is missing in flight; no known effect explains it.", "stays as it is", "\u{2717} failed"];
    let insufficient: &[&str] = &["The data are insufficient", "recordings.short", "stays as it is"];
    vec![
        ("named", seen("light_1.csv light_2.csv light_3.csv light_4.csv --held-out light_5.csv"), 0, named),
        ("one_of", "diagnose --sim scene.toml --observation light_1.csv".into(), 3, one_of),
        ("unknown", seen("shaken_1.csv shaken_2.csv shaken_3.csv"), 3, unknown),
        ("insufficient", seen("bounces.csv"), 3, insufficient),
        ("nothing", seen("drop.csv"), 0, &["Nothing is missing", "Tuned, the gap is"]),
        ("unusable", seen("still.csv"), 3, &["Insufficient", "does not move", "Excluded effects and recordings"]),
        (
            "objects",
            diagnose("--manifest objects.toml"),
            0,
            &["4 recordings of 2 objects", "<h3>red</h3>", "<h3>blue</h3>"],
        ),
    ]
}

/// All pages, made once: name and text.
fn pages() -> Vec<(&'static str, String)> {
    static MADE: OnceLock<Vec<(&'static str, String)>> = OnceLock::new();
    MADE.get_or_init(|| made_in(&folder())).clone()
}

fn made_in(folder: &Folder) -> Vec<(&'static str, String)> {
    let made = kinds().into_iter().map(|(name, line, exit, wanted)| {
        let ran = folder.run(&format!("{line} --report {name}.html --json")).ends(exit);
        assert!(ran.json()["schema"].is_string() && ran.stderr.contains(&format!("report   {name}.html")));
        let page = folder.text(&format!("{name}.html"));
        for text in wanted {
            assert!(page.contains(text), "{name}: no `{text}`");
        }
        (name, page)
    });
    made.collect()
}

/// Checks that every element is closed where it was opened and every attribute quoted; returns the names of all elements.
#[track_caller]
fn elements(page: &str) -> Vec<String> {
    const EMPTY: [&str; 2] = ["meta", "br"];
    let mut rest = page.strip_prefix("<!DOCTYPE html>").expect("a document type");
    let (mut open, mut all): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    while let Some(begin) = rest.find('<') {
        assert!(!rest[..begin].contains('>'), "a bare `>` in `{}`", &rest[..begin]);
        let end = begin + rest[begin..].find('>').expect("a tag that ends");
        let tag = &rest[begin + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "closed where {open:?} is open");
            continue;
        }
        let name = tag.split(' ').next().unwrap();
        assert!(!name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric()), "`{tag}` is no tag");
        let outside: String = tag.split('"').step_by(2).collect();
        assert!(tag.matches('"').count().is_multiple_of(2) && !outside.contains('<'), "`{tag}` is not quoted");
        all.push(name.to_string());
        if name == "style" {
            let (_, after) = rest.split_once("</style>").expect("a style that ends");
            rest = after;
        } else if !EMPTY.contains(&name) {
            open.push(name.to_string());
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
    all
}

/// Nothing runs and nothing is fetched.
#[track_caller]
fn self_contained(page: &str) {
    let found = elements(page);
    for name in ["script", "link", "img", "iframe", "object", "embed", "base", "form", "image", "use", "foreignObject"]
    {
        assert!(!found.iter().any(|f| f == name), "`{name}` in a page");
    }
    for text in ["http:", "https:", "url(", "@import", "@font-face", "javascript:", "src=\"", "http-equiv"] {
        assert!(!page.contains(text), "`{text}` in a page");
    }
    assert!(!page.contains("<details"), "what is folded does not print");
    // The only links lead to a place on the page itself.
    for link in page.split("href=\"").skip(1) {
        assert!(link.starts_with('#'), "{}", &link[..20.min(link.len())]);
    }
}

#[test]
fn every_verdict_has_a_page_that_is_complete_in_itself() {
    for (name, page) in pages() {
        self_contained(&page);
        assert!(page.len() < 400_000, "{name}: {} bytes", page.len());
        assert!(page.contains("SHA-256") && page.contains("--report"), "{name}");
        assert!(!page.contains("NaN") && !page.contains("inf\""), "{name}");
    }
}

#[test]
fn a_page_that_is_not_balanced_is_noticed() {
    let broken = [
        "<!DOCTYPE html><p><b></p></b>",
        "<!DOCTYPE html><p>",
        "<!DOCTYPE html><p a=\"b></p>",
        "<!DOCTYPE html>a > b<p></p>",
    ];
    for page in broken {
        assert!(std::panic::catch_unwind(|| elements(page)).is_err(), "{page}");
    }
}

#[test]
fn names_of_people_and_files_are_only_text() {
    let folder = Folder::new();
    let hostile = "<img src=x onerror=alert(1)>";
    let file = format!("{hostile}.csv");
    let mut csv = String::new();
    for (i, line) in Drop::default().csv().lines().enumerate() {
        writeln!(csv, "{line},{}", if i == 0 { "<svg/onload=alert(2)>" } else { "1" }).unwrap();
    }
    folder.write(&file, csv);
    folder.write("'\"><b>.toml", SCENE);
    for each in [false, true] {
        let mut command = folder.command();
        command.args(["tune", "--sim", "'\"><b>.toml", "--report", "page.html", "--observation", &file]);
        if each {
            command.args(["--observation", "</title><script>alert(3)</script>", "--each"]);
        }
        crate::common::Ran::from(command.output().unwrap()).ends(i32::from(each));
        let page = folder.text("page.html");
        self_contained(&page);
        assert!(page.contains("&lt;img src=x onerror=alert(1)&gt;.csv"));
        assert!(page.contains("&lt;svg/onload=alert(2)&gt;"), "the ignored column is named");
        assert!(page.contains("'&quot;&gt;&lt;b&gt;.toml"));
    }
}

#[test]
fn names_in_a_diagnosis_are_only_text() {
    let folder = folder();
    let file = "<img src=x onerror=alert(1)>.csv";
    folder.write(file, folder.read("light_1.csv"));
    folder.write("'\"><b>.toml", format!("# </pre><script>alert(2)</script>\n{SCENE}"));
    let objects = objects(&[("<i>red", 2, false), ("b", 3, false)]);
    folder.write("m.toml", format!("{objects}[[observation]]\nfile = \"{file}\"\nobject = \"<i>red\"\n"));
    for rest in [&["--manifest", "m.toml"][..], &["--observation", file]] {
        let mut command = folder.command();
        command.args(["diagnose", "--sim", "'\"><b>.toml", "--report", "page.html"]).args(rest);
        let ran = crate::common::Ran::from(command.output().unwrap());
        assert!(ran.code == Some(0) || ran.code == Some(3), "{}", ran.stderr);
        let page = folder.text("page.html");
        self_contained(&page);
        assert!(page.contains("&lt;img src=x onerror=alert(1)&gt;.csv") && page.contains("'&quot;&gt;&lt;b&gt;.toml"));
        assert!(page.contains("&lt;i&gt;red") == (rest[0] == "--manifest"), "the object is named");
    }
}

#[test]
fn equal_runs_write_equal_bytes() {
    let light = "light_1.csv light_2.csv light_3.csv --held-out light_5.csv";
    let lines = [
        format!("tune --sim scene.toml --observation throw.csv {FREE} --report page.html"),
        format!("diagnose --sim scene.toml --observation {light} --report page.html"),
    ];
    for line in lines {
        let made = ["1", "2"].map(|threads| {
            let folder = folder();
            let mut command = folder.command();
            command.env("RAYON_NUM_THREADS", threads).args(line.split_whitespace());
            crate::common::Ran::from(command.output().unwrap()).ends(0);
            folder.read("page.html")
        });
        assert!(made[0] == made[1], "other bytes: {line}");
    }
}

#[test]
fn what_a_page_may_not_replace() {
    let folder = folder();
    for (line, exit) in [
        ("tune --observation drop.csv --report drop.csv", 1),
        ("tune --observation drop.csv --report scene.toml", 1),
        ("tune --observation drop.csv --report none/page.html", 1),
        ("tune --observation drop.csv --report tuned.toml --out tuned.toml", 2),
        ("diagnose --observation drop.csv --report drop.csv", 1),
        ("diagnose --observation light_1.csv --held-out drop.csv --report drop.csv", 1),
        ("diagnose --observation drop.csv --report scene.toml", 1),
        ("diagnose --observation drop.csv --report none/page.html", 1),
        ("diagnose --observation drop.csv --report new.toml --out new.toml", 2),
        ("diagnose --observation drop.csv --report ./new.toml --out new.toml", 2),
        ("diagnose --manifest objects.toml --report objects.toml", 1),
        ("diagnose --manifest objects.toml --report light_2.csv", 1),
        ("diagnose --manifest objects.toml --report new/red.toml --out new", 2),
    ] {
        let before = folder.names();
        let ran = folder.run(&format!("{line} --sim scene.toml")).ends(exit);
        assert!(ran.stdout.is_empty() && ran.stderr.starts_with("error"), "{line}: {}", ran.stderr);
        assert_eq!(folder.names(), before, "{line}");
    }
    // An older page is replaced.
    folder.run("tune --sim scene.toml --observation drop.csv --report page.html").ends(0);
    let older = folder.read("page.html");
    folder.run("tune --sim scene.toml --observation light_1.csv --report page.html");
    assert!(folder.read("page.html") != older);
}

/// The browser that `TUNENET_CHROMIUM` names, or one on the path.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("TUNENET_CHROMIUM") {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name))).find(|p| p.is_file())
}

/// Runs in the test's own page, which holds every page at every width in a frame, and leaves what it found as text.
const LOOK: &str = r"
const wrong = [];
let drawings = 0, texts = 0;
for (const frame of document.querySelectorAll('iframe')) {
  const inner = frame.contentDocument, where = frame.title, say = what => wrong.push(where + ': ' + what);
  const wide = inner.documentElement.clientWidth;
  if (wide < 300 || !inner.querySelector('main')) say('not shown, width ' + wide);
  if (inner.documentElement.scrollWidth > wide) say('scrolls sideways, ' + inner.documentElement.scrollWidth + ' in ' + wide);
  for (const element of inner.body.querySelectorAll('*')) {
    const box = element.getBoundingClientRect();
    if (box.width > 0 && (box.right > wide + 1 || box.left < -1)) say('<' + element.tagName + '> leaves the page: ' + element.textContent.slice(0, 40));
  }
  for (const svg of inner.querySelectorAll('svg')) {
    const frame = svg.getBoundingClientRect();
    if (frame.width === 0) continue;
    drawings += 1;
    const seen = [];
    for (const text of svg.querySelectorAll('text')) {
      texts += 1;
      const box = text.getBoundingClientRect(), words = text.textContent;
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) say('outside its drawing: ' + words);
      const size = parseFloat(inner.defaultView.getComputedStyle(text).fontSize) * text.getScreenCTM().a;
      if (size < 12) say('small, ' + size.toFixed(1) + ' px: ' + words);
      for (const [other, name] of seen) {
        const x = Math.min(box.right, other.right) - Math.max(box.left, other.left);
        const y = Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top);
        if (x > 2 && y > 4) say('over each other: ' + words + ' and ' + name);
      }
      seen.push([box, words]);
    }
  }
}
document.body.textContent = JSON.stringify({ frames: document.querySelectorAll('iframe').length, drawings, texts, wrong });
";

/// The page with a frame for each of `pages` at each width, and the script that looks at them.
fn wrapper(pages: &[(&'static str, String)]) -> String {
    let mut text = String::from("<!DOCTYPE html><meta charset=\"utf-8\"><body>");
    for (name, page) in pages {
        let inside = page.replace('&', "&amp;").replace('"', "&quot;");
        for width in [400, 800, 1200] {
            write!(
                text,
                "<iframe title=\"{name} at {width}\" style=\"width:{width}px;height:900px;border:0\" srcdoc=\"{inside}\"></iframe>"
            )
            .unwrap();
        }
    }
    write!(text, "<script>addEventListener('load', () => {{{LOOK}}});</script></body>").unwrap();
    text
}

#[test]
fn nothing_overflows_at_any_width() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no chromium on the path, and TUNENET_CHROMIUM names none");
        return;
    };
    let folder = folder();
    let mut pages = pages();
    let long = "a_recording_with_a_name_as_long_as_people_give_them_when_they_number_their_trials_0001.csv";
    folder.write(long, Drop::default().csv());
    let ran = folder.run(&format!("tune --sim scene.toml --observation {long} drop.csv --report long.html"));
    assert!(folder.path("long.html").exists(), "{}", ran.stderr);
    pages.push(("long", folder.text("long.html")));
    folder.write("wrapper.html", wrapper(&pages));
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", folder.path("profile").display()));
    command.arg(format!("file://{}", folder.path("wrapper.html").display()));
    let out = folder.path("seen.html");
    command.stdout(std::fs::File::create(&out).unwrap()).stderr(Stdio::null());
    let (mut child, began) = (command.spawn().expect("the browser starts"), Instant::now());
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_mins(1) {
            child.kill().unwrap();
            panic!("the browser did not end within a minute");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let seen = std::fs::read_to_string(&out).unwrap();
    let begin = seen.find("{\"frames\"").unwrap_or_else(|| panic!("the browser saw nothing: {seen:.300}"));
    let end = begin + seen[begin..].find("</body>").unwrap();
    let text = seen[begin..end].trim().replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(found["frames"], 3 * pages.len());
    assert!(found["drawings"].as_u64() > Some(100) && found["texts"].as_u64() > Some(1000), "{found}");
    let wrong: Vec<&str> = found["wrong"].as_array().unwrap().iter().filter_map(|w| w.as_str()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Of a poor fit the value that was read off the contacts is the answer: gap, drawings and the ratio to the noise are all of it.
#[test]
fn a_poor_fit_tells_one_value_everywhere() {
    let folder = folder();
    let line = "tune --sim scene.toml --observation light_1.csv --json";
    let json = folder.run(&format!("{line} --report page.html")).ends(3).json();
    let value = json["parameters"]["restitution"]["value"].as_f64().unwrap();
    let warning = |code: &str| {
        let all = json["warnings"].as_array().unwrap();
        all.iter().find(|w| w["code"] == code).unwrap()["text"].as_str().unwrap().to_owned()
    };
    assert!(warning("fit.local").contains(&format!("{value:.4}")));
    // The gap before, of a start at this value, is the gap of this value.
    let from = folder.run(&format!("{line} --initial restitution={value}")).json();
    let (before, after) = (from["gap"]["before"].as_f64().unwrap(), json["gap"]["after"].as_f64().unwrap());
    assert!((before / after - 1.0).abs() < 1e-3, "{before} {after}");
    let page = folder.text("page.html");
    let ratio: f64 = warning("fit.poor").split(" times").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    let shown = page.split("residual / noise").nth(1).unwrap();
    let numbers = shown.split(['>', '<']).filter_map(|text| text.trim().parse::<f64>().ok());
    let shown: f64 = numbers.into_iter().next().unwrap();
    assert!((shown - ratio).abs() <= 0.051, "{shown} on the page, {ratio} in the warning");
}

/// A bound that the truth lies beyond holds the value, is told, and leaves an interval.
#[test]
fn a_bound_below_the_truth_is_told() {
    let folder = folder();
    let line = "tune --sim scene.toml --set parameters.restitution.max=0.6 --observation drop.csv --json";
    let json = folder.run(line).ends(3).json();
    assert_eq!(json["verdict"], "poor_fit");
    let found = &json["parameters"]["restitution"];
    assert_eq!((found["value"].as_f64(), found["status"].as_str()), (Some(0.6), Some("at_bound")), "{found}");
    let (low, high) = (found["interval95"][0].as_f64().unwrap(), found["interval95"][1].as_f64().unwrap());
    assert!(low < high && high <= 0.6, "{found}");
    assert!(json["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "parameter.at_bound"), "{json}");
}
