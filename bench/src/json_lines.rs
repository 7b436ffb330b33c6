//! The line on which a key stands in a JSON text. `serde_json` tells the line of a mistake that it finds itself. This
//! tells the line of a value that it could read and that breaks a rule of ours.

/// One step down a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Down<'a> {
    Key(&'a str),
    Index(usize),
}

/// The steps of a path such as `keyframes[2].state[0]`.
fn steps(path: &str) -> impl Iterator<Item = Down<'_>> {
    let parts = path.split(['.', '[']).filter(|part| !part.is_empty());
    parts.map(|part| match part.strip_suffix(']').and_then(|index| index.parse().ok()) {
        Some(index) => Down::Index(index),
        None => Down::Key(part),
    })
}

/// The line, from 1, on which the value at `path` begins in `text`, which is valid JSON. Where there is no such value,
/// it is the line of the innermost part of the path that is there.
pub(crate) fn line_of(text: &str, path: &str) -> usize {
    let mut cursor = Cursor { bytes: text.as_bytes(), at: 0 };
    cursor.space();
    let mut found = cursor.at;
    for step in steps(path) {
        if !cursor.descend(step) {
            break;
        }
        found = cursor.at;
    }
    1 + text.as_bytes()[..found].iter().filter(|byte| **byte == b'\n').count()
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    fn space(&mut self) {
        while self.peek().is_ascii_whitespace() {
            self.at += 1;
        }
    }

    /// Moves over a byte if it is the next one, and over the space behind it.
    fn take(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == byte;
        if is_next {
            self.at += 1;
            self.space();
        }
        is_next
    }

    /// Moves from the start of a container to the start of one of its values. Returns whether there is such a value.
    fn descend(&mut self, step: Down) -> bool {
        let (open, close) = if matches!(step, Down::Key(_)) { (b'{', b'}') } else { (b'[', b']') };
        if !self.take(open) {
            return false;
        }
        let mut index = 0;
        while self.at < self.bytes.len() && self.peek() != close {
            let is_it = match step {
                Down::Index(wanted) => index == wanted,
                Down::Key(wanted) => {
                    let start = self.at;
                    self.string();
                    let key: Option<String> = serde_json::from_slice(&self.bytes[start..self.at]).ok();
                    self.space();
                    self.take(b':');
                    key.as_deref() == Some(wanted)
                }
            };
            if is_it {
                return true;
            }
            self.value();
            self.take(b',');
            index += 1;
        }
        false
    }

    fn string(&mut self) {
        self.at += 1;
        while self.at < self.bytes.len() && self.peek() != b'"' {
            self.at += if self.peek() == b'\\' { 2 } else { 1 };
        }
        self.at = (self.at + 1).min(self.bytes.len());
    }

    /// Moves over a value and the space behind it.
    fn value(&mut self) {
        let mut depth = 0_usize;
        while self.at < self.bytes.len() {
            match self.peek() {
                b'"' => {
                    self.string();
                    continue;
                }
                b'{' | b'[' => depth += 1,
                b',' if depth == 0 => break,
                b'}' | b']' if depth == 0 => break,
                b'}' | b']' => depth -= 1,
                _ => {}
            }
            self.at += 1;
        }
        self.space();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_keys() {
        let text = "{\n \"a\\\"]\": [1,\n  {\"b\": \"}\"},\n  [[], 3]\n ],\n \"c\"\n :\n {\"d\": null}}";
        let cases = [("", 1), ("c", 8), ("c.d", 8), ("a\"]", 2), ("nothing", 1), ("c.e", 8)];
        for (path, line) in cases {
            assert_eq!(line_of(text, path), line, "{path}");
        }
        let text = "[1,\n[2,\n {\"x\": [\"[\",\n5]}]]";
        for (path, line) in [("[0]", 1), ("[1][0]", 2), ("[1][1]", 3), ("[1][1].x[1]", 4), ("[1][7]", 2), ("[2]", 1)] {
            assert_eq!(line_of(text, path), line, "{path}");
        }
    }
}
