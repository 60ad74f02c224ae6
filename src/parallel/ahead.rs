//! Decoding ahead: pieces that are read one after the other, worked on side by side, and handed out in order.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError};

use super::{Alarm, lock, threads};
use crate::{Error, Result};

/// Where pieces come from, and what is done with each.
pub trait Pieces: Send + 'static {
    /// One piece, raw and then done; used again and again.
    type Piece: Default + Send + 'static;
    /// What both need besides the piece.
    type Tools: Send + Sync + 'static;

    /// Reads the next piece, quickly; false after the last.
    fn fill(&mut self, tools: &Self::Tools, piece: &mut Self::Piece) -> Result<bool>;

    /// Works on a piece.
    fn work(tools: &Self::Tools, piece: &mut Self::Piece) -> Result<()>;

    /// Goes back before the first piece; false if it cannot.
    fn rewind(&mut self) -> Result<bool>;
}

/// Pieces on their way a thread: more would only take memory.
const UNDER_WAY: u64 = 2;
/// How often a thread looks again before it sleeps: reading a piece takes not much longer than falling asleep and waking.
const LOOKS: usize = 2000;

/// Hands out pieces. With one thread each is read and worked on when it is asked for; with more, others read and work ahead
/// meanwhile, and who asks works too instead of waiting.
pub struct Ahead<P: Pieces> {
    shared: Arc<Shared<P>>,
    ended: bool,
    /// Have the others started?
    started: bool,
}

struct Shared<P: Pieces> {
    source: Mutex<P>,
    tools: P::Tools,
    books: Mutex<Books<P::Piece>>,
    changed: Condvar,
}

struct Books<T> {
    /// Pieces begun.
    begun: u64,
    /// Pieces handed out.
    taken: u64,
    /// The source has no more, or has failed.
    ended: bool,
    /// Done and not yet handed out; `None` stands for the end.
    done: BTreeMap<u64, Result<Option<Owned<T>>>>,
    spare: Vec<Owned<T>>,
    /// Counts rewinds: what was begun before one comes too late.
    round: u64,
    /// Threads that wait for something to do.
    waiting: usize,
    /// Nobody will ask again.
    dropped: bool,
}

/// A piece, and the thread that fills it again and again: its memory lies in that one's cache.
struct Owned<T>(usize, T);

type Guard<'a, P> = MutexGuard<'a, Books<<P as Pieces>::Piece>>;

impl<T> Books<T> {
    fn room(&self) -> u64 {
        (self.taken + UNDER_WAY * threads() as u64).saturating_sub(self.begun)
    }

    fn wants_more(&self) -> bool {
        !self.ended && self.room() > 0
    }
}

impl<P: Pieces> Ahead<P> {
    /// Nothing is read before the first [`Ahead::next`].
    pub fn new(source: P, tools: P::Tools) -> Ahead<P> {
        let (done, spare) = (BTreeMap::new(), Vec::new());
        let books = Books { begun: 0, taken: 0, ended: false, done, spare, round: 0, waiting: 0, dropped: false };
        let (source, books) = (Mutex::new(source), Mutex::new(books));
        Ahead {
            shared: Arc::new(Shared { source, tools, books, changed: Condvar::new() }),
            ended: false,
            started: false,
        }
    }

    /// Shows the next piece; false after the last. After a failure there is no more.
    pub fn next(&mut self, show: impl FnOnce(&mut P::Piece)) -> Result<bool> {
        if self.ended {
            return Ok(false);
        }
        if !self.started {
            self.started = true;
            for owner in 1..threads() {
                let shared = self.shared.clone();
                // Where the system has no thread to give, fewer must do.
                let _ = std::thread::Builder::new().spawn(move || shared.help(owner));
            }
        }
        let piece = self.shared.take();
        self.ended = !matches!(piece, Ok(Some(_)));
        let Some(mut piece) = piece? else { return Ok(false) };
        show(&mut piece.1);
        lock(&self.shared.books).spare.push(piece);
        Ok(true)
    }

    /// Goes back before the first piece; false if the source cannot.
    pub fn rewind(&mut self) -> Result<bool> {
        let mut source = lock(&self.shared.source);
        if !source.rewind()? {
            return Ok(false);
        }
        let mut books = lock(&self.shared.books);
        (books.begun, books.taken, books.ended) = (0, 0, false);
        books.round += 1;
        books.done.clear();
        self.ended = false;
        drop(books);
        self.shared.changed.notify_all();
        Ok(true)
    }
}

impl<P: Pieces> Drop for Ahead<P> {
    fn drop(&mut self) {
        // The others may wait for bytes that never come, so nobody waits for them.
        lock(&self.shared.books).dropped = true;
        self.shared.changed.notify_all();
    }
}

impl<P: Pieces> Shared<P> {
    /// The next piece in order, however it comes about.
    fn take(&self) -> Result<Option<Owned<P::Piece>>> {
        loop {
            let mut books = lock(&self.books);
            let next = books.taken;
            if let Some(done) = books.done.remove(&next) {
                books.taken += 1;
                // Others are woken when there is enough for them to do.
                let wake = books.waiting > 0 && !books.ended && 2 * books.room() >= UNDER_WAY * threads() as u64;
                drop(books);
                if wake {
                    self.changed.notify_all();
                }
                return done;
            }
            // Meanwhile the books were closed, and the piece may have come.
            if let Err(books) = self.step(0, books)
                && !books.done.contains_key(&next)
            {
                self.wait(books);
            }
        }
    }

    /// Reads and works while there is room for more.
    fn help(&self, owner: usize) {
        loop {
            let books = lock(&self.books);
            if books.dropped {
                return;
            }
            if let Err(books) = self.step(owner, books) {
                self.wait(books);
            }
        }
    }

    fn wait(&self, mut books: Guard<P>) {
        books.waiting += 1;
        let mut books = self.changed.wait(books).unwrap_or_else(PoisonError::into_inner);
        books.waiting -= 1;
    }

    /// Reads a piece and works on it; gives the books back where no more are wanted, or another thread goes on reading.
    fn step<'a>(&'a self, owner: usize, books: Guard<'a, P>) -> Result<(), Guard<'a, P>> {
        if !books.wants_more() {
            return Err(books);
        }
        drop(books);
        for _ in 0..LOOKS {
            if self.source.try_lock().is_ok() {
                break;
            }
            std::hint::spin_loop();
        }
        // With the books at hand: whoever reads now will find in them that this thread waits.
        let mut books = lock(&self.books);
        let mut source = match self.source.try_lock() {
            Ok(source) if books.wants_more() => source,
            Err(TryLockError::Poisoned(e)) if books.wants_more() => e.into_inner(),
            _ => return Err(books),
        };
        let (number, round) = (books.begun, books.round);
        books.begun += 1;
        let own = books.spare.iter().position(|piece| piece.0 == owner);
        let mut piece = own.map_or_else(|| Owned(owner, Default::default()), |i| books.spare.swap_remove(i));
        drop(books);
        let failed = || Error::Unsupported("a thread broke off".into());
        let _alarm = Alarm(|| self.enter(round, |books| drop(books.done.insert(number, Err(failed())))));
        let filled = source.fill(&self.tools, &mut piece.1);
        drop(source);
        let more = matches!(filled, Ok(true));
        self.enter(round, |books| books.ended |= !more);
        let done =
            filled.and_then(|more| if more { P::work(&self.tools, &mut piece.1).map(|()| true) } else { Ok(false) });
        self.enter(round, |books| drop(books.done.insert(number, done.map(|more| more.then_some(piece)))));
        Ok(())
    }

    /// Changes the books, unless there was a rewind since the round, and wakes who waits.
    fn enter(&self, round: u64, change: impl FnOnce(&mut Books<P::Piece>)) {
        let mut books = lock(&self.books);
        if books.round == round {
            change(&mut books);
        }
        let wake = books.waiting > 0;
        drop(books);
        if wake {
            self.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 500 numbers; reading fails after as many as `breaks_at` says.
    struct Numbers {
        next: u64,
        breaks_at: u64,
    }

    impl Pieces for Numbers {
        type Piece = u64;
        type Tools = u64;

        fn fill(&mut self, _: &u64, piece: &mut u64) -> Result<bool> {
            if self.next == self.breaks_at {
                return Err(Error::Invalid("broken".into()));
            }
            *piece = self.next;
            self.next += 1;
            Ok(self.next <= 500)
        }

        fn work(factor: &u64, piece: &mut u64) -> Result<()> {
            if (*piece * 7919).is_multiple_of(64) {
                std::thread::sleep(std::time::Duration::from_micros(20));
            }
            *piece *= factor;
            Ok(())
        }

        fn rewind(&mut self) -> Result<bool> {
            self.next = 0;
            Ok(true)
        }
    }

    fn all(ahead: &mut Ahead<Numbers>) -> (Vec<u64>, Result<bool>) {
        let mut out = Vec::new();
        loop {
            match ahead.next(|piece| out.push(*piece)) {
                Ok(true) => {}
                end => return (out, end),
            }
        }
    }

    #[test]
    fn pieces_come_in_order_once_more_and_up_to_the_first_failure() {
        super::super::set_threads(2);
        let whole: Vec<u64> = (0..500).map(|n| 3 * n).collect();
        let mut ahead = Ahead::new(Numbers { next: 0, breaks_at: u64::MAX }, 3);
        for _ in 0..200 {
            let (out, end) = all(&mut ahead);
            assert_eq!(out, whole);
            assert!(matches!(end, Ok(false)) && matches!(ahead.next(|_| ()), Ok(false)));
            assert!(ahead.rewind().unwrap());
        }
        for _ in 0..20 {
            assert!(ahead.next(|_| ()).unwrap());
        }
        assert!(ahead.rewind().unwrap()); // with pieces under way
        assert_eq!(all(&mut ahead).0, whole);
        let (out, end) = all(&mut Ahead::new(Numbers { next: 0, breaks_at: 300 }, 3));
        assert_eq!((out, end.unwrap_err().to_string()), (whole[..300].to_vec(), "broken".into()));
    }
}
