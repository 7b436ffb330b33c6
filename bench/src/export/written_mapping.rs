//! The mapping by which `import` reads an export again, so that the demonstrations come back as they were.

use std::fmt::Write;

use situ::demonstration::Kind;
use situ::state::Axis;

use crate::export::timeline::Timeline;

/// The names of what a mapping names in the exported file.
pub(super) struct Names {
    /// Text of the tables `[columns]`, `[gripper]` and `[opening]`.
    pub(super) tables: String,
    /// Text of an object's table, under its heading.
    pub(super) object: fn(&str) -> String,
}

/// A word of a TOML file.
pub(super) fn quoted(word: &str) -> String {
    toml::Value::from(word).to_string()
}

/// Seven columns as the keys of a pose.
pub(super) fn pose_keys(name: impl Fn(&str) -> String) -> String {
    let list = |parts: &[&str]| parts.iter().map(|part| quoted(&name(part))).collect::<Vec<_>>().join(", ");
    format!("position = [{}]\nquaternion = [{}]\n", list(&["x", "y", "z"]), list(&["qw", "qx", "qy", "qz"]))
}

/// The text of the mapping.
pub(super) fn text(timeline: &Timeline<'_>, names: &Names) -> String {
    let mut text = "# Written by `situ-bench export`: `situ-bench import` reads the export with it.\n".to_owned();
    text += "quaternion_order = \"wxyz\"\n";
    let half_turn = timeline.episodes.first().and_then(|episode| episode.file.schema.half_turn());
    let axis = half_turn.map(|axis| match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Z => "z",
    });
    if let Some(axis) = axis {
        let _ = writeln!(text, "half_turn = \"{axis}\"");
    }
    let _ = write!(text, "\n{}", names.tables);
    for object in &timeline.objects {
        let _ = write!(text, "\n[objects.{}]\n{}", quoted(object), (names.object)(object));
    }
    for (index, episode) in timeline.episodes.iter().enumerate() {
        let (demonstration, before) = (&episode.file.demonstration, &episode.file.before);
        let name = quoted(demonstration.name());
        let _ = write!(text, "\n[[episodes]]\nepisode = {index}\n");
        let _ = match demonstration.kind() {
            Kind::Original => writeln!(text, "name = {name}"),
            Kind::Corrective => writeln!(text, "corrections = [{name}]"),
        };
        let _ = writeln!(text, "carried_to_end = {}", demonstration.carried_to_end());
        if demonstration.kind() == Kind::Corrective {
            let named = before.after.as_ref().or(before.interrupted.as_ref());
            let follows = named.map(|named| named.demonstration.as_str());
            let follows = follows.or(timeline.episodes.first().map(|first| &**first.file.demonstration.name()));
            // Of another demonstration than the one that is followed nothing can be said here.
            let index = |of: &Option<crate::demonstration_file::Instance>| {
                let same = of.as_ref().filter(|of| Some(of.demonstration.as_str()) == follows);
                same.map_or("\"none\"".to_owned(), |of| of.segment.to_string())
            };
            let (after, interrupted) = (index(&before.after), index(&before.interrupted));
            let _ = writeln!(text, "follows = {}", quoted(follows.unwrap_or_default()));
            let _ = writeln!(text, "after = {after}\ninterrupted = {interrupted}");
        }
    }
    text
}
