//! What goes wrong with a file of TOML or JSON, whatever it is about.

use std::ops::Range;

use proptest::sample::Index;

/// What may stand where a number or a text stood.
const VALUES: [&str; 36] = [
    "0",
    "-0.0",
    "-1",
    "2",
    "0.5",
    "1e6",
    "-1e9",
    "1e308",
    "1e400",
    "-1e400",
    "5e-324",
    "nan",
    "NaN",
    "inf",
    "18446744073709551615",
    "18446744073709551616",
    "9223372036854775807",
    "4294967295",
    "4294967296",
    "100000",
    "99999999999999999999999999999999",
    "0x7fffffffffffffff",
    "1979-05-27",
    "true",
    "null",
    "[]",
    "{}",
    "[1, 1]",
    "\"\"",
    "\"x\"",
    "\"..\"",
    "\"a\\nb\"",
    "\"\\u001b[31m\"",
    "\"\\u0000\"",
    "\"a|b\"",
    "\"\u{202e}\"",
];
/// What may be put anywhere.
const ODD: [&str; 20] = [
    "\0",
    "\u{1b}[31m",
    "\r",
    "\u{7f}",
    "\u{85}",
    "\u{2028}",
    "\u{202e}",
    "\u{feff}",
    "\"",
    "\\",
    "é",
    "\u{1d54f}",
    "\\u001b",
    "\\n",
    "\n",
    "\t",
    "#",
    ",",
    "}",
    "]",
];
/// How long a name is that is very long, and how deep nesting that is deep.
const LONG: usize = 20_000;
const DEEP: usize = 3_000;

/// One change of a file.
pub(super) struct Mutation {
    kind: u8,
    place: Index,
    choice: Index,
}

impl Mutation {
    pub(super) fn of(kind: u8, place: Index, choice: Index) -> Self {
        Self { kind, place, choice }
    }

    /// The file after it. A file that has no such place stays as it is.
    pub(super) fn apply(&self, text: &str) -> String {
        match self.kind % 16 {
            0..=4 => self.in_value(text, pick(self.choice, &VALUES)),
            5 => self.in_value(text, &self.borrowed(text)),
            6 => self.in_value(text, &format!("\"{}\"", "n".repeat(LONG))),
            7 => {
                let (open, close) = *self.choice.get(&[("[", "]"), ("{\"a\": ", "}"), ("{a = ", "}"), ("[", "")]);
                self.in_value(text, &format!("{}1{}", open.repeat(DEEP), close.repeat(DEEP)))
            }
            8 => self.in_lines(text, |lines, at| lines.insert(at, lines[at])),
            9 => self.in_lines(text, |lines, at| {
                lines.remove(at);
            }),
            10 => self.in_lines(text, |lines, at| {
                let other = self.choice.index(lines.len());
                lines.swap(at, other);
            }),
            11 => {
                let at = self.boundary(text);
                text[..at].to_owned()
            }
            12 => {
                let at = self.boundary(text);
                text[..at].to_owned() + &text[at + text[at..].chars().next().map_or(0, char::len_utf8)..]
            }
            13 => self.in_key(text),
            _ => {
                let at = self.boundary(text);
                text[..at].to_owned() + pick(self.choice, &ODD) + &text[at..]
            }
        }
    }

    /// A place between two letters.
    fn boundary(&self, text: &str) -> usize {
        let mut at = self.place.index(text.len() + 1);
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }

    fn in_lines(&self, text: &str, change: impl Fn(&mut Vec<&str>, usize)) -> String {
        let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
        if !lines.is_empty() {
            let at = self.place.index(lines.len());
            change(&mut lines, at);
        }
        lines.concat()
    }

    fn in_value(&self, text: &str, value: &str) -> String {
        let values = values(text);
        if values.is_empty() {
            return text.to_owned();
        }
        let place = self.place.get(&values).clone();
        [&text[..place.start], value, &text[place.end..]].concat()
    }

    /// Another value of the file.
    fn borrowed(&self, text: &str) -> String {
        let values = values(text);
        if values.is_empty() { String::new() } else { text[self.choice.get(&values).clone()].to_owned() }
    }

    /// A word of the file, where it is a key or within a text, is another or an odd one.
    fn in_key(&self, text: &str) -> String {
        let words: Vec<&str> = text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_').collect();
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            return text.to_owned();
        }
        let word = pick(self.place, &words);
        let at = word.as_ptr().addr() - text.as_ptr().addr();
        [&text[..at], pick(self.choice, &words), &text[at + word.len()..]].concat()
    }
}

/// One of these, of which there are some.
fn pick<'a>(index: Index, words: &[&'a str]) -> &'a str {
    words[index.index(words.len())]
}

/// Where the numbers and the texts of a file are.
fn values(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        match bytes[at] {
            b'"' => {
                at += 1;
                while at < bytes.len() && bytes[at] != b'"' && bytes[at] != b'\n' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at = (at + 1).min(bytes.len());
                if text.is_char_boundary(at) {
                    found.push(start..at);
                }
            }
            b'-' | b'0'..=b'9' => {
                while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || b"+-._".contains(&bytes[at])) {
                    at += 1;
                }
                found.push(start..at);
            }
            letter if letter.is_ascii_alphabetic() || letter == b'_' => {
                while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_') {
                    at += 1;
                }
            }
            _ => at += 1,
        }
    }
    found
}
