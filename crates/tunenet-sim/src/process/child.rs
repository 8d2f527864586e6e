//! One running copy of a program.

use std::io::{ErrorKind, Write};
use std::process::{Child as Process, Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::failure::Failure;
use super::pipes::{Answers, Received, Troubles};
use super::program::Program;
use super::protocol::{Answer, LONGEST_GREETING, Wrong, answered, greeted, greeting, longest_answer, request};

/// How long a program may take to end by itself once its input has ended.
const FAREWELL: Duration = Duration::from_millis(300);
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
}

impl Child {
    /// Starts a copy and greets it.
    pub fn start(program: &Program) -> Result<Self, Failure> {
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
        let mut child = Self { process, input: Some(input), answers, troubles, asked: 0 };
        let hello = (greeting(program), LONGEST_GREETING, program.start_timeout);
        let line = child.exchange(program, "the first line", hello, "process.start_timeout_s")?;
        greeted(&line).map_err(|wrong| child.misspoke(program, "the first line", &wrong))?;
        Ok(child)
    }

    /// One rollout with these parameters at these instants.
    pub fn ask(&mut self, program: &Program, parameters: &[f64], clock: &[f64]) -> Result<Answer, Failure> {
        self.asked += 1;
        let id = self.asked;
        let named = program.parameters.iter().zip(parameters).map(|(p, value)| format!("{}={value}", p.name));
        let what = format!("request {id} ({})", named.collect::<Vec<_>>().join(" "));
        let longest = longest_answer(clock.len().saturating_mul(program.headers.len()));
        let line = (request(program, id, parameters, clock), longest, program.timeout);
        let line = self.exchange(program, &what, line, "process.timeout_s")?;
        answered(&line, id, clock.len(), &program.headers).map_err(|wrong| self.misspoke(program, &what, &wrong))
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

    use super::*;
    use crate::SimulationFile;

    fn shell(script: &str) -> Program {
        let text = format!(
            "kind = \"process\"\n[process]\ncommand = [\"sh\", \"-c\", '''{script}''']\nchannels = [\"z_m\"]\ntimeout_s = 0.2\n\
             [parameters.k]\nvalue = 1\nmin = 0\nmax = 2\n"
        );
        Program::of(&SimulationFile::parse(Path::new("a.toml"), &text).unwrap()).unwrap()
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
                child.ask(&program, &[1.0], &[0.0, 1.0]).unwrap_err();
                // A failure ends it at once, before the caller releases it.
                assert!(!stays(&child), "{rest}");
            }
            drop(child);
            assert!(!Path::new(&place).exists(), "{rest}");
        }
    }
}
