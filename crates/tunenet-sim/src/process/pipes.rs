//! Reading what a program prints: its answers line by line, never longer than asked for, and the end of what it says of its
//! troubles.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How much of standard error is kept, bytes.
const KEPT: usize = 4096;
/// Lines of it that are reported.
const LINES_REPORTED: usize = 5;
/// How long its end is waited for once a program is gone.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// What came from standard output.
#[derive(Debug)]
pub(super) enum Received {
    /// A line without its end.
    Line(Vec<u8>),
    /// More than so many bytes without an end.
    TooLong(usize),
    /// Nothing more will come.
    End,
}

/// Standard output, read by its own thread, so that waiting has a time limit.
#[derive(Debug)]
pub(super) struct Answers {
    lines: Receiver<Received>,
    longest: Arc<AtomicUsize>,
}

impl Answers {
    /// Reads `output` until its end; one line is read ahead at most.
    pub fn of(output: impl Read + Send + 'static) -> std::io::Result<Self> {
        let (received, lines) = sync_channel(1);
        let longest = Arc::new(AtomicUsize::new(0));
        let limit = Arc::clone(&longest);
        thread::Builder::new()
            .name("answers".into())
            .spawn(move || listen(BufReader::new(output), &limit, &received))?;
        Ok(Self { lines, longest })
    }

    /// Allows the next line this many bytes.
    pub fn allow(&self, longest: usize) {
        self.longest.store(longest, Ordering::Relaxed);
    }

    /// The next line; `None` where none came in time.
    pub fn next(&self, within: Duration) -> Option<Received> {
        use std::sync::mpsc::RecvTimeoutError::{Disconnected, Timeout};
        match self.lines.recv_timeout(within) {
            Ok(received) => Some(received),
            Err(Timeout) => None,
            Err(Disconnected) => Some(Received::End),
        }
    }
}

fn listen(mut output: impl BufRead, limit: &AtomicUsize, received: &SyncSender<Received>) {
    let mut line = Vec::new();
    loop {
        let part = match output.fill_buf() {
            Ok([]) => break,
            Ok(part) => part,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        let end = part.iter().position(|byte| *byte == b'\n');
        line.extend_from_slice(&part[..end.unwrap_or(part.len())]);
        let used = end.map_or(part.len(), |end| end + 1);
        output.consume(used);
        // What was begun unasked is looked at with the limit of the next request.
        let most = limit.load(Ordering::Relaxed).max(super::protocol::LONGEST_GREETING);
        if line.len() > most {
            // Nobody is there any more where sending fails.
            let _ = received.send(Received::TooLong(most));
            return;
        }
        if end.is_some() && received.send(Received::Line(std::mem::take(&mut line))).is_err() {
            return;
        }
    }
    if !line.is_empty() {
        // A last line without its end counts as one.
        let _ = received.send(Received::Line(line));
    }
    let _ = received.send(Received::End);
}

/// Standard error, read to its end so that the pipe never fills, of which the last bytes are kept.
#[derive(Debug)]
pub(super) struct Troubles {
    kept: Arc<Mutex<VecDeque<u8>>>,
    ended: Receiver<()>,
}

impl Troubles {
    pub fn of(mut error: impl Read + Send + 'static) -> std::io::Result<Self> {
        let kept = Arc::new(Mutex::new(VecDeque::with_capacity(KEPT)));
        let (done, ended) = sync_channel(1);
        let keeps = Arc::clone(&kept);
        thread::Builder::new().name("troubles".into()).spawn(move || {
            let mut part = [0; KEPT];
            while let Ok(count @ 1..) = error.read(&mut part) {
                let mut kept = keeps.lock().unwrap_or_else(PoisonError::into_inner);
                kept.extend(&part[..count]);
                let over = kept.len().saturating_sub(KEPT);
                kept.drain(..over);
            }
            let _ = done.send(());
        })?;
        Ok(Self { kept, ended })
    }

    /// The last lines that a program, which is gone now, wrote to standard error.
    pub fn last_words(&self) -> Vec<String> {
        // A child of the program may hold the pipe open: what is there by then has to do.
        let _ = self.ended.recv_timeout(LAST_WORDS);
        let bytes: Vec<u8> = self.kept.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let lines: Vec<String> = text.lines().map(super::failure::printable).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(LINES_REPORTED)..].to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn received(bytes: impl AsRef<[u8]> + Send + 'static, longest: usize) -> Vec<String> {
        let limit = AtomicUsize::new(longest);
        let (send, receive) = sync_channel(100);
        listen(Cursor::new(bytes), &limit, &send);
        drop(send);
        let text = |line: Received| match line {
            Received::Line(line) => String::from_utf8_lossy(&line).into_owned(),
            other => format!("{other:?}"),
        };
        receive.iter().map(text).collect()
    }

    #[test]
    fn lines_come_one_by_one_and_the_last_needs_no_end() {
        assert_eq!(received("a\n\nb", 10), ["a", "", "b", "End"]);
    }

    /// A line without an end is given up after the greatest length of an answer, independent of what follows.
    #[test]
    fn a_line_has_a_greatest_length() {
        let long = super::super::protocol::LONGEST_GREETING + 1;
        assert_eq!(received(vec![b'x'; 10 * long], 10), [format!("TooLong({})", long - 1)]);
        assert_eq!(received(vec![b'x'; long], 2 * long).len(), 2);
    }

    #[test]
    fn the_last_lines_of_standard_error_are_kept() {
        let text = (0..10_000).map(|i| format!("line {i}")).collect::<Vec<_>>().join("\n");
        let troubles = Troubles::of(Cursor::new(text)).unwrap();
        assert_eq!(troubles.last_words(), (9995..10_000).map(|i| format!("line {i}")).collect::<Vec<_>>());
    }

    proptest::proptest! {
        /// All input, in any pieces, is cut at its line ends and nowhere else.
        #[test]
        fn lines_do_not_depend_on_how_they_come(bytes: Vec<u8>, piece in 1..20_usize) {
            let limit = AtomicUsize::new(1 << 20);
            let (send, receive) = sync_channel(1 + bytes.len() + 2);
            listen(BufReader::with_capacity(piece, Cursor::new(bytes.clone())), &limit, &send);
            drop(send);
            let found: Vec<Vec<u8>> = receive
                .iter()
                .filter_map(|line| match line {
                    Received::Line(line) => Some(line),
                    Received::TooLong(_) | Received::End => None,
                })
                .collect();
            let mut expected: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            if expected.last().is_some_and(|last| last.is_empty()) {
                expected.pop();
            }
            proptest::prop_assert_eq!(found, expected);
        }
    }
}
