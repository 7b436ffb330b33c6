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

/// A text of a file as a message repeats it: on one line and in plain letters, however long it is and whatever it
/// holds. A letter that would control the terminal or turn the line is written out as an escape, and what is too long
/// is cut.
pub fn shown(text: &str) -> String {
    let is_odd = |letter: char| {
        letter.is_control() || matches!(letter, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    let (mut shown, mut word) = (String::new(), 0);
    for (index, letter) in text.chars().enumerate() {
        if index == SHOWN_TEXT {
            return shown + "…";
        }
        word = if letter == ' ' { 0 } else { word + 1 };
        match word.cmp(&SHOWN_WORD) {
            Ordering::Greater => {}
            Ordering::Equal => shown.push('…'),
            Ordering::Less if is_odd(letter) => shown.extend(letter.escape_default()),
            Ordering::Less => shown.push(letter),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{mistake, shown};

    #[test]
    fn what_is_shown_is_one_line() {
        assert_eq!(shown("a \u{1b}[31m\nred\u{202e} é"), "a \\u{1b}[31m\\nred\\u{202e} é");
        assert_eq!(shown(&format!("`{}` b", "n".repeat(500))), format!("`{}… b", "n".repeat(98)));
        assert_eq!(shown(&"a ".repeat(5000)).chars().count(), 1001);
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
