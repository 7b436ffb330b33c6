//! A table, and how it is written in Markdown and CSV. LaTeX has a file of its own.

use std::collections::BTreeSet;
use std::fmt::Write;

use situ_tasks::name::one_line;

use super::column::{Cell, Columns, Head, Shape};
use super::heading::Heading;
use crate::chart::{Chart, to_svg};
use crate::ledger::Canonical;
use crate::stats;

/// Tables and figures under one name: one Markdown file for all tables, a CSV and a LaTeX file for each, and an SVG
/// file for each figure.
#[derive(Clone, Copy, Debug)]
pub struct Publication {
    /// The name on the command line and of the Markdown file.
    pub name: &'static str,
    /// The question it answers, in one sentence.
    pub question: &'static str,
    /// Its tables.
    pub(super) tables: fn(&Canonical) -> Vec<Table>,
    /// Its figures.
    pub(super) figures: fn(&Canonical) -> Vec<Figure>,
}

/// A publication that has no figure.
pub(super) const NO_FIGURES: fn(&Canonical) -> Vec<Figure> = |_| Vec::new();

/// A chart under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The name of its file, without the ending.
    pub id: &'static str,
    /// What is drawn.
    pub chart: Chart,
}

impl Publication {
    /// Its tables of these records, but for those that have no row.
    pub fn tables(&self, records: &Canonical) -> Vec<Table> {
        (self.tables)(records).into_iter().filter(|table| !table.is_empty()).collect()
    }

    /// Its figures of these records, but for those that have no line.
    pub fn figures(&self, records: &Canonical) -> Vec<Figure> {
        (self.figures)(records).into_iter().filter(|figure| !figure.chart.panels.is_empty()).collect()
    }

    /// Its files of these records, each with its name; none where no table has a row. `heading` says where the records
    /// are from.
    pub fn files(&self, records: &Canonical, heading: &Heading) -> Vec<(String, String)> {
        let tables = self.tables(records);
        if tables.is_empty() {
            return Vec::new();
        }
        let command = self.command(heading);
        let markdown = tables.iter().map(|table| table.to_markdown(heading, &command)).collect::<Vec<_>>().join("\n");
        let of_tables = tables.iter().flat_map(|table| {
            let latex = table.to_latex(heading, &command);
            [(format!("{}.csv", table.id()), table.to_csv()), (format!("{}.tex", table.id()), latex)]
        });
        let figures = self.figures(records).into_iter();
        let svg = figures.map(|figure| (format!("{}.svg", figure.id), to_svg(&figure.chart)));
        [(format!("{}.md", self.name), markdown)].into_iter().chain(of_tables).chain(svg).collect()
    }

    /// Its tables for a terminal, in lines of at most `width` signs.
    pub fn aligned(&self, records: &Canonical, heading: &Heading, width: usize) -> String {
        let command = self.command(heading);
        let tables = self.tables(records).into_iter();
        tables.map(|table| table.to_aligned(heading, &command, width)).collect::<Vec<_>>().join("\n")
    }

    /// The command that makes it again.
    fn command(&self, heading: &Heading) -> String {
        one_line(&format!("situ-bench tables {} --table {}", heading.ledgers, self.name))
    }

    /// The names of all files that it can have.
    pub fn names(&self) -> Vec<String> {
        let tables = (self.tables)(&Canonical::default());
        let of_tables = tables.iter().flat_map(|table| ["csv", "tex"].map(|ending| format!("{}.{ending}", table.id())));
        let figures = (self.figures)(&Canonical::default());
        let svg = figures.iter().map(|figure| format!("{}.svg", figure.id));
        [format!("{}.md", self.name)].into_iter().chain(of_tables).chain(svg).collect()
    }
}

/// How a table is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Title {
    /// The name of its CSV file, without the ending.
    pub(super) id: &'static str,
    /// Its heading.
    pub(super) text: &'static str,
    /// An explanation for the reader.
    pub(super) note: &'static str,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub(super) title: Title,
    pub(super) heads: Vec<Head>,
    pub(super) rows: Vec<Vec<Cell>>,
    protocols: BTreeSet<String>,
    records: usize,
    /// Sentences that say what the rows come to.
    pub(super) said: Vec<String>,
}

/// Decimals of a share.
const SHARE: usize = 2;
/// Decimals of every number in CSV.
const CSV: usize = 6;

impl Table {
    /// A table of these rows. `source` is the protocol and the number of records of each row.
    pub(super) fn new<'a, R>(
        title: Title,
        columns: Columns<'_, R>,
        rows: &[R],
        source: impl Iterator<Item = (&'a str, usize)>,
    ) -> Self {
        let cells = |row: &R| columns.0.iter().map(|column| (column.cell)(row)).collect();
        let (mut protocols, mut records) = (BTreeSet::new(), 0);
        for (protocol, count) in source {
            protocols.insert(protocol.to_owned());
            records += count;
        }
        let heads: Vec<Head> = columns.0.iter().map(|column| column.head).collect();
        let rows: Vec<Vec<Cell>> = rows.iter().map(cells).collect();
        // A column that says nothing in any row is left out.
        let says = |index: usize| rows.iter().any(|row: &Vec<Cell>| row[index].says_something());
        let kept: Vec<usize> = (0..heads.len()).filter(|index| says(*index)).collect();
        let rows = rows.iter().map(|row| kept.iter().map(|index| row[*index].clone()).collect()).collect();
        let heads = kept.iter().map(|index| heads[*index]).collect();
        Self { title, heads, rows, protocols, records, said: Vec::new() }
    }

    /// The same table with sentences that say what its rows come to.
    pub(super) fn saying(self, said: Vec<String>) -> Self {
        Self { said, ..self }
    }

    /// The name of its file, without an ending.
    pub fn id(&self) -> &'static str {
        self.title.id
    }

    /// Whether it has no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The line that says where the table is from; `command` makes it again.
    pub(super) fn origin(&self, heading: &Heading, command: &str) -> String {
        let protocols = self.protocols.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let protocols = if protocols.is_empty() { "none".to_owned() } else { protocols };
        heading.line(&protocols, self.records, command)
    }

    /// The table in Markdown, below a heading; `command` makes it again.
    pub fn to_markdown(&self, heading: &Heading, command: &str) -> String {
        let line = self.origin(heading, command);
        let mut text = format!("## {}\n\n{line}\n\n{}\n\n", self.title.text, self.title.note);
        self.said.iter().for_each(|sentence| text += &format!("- {sentence}\n"));
        if !self.said.is_empty() {
            text.push('\n');
        }
        let heads = self.heads.iter().map(|head| head.words().replace('|', "\\|"));
        let rule = self.heads.iter().map(|head| if head.shape == Shape::Text { "---" } else { "---:" }.to_owned());
        let rows = self
            .rows
            .iter()
            .map(|row| self.heads.iter().zip(row).map(|(head, cell)| markdown(head.shape, cell)).collect::<Vec<_>>());
        for row in [heads.collect::<Vec<_>>(), rule.collect()].into_iter().chain(rows) {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    /// The table in CSV, a header first.
    pub fn to_csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let heads = self.heads.iter().flat_map(|head| {
            let clock = if head.wall { "_wall" } else { "" };
            suffixes(head.shape).iter().map(move |suffix| format!("{}{suffix}{clock}", csv_name(head.name)))
        });
        let rows = self.rows.iter().map(|row| {
            self.heads.iter().zip(row).flat_map(|(head, cell)| fields(head.shape, cell)).collect::<Vec<_>>()
        });
        let (heads, rows): (Vec<String>, Vec<Vec<String>>) = (heads.collect(), rows.collect());
        // A part of a column that says nothing in any row is left out, such as the bound where all data are exact.
        let kept: Vec<usize> =
            (0..heads.len()).filter(|index| rows.iter().any(|row| !row[*index].is_empty())).collect();
        for row in std::iter::once(&heads).chain(&rows) {
            writer.write_record(kept.iter().map(|index| &row[*index])).expect("rows of one length, in memory");
        }
        String::from_utf8(writer.into_inner().expect("in memory")).expect("made of strings")
    }
}

/// A column's name without signs: `|Z|` is `applicable`, `|T|` is `model_size`.
fn csv_name(name: &str) -> String {
    name.replace("|Z|", "applicable").replace("|T|", "model_size").replace('/', "_over_").replace([' ', '-'], "_")
}

const fn suffixes(shape: Shape) -> &'static [&'static str] {
    match shape {
        Shape::Text | Shape::Count | Shape::Number(_) => &[""],
        Shape::Rate => &["_successes", "_n", "_low", "_high"],
        Shape::Estimate(_) => &["", "_low", "_high", "_bound"],
        Shape::Pooled(_) => &["", "_low", "_high", "_variations_low", "_variations_high", "_bound"],
    }
}

/// A number with so many decimals. A number that rounds to 0 has no sign.
fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|digit| matches!(digit, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

fn fields(shape: Shape, cell: &Cell) -> Vec<String> {
    let number = |value: &f64| fixed(*value, CSV);
    match cell {
        Cell::Text(text) => vec![one_line(text)],
        Cell::Count(count) => vec![count.to_string()],
        Cell::Number(value) => vec![number(value)],
        Cell::Rate(rate) => {
            let (low, high) = stats::wilson(rate.successes, rate.rollouts);
            vec![rate.successes.to_string(), rate.rollouts.to_string(), number(&low), number(&high)]
        }
        Cell::Estimate(estimate, bound) => {
            vec![number(&estimate.value), number(&estimate.low), number(&estimate.high), bound.mark().to_owned()]
        }
        Cell::Pooled(pooled, bound) => {
            let ends = [pooled.units, pooled.variations].into_iter().flat_map(|interval| {
                interval.map_or_else(|| [String::new(), String::new()], |(low, high)| [number(&low), number(&high)])
            });
            [number(&pooled.value)].into_iter().chain(ends).chain([bound.mark().to_owned()]).collect()
        }
        Cell::Nothing => vec![String::new(); suffixes(shape).len()],
    }
}

/// A cell as Markdown has it.
pub(super) fn markdown(shape: Shape, cell: &Cell) -> String {
    words(shape, cell).replace('|', "\\|")
}

/// A cell in words and numbers.
pub(super) fn words(shape: Shape, cell: &Cell) -> String {
    let digits = match shape {
        Shape::Number(digits) | Shape::Estimate(digits) | Shape::Pooled(digits) => digits,
        _ => SHARE,
    };
    match cell {
        Cell::Text(text) => one_line(text),
        Cell::Count(count) => count.to_string(),
        Cell::Number(value) => fixed(*value, digits),
        Cell::Rate(rate) => {
            let (low, high) = stats::wilson(rate.successes, rate.rollouts);
            format!("{}/{} [{low:.SHARE$}, {high:.SHARE$}]", rate.successes, rate.rollouts)
        }
        Cell::Estimate(estimate, bound) => {
            let number = |value| fixed(value, digits);
            format!("{}{} [{}, {}]", bound.mark(), number(estimate.value), number(estimate.low), number(estimate.high))
        }
        Cell::Pooled(pooled, bound) => {
            let interval = |(low, high)| format!(" [{}, {}]", fixed(low, digits), fixed(high, digits));
            let intervals: String = [pooled.units, pooled.variations].into_iter().flatten().map(interval).collect();
            format!("{}{}{intervals}", bound.mark(), fixed(pooled.value, digits))
        }
        Cell::Nothing => "–".to_owned(),
    }
}
