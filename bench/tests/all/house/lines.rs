//! What a line holds: code, a comment, both or neither.

/// A line of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Line {
    /// Something that the compiler reads.
    pub code: bool,
    /// A comment, or prose of a Markdown file.
    pub comment: bool,
    /// Characters.
    pub columns: usize,
}

/// The lines of a file, whose ending says how comments look there.
pub(crate) fn read(path: &str, text: &str) -> Vec<Line> {
    let mut lines: Vec<Line> =
        text.lines().map(|line| Line { columns: line.chars().count(), ..Line::default() }).collect();
    if path.ends_with(".md") {
        prose(text, &mut lines);
    } else {
        Reader { text, at: 0, line: 0, lines: &mut lines, slashes: path.ends_with(".rs") }.read();
    }
    lines
}

/// Prose of Markdown: what is neither a table nor between code fences.
fn prose(text: &str, lines: &mut [Line]) {
    let mut fenced = false;
    for (line, words) in lines.iter_mut().zip(text.lines().map(str::trim_start)) {
        let fence = words.starts_with("```");
        fenced ^= fence;
        line.comment = !words.is_empty() && !fence && !fenced && !words.starts_with('|');
    }
}

/// Reads a file from its beginning and marks what it passes.
struct Reader<'a> {
    text: &'a str,
    /// Bytes that are read.
    at: usize,
    line: usize,
    lines: &'a mut Vec<Line>,
    /// Comments begin with `//` and not with `#`.
    slashes: bool,
}

impl Reader<'_> {
    fn read(mut self) {
        while let Some(next) = self.rest().chars().next() {
            let length = match next {
                '/' if self.slashes && self.rest().starts_with("//") => self.until("\n", 0),
                '/' if self.slashes && self.rest().starts_with("/*") => self.block(),
                '#' if !self.slashes => self.until("\n", 0),
                'r' if self.slashes && self.raw().is_some() => self.raw().expect("just seen"),
                '"' if !self.slashes && self.rest().starts_with("\"\"\"") => self.until("\"\"\"", 3) + 3,
                '"' => self.quoted('"'),
                '\'' if !self.slashes || self.is_character() => self.quoted('\''),
                _ => next.len_utf8(),
            };
            let opening = self.rest();
            let comment = if self.slashes {
                opening.starts_with("//") || opening.starts_with("/*")
            } else {
                opening.starts_with('#')
            };
            self.pass(length, comment);
        }
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// Bytes from `skipped` on until `end`, or until the file ends.
    fn until(&self, end: &str, skipped: usize) -> usize {
        self.rest()[skipped..].find(end).map_or(self.rest().len(), |found| found + skipped)
    }

    /// Bytes of a block comment; they nest.
    fn block(&self) -> usize {
        let (mut depth, mut at) = (0, 0);
        let bytes = self.rest().as_bytes();
        while at < bytes.len() {
            match bytes[at..] {
                [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
                [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
                _ => at += 1,
            }
            if depth == 0 {
                break;
            }
        }
        at
    }

    /// Bytes of a raw string, if one begins here.
    fn raw(&self) -> Option<usize> {
        let hashes = self.rest()[1..].chars().take_while(|next| *next == '#').count();
        let named = self.text[..self.at].chars().next_back().is_some_and(|last| last.is_alphanumeric() && last != 'b');
        (!named && self.rest()[1 + hashes..].starts_with('"')).then(|| {
            let end = format!("\"{}", "#".repeat(hashes));
            self.until(&end, hashes + 2) + end.len()
        })
    }

    /// Bytes of what stands in quotes, with the quotes. A text of `.toml` or `.py` in single quotes ends with its line.
    fn quoted(&self, quote: char) -> usize {
        let mut escaped = false;
        for (at, next) in self.rest().char_indices().skip(1) {
            if !escaped && next == quote || next == '\n' && !self.slashes {
                return at + next.len_utf8();
            }
            escaped = !escaped && next == '\\';
        }
        self.rest().len()
    }

    /// A character begins here, and not a lifetime.
    fn is_character(&self) -> bool {
        let mut next = self.rest().chars().skip(1);
        next.next() == Some('\\') || next.next() == Some('\'')
    }

    fn pass(&mut self, length: usize, comment: bool) {
        let end = (self.at + length).min(self.text.len());
        for next in self.text[self.at..end].chars() {
            if next == '\n' {
                self.line += 1;
            } else if comment {
                self.lines[self.line].comment = true;
            } else if !next.is_whitespace() {
                self.lines[self.line].code = true;
            }
        }
        self.at = end;
    }
}
