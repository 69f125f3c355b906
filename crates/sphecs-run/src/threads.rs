//! Thread pool of a run, whose threads have ended when the run returns.
//!
//! Dropping a rayon pool tells its threads to end but does not wait for them. A thread that has
//! used NetCDF frees memory as it ends: libcrypto, which NetCDF loads through libcurl, has
//! thread-local data. If `main` returned meanwhile, the exit handler of libcrypto would free the
//! same data, and the allocator would abort a process whose results are complete.

use std::thread::{Builder, JoinHandle};

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

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
    // Dropped after the pool, which tells the threads to end.
    let mut threads = Threads::default();
    let pool = ThreadPoolBuilder::new()
        .num_threads(count.unwrap_or(0))
        .spawn_handler(|thread| {
            let named = Builder::new().name(format!("flow {}", thread.index()));
            threads.0.push(named.spawn(|| thread.run())?);
            Ok(())
        })
        .build()?;
    Ok(pool.install(work))
}

/// Threads joined on drop: a scope would wait for their work only, not for their thread-local
/// values.
#[derive(Default)]
struct Threads(Vec<JoinHandle<()>>);

impl Drop for Threads {
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
    use std::panic::{AssertUnwindSafe, catch_unwind};
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
