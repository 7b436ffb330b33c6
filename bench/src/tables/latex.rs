//! A table in LaTeX, for the package booktabs: a `tabular` to put into an environment of one's own, below comments that
//! say what it is and where it is from.

use super::column::Shape;
use super::heading::Heading;
use super::table::{Table, words};

/// How a comment begins.
pub(super) const COMMENT: &str = "% ";
/// What stands between two cells.
pub(super) const CELL_END: &str = " & ";
/// How a row ends.
pub(super) const ROW_END: &str = r" \\";

impl Table {
    /// The table in LaTeX; `command` makes it again.
    pub fn to_latex(&self, heading: &Heading, command: &str) -> String {
        let comments = [self.title.text, &self.origin(heading, command), self.title.note];
        let comments = comments.map(|text| format!("{COMMENT}{text}\n")).concat();
        let align: String = self.heads.iter().map(|head| if head.shape == Shape::Text { 'l' } else { 'r' }).collect();
        let line = |cells: Vec<String>| format!("{}{ROW_END}\n", cells.join(CELL_END));
        let head = line(self.heads.iter().map(|head| escaped(&head.words())).collect());
        let rows = self.rows.iter().map(|row| {
            line(self.heads.iter().zip(row).map(|(head, cell)| escaped(&words(head.shape, cell))).collect())
        });
        let rows: String = rows.collect();
        format!(
            "{comments}\\begin{{tabular}}{{{align}}}\n\\toprule\n{head}\\midrule\n{rows}\\bottomrule\n\\end{{tabular}}\n"
        )
    }
}

/// A text in which no character has a meaning of its own, and those outside ASCII that tables have are commands.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', sign]),
            '\\' => out.push_str(r"\textbackslash{}"),
            '~' => out.push_str(r"$\sim$"),
            '^' => out.push_str(r"\textasciicircum{}"),
            '|' => out.push_str("$|$"),
            '<' | '>' => out.extend(['$', sign, '$']),
            '≥' => out.push_str(r"$\geq$"),
            '≤' => out.push_str(r"$\leq$"),
            '×' => out.push_str(r"$\times$"),
            '−' => out.push_str("$-$"),
            '–' => out.push_str("--"),
            '°' => out.push_str(r"$^\circ$"),
            'µ' => out.push_str(r"$\mu$"),
            _ => out.push(sign),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sign_of_a_name_is_a_command() {
        assert_eq!(escaped("≥1.5 [0.9, 2.0]"), r"$\geq$1.5 [0.9, 2.0]");
        assert_eq!(escaped("all_nodes & |Z| 5 %"), r"all\_nodes \& $|$Z$|$ 5 \%");
        assert_eq!(escaped(r"a\b~{c}^d – e"), r"a\textbackslash{}b$\sim$\{c\}\textasciicircum{}d -- e");
    }
}
