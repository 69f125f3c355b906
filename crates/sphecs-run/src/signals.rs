//! Ctrl-C and SIGTERM end a run with whole files and a checkpoint; a second one ends it at once. SIGUSR1 asks for a checkpoint.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// A request to stop that a run heeds after its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, as batch systems send it before the end of the slot.
    Terminate,
}

impl Signal {
    /// Exit code by the custom of shells: 128 + the number of the signal.
    pub fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }

    /// Word for messages and `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Signal::Interrupt => "interrupted",
            Signal::Terminate => "terminated",
        }
    }

    fn number(self) -> i32 {
        match self {
            Signal::Interrupt => SIGINT,
            Signal::Terminate => SIGTERM,
        }
    }
}

/// What has been asked for since the handlers were set.
#[derive(Debug)]
pub struct Signals {
    received: Arc<AtomicUsize>,
    checkpoint: Arc<AtomicBool>,
}

impl Signals {
    /// Sets the handlers. They stay for the life of the process.
    ///
    /// # Errors
    /// When the system refuses a handler.
    pub fn listen() -> io::Result<Self> {
        let armed = Arc::new(AtomicBool::new(false));
        let received = Arc::new(AtomicUsize::new(0));
        for signal in [Signal::Interrupt, Signal::Terminate] {
            // The order matters: the first signal finds the flag down, passes the shutdown and arms it for the second.
            flag::register_conditional_shutdown(
                signal.number(),
                i32::from(signal.exit_code()),
                Arc::clone(&armed),
            )?;
            flag::register(signal.number(), Arc::clone(&armed))?;
            flag::register_usize(signal.number(), Arc::clone(&received), signal.number() as usize)?;
        }
        Ok(Self { received, checkpoint: checkpoint_flag()? })
    }

    /// Those of a run beside others: what stops one stops all, a checkpoint is asked of each.
    ///
    /// # Errors
    /// When the system refuses a handler.
    pub fn beside(&self) -> io::Result<Self> {
        Ok(Self { received: Arc::clone(&self.received), checkpoint: checkpoint_flag()? })
    }

    /// Whether a checkpoint has been asked for since this was asked last.
    pub fn take_checkpoint(&self) -> bool {
        self.checkpoint.swap(false, Ordering::Relaxed)
    }

    /// As if this signal had come: all that heed these signals stop.
    pub fn ask(&self, signal: Signal) {
        self.received.store(signal.number() as usize, Ordering::Relaxed);
    }

    /// The signal received last, if any.
    pub fn received(&self) -> Option<Signal> {
        let number = self.received.load(Ordering::Relaxed);
        [Signal::Interrupt, Signal::Terminate].into_iter().find(|signal| signal.number() as usize == number)
    }
}

/// A flag that each SIGUSR1 raises.
fn checkpoint_flag() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    flag::register(SIGUSR1, Arc::clone(&flag))?;
    Ok(flag)
}
