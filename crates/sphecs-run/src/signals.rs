//! Signals that a run obeys: SIGINT and SIGTERM stop it after its step, SIGUSR1 requests a
//! checkpoint.
//!
//! The first SIGINT or SIGTERM ends the run with complete files and a checkpoint, the second ends
//! the process at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// Request to stop, obeyed after the current step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, as batch systems send it before the end of the slot.
    Terminate,
}

impl Signal {
    /// Returns the exit code by the convention of shells: 128 + the number of the signal.
    pub fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }

    fn number(self) -> i32 {
        match self {
            Signal::Interrupt => SIGINT,
            Signal::Terminate => SIGTERM,
        }
    }
}

/// Requests received since the handlers were set.
#[derive(Debug)]
pub struct Signals {
    received: Arc<AtomicUsize>,
    checkpoint: Arc<AtomicBool>,
}

impl Signals {
    /// Sets the handlers, which stay for the life of the process.
    ///
    /// # Errors
    /// The system refuses a handler.
    pub fn listen() -> io::Result<Self> {
        let armed = Arc::new(AtomicBool::new(false));
        let received = Arc::new(AtomicUsize::new(0));
        for signal in [Signal::Interrupt, Signal::Terminate] {
            // The order matters: the first signal finds the flag unset, so the process survives,
            // and sets it for the second.
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

    /// Returns the signals of a concurrent run: stop requests are shared, each run has its own
    /// checkpoint flag.
    ///
    /// # Errors
    /// The system refuses a handler.
    pub fn for_concurrent_run(&self) -> io::Result<Self> {
        Ok(Self { received: Arc::clone(&self.received), checkpoint: checkpoint_flag()? })
    }

    /// Returns true if a checkpoint was requested since the last call.
    pub fn take_checkpoint_request(&self) -> bool {
        self.checkpoint.swap(false, Ordering::Relaxed)
    }

    /// Stops all runs that share these signals, as if the signal had been received.
    pub fn raise(&self, signal: Signal) {
        self.received.store(signal.number() as usize, Ordering::Relaxed);
    }

    /// Returns the last stop request.
    pub fn received(&self) -> Option<Signal> {
        let number = self.received.load(Ordering::Relaxed);
        [Signal::Interrupt, Signal::Terminate].into_iter().find(|signal| signal.number() as usize == number)
    }
}

/// Returns a flag that each SIGUSR1 sets.
fn checkpoint_flag() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    flag::register(SIGUSR1, Arc::clone(&flag))?;
    Ok(flag)
}
