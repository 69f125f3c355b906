//! The threads that a run computes on. They have ended when it returns.
//!
//! A dropped pool only tells its threads to end, and does not wait. A thread that has used NetCDF has something to free as it ends:
//! libcrypto, which NetCDF brings in by libcurl, keeps notes for each thread. If `main` returned meanwhile, the exit handler of
//! libcrypto would free the same notes, and the allocator would end a process whose results are whole.

use std::thread::{Builder, JoinHandle};

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// Does some work on a pool of so many threads, None: one for each core. No thread is left when this returns or unwinds, nor its
/// thread-local values.
///
/// # Errors
/// When the system refuses a thread.
pub fn on_threads<T: Send>(
    count: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    // Dropped after the pool, which tells them to end.
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

/// Threads that are waited for until the system knows them no more: a scope would wait for their work only.
#[derive(Default)]
struct Threads(Vec<JoinHandle<()>>);

impl Drop for Threads {
    fn drop(&mut self) {
        for thread in self.0.drain(..) {
            // A panic of the work has been handed on by the pool.
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

    /// Something that a library frees as a thread ends, and takes its time.
    struct Notes(Arc<AtomicUsize>);

    impl Drop for Notes {
        fn drop(&mut self) {
            std::thread::sleep(Duration::from_millis(50));
            self.0.fetch_sub(1, SeqCst);
        }
    }

    thread_local! {
        static NOTES: RefCell<Option<Notes>> = const { RefCell::new(None) };
    }

    fn take_notes(left: &Arc<AtomicUsize>) {
        rayon::broadcast(|_| {
            left.fetch_add(1, SeqCst);
            NOTES.set(Some(Notes(Arc::clone(left))));
        });
        assert_eq!(left.load(SeqCst), 3);
    }

    #[test]
    fn nothing_of_its_threads_outlives_the_work() {
        let left = Arc::new(AtomicUsize::new(0));
        let count = on_threads(Some(3), || {
            take_notes(&left);
            rayon::current_num_threads()
        });
        assert_eq!((count.expect("three threads"), left.load(SeqCst)), (3, 0));
    }

    #[test]
    fn nor_work_that_panics() {
        let left = Arc::new(AtomicUsize::new(0));
        let work = || {
            take_notes(&left);
            panic!("as asked for");
        };
        assert!(catch_unwind(AssertUnwindSafe(|| on_threads::<()>(Some(3), work))).is_err());
        assert_eq!(left.load(SeqCst), 0);
    }
}
