//! The notation of conditions and features in a task file: calls such as `all(held(pitcher), not(on(lid, pitcher)))`.

use std::fmt;

/// How deep calls may be nested. People write the files, and the bound keeps a hostile file from exhausting the stack.
const MAX_DEPTH: usize = 16;

/// A call: a word and its arguments in brackets.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call {
    pub(crate) word: String,
    pub(crate) arguments: Vec<Argument>,
}

/// What may stand between the brackets of a call.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Argument {
    Call(Call),
    Name(String),
    Number(f64),
}

impl Call {
    /// Reads one call; the text must end after it. The error says what was expected, and in which column.
    pub(crate) fn parse(text: &str) -> Result<Call, String> {
        let mut reader = Reader { text, at: 0 };
        let call = match reader.argument(0)? {
            Argument::Call(call) => call,
            Argument::Name(name) => return Err(reader.expected(&format!("`(` after `{name}`"))),
            Argument::Number(_) => return Err(format!("expected a word such as `held`, found a number in `{text}`")),
        };
        reader.skip_space();
        if reader.at < text.len() { Err(reader.expected("the end")) } else { Ok(call) }
    }
}

impl Call {
    /// The same call with another name in the place of one.
    pub(crate) fn with(&self, name: &str, other: &str) -> Call {
        let replaced = |argument: &Argument| match argument {
            Argument::Name(own) if own == name => Argument::Name(other.to_owned()),
            Argument::Call(call) => Argument::Call(call.with(name, other)),
            argument => argument.clone(),
        };
        Call { word: self.word.clone(), arguments: self.arguments.iter().map(replaced).collect() }
    }

    /// Whether a name stands in it.
    pub(crate) fn speaks_of(&self, name: &str) -> bool {
        self.arguments.iter().any(|argument| match argument {
            Argument::Name(own) => own == name,
            Argument::Call(call) => call.speaks_of(name),
            Argument::Number(_) => false,
        })
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Argument::Call(call) => write!(f, "`{}(…)`", call.word),
            Argument::Name(name) => write!(f, "`{name}`"),
            Argument::Number(number) => write!(f, "`{number}`"),
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    fn argument(&mut self, depth: usize) -> Result<Argument, String> {
        if depth > MAX_DEPTH {
            return Err(format!("expected at most {MAX_DEPTH} nested brackets"));
        }
        self.skip_space();
        let token = self.token();
        if token.is_empty() {
            return Err(self.expected("a word or a number"));
        }
        if token.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '.') {
            let number: f64 = token.parse().map_err(|_| format!("expected a number, found `{token}`"))?;
            return Ok(Argument::Number(number));
        }
        self.skip_space();
        if !self.eat('(') {
            return Ok(Argument::Name(token));
        }
        let mut arguments = Vec::new();
        self.skip_space();
        if self.eat(')') {
            return Ok(Argument::Call(Call { word: token, arguments }));
        }
        loop {
            arguments.push(self.argument(depth + 1)?);
            self.skip_space();
            if self.eat(')') {
                return Ok(Argument::Call(Call { word: token, arguments }));
            }
            if !self.eat(',') {
                return Err(self.expected("`,` or `)`"));
            }
        }
    }

    fn token(&mut self) -> String {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || "_-.".contains(c))).unwrap_or(rest.len());
        self.at += end;
        rest[..end].to_owned()
    }

    fn skip_space(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn eat(&mut self, wanted: char) -> bool {
        let found = self.text[self.at..].starts_with(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn expected(&self, what: &str) -> String {
        let column = 1 + self.text[..self.at].chars().count();
        let found = self.text[self.at..].chars().next().map_or("the end".to_owned(), |c| format!("`{c}`"));
        format!("expected {what} in column {column} of `{}`, found {found}", self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_nest_and_mistakes_name_their_column() {
        let call = Call::parse("all(held(a), near(a, b, 0.05) )").expect("well formed");
        assert_eq!(call.word, "all");
        let Argument::Call(near) = &call.arguments[1] else { panic!("the second argument is a call") };
        assert_eq!(near.arguments[2], Argument::Number(0.05));

        for (text, column) in
            [("held(a", "column 7"), ("held(a))", "column 8"), ("held(,a)", "column 6"), ("held", "column 5")]
        {
            let message = Call::parse(text).expect_err("malformed");
            assert!(message.contains(column), "{text}: {message}");
        }
        assert!(Call::parse(&"not(".repeat(1000)).is_err(), "deep nesting is refused, not a stack overflow");
    }
}
