//! Sign of life on a terminal while something takes long: a spinner with the time so far.

#[cfg(feature = "progress")]
use with_indicatif::Waiting;

/// Runs a task; `text` says beside the spinner what it does. Nothing appears within the first
/// second, unless standard error is a terminal, and in a build without the feature `progress`.
pub fn during<T>(text: &'static str, task: impl FnOnce() -> T) -> T {
    #[cfg(feature = "progress")]
    let _waiting = Waiting::begin(text);
    #[cfg(not(feature = "progress"))]
    let _ = text;
    task()
}

#[cfg(feature = "progress")]
mod with_indicatif {
    use std::io::IsTerminal;
    use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
    use std::thread::JoinHandle;
    use std::time::Duration;

    use indicatif::{ProgressBar, ProgressStyle};

    /// Time after which the spinner appears.
    const PATIENCE: Duration = Duration::from_secs(1);

    /// Time between two pictures of the spinner.
    const TICK: Duration = Duration::from_millis(120);

    /// Spinner on standard error that appears after a second and is removed when dropped.
    #[derive(Debug)]
    pub(super) struct Waiting(Option<(Sender<()>, JoinHandle<()>)>);

    impl Waiting {
        /// Begins to wait.
        pub(super) fn begin(text: &'static str) -> Self {
            if !std::io::stderr().is_terminal() {
                return Self(None);
            }
            let (sender, ended) = channel::<()>();
            let thread = std::thread::spawn(move || {
                if ended.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
                // The template is a constant and valid, and the default style would do as well.
                let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}")
                    .unwrap_or_else(|_| ProgressStyle::default_spinner());
                let spinner = ProgressBar::new_spinner().with_style(style).with_elapsed(PATIENCE);
                spinner.set_message(text);
                spinner.enable_steady_tick(TICK);
                // Ends when the sender is dropped.
                let _ = ended.recv();
                spinner.finish_and_clear();
            });
            Self(Some((sender, thread)))
        }
    }

    impl Drop for Waiting {
        fn drop(&mut self) {
            if let Some((sender, thread)) = self.0.take() {
                drop(sender);
                // A thread that panicked has no spinner either.
                let _ = thread.join();
            }
        }
    }
}
