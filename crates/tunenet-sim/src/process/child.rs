//! One running copy of a program.

use std::io::{ErrorKind, Write};
use std::process::{Child as Process, Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::failure::Failure;
use super::greeting::{Greeted, Older, greeted, greeting};
use super::pipes::{Answers, Received, Troubles};
use super::program::Program;
use super::protocol::{
    Answer, LONGEST_GREETING, Wrong, all_answered, announcement, answered, batch, forget, longest_answer, noted,
    request,
};
use super::request::{Recording, Request};
use super::version::Version;

/// How long a program may take to end by itself once its input has ended.
const FAREWELL: Duration = Duration::from_millis(300);
/// Most recordings that a copy keeps; it has to forget the one that was asked for the longest ago.
const MOST_RECORDINGS: usize = 128;
/// How often it is looked at meanwhile.
const LOOK: Duration = Duration::from_millis(2);

/// A running copy of a program that was greeted. It is gone, and waited for, when this is dropped.
#[derive(Debug)]
pub(super) struct Child {
    process: Process,
    /// Lines for its standard input, written by a thread of its own: a program that does not read must not hold up anybody.
    /// `None` once it was bidden farewell.
    input: Option<Sender<Vec<u8>>>,
    answers: Answers,
    troubles: Troubles,
    asked: u64,
    version: Version,
    /// Numbers of the recordings that were announced to it, the one that was asked for last at the end.
    announced: Vec<u64>,
}

impl Child {
    /// Starts a copy and greets it, in the newest version that it speaks.
    pub fn start(program: &Program) -> Result<Self, Failure> {
        if let Some(version) = program.speaks.get() {
            return match Self::greeted(program, *version)? {
                Ok(child) => Ok(child),
                Err((mut child, found)) => Err(child.older(program, &found, None)),
            };
        }
        let (child, version) = match Self::greeted(program, Version::Two)? {
            Ok(child) => (child, Version::Two),
            Err((mut child, found)) => {
                if let Some(needs) = program.beyond_one() {
                    return Err(child.older(program, &found, Some(&needs)));
                }
                drop(child);
                match Self::greeted(program, Version::One)? {
                    Ok(child) => (child, Version::One),
                    Err((mut child, found)) => return Err(child.older(program, &found, None)),
                }
            }
        };
        let _ = program.speaks.set(version);
        Ok(child)
    }

    /// A copy that was greeted in `version`; or what it answered, where it may speak an older one.
    fn greeted(program: &Program, version: Version) -> Result<Result<Self, (Self, Older)>, Failure> {
        let mut child = Self::spawn(program, version)?;
        let hello = (greeting(program, version), LONGEST_GREETING, program.start_timeout);
        let line = child.exchange(program, "the first line", hello, "process.start_timeout_s")?;
        match greeted(&line, version) {
            Ok(Greeted::Yes) => Ok(Ok(child)),
            Ok(Greeted::Older(found)) => Ok(Err((child, found))),
            Err(wrong) => Err(child.misspoke(program, "the first line", &wrong)),
        }
    }

    /// It does not speak the version that is needed, for what.
    fn older(&mut self, program: &Program, answer: &Older, needs: Option<&str>) -> Failure {
        let needs = needs.map_or_else(String::new, |needs| format!(" for the {needs}"));
        let Older { found, error } = answer;
        let message = format!("expected a program that speaks protocol 2{needs}, found {found}");
        let version = "answer the first line with `{\"tunenet\":2}` and read recordings as docs/process.md shows, or leave what it \
                       does not know out of the simulation file";
        let hint = if *error {
            format!("mend what the error says; if it is about the version, {version}")
        } else {
            version.into()
        };
        self.misspoke(program, "the first line", &Wrong { message, hint })
    }

    /// Starts a copy that was not spoken with.
    fn spawn(program: &Program, version: Version) -> Result<Self, Failure> {
        let mut command = Command::new(program.executable());
        command.args(&program.command[1..]).current_dir(&program.folder);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().map_err(|error| unstarted(program, &error))?;
        let piped = (process.stdin.take(), process.stdout.take(), process.stderr.take());
        let failed = |error: &dyn std::fmt::Display| {
            Failure::new(
                format!("{} could not be spoken with: {error}", program.shown()),
                "close other programs and try again",
            )
        };
        let (Some(mut stdin), Some(stdout), Some(stderr)) = piped else { return Err(failed(&"a pipe is missing")) };
        let (input, lines) = channel::<Vec<u8>>();
        let writes = move || {
            for line in lines {
                // It ended, which shows in what it prints.
                if stdin.write_all(&line).and_then(|()| stdin.flush()).is_err() {
                    return;
                }
            }
        };
        let threads = Answers::of(stdout).and_then(|answers| {
            let troubles = Troubles::of(stderr)?;
            thread::Builder::new().name("requests".into()).spawn(writes)?;
            Ok((answers, troubles))
        });
        let (answers, troubles) = match threads {
            Ok(threads) => threads,
            Err(error) => {
                let _ = process.kill();
                let _ = process.wait();
                return Err(failed(&error));
            }
        };
        Ok(Self { process, input: Some(input), answers, troubles, asked: 0, version, announced: Vec::new() })
    }

    /// One rollout.
    pub fn ask(&mut self, program: &Program, asked: &Request) -> Result<Answer, Failure> {
        self.announce(program, &asked.recording)?;
        self.asked += 1;
        let id = self.asked;
        let what = format!("request {id} ({})", described(program, asked));
        let longest = longest_answer(asked.times_s.len().saturating_mul(program.headers.len()));
        let line = (request(program, self.version, id, asked), longest, program.timeout);
        let line = self.exchange(program, &what, line, "process.timeout_s")?;
        let answer = answered(&line, id, asked.times_s.len(), &program.headers);
        answer.map_err(|wrong| self.misspoke(program, &what, &wrong))
    }

    /// Many rollouts: in one line where the program speaks a version that has such lines.
    pub fn ask_all(&mut self, program: &Program, asked: &[Arc<Request>]) -> Result<Vec<Answer>, Failure> {
        if asked.len() == 1 || self.version < Version::Two {
            return asked.iter().map(|one| self.ask(program, one)).collect();
        }
        for one in asked {
            self.announce(program, &one.recording)?;
        }
        self.asked += 1;
        let id = self.asked;
        let what = format!("request {id} (a batch of {}, the first {})", asked.len(), described(program, &asked[0]));
        let samples: Vec<usize> = asked.iter().map(|one| one.times_s.len()).collect();
        let longest = samples.iter().map(|samples| longest_answer(samples.saturating_mul(program.headers.len()))).sum();
        let within = program.timeout.saturating_mul(u32::try_from(asked.len()).unwrap_or(u32::MAX));
        let line = self.exchange(program, &what, (batch(program, id, asked), longest, within), "process.timeout_s")?;
        all_answered(&line, id, &samples, &program.headers).map_err(|wrong| self.misspoke(program, &what, &wrong))
    }

    /// Announces a recording to it, unless it knows it.
    fn announce(&mut self, program: &Program, recording: &Recording) -> Result<(), Failure> {
        if self.version < Version::Two {
            return Ok(());
        }
        if let Some(at) = self.announced.iter().position(|number| *number == recording.number) {
            let number = self.announced.remove(at);
            self.announced.push(number);
            return Ok(());
        }
        if self.announced.len() == MOST_RECORDINGS {
            let oldest = self.announced.remove(0);
            self.say(program, &format!("the line that frees recording {oldest}"), |id| forget(id, oldest))?;
        }
        let number = format!("recording {}", recording.number);
        let what = if recording.name.is_empty() { number } else { recording.name.clone() };
        self.say(program, &what, |id| announcement(program, id, recording))?;
        self.announced.push(recording.number);
        Ok(())
    }

    /// Says a line that asks for nothing.
    fn say(&mut self, program: &Program, what: &str, line: impl Fn(u64) -> Vec<u8>) -> Result<(), Failure> {
        self.asked += 1;
        let id = self.asked;
        let what = format!("request {id} ({what})");
        let line =
            self.exchange(program, &what, (line(id), longest_answer(0), program.timeout), "process.timeout_s")?;
        noted(&line, id).map_err(|wrong| self.misspoke(program, &what, &wrong))
    }

    /// Says a line and waits for one, of at most so many bytes, within the time.
    fn exchange(
        &mut self,
        program: &Program,
        what: &str,
        (line, longest, within): (Vec<u8>, usize, Duration),
        key: &str,
    ) -> Result<Vec<u8>, Failure> {
        self.answers.allow(longest);
        // Where it cannot be sent the program ended, which is received next.
        let _ = self.input.as_ref().map(|input| input.send(line));
        let seconds = within.as_secs_f64();
        let name = program.shown();
        match self.answers.next(within) {
            Some(Received::Line(line)) => Ok(line),
            Some(Received::TooLong(most)) => {
                let message =
                    format!("{name}, {what}: expected an answer of at most {most} bytes, found a longer line");
                Err(self.gone(message, "print nothing but answers on standard output, one on each line"))
            }
            None => {
                let message =
                    format!("{name}, {what}: expected an answer within {seconds} s, found none, and stopped it");
                let hint = format!(
                    "let it flush what it prints (Python: `print(…, flush=True)`) and read its input line by line, or give it \
                     more time with `{key}`"
                );
                Err(self.gone(message, &hint))
            }
            Some(Received::End) => {
                let how = match self.process.try_wait_for(FAREWELL) {
                    Some(status) => format!("it ended ({status})"),
                    None => "it closed its standard output".into(),
                };
                let message = format!("{name}, {what}: expected an answer, but {how}");
                let hint = if self.asked == 0 {
                    "run it by hand to see why it ends: it has to answer the first line, and then every line until its input ends"
                } else {
                    "answer every line until the input ends, and `{\"id\": …, \"error\": \"why\"}` where parameters cannot be \
                     simulated"
                };
                Err(self.gone(message, hint))
            }
        }
    }

    /// A failure in what was answered.
    fn misspoke(&mut self, program: &Program, what: &str, wrong: &Wrong) -> Failure {
        self.gone(format!("{}, answer to {what}: {}", program.shown(), wrong.message), &wrong.hint)
    }

    /// Ends the program and adds its last words to the error.
    fn gone(&mut self, message: String, hint: &str) -> Failure {
        self.input = None;
        let _ = self.process.kill();
        let _ = self.process.wait();
        let words = self.troubles.last_words();
        match words.as_slice() {
            [] => Failure::new(message, hint),
            [.., last] => {
                let before = if words.len() > 1 {
                    format!("\n  standard error ended with:\n    {}", words.join("\n    "))
                } else {
                    String::new()
                };
                Failure::new(format!("{message}; its last words: `{last}`"), format!("{hint}{before}"))
            }
        }
    }

    /// Ends its input, upon which a program should end.
    pub fn farewell(&mut self) {
        self.input = None;
    }
}

impl Drop for Child {
    /// Leaves no process behind: one that does not end by itself is killed, and every one is waited for.
    fn drop(&mut self) {
        self.farewell();
        if self.process.try_wait_for(FAREWELL).is_none() {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

/// Waiting no longer than wanted.
trait Patience {
    fn try_wait_for(&mut self, most: Duration) -> Option<std::process::ExitStatus>;
}

impl Patience for Process {
    fn try_wait_for(&mut self, most: Duration) -> Option<std::process::ExitStatus> {
        let until = Instant::now() + most;
        loop {
            match self.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < until => thread::sleep(LOOK),
                Ok(None) | Err(_) => return None,
            }
        }
    }
}

/// What a rollout is of, for users: its parameters, the coefficients that are not absent, its start, and its recording.
fn described(program: &Program, asked: &Request) -> String {
    let own = program.parameters.iter().zip(&asked.parameters).map(|(p, value)| format!("{}={value}", p.name));
    let coefficients = program.candidates.iter().flat_map(|effect| {
        let names = (0..effect.coefficients.len()).map(|i| (effect.parameter_name(i), effect.coefficients[i].absent));
        names.collect::<Vec<_>>()
    });
    let present = coefficients.zip(&asked.coefficients).filter(|((_, absent), value)| absent != *value);
    let states = program.states.iter().zip(&asked.start).map(|(name, value)| format!("start.{name}={value}"));
    let present = present.map(|((name, _), value)| format!("{name}={value}"));
    let numbers = own.chain(present).chain(states).collect::<Vec<_>>().join(" ");
    let recording = &asked.recording.name;
    if recording.is_empty() { numbers } else { format!("{recording}, {numbers}") }
}

fn unstarted(program: &Program, error: &std::io::Error) -> Failure {
    let message = format!("{} could not be started in {}: {error}", program.shown(), program.folder.display());
    let hint = match error.kind() {
        ErrorKind::NotFound if program.executable().is_absolute() => {
            "check `process.command`: its path is seen from the folder in which it runs"
        }
        ErrorKind::NotFound => "install it, or write its path into `process.command`",
        ErrorKind::PermissionDenied => {
            "make it executable (`chmod +x`), or name its interpreter first: [\"python3\", \"program.py\"]"
        }
        _ => "name the program and each argument as a text of its own in `process.command`; no shell is used",
    };
    Failure::new(message, hint)
}

#[cfg(all(test, unix))]
mod tests {
    use std::path::Path;

    use super::super::request::tests::request;
    use super::*;
    use crate::SimulationFile;

    fn shell(script: &str) -> Program {
        let text = format!(
            "kind = \"process\"\n[process]\ncommand = [\"sh\", \"-c\", '''{script}''']\nchannels = [\"z_m\"]\ntimeout_s = 0.2\n\
             [parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n"
        );
        Program::of(&[&SimulationFile::parse(Path::new("a.toml"), &text).unwrap()]).unwrap()
    }

    /// Neither a process nor a zombie stays behind.
    #[test]
    fn nothing_stays_of_it() {
        const GREETS: &str = "read first; echo '{\"tunenet\":1}'; ";
        let stays = |child: &Child| Path::new(&format!("/proc/{}", child.process.id())).exists();
        for (rest, asked) in [
            ("cat > none", false),          // ends with its input
            ("exec sleep 100", false),      // does not end: it is killed
            ("exit 3", false),              // is over already
            ("exec sleep 100", true),       // hangs when it is asked
            ("echo hello; exec cat", true), // says what it should not
        ] {
            let rest = rest.replace("none", "/dev/null");
            let program = shell(&format!("{GREETS}{rest}"));
            let mut child = Child::start(&program).unwrap();
            let place = format!("/proc/{}", child.process.id());
            if asked {
                child.ask(&program, &request(&[1.0], &[0.0, 1.0])).unwrap_err();
                // A failure ends it at once, before the caller releases it.
                assert!(!stays(&child), "{rest}");
            }
            drop(child);
            assert!(!Path::new(&place).exists(), "{rest}");
        }
    }
}
