//! Text of strangers where one line is expected: in DOT, Markdown and CSV.

/// The text as one line: control characters are escaped, and so are the marks that turn the direction of writing.
pub fn one_line(text: &str) -> String {
    let turns =
        |letter: char| matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let breaks = |letter: char| letter.is_control() || matches!(letter, '\u{2028}' | '\u{2029}');
    let mut line = String::with_capacity(text.len());
    for letter in text.chars() {
        if breaks(letter) || turns(letter) {
            line.extend(letter.escape_default());
        } else {
            line.push(letter);
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn a_line_stays_one_line() {
        assert_eq!(one_line("a | é\tb\r\n\u{1b}[1m\u{202e}c\u{2028}"), "a | é\\tb\\r\\n\\u{1b}[1m\\u{202e}c\\u{2028}");
    }
}
