//! What is said to a program, and what it may answer: one JSON object on a line each.
//!
//! ```text
//! {"tunenet":2,"channels":["angle_rad"],"parameters":[{"name":"length","unit":"m"}],"effects":[],
//!  "inputs":[{"name":"torque_nm","unit":"N·m","hold":"previous"}],"states":["angle_rad"],"settings":{}}
//! {"tunenet":2}
//! {"id":1,"recording":1,"start_s":0.0,"inputs":{"torque_nm":{"times_s":[0.0,0.1],"values":[1.0,0.0]}},"settings":{}}
//! {"id":1}
//! {"id":2,"recording":1,"parameters":{"length":1.0},"effects":{},"start":{"angle_rad":0.5},"times_s":[0.0,0.1]}
//! {"id":2,"values":[[0.5],[0.47]]}
//! {"id":3,"batch":[{"recording":1,"parameters":{"length":2.0},"effects":{},"start":{"angle_rad":0.5},"times_s":[0.0]}]}
//! {"id":3,"answers":[{"values":[[0.5]]}]}
//! {"id":4,"forget":1}
//! {"id":4}
//! ```
//!
//! Numbers are written with the fewest digits that give the same bits back, and read to the last bit.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json, json};

use super::failure::printable;
use super::program::Program;
use super::request::{Recording, Request};
use super::version::Version;

/// Longest answer to a greeting, bytes.
pub(super) const LONGEST_GREETING: usize = 64 * 1024;
/// Longest answer besides its numbers, bytes: an error's sentence, say.
const LONGEST_TEXT: usize = 64 * 1024;
/// Longest number with what separates it from the next, bytes. The shortest text of a double has 24.
const LONGEST_NUMBER: usize = 64;

/// What a program answered.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Answer {
    /// What is seen at every instant, row-major `[sample, channel]`.
    Values(Vec<f64>),
    /// Why it cannot simulate these parameters.
    Refused(String),
}

impl Answer {
    /// Whether both are the same to the last bit.
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Values(a), Self::Values(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            (Self::Refused(_), Self::Refused(_)) => true,
            _ => false,
        }
    }

    /// How many numbers it holds.
    pub fn len(&self) -> usize {
        match self {
            Self::Values(values) => values.len(),
            Self::Refused(_) => 0,
        }
    }
}

/// What is wrong with an answer: "expected …, found …", and what to try.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wrong {
    pub message: String,
    pub hint: String,
}

pub(super) fn wrong<T>(expected: &str, found: &str, hint: &str) -> Result<T, Wrong> {
    Err(Wrong { message: format!("expected {expected}, found {found}"), hint: hint.to_owned() })
}

/// The line that announces a recording.
pub(super) fn announcement(program: &Program, id: u64, recording: &Recording) -> Vec<u8> {
    let inputs = program.inputs.iter().zip(&recording.inputs).map(|(declared, input)| {
        let values: Vec<f64> = input.series().column(0).collect();
        (declared.name.clone(), json!({ "times_s": input.series().clock(), "values": values }))
    });
    let inputs: Map<String, Json> = inputs.collect();
    ended(&json!({
        "id": id, "recording": recording.number, "start_s": recording.start_s, "inputs": inputs,
        "settings": program.settings(recording.setup),
    }))
}

/// The line that lets a program forget a recording.
pub(super) fn forget(id: u64, recording: u64) -> Vec<u8> {
    ended(&json!({ "id": id, "forget": recording }))
}

#[derive(Serialize)]
struct Old<'a> {
    id: u64,
    parameters: Map<String, Json>,
    times_s: &'a [f64],
    settings: &'a Json,
}

#[derive(Serialize)]
struct New<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    recording: u64,
    parameters: Map<String, Json>,
    effects: Map<String, Json>,
    start: Map<String, Json>,
    times_s: &'a [f64],
}

#[derive(Serialize)]
struct Batch<'a> {
    id: u64,
    batch: Vec<New<'a>>,
}

fn named<'a>(names: impl Iterator<Item = &'a str>, values: &[f64]) -> Map<String, Json> {
    names.zip(values).map(|(name, value)| (name.to_owned(), json!(value))).collect()
}

fn new<'a>(program: &Program, id: Option<u64>, asked: &'a Request) -> New<'a> {
    let mut rest = asked.coefficients.as_slice();
    let effects = program.candidates.iter().map(|effect| {
        let (own, others) = rest.split_at(effect.coefficients.len().min(rest.len()));
        rest = others;
        (effect.name.to_string(), Json::Object(named(effect.coefficients.iter().map(|c| &*c.key), own)))
    });
    New {
        id,
        recording: asked.recording.number,
        parameters: named(program.parameters.iter().map(|p| p.name.as_str()), &asked.parameters),
        effects: effects.collect(),
        start: named(program.states.iter().map(String::as_str), &asked.start),
        times_s: &asked.times_s,
    }
}

/// The line that asks for a rollout.
pub(super) fn request(program: &Program, version: Version, id: u64, asked: &Request) -> Vec<u8> {
    match version {
        Version::One => ended(&Old {
            id,
            parameters: named(program.parameters.iter().map(|p| p.name.as_str()), &asked.parameters),
            times_s: &asked.times_s,
            settings: program.settings(asked.recording.setup),
        }),
        Version::Two => ended(&new(program, Some(id), asked)),
    }
}

/// The line that asks for many rollouts.
pub(super) fn batch(program: &Program, id: u64, asked: &[Arc<Request>]) -> Vec<u8> {
    ended(&Batch { id, batch: asked.iter().map(|one| new(program, None, one)).collect() })
}

fn ended(line: &impl Serialize) -> Vec<u8> {
    // Maps with text keys and numbers always have a text.
    let mut line = serde_json::to_vec(line).unwrap_or_default();
    line.push(b'\n');
    line
}

/// Longest line that may answer a request for so many numbers, bytes.
pub(super) fn longest_answer(numbers: usize) -> usize {
    numbers.saturating_mul(LONGEST_NUMBER).saturating_add(LONGEST_TEXT)
}

const LINES: &str = "answer every line with one line of JSON and print nothing else on standard output; what helps to debug goes to \
                     standard error";
const ROWS: &str = "one row for each instant of `times_s`, with one number for each channel: [[0.5],[0.47]]";
const NUMBERS: &str = "answer `{\"id\": …, \"error\": \"why\"}` where these parameters cannot be simulated";

/// What may stand in an answer; other keys are passed over. A number that is missing within a row is reported by its place.
#[derive(Deserialize)]
pub(super) struct Said {
    pub tunenet: Option<Json>,
    id: Option<Json>,
    values: Option<Vec<Vec<Option<f64>>>>,
    pub error: Option<Json>,
    answers: Option<Vec<SaidOne>>,
}

/// What may stand in one answer of several.
#[derive(Deserialize)]
struct SaidOne {
    values: Option<Vec<Vec<Option<f64>>>>,
    error: Option<Json>,
}

impl SaidOne {
    fn answer(self, samples: usize, headers: &[String]) -> Result<Answer, Wrong> {
        if let Some(error) = self.error.filter(|error| !error.is_null()) {
            let text = error.as_str().map_or_else(|| quoted(&error), printable);
            return Ok(Answer::Refused(if text.is_empty() { "it does not say why".into() } else { text }));
        }
        match self.values {
            Some(rows) => numbers(&rows, samples, headers).map(Answer::Values),
            None => wrong("`values` or `error`", "neither", NUMBERS),
        }
    }
}

/// Refuses an answer to another request than `id`.
fn of_request(said: &Said, line: &[u8], id: u64) -> Result<(), Wrong> {
    match &said.id {
        Some(found) if *found == id => Ok(()),
        Some(found) => wrong(&format!("the answer to request {id}"), &format!("`\"id\": {}`", quoted(found)), LINES),
        None => wrong(&format!("`\"id\": {id}`"), &format!("`{}`", start(line)), "answer with the id of the request"),
    }
}

/// What a program answers to request `id`, for so many samples of `headers`.
pub(super) fn answered(line: &[u8], id: u64, samples: usize, headers: &[String]) -> Result<Answer, Wrong> {
    let said = said(line)?;
    of_request(&said, line, id)?;
    if said.values.is_none() && said.error.as_ref().is_none_or(Json::is_null) {
        return wrong("`values` or `error`", &format!("`{}`", start(line)), NUMBERS);
    }
    SaidOne { values: said.values, error: said.error }.answer(samples, headers)
}

/// What a program answers to batch `id` of rollouts with so many samples of `headers` each.
pub(super) fn all_answered(line: &[u8], id: u64, samples: &[usize], headers: &[String]) -> Result<Vec<Answer>, Wrong> {
    const EACH: &str = "answer a `batch` with `answers`, one for each of its rollouts, in their order";
    let said = said(line)?;
    of_request(&said, line, id)?;
    let Some(answers) = said.answers else {
        return wrong("`answers`", &format!("`{}`", start(line)), EACH);
    };
    if answers.len() != samples.len() {
        return wrong(&format!("{} answers", samples.len()), &answers.len().to_string(), EACH);
    }
    let each = answers.into_iter().zip(samples).enumerate();
    each.map(|(i, (one, samples))| {
        let place =
            |wrong: Wrong| Wrong { message: format!("answer {} of the batch: {}", i + 1, wrong.message), ..wrong };
        one.answer(*samples, headers).map_err(place)
    })
    .collect()
}

/// What a program answers to request `id`, which asks for nothing.
pub(super) fn noted(line: &[u8], id: u64) -> Result<(), Wrong> {
    let said = said(line)?;
    of_request(&said, line, id)?;
    match said.error.filter(|error| !error.is_null()) {
        Some(error) => {
            wrong(&format!("`{{\"id\":{id}}}`"), &format!("the error {}", quoted(&error)), "see what it says")
        }
        None => Ok(()),
    }
}

pub(super) fn said(line: &[u8]) -> Result<Said, Wrong> {
    let Ok(text) = std::str::from_utf8(line) else {
        return wrong("text in UTF-8", &format!("`{}`", start(line)), LINES);
    };
    serde_json::from_str(text).or_else(|error| {
        // serde counts columns in bytes, from 1.
        let at = error.column().saturating_sub(1);
        if let Some(word) = not_a_number(text, at) {
            return wrong("finite numbers", &format!("`{word}` in {}", row(text, at)), NUMBERS);
        }
        if error.is_data() {
            let what = error.to_string();
            let what = printable(what.rsplit_once(" at line").map_or(&*what, |(what, _)| what));
            return wrong(&format!("`values` as {ROWS}"), &format!("in {}: {what}", row(text, at)), NUMBERS);
        }
        let hint = if text.trim_start().starts_with('{') { format!("{LINES} ({error})") } else { LINES.to_owned() };
        wrong("one JSON object on a line", &format!("`{}`", start(line)), &hint)
    })
}

/// The word that is no number of JSON where reading ended: parsing stops at its first sign, or after a minus.
fn not_a_number(text: &str, at: usize) -> Option<&'static str> {
    const WORDS: [&str; 8] = ["-Infinity", "-inf", "-nan", "NaN", "nan", "Infinity", "Inf", "inf"];
    let spots = at.saturating_sub(2)..=at + 1;
    spots.filter_map(|at| text.get(at..)).find_map(|rest| WORDS.into_iter().find(|word| rest.starts_with(word)))
}

/// The row of `values` in which byte `at` stands.
fn row(text: &str, at: usize) -> String {
    let values = text.find("\"values\"").filter(|start| *start < at).and_then(|start| text.get(start..at));
    values.map_or_else(|| "its answer".into(), |before| format!("row {} of `values`", before.matches(']').count() + 1))
}

/// The numbers of `values`, one row for each sample.
fn numbers(rows: &[Vec<Option<f64>>], samples: usize, headers: &[String]) -> Result<Vec<f64>, Wrong> {
    let width = headers.len();
    let each_row = "one row for each instant of `times_s`, in their order";
    // What a row holds is reported before their number, which is wrong as well where rows were taken for columns.
    if let Some((i, row)) = rows.iter().enumerate().find(|(_, row)| row.len() != width) {
        let count = if width == 1 { "1 number".into() } else { format!("{width} numbers") };
        let expected = format!("{count} in row {} of `values` ({})", i + 1, headers.join(", "));
        let hint = format!("{each_row}, with one number for each of `process.channels`");
        return wrong(&expected, &row.len().to_string(), &hint);
    }
    if rows.len() != samples {
        return wrong(&format!("{samples} rows in `values`"), &rows.len().to_string(), each_row);
    }
    let place = |i: usize| format!("`null` for `{}` in row {} of `values`", headers[i % width], i / width + 1);
    let each = rows.iter().flatten().enumerate();
    each.map(|(i, value)| value.map_or_else(|| wrong("finite numbers", &place(i), NUMBERS), Ok)).collect()
}

/// The beginning of a line for users.
pub(super) fn start(line: &[u8]) -> String {
    const SHOWN: usize = 200;
    let cut = &line[..line.len().min(4 * SHOWN)];
    printable(&String::from_utf8_lossy(cut).chars().take(SHOWN).collect::<String>())
}

pub(super) fn quoted(value: &Json) -> String {
    value
        .as_str()
        .map_or_else(|| start(value.to_string().as_bytes()), |text| format!("\u{201c}{}\u{201d}", printable(text)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(line: &str) -> String {
        let headers = ["angle_rad".to_owned()];
        answered(line.as_bytes(), 3, 2, &headers).map_or_else(|e| e.message, |answer| format!("{answer:?}"))
    }

    #[test]
    fn an_answer_is_its_numbers_to_the_last_bit() {
        let values = [0.1 + 0.2, 5e-324];
        let line = format!("{{\"id\":3,\"values\":[[{}],[{:e}]],\"more\":1}}\r", values[0], values[1]);
        let found = answered(line.as_bytes(), 3, 2, &["a_m".to_owned()]).unwrap();
        assert!(found.is(&Answer::Values(values.to_vec())));
        assert_eq!(parsed(r#"{"id":3,"values":[[1],[-0]]}"#), "Values([1.0, -0.0])");
        // A double that is easily read wrong by one bit.
        let hard = 2.225_073_858_507_201e-308_f64;
        let line = format!("{{\"id\":1,\"values\":[[{hard:?}]]}}");
        assert!(answered(line.as_bytes(), 1, 1, &["a_m".to_owned()]).unwrap().is(&Answer::Values(vec![hard])));
    }

    #[test]
    fn a_refusal_is_an_answer() {
        assert_eq!(parsed(r#"{"id":3,"error":"too short"}"#), r#"Refused("too short")"#);
        assert_eq!(parsed(r#"{"id":3,"values":null,"error":{"a":1}}"#), r#"Refused("{\"a\":1}")"#);
    }

    #[test]
    fn what_is_wrong_with_an_answer_is_reported_with_its_place() {
        for (line, expected) in [
            ("hello", "expected one JSON object on a line, found `hello`"),
            ("", "expected one JSON object on a line, found ``"),
            ("[1]", "expected `values` as"),
            (r#"{"id":2,"values":[]}"#, "expected the answer to request 3, found `\"id\": 2`"),
            (r#"{"values":[[1],[2]]}"#, "expected `\"id\": 3`, found `{\"values\""),
            (r#"{"id":3}"#, "expected `values` or `error`"),
            (r#"{"id":3,"values":[[1]]}"#, "expected 2 rows in `values`, found 1"),
            (r#"{"id":3,"values":[[1],[2,3]]}"#, "expected 1 number in row 2 of `values` (angle_rad), found 2"),
            (r#"{"id":3,"values":[[1],[NaN]]}"#, "expected finite numbers, found `NaN` in row 2"),
            (r#"{"id":3,"values":[[-Infinity],[1]]}"#, "expected finite numbers, found `-Infinity` in row 1"),
            (r#"{"id":3,"values":[[null],[1]]}"#, "found `null` for `angle_rad` in row 1"),
            (r#"{"id":3,"values":[1,2]}"#, "expected `values` as one row for each instant"),
            (r#"{"id":3,"values":[[1],["2"]]}"#, "found in row 2 of `values`: invalid type: string \"2\""),
            (r#"{"id":3,"values":[[1],[1e999]]}"#, "number out of range"),
        ] {
            let message = parsed(line);
            assert!(message.contains(expected) || line.contains("1e999"), "{line}: {message}");
        }
        assert!(answered(b"\xff", 3, 2, &[]).unwrap_err().message.contains("text in UTF-8"));
    }

    #[test]
    fn a_batch_has_an_answer_for_each_of_its_rollouts() {
        let headers = ["angle_rad".to_owned()];
        let all = |line: &str| all_answered(line.as_bytes(), 3, &[1, 2], &headers).map_err(|wrong| wrong.message);
        let found = all(r#"{"id":3,"answers":[{"error":"short"},{"values":[[1],[2]]}]}"#).unwrap();
        assert_eq!(found, [Answer::Refused("short".into()), Answer::Values(vec![1.0, 2.0])]);
        for (line, expected) in [
            (r#"{"id":3,"answers":[{"values":[[1]]}]}"#, "expected 2 answers, found 1"),
            (r#"{"id":3,"values":[[1]]}"#, "expected `answers`"),
            (r#"{"id":3,"answers":[{"values":[[1]]},{}]}"#, "answer 2 of the batch: expected `values` or `error`"),
            (r#"{"id":3,"answers":[{"values":[[1]]},{"values":[[1]]}]}"#, "answer 2 of the batch: expected 2 rows"),
            (r#"{"id":2,"answers":[]}"#, "expected the answer to request 3"),
        ] {
            let message = all(line).unwrap_err();
            assert!(message.contains(expected), "{line}: {message}");
        }
        assert!(noted(br#"{"id":3}"#, 3).is_ok() && noted(br#"{"id":3,"error":"full"}"#, 3).is_err());
    }

    /// Text that begins as an answer does and then goes anywhere.
    fn nearly() -> impl Strategy<Value = Vec<u8>> {
        let part = proptest::sample::select(vec![
            "{",
            "}",
            "[",
            "]",
            ",",
            ":",
            "\"id\"",
            "\"values\"",
            "\"error\"",
            "\"tunenet\"",
            "3",
            "1",
            "-0.5",
            "1e308",
            "1e999",
            "NaN",
            "-Infinity",
            "null",
            "true",
            "\"x\"",
            "\u{1f600}",
            " ",
            "\\",
            "[[1],[2]]",
        ]);
        let parts = proptest::collection::vec(part, 0..30).prop_map(|parts| parts.concat().into_bytes());
        prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..200),
            parts.clone(),
            parts.clone().prop_map(|rest| [&b"{\"id\":3,\"values\":["[..], &rest].concat()),
            parts.prop_map(|rest| [&b"{\"id\":3,\"values\":[[1],[2]]"[..], &rest, b"}"].concat()),
        ]
    }

    proptest! {
        /// Any output of a program is an answer of the right shape, or is reported in one line.
        #[test]
        fn any_line_is_an_answer_or_a_sentence(line in nearly(), width in 1..3_usize) {
            let headers: Vec<String> = ["a_m", "b_m"][..width].iter().map(|h| (*h).to_owned()).collect();
            for parsed in [answered(&line, 3, 2, &headers), noted(&line, 3).map(|()| Answer::Values(vec![0.0; 2 * width]))] {
                match parsed {
                    Ok(Answer::Values(values)) => {
                        prop_assert!(values.len() == 2 * width && values.iter().all(|v| v.is_finite()));
                    }
                    Ok(Answer::Refused(text)) => prop_assert!(!text.is_empty() && !text.contains('\n')),
                    Err(wrong) => prop_assert!(!wrong.message.contains(char::is_control), "{:?}", wrong.message),
                }
            }
        }

        /// Every double comes back to the bit, as written and as a program in another language writes it.
        #[test]
        fn every_double_comes_back(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            for text in [format!("{value:?}"), format!("{value:e}"), format!("{value:.17e}"), json!(value).to_string()] {
                let line = format!("{{\"id\":1,\"values\":[[{text}]]}}");
                let found = answered(line.as_bytes(), 1, 1, &["a_m".to_owned()]).unwrap();
                prop_assert!(found.is(&Answer::Values(vec![value])), "{}", text);
            }
        }
    }
}
