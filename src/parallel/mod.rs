//! How many threads, and how rows are dealt to them.

mod ahead;

use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use rayon::prelude::*;

use crate::{Error, Result};
pub use ahead::{Ahead, Pieces};

/// A larger request is brought down to this many threads a processor.
const MOST_A_PROCESSOR: usize = 4;

static REQUEST: OnceLock<usize> = OnceLock::new();
static THREADS: OnceLock<usize> = OnceLock::new();

/// Asks for a number of threads for the whole process, before any work; 0 means all processors. They start when work for
/// them comes.
pub fn set_threads(count: usize) {
    let _ = REQUEST.set(count); // the first word counts
}

/// The number of threads in use; 1 where nobody asked.
pub fn threads() -> usize {
    *THREADS.get_or_init(|| {
        let all = || std::thread::available_parallelism().map_or(1, |n| n.get());
        // More threads than that only take turns.
        match REQUEST.get() {
            None => 1,
            Some(0) => all(),
            Some(count) => (*count).min(MOST_A_PROCESSOR * all()),
        }
    })
}

/// Readies rayon's threads for work that is dealt out by it; false where there is one thread, or the system has none to give.
pub fn pool() -> bool {
    static POOL: OnceLock<bool> = OnceLock::new();
    let build = || rayon::ThreadPoolBuilder::new().num_threads(threads()).build_global().is_ok();
    *POOL.get_or_init(|| threads() > 1 && build())
}

/// Gives rayon the number of threads that was asked for, one included, before work that uses it unasked (a library's, say):
/// whoever comes first settles the number for the whole process.
pub fn ready() {
    if threads() > 1 {
        pool();
    } else {
        // Fails only where it has been done already.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    }
}

/// Runs `f` over consecutive pieces of `data`, each a multiple of `unit` long, on all threads. `f` gets the index of the
/// piece's first unit.
pub fn for_pieces<T: Send>(data: &mut [T], unit: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    let units = data.len() / unit;
    if units < 2 || !pool() {
        return f(0, data);
    }
    let each = units.div_ceil(threads());
    data.par_chunks_mut(each * unit).enumerate().for_each(|(i, piece)| f(i * each, piece));
}

/// Work that comes and goes in order and is done side by side: each thread has an `S` of its own and, again and again, fills
/// it while it holds the source, works on it alone, and drains it when its turn has come. `fill` says false after the last.
/// The first failure ends everything.
pub fn in_order<S: Default + Send>(
    fill: impl FnMut(&mut S) -> Result<bool> + Send,
    work: impl Fn(&mut S) -> Result<()> + Sync,
    drain: impl FnMut(&mut S) -> Result<()> + Send,
) -> Result<()> {
    let (mut fill, mut drain) = (fill, drain);
    if threads() == 1 {
        let mut state = S::default();
        while fill(&mut state)? {
            work(&mut state)?;
            drain(&mut state)?;
        }
        return Ok(());
    }
    let (source, sink) = (Mutex::new((fill, 0u64, false)), Mutex::new((drain, 0u64, None)));
    let turn = Condvar::new();
    let worker = || {
        let _alarm = Alarm(|| {
            lock(&sink).2 = Some(Error::Unsupported("a thread broke off".into()));
            turn.notify_all();
        });
        let mut state = S::default();
        loop {
            let mut from = lock(&source);
            let (fill, count, ended) = &mut *from;
            if *ended {
                return;
            }
            let filled = fill(&mut state);
            *ended = !matches!(filled, Ok(true));
            let mine = *count;
            *count += 1;
            drop(from);
            let done = filled.and_then(|more| if more { work(&mut state).map(|()| true) } else { Ok(false) });
            let mut to = lock(&sink);
            while to.1 != mine && to.2.is_none() {
                to = turn.wait(to).unwrap_or_else(PoisonError::into_inner);
            }
            if to.2.is_some() {
                return;
            }
            let drained = done.and_then(|more| if more { (to.0)(&mut state).map(|()| true) } else { Ok(false) });
            to.1 += 1;
            let ended = match drained {
                Ok(more) => !more,
                Err(e) => {
                    to.2 = Some(e);
                    true
                }
            };
            drop(to);
            turn.notify_all();
            if ended {
                lock(&source).2 = true;
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads() {
            // Where the system has no thread to give, fewer must do.
            let _ = std::thread::Builder::new().spawn_scoped(scope, worker);
        }
        worker();
    });
    let (_, _, failed) = sink.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.map_or(Ok(()), Err)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Wakes the others when its thread panics, so that none waits for a turn that never comes; the panic itself goes on.
struct Alarm<F: Fn()>(F);

impl<F: Fn()> Drop for Alarm<F> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            (self.0)();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is drained is what was filled, in order, for unequal work; a failure comes after all that stood before it.
    #[test]
    fn order_is_kept_and_the_first_failure_counts() {
        set_threads(2);
        let drained = |fails_at: u64| {
            let (mut next, mut out) = (0u64, Vec::new());
            let result = in_order(
                |n: &mut u64| {
                    next += 1;
                    *n = next;
                    Ok(next <= 500)
                },
                |n| {
                    std::thread::sleep(std::time::Duration::from_micros(*n * 7919 % 50));
                    if *n >= fails_at { Err(Error::Invalid(n.to_string())) } else { Ok(()) }
                },
                |n| {
                    out.push(*n);
                    Ok(())
                },
            );
            (out, result)
        };
        let (out, result) = drained(u64::MAX);
        assert!(result.is_ok() && out == (1..=500).collect::<Vec<u64>>());
        let (out, result) = drained(300);
        assert_eq!((out, result.unwrap_err().to_string()), ((1..300).collect(), "300".to_string()));
    }
}
