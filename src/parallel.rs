//! How many threads, and how rows are dealt to them.

use std::sync::OnceLock;

use rayon::prelude::*;

/// A larger request is brought down to this many threads a processor.
const MOST_A_PROCESSOR: usize = 4;

static REQUEST: OnceLock<usize> = OnceLock::new();
static THREADS: OnceLock<usize> = OnceLock::new();

/// Asks for a number of threads for the whole process, before any work; 0 means all processors. They start when work for
/// them comes.
pub fn set_threads(count: usize) {
    let _ = REQUEST.set(count); // the first word counts
}

/// The number of threads in use; 1 where nobody asked, and where the system has none to give.
pub fn threads() -> usize {
    *THREADS.get_or_init(|| {
        let all = || std::thread::available_parallelism().map_or(1, |n| n.get());
        // More threads than that only take turns.
        let count = match REQUEST.get() {
            None => 1,
            Some(0) => all(),
            Some(count) => (*count).min(MOST_A_PROCESSOR * all()),
        };
        let pool = count > 1 && rayon::ThreadPoolBuilder::new().num_threads(count).build_global().is_ok();
        if pool { count } else { 1 }
    })
}

/// Runs `f` over consecutive pieces of `data`, each a multiple of `unit` long, on all threads. `f` gets the index of the
/// piece's first unit.
pub fn for_pieces<T: Send>(data: &mut [T], unit: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    let units = data.len() / unit;
    if threads() == 1 || units < 2 {
        return f(0, data);
    }
    let each = units.div_ceil(threads());
    data.par_chunks_mut(each * unit).enumerate().for_each(|(i, piece)| f(i * each, piece));
}
