//! Graded changes: one change in growing sizes, or one world shown by teachers who err more and more. Where does a
//! method begin to see a modification, and where does it see one that is not there?

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use situ_tasks::Setting;
use situ_tasks::key::{Document, KeyPath};

use crate::error::BenchError;

/// A series of sizes of one thing. Where a protocol has any, it runs what they name and nothing else.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradeSeries {
    /// What grows, with its unit.
    pub series: String,
    /// Whether the world changes with it. If it does not, no modification is right.
    pub changes: bool,
    /// Who shows those of the points that name no teacher.
    #[serde(default)]
    pub teachers: Vec<String>,
    /// The sizes.
    pub point: Vec<GradePoint>,
}

/// One size of a series.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradePoint {
    /// The size.
    pub size: f64,
    /// The variation that is of this size.
    pub variation: String,
    /// The teacher who is, where the series is one of teachers.
    pub teacher: Option<String>,
}

/// The place of a run in a series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grade {
    /// The series.
    pub series: String,
    /// The size.
    pub size: f64,
    /// Whether the world changes with it.
    pub changes: bool,
}

impl GradeSeries {
    /// Who shows a point.
    fn teachers<'a>(&'a self, point: &'a GradePoint) -> impl Iterator<Item = &'a String> {
        let own = point.teacher.iter();
        own.chain(self.teachers.iter().filter(|_| point.teacher.is_none()))
    }

    /// The place in it of what this teacher shows of this variation.
    fn grade(&self, variation: &str, teacher: &str) -> Option<Grade> {
        let is_it =
            |point: &&GradePoint| point.variation == variation && self.teachers(point).any(|name| name == teacher);
        let point = self.point.iter().find(is_it)?;
        Some(Grade { series: self.series.clone(), size: point.size, changes: self.changes })
    }
}

/// The place of a run among the series; `None` where it is in none.
pub fn grade(series: &[GradeSeries], setting: &Setting, teacher: &str) -> Option<Grade> {
    let variation = setting.variation.as_deref()?;
    series.iter().find_map(|series| series.grade(variation, teacher))
}

/// Checks what no key can say for itself. Every teacher of a series must be one of the protocol's.
///
/// # Errors
/// With file, line, key and what was expected.
pub(crate) fn check(all: &[GradeSeries], teachers: &[String], document: &Document<'_>) -> Result<(), BenchError> {
    let refuse = |key: KeyPath, expected: String| Err(BenchError::from(document.error(&key, expected)));
    let mut met = BTreeSet::new();
    for (index, series) in all.iter().enumerate() {
        let at = KeyPath::default().field("grade").index(index);
        if all[..index].iter().any(|other| other.series == series.series) {
            return refuse(at.field("series"), "expected a name that no other series has".to_owned());
        }
        for (place, point) in series.point.iter().enumerate() {
            let at = at.field("point").index(place);
            if !(point.size.is_finite() && point.size >= 0.0) {
                return refuse(at.field("size"), format!("{}: expected a size of 0 or more", point.size));
            }
            if series.teachers(point).next().is_none() {
                return refuse(at, "expected `teacher`, or `teachers` for all points of the series".to_owned());
            }
            for teacher in series.teachers(point) {
                if !teachers.contains(teacher) {
                    return refuse(at, format!("`{teacher}`: expected one of the protocol's `teachers`"));
                }
                if !met.insert((&point.variation, teacher)) {
                    let what = format!("`{}` shown by `{teacher}` has a place already", point.variation);
                    return refuse(at, format!("{what}; expected each once"));
                }
            }
        }
    }
    Ok(())
}
