//! Progress where standard error is no terminal: a plain line now and then, for logs of batch jobs and notebooks.

use std::time::Duration;

use indicatif::ProgressBar;

/// Time between two lines; work that takes less prints none.
pub const INTERVAL: Duration = Duration::from_secs(60);

/// Hands `bar` to `print` every `interval`, until it is finished or dropped.
pub fn report(bar: &ProgressBar, interval: Duration, print: impl Fn(&ProgressBar) + Send + 'static) {
    let bar = bar.downgrade();
    let report = move || loop {
        std::thread::sleep(interval);
        match bar.upgrade() {
            Some(bar) if !bar.is_finished() => print(&bar),
            _ => return,
        }
    };
    // Without a thread to spare the work goes on in silence.
    drop(std::thread::Builder::new().name("progress".into()).spawn(report));
}

/// `training: 120 of 400, 20 s`.
pub fn counted(bar: &ProgressBar) -> String {
    match bar.length() {
        Some(all) if all > 0 => format!("{}: {} of {all}, {}", bar.message(), bar.position(), seconds(bar)),
        _ => elapsed(bar),
    }
}

/// `tuning: 1200 rollouts, 20 s`.
pub fn rolled(bar: &ProgressBar, rollouts: u64) -> String {
    format!("{}: {rollouts} rollouts, {}{}", bar.message(), bar.prefix(), seconds(bar))
}

/// `tuning: 20 s`.
pub fn elapsed(bar: &ProgressBar) -> String {
    format!("{}: {}{}", bar.message(), bar.prefix(), seconds(bar))
}

fn seconds(bar: &ProgressBar) -> String {
    format!("{} s", bar.elapsed().as_secs())
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn lines_come_while_the_work_goes_on_and_end_with_it() {
        let bar = ProgressBar::hidden().with_message("training");
        bar.set_length(400);
        bar.set_position(120);
        let (send, lines) = mpsc::channel();
        report(&bar, Duration::from_millis(5), move |bar| drop(send.send(counted(bar))));
        for _ in 0..2 {
            assert_eq!(lines.recv_timeout(Duration::from_secs(5)).unwrap(), "training: 120 of 400, 0 s");
        }
        bar.finish_and_clear();
        // The thread ends, and with it the channel.
        while lines.recv_timeout(Duration::from_secs(5)).is_ok() {}
        assert!(matches!(lines.try_recv(), Err(mpsc::TryRecvError::Disconnected)));
    }

    #[test]
    fn work_without_an_end_says_how_long_it_takes() {
        let bar = ProgressBar::new_spinner().with_message("tuning");
        assert_eq!((elapsed(&bar), rolled(&bar, 7)), ("tuning: 0 s".into(), "tuning: 7 rollouts, 0 s".into()));
        assert_eq!(counted(&bar), "tuning: 0 s");
    }
}
