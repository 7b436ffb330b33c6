//! Names of things in files: they stand in tables, in paths and in commands, so they are plain words.

use std::cmp::Ordering;

/// The most letters of a name. A path has room for some of them.
const LONGEST: usize = 60;

/// What is wrong with a name of a task, a setting, a protocol, a teacher or a sequence, and what would be right; `None`
/// where it is a name.
pub fn mistake(name: &str) -> Option<String> {
    let is_fine = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
    if !name.starts_with(|first: char| first.is_ascii_lowercase()) || !name.chars().all(is_fine) {
        let shown = name.escape_debug();
        return Some(format!("`{shown}`: expected a name of small letters, digits and `_` that begins with a letter"));
    }
    (name.len() > LONGEST).then(|| format!("`{name}`: expected a name of at most {LONGEST} letters"))
}

/// The most letters of a word, and of a text, that a message repeats.
const SHOWN_WORD: usize = 100;
const SHOWN_TEXT: usize = 1000;

/// A stranger's text on one line and in plain letters, for DOT, Markdown, CSV and the terminal: what would break the
/// line, control the terminal or turn the direction of writing is written out as an escape.
pub fn one_line(text: &str) -> String {
    let is_odd = |letter: char| {
        letter.is_control()
            || matches!(letter, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    let mut line = String::with_capacity(text.len());
    for letter in text.chars() {
        if is_odd(letter) { line.extend(letter.escape_default()) } else { line.push(letter) }
    }
    line
}

/// A text of a file as a message repeats it: [`one_line`] of it, cut where it is too long.
pub fn shown(text: &str) -> String {
    let (mut shown, mut letters, mut word) = (String::new(), 0, 0);
    for letter in one_line(text).chars() {
        word = if letter == ' ' { 0 } else { word + 1 };
        letters += usize::from(word < SHOWN_WORD);
        if letters > SHOWN_TEXT {
            return shown + "…";
        }
        match word.cmp(&SHOWN_WORD) {
            Ordering::Greater => {}
            Ordering::Equal => shown.push('…'),
            Ordering::Less => shown.push(letter),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{mistake, one_line, shown};

    #[test]
    fn what_is_shown_is_one_line() {
        assert_eq!(shown("a \u{1b}[31m\nred\u{202e} é"), "a \\u{1b}[31m\\nred\\u{202e} é");
        assert_eq!(shown(&format!("`{}` b", "n".repeat(5000))), format!("`{}… b", "n".repeat(98)));
        assert_eq!(shown(&"a ".repeat(5000)).chars().count(), 1001);
        assert_eq!(shown(&"\u{7f} ".repeat(5000)).chars().count(), 1001);
    }

    #[test]
    fn a_line_stays_one_line() {
        assert_eq!(one_line("a | é\tb\r\n\u{1b}[1m\u{202e}c\u{2028}"), "a | é\\tb\\r\\n\\u{1b}[1m\\u{202e}c\\u{2028}");
    }

    #[test]
    fn a_name_is_a_plain_word() {
        for name in ["a", "tower_2", &"n".repeat(60)] {
            assert_eq!(mistake(name), None);
        }
        for bad in ["", "..", "../a", "A", "2a", "_a", "a b", "a\nb", "a/b", "a|b", "é", "a\u{202e}b", &"n".repeat(61)]
        {
            let problem = mistake(bad).unwrap();
            assert!(problem.contains("expected a name") && !problem.contains('\n'), "{problem}");
        }
    }
}
