//! Thread pool of a run, whose threads have ended when the run returns.
//!
//! Dropping a rayon pool tells its threads to end but does not wait for them. A thread that has
//! used NetCDF frees memory as it ends: libcrypto, which NetCDF loads through libcurl, has
//! thread-local data. If `main` returned meanwhile, the exit handler of libcrypto would free the
//! same data, and the allocator would abort a process whose results are complete.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::{Builder, JoinHandle};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Runs `work` on a pool of `count` threads; None: one for each core.
///
/// All threads and their thread-local values are gone when this returns or unwinds.
///
/// # Errors
/// The system refuses a thread.
pub fn on_threads<T: Send>(
    count: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    Ok(Threads::start(count)?.run(work))
}

/// Thread pool for several pieces of work; dropping it waits until its threads have ended.
#[derive(Debug)]
pub struct Threads {
    pool: ThreadPool,
    // Dropped after the pool, which tells the threads to end.
    _handles: Handles,
}

impl Threads {
    /// Starts a pool of `count` threads; None: one for each core.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn start(count: Option<usize>) -> Result<Self, ThreadPoolBuildError> {
        let mut handles = Handles::default();
        let pool = ThreadPoolBuilder::new()
            .num_threads(count.unwrap_or(0))
            .spawn_handler(|thread| {
                let named = Builder::new().name(format!("flow {}", thread.index()));
                handles.0.push(named.spawn(|| thread.run())?);
                Ok(())
            })
            .build()?;
        Ok(Self { pool, _handles: handles })
    }

    /// Runs `work` on the pool.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Begins `work` on the pool; a panic ends this work alone.
    pub fn begin(&self, work: impl FnOnce() + Send + 'static) {
        self.pool.spawn(|| {
            // The panic has been reported, and rayon would end the process.
            let _ended = catch_unwind(AssertUnwindSafe(work));
        });
    }
}

/// Threads joined on drop: a scope would wait for their work only, not for their thread-local
/// values.
#[derive(Debug, Default)]
struct Handles(Vec<JoinHandle<()>>);

impl Drop for Handles {
    fn drop(&mut self) {
        for thread in self.0.drain(..) {
            // The pool has passed on a panic of the work.
            let _ended = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
    use std::time::Duration;

    use super::*;

    /// Thread-local value that a library frees slowly as the thread ends.
    struct LocalValue(Arc<AtomicUsize>);

    impl Drop for LocalValue {
        fn drop(&mut self) {
            std::thread::sleep(Duration::from_millis(50));
            self.0.fetch_sub(1, SeqCst);
        }
    }

    thread_local! {
        static LOCAL: RefCell<Option<LocalValue>> = const { RefCell::new(None) };
    }

    fn set_local_values(left: &Arc<AtomicUsize>) {
        rayon::broadcast(|_| {
            left.fetch_add(1, SeqCst);
            LOCAL.set(Some(LocalValue(Arc::clone(left))));
        });
        assert_eq!(left.load(SeqCst), 3);
    }

    #[test]
    fn no_thread_local_value_outlives_the_work() {
        let left = Arc::new(AtomicUsize::new(0));
        let count = on_threads(Some(3), || {
            set_local_values(&left);
            rayon::current_num_threads()
        });
        assert_eq!((count.expect("three threads"), left.load(SeqCst)), (3, 0));
    }

    #[test]
    fn no_thread_local_value_outlives_a_panic() {
        let left = Arc::new(AtomicUsize::new(0));
        let work = || {
            set_local_values(&left);
            panic!("intended");
        };
        assert!(catch_unwind(AssertUnwindSafe(|| on_threads::<()>(Some(3), work))).is_err());
        assert_eq!(left.load(SeqCst), 0);
    }
}
