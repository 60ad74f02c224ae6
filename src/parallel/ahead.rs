//! Decoding ahead: pieces that are read one after the other, worked on side by side, and handed out in order.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use super::{Alarm, lock, threads};
use crate::{Error, Result};

/// Where pieces come from, and what is done with each.
pub trait Pieces: Send + 'static {
    /// One piece, raw and then done; used again and again.
    type Piece: Default + Send + 'static;
    /// What the work needs besides the piece.
    type Tools: Send + Sync + 'static;

    /// Reads the next piece, quickly; false after the last.
    fn fill(&mut self, piece: &mut Self::Piece) -> Result<bool>;

    /// Works on a piece.
    fn work(tools: &Self::Tools, piece: &mut Self::Piece) -> Result<()>;

    /// Goes back before the first piece; false if it cannot.
    fn rewind(&mut self) -> Result<bool>;
}

/// Pieces ready a thread: more would only take memory.
const READY_A_THREAD: u64 = 2;

/// Hands out pieces. With one thread each is read and worked on when it is asked for; with more, others begin the next ones
/// meanwhile, and who asks works too instead of waiting.
pub struct Ahead<P: Pieces> {
    shared: Arc<Shared<P>>,
    /// Number of pieces handed out.
    taken: u64,
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
    /// What is done and not yet handed out; `None` stands for the end.
    done: BTreeMap<u64, Result<Option<T>>>,
    spare: Vec<T>,
    /// Counts rewinds: what was begun before one comes too late.
    round: u64,
    /// Nobody will ask again.
    dropped: bool,
}

impl<T> Books<T> {
    fn wants_more(&self) -> bool {
        !self.ended && self.begun < self.taken + READY_A_THREAD * threads() as u64
    }
}

impl<P: Pieces> Ahead<P> {
    /// Nothing is read before the first [`Ahead::next`].
    pub fn new(source: P, tools: P::Tools) -> Ahead<P> {
        let (done, spare) = (BTreeMap::new(), Vec::new());
        let books = Mutex::new(Books { begun: 0, taken: 0, ended: false, done, spare, round: 0, dropped: false });
        let shared = Arc::new(Shared { source: Mutex::new(source), tools, books, changed: Condvar::new() });
        Ahead { shared, taken: 0, ended: false, started: false }
    }

    /// Shows the next piece; false after the last. After a failure there is no more.
    pub fn next(&mut self, show: impl FnOnce(&mut P::Piece)) -> Result<bool> {
        if self.ended {
            return Ok(false);
        }
        let piece = self.piece();
        self.ended = !matches!(piece, Ok(Some(_)));
        let Some(mut piece) = piece? else { return Ok(false) };
        show(&mut piece);
        lock(&self.shared.books).spare.push(piece);
        Ok(true)
    }

    fn piece(&mut self) -> Result<Option<P::Piece>> {
        if threads() > 1 && !self.started {
            self.started = true;
            for _ in 1..threads() {
                let shared = self.shared.clone();
                std::thread::spawn(move || shared.help());
            }
        }
        loop {
            let mut books = lock(&self.shared.books);
            if let Some(done) = books.done.remove(&self.taken) {
                self.taken += 1;
                books.taken = self.taken;
                drop(books);
                self.shared.changed.notify_all();
                return done;
            }
            if books.wants_more() {
                drop(books);
                self.shared.step();
            } else {
                drop(self.shared.changed.wait(books).unwrap_or_else(PoisonError::into_inner));
            }
        }
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
        (self.taken, self.ended) = (0, false);
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
    /// Begins pieces while there is room for more.
    fn help(&self) {
        loop {
            let mut books = lock(&self.books);
            while !books.dropped && !books.wants_more() {
                books = self.changed.wait(books).unwrap_or_else(PoisonError::into_inner);
            }
            if books.dropped {
                return;
            }
            drop(books);
            self.step();
        }
    }

    /// Reads the next piece and works on it.
    fn step(&self) {
        let mut source = lock(&self.source);
        let (number, round, mut piece) = {
            let mut books = lock(&self.books);
            if books.ended {
                return;
            }
            books.begun += 1;
            (books.begun - 1, books.round, books.spare.pop().unwrap_or_default())
        };
        let _alarm = Alarm(|| self.settle(number, round, Err(Error::Unsupported("a thread broke off".into()))));
        let filled = source.fill(&mut piece);
        if !matches!(filled, Ok(true)) {
            lock(&self.books).ended = true;
        }
        drop(source);
        let done =
            filled.and_then(|more| if more { P::work(&self.tools, &mut piece).map(|()| true) } else { Ok(false) });
        self.settle(number, round, done.map(|more| more.then_some(piece)));
    }

    fn settle(&self, number: u64, round: u64, done: Result<Option<P::Piece>>) {
        let mut books = lock(&self.books);
        if books.round == round {
            books.done.insert(number, done);
        }
        drop(books);
        self.changed.notify_all();
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

        fn fill(&mut self, piece: &mut u64) -> Result<bool> {
            if self.next == self.breaks_at {
                return Err(Error::Invalid("broken".into()));
            }
            *piece = self.next;
            self.next += 1;
            Ok(self.next <= 500)
        }

        fn work(factor: &u64, piece: &mut u64) -> Result<()> {
            std::thread::sleep(std::time::Duration::from_micros(*piece * 7919 % 50));
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
        for _ in 0..2 {
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
