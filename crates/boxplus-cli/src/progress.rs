//! A line on the terminal for what takes longer than a second.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output::Console;

const PATIENCE: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(120);

/// Shows nothing for a second, then what is going on, until dropped.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// Dropping it ends the patience of the thread that shows the bar.
    _alive: Sender<()>,
}

impl Progress {
    /// Starts with `task`; on anything but a terminal it stays silent.
    pub fn start(console: Console, task: &str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{spinner:.cyan} {msg} {elapsed:.dim}") {
            bar.set_style(style);
        }
        bar.set_message(task.to_owned());
        let (alive, dropped) = channel();
        if console.is_live() {
            let bar = bar.clone();
            thread::spawn(move || show(&bar, &dropped));
        }
        Self { bar, _alive: alive }
    }

    /// What is going on now.
    pub fn now(&self, task: String) {
        self.bar.set_message(task);
    }
}

fn show(bar: &ProgressBar, dropped: &Receiver<()>) {
    if dropped.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        bar.enable_steady_tick(TICK);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
