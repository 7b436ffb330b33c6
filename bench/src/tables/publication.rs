//! A publication: tables under one name.

use super::table::Table;
use crate::ledger::Canonical;

/// Tables under one name: one Markdown file for all, and one CSV file for each.
#[derive(Clone, Copy, Debug)]
pub struct Publication {
    /// The name on the command line and of the Markdown file.
    pub name: &'static str,
    /// The question it answers, in one sentence.
    pub question: &'static str,
    /// Its tables.
    pub(super) tables: fn(&Canonical) -> Vec<Table>,
}

impl Publication {
    /// Its tables of these records.
    pub fn tables(&self, records: &Canonical) -> Vec<Table> {
        (self.tables)(records)
    }

    /// Its files of these records, each with its name. `ledgers` are the words that name the records on the command
    /// line.
    pub fn files(&self, records: &Canonical, ledgers: &str) -> Vec<(String, String)> {
        let tables = self.tables(records);
        let csv = tables.iter().map(|table| (format!("{}.csv", table.id()), table.to_csv()));
        [(format!("{}.md", self.name), self.markdown(&tables, ledgers))].into_iter().chain(csv).collect()
    }

    /// Its Markdown. `ledgers` are the words that name the records on the command line.
    fn markdown(&self, tables: &[Table], ledgers: &str) -> String {
        let command = format!("situ-bench tables {ledgers} --table {}", self.name);
        tables.iter().map(|table| table.to_markdown(&command)).collect::<Vec<_>>().join("\n")
    }
}
