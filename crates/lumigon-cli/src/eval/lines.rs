//! Lines read ahead on a thread of their own, within bounded memory.

use std::io::{self, Read};
use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Longest line in bytes, its end not counted.
#[derive(Clone, Copy, Debug)]
pub(super) struct LongestLine(pub(super) usize);

/// Bytes to read at once.
const BLOCK: usize = 1 << 17;
/// Bytes of whole lines to read ahead.
const AHEAD: usize = 4 << 20;

/// A line of a [`Batch`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// Where it is in the batch's text.
    Text(Range<usize>),
    /// It was longer than allowed and was dropped.
    TooLong,
}

/// Some whole lines.
#[derive(Debug, Default)]
pub(super) struct Batch {
    text: Vec<u8>,
    lines: Vec<Line>,
}

impl Batch {
    pub(super) fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// The line's bytes, or `None` where it was too long.
    pub(super) fn text(&self, line: &Line) -> Option<&[u8]> {
        match line {
            Line::Text(range) => Some(&self.text[range.clone()]),
            Line::TooLong => None,
        }
    }

    fn clear(&mut self) {
        self.text.clear();
        self.lines.clear();
        // One huge line should not keep its memory for good.
        self.text.shrink_to(2 * AHEAD);
    }
}

/// Cuts blocks into lines.
struct Splitter {
    longest: LongestLine,
    /// The line that has begun and not ended.
    begun: Vec<u8>,
    too_long: bool,
}

impl Splitter {
    fn split(&mut self, block: &[u8], batch: &mut Batch) {
        let mut start = 0;
        for end in memchr::memchr_iter(b'\n', block) {
            self.extend(&block[start..end]);
            self.end(batch);
            start = end + 1;
        }
        self.extend(&block[start..]);
    }

    fn extend(&mut self, piece: &[u8]) {
        if self.too_long || self.begun.len() + piece.len() > self.longest.0 {
            self.too_long = true;
            self.begun = Vec::new();
        } else {
            self.begun.extend_from_slice(piece);
        }
    }

    fn end(&mut self, batch: &mut Batch) {
        if self.too_long {
            batch.lines.push(Line::TooLong);
        } else {
            let start = batch.text.len();
            batch.text.extend_from_slice(&self.begun);
            batch.lines.push(Line::Text(start..batch.text.len()));
        }
        self.begun.clear();
        self.too_long = false;
    }

    /// Ends a last line that has no end of its own.
    fn finish(&mut self, batch: &mut Batch) {
        if self.too_long || !self.begun.is_empty() {
            self.end(batch);
        }
    }
}

/// Reads lines ahead of whoever works on them.
pub(super) struct ReadAhead {
    shared: Arc<Shared>,
}

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    batch: Batch,
    end: Option<io::Result<()>>,
}

impl ReadAhead {
    /// Begins to read. The thread ends with its input; where the reader goes away earlier it
    /// waits for ever, so that goes before the process only.
    pub(super) fn start(
        input: impl Read + Send + 'static,
        longest: LongestLine,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            changed: Condvar::new(),
        });
        let reader = Arc::clone(&shared);
        std::thread::Builder::new()
            .name("lines".to_owned())
            .spawn(move || reader.read(input, longest))?;
        Ok(Self { shared })
    }

    /// Puts all lines that have arrived into `batch`, at least one unless the input has ended.
    /// Whether there may be more.
    ///
    /// # Errors
    /// Where reading failed; the lines before are in the batch.
    pub(super) fn next(&self, batch: &mut Batch) -> io::Result<bool> {
        batch.clear();
        let mut state = self.shared.lock();
        while state.batch.lines.is_empty() && state.end.is_none() {
            state = self.shared.wait(state);
        }
        std::mem::swap(batch, &mut state.batch);
        let end = state.end.take();
        drop(state);
        self.shared.changed.notify_all();
        end.map_or(Ok(true), |result| result.map(|()| false))
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        self.changed
            .wait(state)
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn read(&self, mut input: impl Read, longest: LongestLine) {
        let mut splitter = Splitter {
            longest,
            begun: Vec::new(),
            too_long: false,
        };
        let mut block = vec![0; BLOCK];
        let end = loop {
            match input.read(&mut block) {
                Ok(0) => break Ok(()),
                Ok(count) => {
                    let mut state = self.lock();
                    while state.batch.text.len() + state.batch.lines.len() >= AHEAD {
                        state = self.wait(state);
                    }
                    splitter.split(&block[..count], &mut state.batch);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => break Err(error),
            }
            self.changed.notify_all();
        };
        let mut state = self.lock();
        splitter.finish(&mut state.batch);
        state.end = Some(end);
        drop(state);
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    fn all(input: &[u8], longest: usize) -> Vec<Option<Vec<u8>>> {
        let input = io::Cursor::new(input.to_vec());
        let ahead = ReadAhead::start(input, LongestLine(longest)).unwrap();
        let (mut batch, mut lines) = (Batch::default(), Vec::new());
        loop {
            let more = ahead.next(&mut batch).unwrap();
            let texts = batch.lines().iter().map(|line| batch.text(line));
            lines.extend(texts.map(|text| text.map(<[u8]>::to_vec)));
            if !more {
                return lines;
            }
        }
    }

    #[test]
    fn lines_of_any_length_across_blocks() {
        let long = vec![b'x'; 3 * BLOCK];
        let input = [b"a\n\nbc\n".as_slice(), &long, b"\n", &long[1..], b"\nlast"].concat();
        let got = all(&input, long.len() - 1);
        let text = |s: &[u8]| Some(s.to_vec());
        assert_eq!(got[..3], [text(b"a"), text(b""), text(b"bc")]);
        assert_eq!(got[3..], [None, text(&long[1..]), text(b"last")]);
        assert_eq!(all(b"", 10), []);
        assert_eq!(all(b"0123456789x", 10), [None]);
    }

    /// Hands out what it is sent, then fails.
    struct Channel(mpsc::Receiver<&'static [u8]>);

    impl Read for Channel {
        fn read(&mut self, block: &mut [u8]) -> io::Result<usize> {
            let bytes = self.0.recv().map_err(io::Error::other)?;
            block[..bytes.len()].copy_from_slice(bytes);
            Ok(bytes.len())
        }
    }

    #[test]
    fn lines_come_as_soon_as_they_are_whole() {
        let (sender, receiver) = mpsc::channel();
        let ahead = ReadAhead::start(Channel(receiver), LongestLine(100)).unwrap();
        let mut batch = Batch::default();
        for _ in 0..3 {
            sender.send(b"one").unwrap();
            sender.send(b" line\nand ").unwrap();
            assert!(ahead.next(&mut batch).unwrap());
            assert_eq!(batch.lines().len(), 1);
            assert!(batch.text.ends_with(b"one line"));
            sender.send(b"another\n").unwrap();
            assert!(ahead.next(&mut batch).unwrap());
            assert_eq!(batch.text, b"and another");
        }
        drop(sender);
        assert!(ahead.next(&mut batch).is_err());
    }
}
