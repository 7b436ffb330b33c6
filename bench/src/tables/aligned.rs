//! A table for a terminal: in so many blocks of columns as its width asks for, each with the columns that name the row.

use comfy_table::{CellAlignment, ContentArrangement, Table as Grid, presets::NOTHING};

use super::column::Shape;
use super::heading::Heading;
use super::table::{Table, words};

/// What stands between two columns.
const GAP: usize = 2;
/// The least width that a column of words is left with where it is too wide for its block.
const LEAST: usize = 12;

impl Table {
    /// The table in lines of at most `width` signs; `command` makes it again.
    pub fn to_aligned(&self, heading: &Heading, command: &str, width: usize) -> String {
        let cells = |row: &Vec<_>| self.heads.iter().zip(row).map(|(head, cell)| words(head.shape, cell)).collect();
        let rows: Vec<Vec<String>> = self.rows.iter().map(cells).collect();
        let heads: Vec<String> = self.heads.iter().map(|head| head.words()).collect();
        let names = self.heads.iter().take_while(|head| head.shape == Shape::Text).count();
        // What is the same in every row is said once.
        let is_one = |column: usize| rows.len() > 1 && rows.iter().all(|row| row[column] == rows[0][column]);
        let (said, kept): (Vec<usize>, Vec<usize>) = (0..names).partition(|column| is_one(*column));
        let mut text = format!("{}\n\n", wrapped(self.title.text, width));
        for sentence in self.said.iter().map(|sentence| sentence.replace('`', "")) {
            text.push_str(&format!("- {}\n", wrapped(&sentence, width - GAP).replace('\n', "\n  ")));
        }
        if !self.said.is_empty() {
            text.push('\n');
        }
        if !said.is_empty() {
            let all: Vec<String> =
                said.iter().map(|column| format!("{} {}", heads[*column], rows[0][*column])).collect();
            text.push_str(&format!("{}\n", wrapped(&format!("All of {}.", all.join(", ")), width)));
        }
        for columns in blocks(&heads, &rows, &kept, names, width) {
            text.push_str(&self.grid(&heads, &rows, &columns, width));
            text.push('\n');
        }
        text.push_str(&wrapped(&self.title.note.replace('`', ""), width));
        text.push_str(&format!("\n\n{}\n", wrapped(&self.origin(heading, command).replace('`', ""), width)));
        text
    }

    /// Some columns of the table, with lines of at most `width` signs.
    fn grid(&self, heads: &[String], rows: &[Vec<String>], columns: &[usize], width: usize) -> String {
        let mut grid = Grid::new();
        grid.load_style(NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_width(width as u16);
        let of = |row: &[String]| columns.iter().map(|column| row[*column].clone()).collect::<Vec<_>>();
        grid.set_header(of(heads));
        for row in rows {
            grid.add_row(of(row));
        }
        for (place, column) in columns.iter().enumerate() {
            let is_text = self.heads[*column].shape == Shape::Text;
            if let Some(aligned) = grid.column_mut(place) {
                aligned.set_cell_alignment(if is_text { CellAlignment::Left } else { CellAlignment::Right });
                aligned.set_padding((0, GAP as u16));
            }
        }
        let lines: Vec<String> = grid.lines().map(|line| line.trim_end().to_owned() + "\n").collect();
        lines.concat()
    }
}

/// The columns of each block: those that are `kept` of the first `names`, and as many of the others as there is room.
fn blocks(heads: &[String], rows: &[Vec<String>], kept: &[usize], names: usize, width: usize) -> Vec<Vec<usize>> {
    let of = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([heads[column].chars().count()]).max().unwrap_or(0) + GAP
    };
    let named: usize = kept.iter().map(|column| of(*column)).sum();
    let (mut blocks, mut used) = (vec![kept.to_vec()], named);
    for column in names..heads.len() {
        let wide = of(column).min(width.saturating_sub(named).max(LEAST));
        if used + wide > width && used > named {
            blocks.push(kept.to_vec());
            used = named;
        }
        used += wide;
        if let Some(block) = blocks.last_mut() {
            block.push(column);
        }
    }
    blocks
}

/// A text in lines of at most `width` signs, where no word is longer.
pub(super) fn wrapped(text: &str, width: usize) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::Canonical;
    use crate::sample;
    use crate::tables::ALL;

    /// Whatever the table and the width, no line is wider, and no value is missing.
    #[test]
    fn a_table_fits_a_terminal_and_says_all() {
        let records = Canonical::from(sample::records());
        let heading = Heading { ledgers: "a.jsonl".into(), revision: "Revision: `b`".into(), superseded: None };
        for table in ALL.iter().flat_map(|publication| publication.tables(&records)) {
            for width in [60, 80, 100, 200] {
                let text = table.to_aligned(&heading, "situ-bench tables a.jsonl", width);
                let widest = text.lines().map(|line| line.chars().count()).max();
                assert!(widest.is_some_and(|widest| widest <= width), "{} in {width}:\n{text}", table.id());
                let squeezed: String = text.split_whitespace().collect();
                for (head, cell) in table.rows.iter().flat_map(|row| table.heads.iter().zip(row)) {
                    let said = words(head.shape, cell);
                    let first = said.split_whitespace().next().unwrap_or("");
                    assert!(width < 100 || squeezed.contains(first), "{} in {width}: {said}\n{text}", table.id());
                }
            }
        }
    }

    #[test]
    fn a_text_is_wrapped_at_spaces() {
        assert_eq!(wrapped("one two  three four", 9), "one two\nthree\nfour");
        assert_eq!(wrapped("unbreakable", 4), "unbreakable");
        assert_eq!(wrapped("", 4), "");
    }
}
