//! What an import says: one line a keyframe, so that its decisions can be looked through.

use std::fmt::Write;

use situ::demonstration::{Gripper, Kind};
use situ_tasks::name::shown;

use crate::demonstration_file::Instance;
use crate::import::drawn::Drawn;

/// The widest a name is shown; a line then fits a terminal of 100 columns.
const WIDEST: usize = 22;

/// The lines about a demonstration.
pub(super) fn demonstration(
    drawn: &Drawn<'_>,
    (after, interrupted): (Option<&Instance>, Option<&Instance>),
    because: &str,
) -> String {
    let kind = match drawn.kind {
        Kind::Original => "original",
        Kind::Corrective => "corrective",
    };
    let seconds = drawn.frames.last().map_or(0.0, |last| last.seconds - drawn.frames[0].seconds);
    let mut text = format!(
        "{}: {kind}, {} in {}, of {} in {seconds:.2} s\n",
        shown(&drawn.name),
        counted(drawn.keyframes.len(), "keyframe"),
        counted(drawn.segments().len(), "segment"),
        counted(drawn.frames.len(), "frame"),
    );
    if drawn.kind == Kind::Corrective {
        let place = |instance: &Instance| format!("segment {} of {}", instance.segment, cut(&instance.demonstration));
        let last = after.map_or("START".to_owned(), place);
        let under_way = interrupted.map_or("nothing".to_owned(), place);
        let _ = writeln!(text, "  ran last   {last}\n  under way  {under_way}: {because}");
    }
    let mut rows = vec![["#", "time", "keyframe", "gripper", "reference", "because"].map(str::to_owned)];
    for (index, keyframe) in drawn.keyframes.iter().enumerate() {
        rows.push([
            index.to_string(),
            format!("{:.2} s", drawn.seconds(keyframe)),
            keyframe.picked.reason.word().to_owned(),
            gripper(keyframe.gripper),
            cut(drawn.reference(keyframe)),
            cut_to(&keyframe.about.because, 2 * WIDEST),
        ]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 6] = std::array::from_fn(width);
    for row in &rows {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(widths).enumerate() {
            // Numbers stand to the right.
            let _ = if column < 2 { write!(line, "  {cell:>width$}") } else { write!(line, "  {cell:<width$}") };
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// So many of a thing.
pub(super) fn counted(number: usize, word: &str) -> String {
    format!("{number} {word}{}", if number == 1 { "" } else { "s" })
}

fn gripper(gripper: Gripper) -> String {
    match gripper {
        Gripper::Opening(share) if share <= 0.0 => "closed".to_owned(),
        Gripper::Opening(share) => format!("open {:.0} %", share * 100.0),
        Gripper::Open(metres) => format!("open {metres:.3} m"),
        Gripper::Close(newtons) => format!("close {newtons:.0} N"),
    }
}

fn cut(text: &str) -> String {
    cut_to(text, WIDEST)
}

fn cut_to(text: &str, most: usize) -> String {
    let text = shown(text);
    if text.chars().count() <= most { text } else { text.chars().take(most - 1).chain(['…']).collect() }
}
