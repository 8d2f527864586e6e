//! A tuning that is killed goes on from its checkpoint, asks the program for less, and answers as one that was not killed.

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common::{Folder, refused, timeless};
use crate::process::programs::{program, python, scene};

const TUNE: &str = "tune --sim a.toml --allow-process a.csv --jobs 1 --json";

/// A folder with a slow program that answers exp(-k t), refuses k below 0.3, and adds a byte to `asked` for every request.
fn counted() -> Folder {
    let folder = Folder::new();
    let answers = "open('asked', 'a').write('.')\ntime.sleep(0.004)\nk = request['parameters']['k']\n\
                   if k < 0.3:\n    print(json.dumps({'id': id, 'error': 'too stiff'}), flush=True)\n    continue\n\
                   rows = [[math.exp(-k * t)] for t in request['times_s']]\n\
                   print(json.dumps({'id': id, 'values': rows}), flush=True)";
    folder.write("a.py", program(answers));
    folder.write("a.toml", scene("[\"python3\", \"a.py\"]").replace("[process]\n", "[process]\nworkers = 1\n"));
    let noise = |i: u32| 0.002 * f64::from(i * 7 % 5) - 0.004;
    let row = |i: u32| format!("{},{}\n", f64::from(i) / 20.0, (-0.7 * f64::from(i) / 20.0).exp() + noise(i));
    folder.write("a.csv", format!("t_s,angle_rad\n{}", (0..40).map(row).collect::<String>()));
    folder
}

/// How many requests the program got since it was last asked.
fn asked(folder: &Folder) -> usize {
    let count = folder.read("asked").len();
    folder.write("asked", "");
    count
}

#[cfg(unix)]
#[test]
fn a_killed_tuning_goes_on_from_its_checkpoint_with_the_same_answer() {
    if !python("json") {
        return;
    }
    let folder = counted();
    let whole = folder.run(TUNE);
    let code = whole.code.unwrap();
    assert!(code == 0 || code == 3, "{}", whole.stderr);
    let (expected, all) = (timeless(whole.stdout.as_bytes()), asked(&folder));
    let line = format!("{TUNE} --checkpoint a.rollouts");
    let mut child = folder.command();
    let mut child = child.args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let until = Instant::now() + Duration::from_secs(60);
    while folder.read("asked").len() < all / 2 {
        assert!(child.try_wait().unwrap().is_none() && Instant::now() < until, "it ended before it was killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let first = asked(&folder);
    assert!(first >= all / 2 && first < all, "{first} of {all}");
    let again = folder.run(&line).ends(code);
    assert_eq!(String::from_utf8(timeless(again.stdout.as_bytes())), String::from_utf8(expected.clone()));
    let second = asked(&folder);
    assert!(second < all * 3 / 4, "{second} of {all}, after {first}");
    assert!(again.stderr.contains("kept     a.rollouts, "), "{}", again.stderr);
    // Now everything that was answered is in the file, whatever stands at its end.
    let mut bytes = folder.read("a.rollouts");
    bytes.extend([9, 0, 0, 0, 1]);
    folder.write("a.rollouts", &bytes);
    let third = folder.run(&line).ends(code);
    assert!(timeless(third.stdout.as_bytes()) == expected);
    assert!(asked(&folder) < second);
}

#[test]
fn a_checkpoint_of_another_problem_is_refused_and_left() {
    if !python("json") {
        return;
    }
    let folder = counted();
    let line = format!("{TUNE} --checkpoint a.rollouts");
    folder.run(&line);
    let kept = folder.read("a.rollouts");
    refused(&folder, &format!("{line} --set process.timeout_s=20"), &["found those of others", "a.rollouts"]);
    folder.write("a.py", folder.text("a.py") + "\n# changed\n");
    refused(&folder, &line, &["found those of others"]);
    assert!(folder.read("a.rollouts") == kept);
    refused(&folder, &format!("{TUNE} --checkpoint a.csv"), &["a.csv"]);
    folder.write("b.txt", "mine");
    refused(&folder, &format!("{TUNE} --checkpoint b.txt"), &["b.txt"]);
    refused(&folder, &format!("{TUNE} --checkpoint b.txt --overwrite"), &["found another file"]);
    for other in ["--each", "--each --shard 0/2"] {
        folder.run(&format!("{line} {other}")).ends(2);
    }
}
