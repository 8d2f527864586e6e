//! The numbers of a text table, with every line that cannot be used.

use crate::findings;
use std::path::{Path, PathBuf};

use super::columns::{Header, Layout, Source, layout};
use super::dates;
use super::lines::{Line, Lines, MOST_IDLE, NoNumber, cells, idle, named, number, separator};
use super::own_columns;
use crate::quantity::Quantity;
use crate::recording::{LARGEST, MOST_NUMBERS, ReadOptions};
use crate::shown::{counted, shortened};
use crate::{Error, Result};
use tunenet_core::observation::{Kind, Note};

/// Most broken lines that are kept with their text; the rest are counted.
const MOST_BROKEN: usize = 10;

/// Largest share of samples that may repeat the time before them. Stamps rounded to the millisecond repeat now and then
/// in a camera's series; more than this is another kind of file.
const MOST_REPEATED: f64 = 0.05;

/// Largest share of lines that may be left out as broken.
const MOST_SKIPPED: f64 = 0.05;

/// How many times its neighbours' interval a time may be ahead before it, and not the next line, is called wrong.
const LEAP: f64 = 10.0;

/// Least time between two impacts, s. Impacts closer than this are one impact.
const SHORTEST_INTERVAL_S: f64 = 1e-6;

/// Greatest number of an impact. A rollout computes every impact up to the last one.
const GREATEST_BOUNCE_NUMBER: f64 = 9_999.0;

/// A line that cannot be used, and why.
#[derive(Debug, Clone)]
pub(crate) struct Broken {
    pub line: usize,
    pub column: usize,
    pub width: usize,
    pub source_line: String,
    pub message: String,
    pub hint: String,
}

impl Broken {
    /// What is wrong with cell `index` of a line.
    fn at(line: &Line, separator: Option<char>, index: usize, message: String, hint: &'static str) -> Self {
        let (column, width) = cells(&line.text, separator).get(index).map_or((1, 1), |cell| cell.place(&line.text));
        Self { line: line.number, column, width, source_line: line.text.clone(), message, hint: hint.into() }
    }

    pub fn error(self, path: &Path, further: &[usize], count: usize) -> Error {
        let lines: Vec<String> = further.iter().map(usize::to_string).collect();
        let more = match count.saturating_sub(1 + further.len()) {
            _ if further.is_empty() => String::new(),
            0 if further.len() == 1 => format!("; also line {}", lines[0]),
            0 => format!("; also lines {}", lines.join(", ")),
            more => format!("; also lines {} and {more} more", lines.join(", ")),
        };
        Error::Text {
            path: path.into(),
            line: self.line,
            column: self.column,
            width: self.width,
            source_line: self.source_line,
            message: self.message,
            hint: format!("{}{more}", self.hint),
        }
    }
}

/// A table as far as it can be read.
#[derive(Debug)]
pub(crate) struct Scan {
    path: PathBuf,
    separator: Option<char>,
    pub layout: Layout,
    pub header: Line,
    /// Lines after the header that hold something.
    pub rows: usize,
    /// Empty for bounce times without numbers.
    pub clock: Vec<f64>,
    pub values: Vec<f64>,
    /// The line of every sample, for bounce times alone, where single lines are named later.
    pub lines: Vec<usize>,
    /// The first few lines that cannot be used.
    pub broken: Vec<Broken>,
    pub broken_count: usize,
    /// The line of the last good sample, where time counts.
    last: Option<Line>,
    /// Samples left out because a cell is empty, and the first such line.
    empty: (usize, usize),
    /// Samples that say the same as the one before, time included.
    same: usize,
    /// Samples at the time of the one before that say something else; the first is kept to be named.
    repeated: (usize, Option<Broken>),
    /// The first zero of a bounce list that may turn out to be its end.
    zero: Option<Line>,
    zeros: usize,
}

/// Reads all lines of a table. `Err` is a file that has no layout; broken lines are in the result.
pub(crate) fn scan(path: &Path, options: &ReadOptions) -> Result<Scan> {
    scan_at_most(path, options, MOST_NUMBERS)
}

fn is_empty(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|file| file.len() == 0)
}

fn scan_at_most(path: &Path, options: &ReadOptions, most: usize) -> Result<Scan> {
    let mut lines = Lines::open(path)?;
    let Some(first) = lines.next()? else {
        let hint = "give a file with a header, such as `t_s,x_m,y_m,z_m` of a ball or `t_s,elbow_goal_rad,elbow_rad` of a robot, and one sample \
            a line";
        let found = if is_empty(path) { "an empty file" } else { "blank lines and comments alone" };
        return Err(Error::file(path, format!("expected a table, found {found}"), hint));
    };
    let separator = separator(&first.text);
    let names = cells(&first.text, separator);
    let (width, named) = (names.len(), named(&names, separator));
    let header = Header { path, line: &first, separator, named, joints: &options.joints, rows: None };
    let layout = if options.channels.is_empty() {
        layout(&header, &options.columns)?
    } else {
        own_columns::layout(&header, options)?
    };
    let mut scan = Scan {
        path: path.into(),
        separator,
        layout,
        header: first.clone(),
        rows: 0,
        clock: Vec::new(),
        values: Vec::new(),
        lines: Vec::new(),
        broken: Vec::new(),
        broken_count: 0,
        last: None,
        empty: (0, 0),
        same: 0,
        repeated: (0, None),
        zero: None,
        zeros: 0,
    };
    let mut next = if named { lines.next()? } else { Some(first) };
    while let Some(line) = next {
        scan.rows += 1;
        if let Err(broken) = scan.add(line, width) {
            scan.blame(*broken);
        }
        if scan.values.len() > most {
            let bytes = std::fs::metadata(path).map_or(0, |about| about.len());
            let message = format!("expected at most {most} numbers, found more in its {bytes} bytes");
            return Err(Error::file(path, message, "cut it into pieces, or keep fewer samples per second"));
        }
        if scan.rows - scan.values.len() / scan.layout.channels.len() > MOST_IDLE {
            return Err(idle(path, "lines without one"));
        }
        next = lines.next()?;
    }
    Ok(scan)
}

impl Scan {
    fn blame(&mut self, broken: Broken) {
        self.broken_count += 1;
        // A leap is known one line later, so it may have to go before the line that was met since.
        let at = self.broken.partition_point(|other| other.line < broken.line);
        self.broken.insert(at, broken);
        self.broken.truncate(MOST_BROKEN);
    }

    /// Takes the last sample back where its time leapt ahead and `time` continues from the one before: one outlier must
    /// not condemn all that follow.
    fn unleap(&mut self, time: f64) {
        let [.., before, last] = self.clock[..] else { return };
        if !(before < time && time < last && last - before > LEAP * (time - before)) {
            return;
        }
        let (Some(line), Some(source)) = (self.last.take(), self.layout.clock) else { return };
        self.clock.pop();
        self.values.truncate(self.values.len() - self.layout.channels.len());
        let message = format!("the time leaps: expected less than {time:?}, the time after it, found {last:?}");
        let hint = "correct the time, or delete the line";
        self.blame(Broken::at(&line, self.separator, source.column, message, hint));
    }

    /// Adds one line's sample.
    fn add(&mut self, line: Line, width: usize) -> std::result::Result<(), Box<Broken>> {
        let cells = cells(&line.text, self.separator);
        let filled = cells.iter().rposition(|cell| !cell.text.is_empty()).map_or(0, |last| last + 1);
        if cells.len() < width || filled > width {
            let found = if cells.len() < width { cells.len() } else { filled };
            let message = format!("expected {width} cells, found {found}");
            let index = found.min(cells.len()).saturating_sub(1).min(if filled > width { width } else { usize::MAX });
            return Err(Box::new(Broken::at(&line, self.separator, index, message, "complete or delete the line")));
        }
        let sources = self.layout.clock.iter().chain(self.layout.values.iter().flatten());
        if sources.clone().any(|source| cells[source.column].text.is_empty()) {
            if self.empty.0 == 0 {
                self.empty.1 = line.number;
            }
            self.empty.0 += 1;
            return Ok(());
        }
        let read = |source: &Source| {
            let text = cells[source.column].text;
            let broken = |expected: &str| {
                // Damaged numbers can be hundreds of digits long.
                let shown = shortened(text);
                let message = format!("`{}`: expected {expected}, found `{shown}`", self.layout.header(source));
                let dated = source.quantity == Quantity::Time && dates::is_date(text);
                let hint = if dated { dates::HINT } else { "correct the cell, or empty it to leave the sample out" };
                Box::new(Broken::at(&line, self.separator, source.column, message, hint))
            };
            match number(text, self.separator).map(|value| source.value(value)) {
                Ok(value) if value.abs() <= LARGEST => Ok(value),
                Ok(_) => Err(broken(&format!("at most {LARGEST:e}"))),
                Err(NoNumber::Word) => Err(broken("a number")),
                Err(NoNumber::NotFinite) => Err(broken("a finite number")),
            }
        };
        let time = self.layout.clock.as_ref().map(read).transpose()?;
        let sample = self.layout.values.iter().map(|source| source.as_ref().map_or(Ok(0.0), read));
        let sample = sample.collect::<std::result::Result<Vec<f64>, _>>()?;
        if self.layout.kind == Kind::EventTimes {
            self.add_bounce(&line, time, sample[0])
        } else {
            self.add_sample(line, time.unwrap_or(0.0), &sample)
        }
    }

    fn add_sample(&mut self, line: Line, time: f64, sample: &[f64]) -> std::result::Result<(), Box<Broken>> {
        let clock = self.layout.clock.map_or(0, |source| source.column);
        self.unleap(time);
        if let Some(&last) = self.clock.last()
            && time <= last
        {
            let broken = |message, hint| Broken::at(&line, self.separator, clock, message, hint);
            if time < last {
                let message = format!("the time falls: expected more than {last:?}, found {time:?}");
                return Err(Box::new(broken(message, "sort the lines by time, or delete this one")));
            }
            if self.values[self.values.len() - sample.len()..] == *sample {
                self.same += 1;
                return Ok(());
            }
            if self.repeated.1.is_none() {
                let message = format!("the time repeats: expected more than {last:?}, found {time:?}");
                self.repeated.1 =
                    Some(broken(message, "write the time with more digits, or keep one line for each time"));
            }
            self.repeated.0 += 1;
            return Ok(());
        }
        self.clock.push(time);
        self.values.extend_from_slice(sample);
        self.last = Some(line);
        Ok(())
    }

    /// Impact times have to rise; zeros are allowed at the end, where a stopwatch leaves its unused rows.
    fn add_bounce(&mut self, line: &Line, number: Option<f64>, time: f64) -> std::result::Result<(), Box<Broken>> {
        let column = self.layout.values[0].map_or(0, |source| source.column);
        if time == 0.0 && !self.values.is_empty() {
            self.zeros += 1;
            self.zero.get_or_insert_with(|| line.clone());
            return Ok(());
        }
        if let Some(zero) = self.zero.take() {
            let last = self.values.last().copied().unwrap_or(0.0);
            let message = format!("the bounce time falls: expected more than {last:?}, found 0 before further times");
            return Err(Box::new(Broken::at(&zero, self.separator, column, message, "delete the line")));
        }
        if let Some(&last) = self.values.last()
            && time <= last
        {
            let message = format!("the bounce time falls: expected more than {last:?}, found {time:?}");
            return Err(Box::new(Broken::at(
                line,
                self.separator,
                column,
                message,
                "sort the times, or delete the line",
            )));
        }
        if let Some(&last) = self.values.last()
            && time - last < SHORTEST_INTERVAL_S
        {
            let message = format!(
                "the bounce time hardly rises: expected {SHORTEST_INTERVAL_S:e} s or more after {last:?}, found {time:?}"
            );
            let hint = "check the unit of the times, or delete the line";
            return Err(Box::new(Broken::at(line, self.separator, column, message, hint)));
        }
        if let (Some(number), Some(source)) = (number, self.layout.clock)
            && !(number.fract() == 0.0 && (0.0..=GREATEST_BOUNCE_NUMBER).contains(&number))
        {
            let message =
                format!("expected a whole bounce number from 0 to {GREATEST_BOUNCE_NUMBER}, found {number:?}");
            let hint = "count the impacts, those too that were not recorded: 0, 1, 2";
            return Err(Box::new(Broken::at(line, self.separator, source.column, message, hint)));
        }
        if let (Some(number), Some(&last), Some(source)) = (number, self.clock.last(), self.layout.clock)
            && number <= last
        {
            let message = format!("the bounce number falls: expected more than {last:?}, found {number:?}");
            let hint = "number the bounces in the order of their times";
            return Err(Box::new(Broken::at(line, self.separator, source.column, message, hint)));
        }
        self.clock.extend(number);
        self.values.push(time);
        self.lines.push(line.number);
        Ok(())
    }

    /// Refuses the table where a line is broken, where it has no line, or where too many times repeat.
    ///
    /// With `skip_broken`, broken lines are left out where they are few and never enough to be the recording itself.
    pub fn check(&self, skip_broken: bool) -> Result<()> {
        let few = self.broken_count as f64 <= MOST_SKIPPED * self.rows as f64;
        if let Some(first) = self.broken.first().filter(|_| !(skip_broken && few)) {
            let further: Vec<usize> = self.broken.iter().skip(1).map(|broken| broken.line).collect();
            let mut broken = first.clone();
            if few && !skip_broken {
                broken.hint = format!("{}, or leave it out with `--skip-broken`", broken.hint);
            }
            return Err(broken.error(&self.path, &further, self.broken_count));
        }
        if self.rows == 0 {
            let header = &self.header;
            return Err(Error::Text {
                path: self.path.clone(),
                line: header.number,
                column: 1,
                width: header.text.chars().count().max(1),
                source_line: header.text.clone(),
                message: "expected samples after the header, found none".into(),
                hint: "record again, or give the file that holds the samples".into(),
            });
        }
        match &self.repeated {
            (count, Some(first)) if *count as f64 > MOST_REPEATED * self.rows as f64 => {
                Err(first.clone().error(&self.path, &[], 1))
            }
            _ => Ok(()),
        }
    }

    /// The lines that were left out as broken, each of the first few with what is wrong.
    fn skipped(&self) -> Option<Note> {
        let each: Vec<String> = self.broken.iter().map(|b| format!("line {}: {}", b.line, b.message)).collect();
        let more = self.broken_count - each.len();
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        let text = format!("{} left out as broken: {}{more}", counted(self.broken_count, "line"), each.join("; "));
        (self.broken_count > 0).then(|| Note::new(findings::ROWS_BROKEN, text, "see whether the rest can be trusted"))
    }

    /// What was noticed, the layout's notes first.
    pub fn notes(&self) -> Vec<Note> {
        let mut notes = self.layout.notes.clone();
        notes.extend(self.skipped());
        if self.empty.0 > 0 {
            let text = format!(
                "{} left out for an empty cell, the first at line {}",
                counted(self.empty.0, "sample"),
                self.empty.1
            );
            notes.push(Note::new(findings::ROWS_EMPTY_CELL, text, ""));
        }
        if self.same > 0 {
            let text = format!("{} left out that repeat the line before", counted(self.same, "sample"));
            notes.push(Note::new(findings::ROWS_REPEATED, text, ""));
        }
        if let (count @ 1.., Some(first)) = &self.repeated {
            let text = format!(
                "{} left out at the time of the sample before, the first at line {}",
                counted(*count, "sample"),
                first.line
            );
            notes.push(Note::new(findings::CLOCK_REPEATED, text, "record the time with more digits"));
        }
        if let Some(zero) = &self.zero {
            let text =
                format!("{} of 0 at the end left out, from line {} on", counted(self.zeros, "sample"), zero.number);
            notes.push(Note::new(findings::BOUNCES_TRAILING_ZERO, text, ""));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};

    #[test]
    fn too_large_a_table_is_refused_with_its_size() {
        let (_folder, path) = file("a.csv", "t_s,u_px,v_px\n0,1,2\n1,1,2\n2,1,2\n");
        assert_eq!(scan_at_most(&path, &ReadOptions::default(), 6).unwrap().values.len(), 6);
        let (message, hint) = error_text(&scan_at_most(&path, &ReadOptions::default(), 5).unwrap_err());
        assert_eq!(message, "a.csv: expected at most 5 numbers, found more in its 32 bytes");
        assert_eq!(hint, "cut it into pieces, or keep fewer samples per second");
    }

    #[test]
    fn a_file_that_goes_on_without_a_sample_is_refused() {
        for (text, what) in [
            (format!("t_s,z_m\n{}", "\n".repeat(MOST_IDLE + 1)), "empty lines"),
            (format!("t_s,z_m\n{}", "# \n".repeat(MOST_IDLE + 1)), "empty lines"),
            (format!("t_s,z_m\n{}", "0,\n".repeat(MOST_IDLE + 1)), "lines without one"),
            (format!("t_s,z_m\n0,1\n{}", "x\n".repeat(MOST_IDLE + 1)), "lines without one"),
        ] {
            let (_folder, path) = file("a.csv", text);
            let (message, _) = error_text(&scan(&path, &ReadOptions::default()).unwrap_err());
            assert_eq!(message, format!("a.csv: expected samples, found more than {MOST_IDLE} {what}"));
        }
    }
}
