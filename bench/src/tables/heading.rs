//! The line below a table's title: of which protocol and revision its records are, how many, and what made it.

/// The beginning of the line.
const BEGINNING: &str = "Protocol: ";
/// Where the number of records begins: what stands before it is the revision.
const RECORDS: &str = " Records: ";
/// How a mark of what has been overtaken begins; it ends the line.
const MARK: &str = " **Superseded**: ";

/// What a table's heading says of the records' origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heading {
    /// The words that name the records on the command line.
    pub ledgers: String,
    /// The revision of the program that made the records, in a phrase such as `Revision: unknown`.
    pub revision: String,
    /// Why the records have been overtaken, where they have.
    pub superseded: Option<String>,
}

impl Heading {
    /// The line of a table of so many records of these protocols, which `command` makes.
    pub(super) fn line(&self, protocols: &str, records: usize, command: &str) -> String {
        let line = format!("{BEGINNING}{protocols}.{RECORDS}{records}. Made by `{command}`; do not edit.");
        self.put_into(&line).unwrap_or(line)
    }

    /// A line with this revision and this mark in place of those that it has; `None` where it is no such line.
    fn put_into(&self, line: &str) -> Option<String> {
        let (protocols, rest) = parts(line)?;
        let rest = rest.split_once(MARK).map_or(rest, |(rest, _)| rest);
        let mark = self.superseded.as_ref().map_or_else(String::new, |why| format!("{MARK}{why}"));
        Some(format!("{protocols} {}.{rest}{mark}", self.revision))
    }

    /// A Markdown file of tables with this revision and this mark in each heading.
    pub fn mark(&self, markdown: &str) -> String {
        markdown.lines().map(|line| self.put_into(line).unwrap_or_else(|| line.to_owned()) + "\n").collect()
    }
}

/// What stands before the revision, its full stop included, and what stands behind it. `None` where it is no heading.
fn parts(line: &str) -> Option<(&str, &str)> {
    let records = line.starts_with(BEGINNING).then(|| line.find(RECORDS)).flatten()?;
    let (before, rest) = line.split_at(records);
    Some((before.split_once(" Revision").map_or(before, |(protocols, _)| protocols), rest))
}

/// A line of a table's file without the revision, which is another where the same was made again.
pub(super) fn without_revision(line: &str) -> String {
    parts(line).map_or_else(|| line.to_owned(), |(protocols, rest)| format!("{protocols}{rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading(revision: &str, superseded: Option<&str>) -> Heading {
        let superseded = superseded.map(str::to_owned);
        Heading { ledgers: "a.jsonl".to_owned(), revision: revision.to_owned(), superseded }
    }

    #[test]
    fn a_mark_takes_the_place_of_the_one_before() {
        let old = "Protocol: `quick`. Records: 54. Made by `situ-bench tables a.jsonl --table t4`; do not edit.";
        let text = format!("## T\n\n{old}\n\nRecords: a note.\n\n| a |\n");
        let first = heading("Revision: unknown", Some("One reason."));
        let marked = first.mark(&text);
        let line = "Protocol: `quick`. Revision: unknown. Records: 54. Made by `situ-bench tables a.jsonl --table t4`; \
                    do not edit. **Superseded**: One reason.";
        assert_eq!(marked, text.replace(old, line));
        assert_eq!(first.mark(&marked), marked);
        let second = heading("Revisions, mixed: `a`; `b`", None);
        let command = "situ-bench tables a.jsonl --table t4";
        assert_eq!(second.mark(&marked), text.replace(old, &second.line("`quick`", 54, command)));
        let stripped = without_revision(&second.line("`quick`", 54, command));
        assert_eq!(stripped, old);
        assert_eq!(without_revision("Revision: a. Records: 3"), "Revision: a. Records: 3");
    }
}
