//! Words of a scene file, each with its line, as Radiance's `fgetword` and `fgetline` cut them.

/// What stands at the beginning of a primitive.
pub enum Next {
    /// The end of the file.
    End,
    /// A line from `!` on, without it; escaped ends of lines joined.
    Command(String, usize),
    /// A primitive begins.
    Primitive,
}

/// A file's bytes being read.
pub struct Lexer<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Lexer<'a> {
    /// From the first line on.
    pub fn new(bytes: &'a [u8]) -> Lexer<'a> {
        Lexer { rest: bytes, line: 1 }
    }

    /// The line that is read, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    fn take(&mut self) -> Option<u8> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        self.line += usize::from(*first == b'\n');
        Some(*first)
    }

    fn skip_white(&mut self) {
        while self.rest.first().is_some_and(|b| white(*b)) {
            self.take();
        }
    }

    /// Passes over blanks and comments, and tells what comes.
    pub fn next(&mut self) -> Next {
        loop {
            self.skip_white();
            match self.rest.first() {
                None => return Next::End,
                Some(b'#') => while self.take().is_some_and(|b| b != b'\n') {},
                Some(b'!') => {
                    let line = self.line;
                    self.take();
                    return Next::Command(self.command(), line);
                }
                Some(_) => return Next::Primitive,
            }
        }
    }

    fn command(&mut self) -> String {
        let mut bytes = Vec::new();
        while let Some(b) = self.take() {
            match b {
                b'\n' if bytes.last() == Some(&b'\\') => {
                    bytes.pop();
                    bytes.push(b' ');
                }
                b'\n' => break,
                b => bytes.push(b),
            }
        }
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// The next word and its line; quotes keep blanks together. `None` at the end.
    pub fn word(&mut self) -> Option<(String, usize)> {
        self.skip_white();
        let line = self.line;
        let (mut bytes, mut quote, mut any) = (Vec::new(), None, false);
        while let Some(b) = self.rest.first().copied() {
            if quote.is_none() && white(b) {
                break;
            }
            any = true;
            self.take();
            match quote {
                Some(q) if b == q => quote = None,
                None if b == b'"' || b == b'\'' => quote = Some(b),
                _ => bytes.push(b),
            }
        }
        any.then(|| (String::from_utf8_lossy(&bytes).into_owned(), line))
    }
}

fn white(b: u8) -> bool {
    b.is_ascii_whitespace() || b == 0x0b
}

/// A command line in words, as a shell would cut it; `Err` holds a character that only a shell understands.
pub fn shell_words(line: &str) -> Result<Vec<String>, char> {
    let (mut words, mut word, mut quote): (Vec<String>, Option<String>, Option<char>) = (Vec::new(), None, None);
    let mut chars = line.chars();
    while let Some(c) = chars.next() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (Some('"'), '$' | '`') => return Err(c),
            (Some(_), c) => word.get_or_insert_default().push(c),
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '\\') => word.get_or_insert_default().extend(chars.next()),
            (None, '|' | ';' | '&' | '<' | '>' | '`' | '$' | '(' | ')' | '*' | '?' | '[' | '{' | '~') => return Err(c),
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (None, c) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_know_their_lines() {
        let mut lex = Lexer::new(b"# a comment\n\n void plastic \"my red\"\n!xform -t 1 \\\n0 0 a.rad\n'x' y");
        assert!(matches!(lex.next(), Next::Primitive));
        let words: Vec<_> = (0..3).filter_map(|_| lex.word()).collect();
        assert_eq!(words, [("void".into(), 3), ("plastic".into(), 3), ("my red".into(), 3)]);
        let Next::Command(text, line) = lex.next() else { panic!("a command") };
        assert_eq!((text.as_str(), line), ("xform -t 1  0 0 a.rad", 4));
        assert!(matches!(lex.next(), Next::Primitive));
        assert_eq!([lex.word(), lex.word(), lex.word()], [Some(("x".into(), 6)), Some(("y".into(), 6)), None]);
        assert!(matches!(lex.next(), Next::End));
    }

    #[test]
    fn shells_are_not_imitated() {
        assert_eq!(shell_words("xform -n 'a b' c\\ d.rad \"\"").unwrap(), ["xform", "-n", "a b", "c d.rad", ""]);
        for (line, c) in
            [("genbox m b 1 1 1 | xform", '|'), ("xform $HOME/a.rad", '$'), ("xform \"$A\"", '$'), ("a > b", '>')]
        {
            assert_eq!(shell_words(line).unwrap_err(), c, "{line}");
        }
    }
}
