//! Progress bar on a terminal, built with the feature `progress` only.

#[cfg(feature = "progress")]
pub(crate) use with_indicatif::Bar;
#[cfg(not(feature = "progress"))]
pub(crate) use without::Bar;

#[cfg(feature = "progress")]
mod with_indicatif {
    use std::io::IsTerminal;

    use indicatif::{ProgressBar, ProgressStyle};

    /// Steps of the bar: more than any terminal has columns.
    const STEPS: u64 = 10_000;

    /// Bar on standard error.
    #[derive(Debug)]
    pub(crate) struct Bar(ProgressBar);

    impl Bar {
        /// Returns a bar if standard error is a terminal.
        pub(crate) fn on_terminal() -> Option<Self> {
            std::io::stderr().is_terminal().then(|| {
                // The template is a constant and valid, and the default style would do as well.
                let style = ProgressStyle::with_template("{bar:24} {msg}")
                    .unwrap_or_else(|_| ProgressStyle::default_bar());
                Self(ProgressBar::new(STEPS).with_style(style))
            })
        }

        /// Draws the part done, 0 to 1, and a text beside it.
        pub(crate) fn show(&self, fraction: f64, text: String) {
            self.0.set_position((fraction * STEPS as f64) as u64);
            self.0.set_message(text);
        }

        /// Hides the bar while `print` runs.
        pub(crate) fn suspend(&self, print: impl FnOnce()) {
            self.0.suspend(print);
        }

        /// Removes the bar.
        pub(crate) fn clear(self) {
            self.0.finish_and_clear();
        }
    }
}

#[cfg(not(feature = "progress"))]
mod without {
    /// Bar of a build without the feature, of which there is none.
    #[derive(Debug)]
    pub(crate) enum Bar {}

    impl Bar {
        /// Returns None.
        pub(crate) fn on_terminal() -> Option<Self> {
            None
        }

        /// Does nothing: there is no bar.
        pub(crate) fn show(&self, _fraction: f64, _text: String) {
            match *self {}
        }

        /// Does nothing: there is no bar.
        pub(crate) fn suspend(&self, _print: impl FnOnce()) {
            match *self {}
        }

        /// Does nothing: there is no bar.
        pub(crate) fn clear(self) {
            match self {}
        }
    }
}
