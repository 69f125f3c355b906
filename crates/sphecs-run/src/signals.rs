//! Signals that a run obeys: SIGINT, SIGTERM, SIGHUP and SIGXCPU stop it after its step, SIGUSR1
//! and SIGUSR2 request a checkpoint, SIGXFSZ makes a write fail.
//!
//! A request to stop ends the run with complete files and a checkpoint. A second SIGINT or SIGTERM
//! ends the process at once. SIGHUP and SIGXCPU do not: a terminal that closes sends the first
//! twice, and the system repeats the other every second.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};
use signal_hook::flag;

/// Request to stop, obeyed after the current step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// SIGTERM, as batch systems send it before the end of the slot.
    Terminate,
    /// SIGHUP: the terminal was closed.
    HangUp,
    /// SIGXCPU: the processor time of `ulimit -t` or of a batch system is used up.
    ProcessorTime,
}

impl Signal {
    const ALL: [Signal; 4] = [Signal::Interrupt, Signal::Terminate, Signal::HangUp, Signal::ProcessorTime];

    /// Returns the exit code by the convention of shells: 128 + the number of the signal.
    pub fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }

    fn number(self) -> i32 {
        match self {
            Signal::Interrupt => SIGINT,
            Signal::Terminate => SIGTERM,
            Signal::HangUp => SIGHUP,
            Signal::ProcessorTime => SIGXCPU,
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
        let ignored = ignored_signals();
        for signal in Signal::ALL {
            let repeats = matches!(signal, Signal::HangUp | Signal::ProcessorTime);
            // `nohup` and batch systems ignore a signal to let the process live on.
            if repeats && ignored & (1 << (signal.number() - 1)) != 0 {
                continue;
            }
            if !repeats {
                // The order matters: the first signal finds the flag unset, so the process
                // survives, and sets it for the second.
                let code = i32::from(signal.exit_code());
                flag::register_conditional_shutdown(signal.number(), code, Arc::clone(&armed))?;
                flag::register(signal.number(), Arc::clone(&armed))?;
            }
            flag::register_usize(signal.number(), Arc::clone(&received), signal.number() as usize)?;
        }
        // With a handler a write beyond `ulimit -f` fails with an error, which ends the run in
        // order; without one the signal kills the process.
        flag::register(SIGXFSZ, Arc::default())?;
        Ok(Self { received, checkpoint: checkpoint_flag()? })
    }

    /// Returns signals without handlers, which [`Self::raise`] alone sets: for a process that
    /// handles signals itself, such as an interpreter.
    pub fn without_handlers() -> Self {
        Self { received: Arc::default(), checkpoint: Arc::default() }
    }

    /// Returns the same requests for another thread, which raises them while a run obeys them.
    #[must_use]
    pub fn shared(&self) -> Self {
        Self { received: Arc::clone(&self.received), checkpoint: Arc::clone(&self.checkpoint) }
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
        Signal::ALL.into_iter().find(|signal| signal.number() as usize == number)
    }
}

/// Returns a flag that each SIGUSR1 and SIGUSR2 sets.
///
/// Grid Engine announces a stop by the first and a kill by the second.
fn checkpoint_flag() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGUSR1, SIGUSR2] {
        flag::register(signal, Arc::clone(&flag))?;
    }
    Ok(flag)
}

/// Returns the signals that the process was started to ignore, as bits from that of signal 1.
///
/// All of them where the system has no `/proc`: a process under `nohup` must not stop.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(u64::MAX)
}
