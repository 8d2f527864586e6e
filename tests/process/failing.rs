//! Programs that fail, each in its own way.

use super::programs::program;

/// What a program does, its text, what the sentence says, and what is to be tried.
pub type Case = (&'static str, String, &'static [&'static str], &'static str);

/// Programs that do not answer.
pub fn ends_or_hangs() -> Vec<Case> {
    let greet = "import sys, time\nprint('{\"tunenet\":1}', flush=True)\n";
    vec![
        (
            "exits at once",
            "import sys\nsys.exit(3)\n".into(),
            &["the first line", "it ended (exit status: 3)"],
            "by hand",
        ),
        ("exits when asked", program("sys.exit('no mesh')"), &["request 1 (k=1)", "its last words: `no mesh`"], "why"),
        (
            "dies of an error",
            program("raise ValueError('<script>\\x1b[31m')"),
            &["exit status: 1", "ValueError: <script>\u{fffd}[31m`"],
            "standard error ended with",
        ),
        ("dies of a signal", program("os.kill(os.getpid(), 9)"), &["signal: 9"], "input ends"),
        (
            "hangs at the start",
            "import time\ntime.sleep(100)\n".into(),
            &["the first line", "within 1 s, found none, and stopped it"],
            "process.start_timeout_s",
        ),
        (
            "hangs later",
            program("time.sleep(100)"),
            &["request 1", "within 1 s, found none, and stopped it"],
            "process.timeout_s",
        ),
        ("does not flush", program("sys.stdout.write(good + '\\n')"), &["within 1 s"], "flush=True"),
        ("does not read", format!("{greet}time.sleep(100)\n"), &["within 1 s, found none"], "line by line"),
        (
            "closes its output",
            program("os.close(1); time.sleep(100)"),
            &["it closed its standard output"],
            "every line",
        ),
    ]
}

/// Programs that answer otherwise than they should.
pub fn misspeaks() -> Vec<Case> {
    vec![
        (
            "prints garbage",
            program("print('Hello', flush=True)"),
            &["expected one JSON object on a line, found `Hello`"],
            "standard error",
        ),
        (
            "prints debug text first",
            program("print('t =', 1)\nprint(good, flush=True)"),
            &["found `t = 1`"],
            "nothing else on standard output",
        ),
        (
            "prints debug text afterwards",
            program("print(good)\nprint('done', flush=True)"),
            &["request 2", "found `done`"],
            "nothing else",
        ),
        (
            "prints bytes",
            program("os.write(1, b'\\xff\\x00\\xfe\\n')"),
            &["expected text in UTF-8"],
            "one line of JSON",
        ),
        (
            "greets another",
            "import time\nprint('{\"tunenet\": 7}', flush=True)\ntime.sleep(9)\n".into(),
            &["expected protocol 2, found 7"],
            "docs/process.md",
        ),
        (
            "another id",
            program("print(good.replace('\"id\": ', '\"id\": 9'), flush=True)"),
            &["expected the answer to request 1, found `\"id\": 91`"],
            "one line",
        ),
        (
            "too few rows",
            program("print(json.dumps({'id': id, 'values': [[1.0]]}), flush=True)"),
            &["expected 40 rows in `values`, found 1"],
            "times_s",
        ),
        (
            "rows too long",
            program("print(json.dumps({'id': id, 'values': [[1.0, 2.0]] * n}), flush=True)"),
            &["expected 1 number in row 1 of `values` (angle_rad), found 2"],
            "process.channels",
        ),
        (
            "no rows",
            program("print(json.dumps({'id': id, 'values': [1.0] * n}), flush=True)"),
            &["expected `values` as one row for each"],
            "error",
        ),
        (
            "not a number",
            program("print(json.dumps({'id': id, 'values': [[0.0], [math.nan]] * n}), flush=True)"),
            &["expected finite numbers, found `NaN` in row 2"],
            "cannot be simulated",
        ),
        (
            "null",
            program("print(json.dumps({'id': id, 'values': [[0.0], [None]] * (n // 2)}), flush=True)"),
            &["found `null` for `angle_rad` in row 2"],
            "cannot be simulated",
        ),
    ]
}

/// Programs that say too much, or not the same twice, or no.
pub fn overdoes() -> Vec<Case> {
    vec![
        (
            "no answer in it",
            program("print(json.dumps({'id': id}), flush=True)"),
            &["expected `values` or `error`"],
            "error",
        ),
        (
            "an endless line",
            program("while True: os.write(1, b'x' * 65536)"),
            &["at most 68096 bytes, found a longer line"],
            "one on each line",
        ),
        (
            "endless lines",
            "import os\nwhile True: os.write(1, b'x\\n' * 30000)\n".into(),
            &["found `x`"],
            "one line of JSON",
        ),
        (
            "chance",
            program("import random\nprint(json.dumps({'id': id, 'values': [[random.random()]] * n}), flush=True)"),
            &["expected the same answer to the same parameters", "row 1"],
            "fixed seed",
        ),
        (
            "beyond all reckoning",
            program("print(json.dumps({'id': id, 'values': [[0.0], [-1e160]] * (n // 2)}), flush=True)"),
            &[
                "the program answered -1e160 for `angle_rad` at sample 2 to the file's own values (k=1): expected a finite \
                 number of at most 1e100",
            ],
            "--set parameters.k.value=…",
        ),
        (
            "its own start",
            program("print(json.dumps({'id': id, 'error': 'no pendulum is so short'}), flush=True)"),
            &["a.toml: the program refused the file's own values (k=1): no pendulum is so short"],
            "--set parameters.k.value=…",
        ),
    ]
}
