//! Whether a table that was made anew is the published one, all but its times and the revision that made it.

use super::{heading, latex};

/// Whether two texts of one file differ in anything but the columns that hold the clock and the revision. A figure that
/// shows the clock says so in its name.
pub fn differs(file: &str, one: &str, other: &str) -> bool {
    if file.ends_with("_wall.svg") {
        return false;
    }
    if file.ends_with(".svg") {
        return one != other;
    }
    let without_times = match file.rsplit_once('.') {
        Some((_, "csv")) => csv_without_times,
        Some((_, "tex")) => latex_without_times,
        _ => markdown_without_times,
    };
    without_times(one) != without_times(other)
}

/// Which columns do not hold the clock.
fn exact<'a>(heads: impl IntoIterator<Item = &'a str>, clock: &str) -> Vec<bool> {
    heads.into_iter().map(|head| !head.ends_with(clock)).collect()
}

/// The fields of the columns that are kept. A line that is too long or too short stays as it is.
fn kept(fields: Vec<&str>, columns: &[bool]) -> Vec<String> {
    let is_whole = fields.len() == columns.len();
    let kept = fields.into_iter().enumerate().filter(|(index, _)| !is_whole || columns[*index]);
    kept.map(|(_, field)| field.to_owned()).collect()
}

fn csv_without_times(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let lines: Vec<csv::StringRecord> = reader.records().map_while(Result::ok).collect();
    let columns = lines.first().map_or_else(Vec::new, |heads| exact(heads, "_wall"));
    lines.iter().map(|line| kept(line.iter().collect(), &columns)).collect()
}

fn markdown_without_times(text: &str) -> Vec<Vec<String>> {
    let row =
        |line: &'_ str| Some(line.strip_prefix("| ")?.strip_suffix(" |")?.split(" | ").map(str::to_owned).collect());
    rows_without_times(text, row, |line| line.to_owned())
}

fn latex_without_times(text: &str) -> Vec<Vec<String>> {
    let row =
        |line: &'_ str| Some(line.strip_suffix(latex::ROW_END)?.split(latex::CELL_END).map(str::to_owned).collect());
    rows_without_times(text, row, |line| line.strip_prefix(latex::COMMENT).unwrap_or(line).to_owned())
}

/// The lines of a text with its tables: the fields of a row that are no times, and any other line without its revision.
fn rows_without_times(
    text: &str,
    row: impl Fn(&str) -> Option<Vec<String>>,
    bare: impl Fn(&str) -> String,
) -> Vec<Vec<String>> {
    let mut columns: Option<Vec<bool>> = None;
    let line = |line: &str| {
        let Some(fields) = row(line) else {
            columns = columns.take().filter(|_| line.starts_with('\\'));
            return vec![heading::without_revision(&bare(line))];
        };
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        let columns = columns.get_or_insert_with(|| exact(fields.iter().copied(), " (wall)"));
        kept(fields, columns)
    };
    text.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARKDOWN: &str = "## T\n\nProtocol: `a`. Revision: `b`. Records: 2.\n\n| method | reached | ms (wall) |\n| --- | ---: | ---: |\n| situ | 1/2 | 3.0 |\n\n| fits |\n| 7 |\n";
    const LATEX: &str = "% Protocol: `a`. Revision: `b`. Records: 2.\n\\begin{tabular}{lrr}\n\\toprule\nmethod & reached & ms (wall) \\\\\n\\midrule\nsitu & 1/2 & 3.0 \\\\\n\\bottomrule\n\\end{tabular}\n";
    const CSV: &str = "method,reached,ms_wall,ms_low_wall\nsitu,1,3.0,2.0\n";

    #[test]
    fn a_figure_says_whether_it_shows_the_clock() {
        assert!(differs("t.svg", "<svg>1</svg>", "<svg>2</svg>"));
        assert!(!differs("t.svg", "<svg>1</svg>", "<svg>1</svg>"));
        assert!(!differs("t_wall.svg", "<svg>1</svg>", "<svg>2</svg>"));
    }

    #[test]
    fn times_may_differ_and_nothing_else() {
        for (file, text, clock) in [("t.md", MARKDOWN, "3.0"), ("t.csv", CSV, "3.0,2.0"), ("t.tex", LATEX, "3.0")] {
            assert!(!differs(file, text, text));
            assert!(!differs(file, text, &text.replace(clock, &clock.replace('0', "5"))), "{file}: a time");
            for (from, to) in [("situ", "rebuild"), ("1", "2"), ("reached", "met")] {
                assert!(differs(file, text, &text.replacen(from, to, 1)), "{file}: {from} and {to}");
            }
            let last_line = text.trim_end().rfind('\n').unwrap();
            assert!(differs(file, text, &text[..last_line]), "{file}: a line less");
        }
        assert!(!differs("t.md", MARKDOWN, &MARKDOWN.replace("`b`", "`c`, changed (sources `d`)")), "the revision");
        assert!(!differs("t.tex", LATEX, &LATEX.replace("`b`", "`c`")), "the revision");
        assert!(differs("t.md", MARKDOWN, &MARKDOWN.replace("`a`", "`c`")), "the protocol");
        assert!(differs("t.md", MARKDOWN, &MARKDOWN.replace("| 7 |", "| 8 |")), "the second table of a file");
        assert!(differs("t.csv", CSV, &CSV.replace("_wall", "")), "a clock that is no longer called one");
    }
}
