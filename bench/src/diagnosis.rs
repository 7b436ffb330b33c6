//! What the originals of a task model say about the teacher and about the model, for people who look at demonstrations
//! of their own: whether there are enough of them, whether they are alike, and what stands out.

use std::collections::BTreeSet;
use std::fmt::Write;

use nalgebra::Vector3;
use situ::error::SituError;
use situ::graph::{Graph, GraphNode};
use situ::keyframe::scatter::Deviation;
use situ::method::{Calibrated, Learned, Method};
use situ::place::{NodeId, Place, SegmentId};
use situ::segment::Segment;
use situ::segmentation::by_reference_object;
use situ::state::State;

use crate::demonstration_file::DemonstrationFile;
use crate::tally::count;

/// A keyframe is alone where it is so many times the teacher's scatter away from those of all other segments.
const ALONE: f64 = 4.0;
/// The scatter where none is known, metres: that of decision D12.
const SCATTER: f64 = 0.02;
/// The most originals that are left out one by one.
const MOST_LEFT_OUT: usize = 20;

/// How often the next primitive is the one of a demonstration that the model has not seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// The choices that could be right.
    pub choices: u32,
    /// Those that were.
    pub right: u32,
    /// The choices of a primitive that only the demonstration itself shows.
    pub alone: u32,
}

/// What the originals say.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    calibrated: Option<Calibrated>,
    originals: usize,
    /// Primitives of one segment, each with its object.
    of_one: Vec<(NodeId, String)>,
    nodes: usize,
    /// `None` with a single original.
    left_out: Option<LeftOut>,
    /// Keyframes that are alone: the demonstration, the index of the keyframe, and the metres to the nearest.
    alone: Vec<(String, usize, f64)>,
}

/// Originals, and what was learned of them.
struct Seen<'a> {
    files: &'a [DemonstrationFile],
    graph: &'a Graph,
    segments: Vec<Vec<Segment>>,
}

impl Seen<'_> {
    /// The node that holds a segment of an original.
    fn node(&self, demonstration: usize, index: usize) -> Option<&GraphNode> {
        let id = SegmentId { demonstration: count(demonstration), index: count(index) };
        self.graph.nodes.iter().find(|node| node.segments.contains(&id))
    }

    /// The keyframes that are farther than `limit` metres, in the frame of the object, from every keyframe of the other
    /// segments of their primitive.
    fn alone(&self, limit: f64) -> Vec<(String, usize, f64)> {
        let mut found = Vec::new();
        for (demonstration, segments) in self.segments.iter().enumerate() {
            let mut before = 0;
            for (index, segment) in segments.iter().enumerate() {
                let others = self.node(demonstration, index).map(|node| self.others(node, demonstration));
                let others = others.unwrap_or_default();
                for (keyframe, shown) in segment.keyframes.iter().enumerate() {
                    let place = shown.pose.translation.vector;
                    let nearest = others.iter().map(|other| (other - place).norm()).reduce(f64::min);
                    if let Some(metres) = nearest.filter(|metres| *metres > limit) {
                        let name = self.files[demonstration].demonstration.name().to_string();
                        found.push((name, before + keyframe, metres));
                    }
                }
                before += segment.keyframes.len();
            }
        }
        found
    }

    /// Where the keyframes of a primitive are in the other originals.
    fn others(&self, node: &GraphNode, demonstration: usize) -> Vec<Vector3<f64>> {
        let others = node.segments.iter().filter(|id| id.demonstration as usize != demonstration);
        let segments = others.filter_map(|id| self.segments.get(id.demonstration as usize)?.get(id.index as usize));
        segments.flat_map(|segment| segment.keyframes.iter().map(|keyframe| keyframe.pose.translation.vector)).collect()
    }

    /// The choices of one original by a model of the others.
    fn choices(&self, demonstration: usize, learned: &dyn Learned) -> Result<LeftOut, SituError> {
        let graph = learned.graph()?;
        // A segment's number among the others.
        let among = |id: &SegmentId| match (id.demonstration as usize).cmp(&demonstration) {
            std::cmp::Ordering::Less => Some(*id),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(SegmentId { demonstration: id.demonstration - 1, index: id.index }),
        };
        let same = |index: usize| -> BTreeSet<SegmentId> {
            self.node(demonstration, index)
                .into_iter()
                .flat_map(|node| node.segments.iter().filter_map(among))
                .collect()
        };
        let holder = |held: &BTreeSet<SegmentId>| {
            let node = graph.nodes.iter().find(|node| node.segments.iter().any(|id| held.contains(id)));
            node.map(|node| Place::Node(node.id))
        };
        let chosen =
            |last: Place, state: &State| Ok::<_, SituError>(learned.next(last, state)?.map(|(place, _)| place));
        let (mut counted, mut last) = (LeftOut::default(), Some(Place::Start));
        for (index, segment) in self.segments[demonstration].iter().enumerate() {
            let expected = holder(&same(index));
            match (last, expected) {
                (Some(before), Some(expected)) => {
                    counted.choices += 1;
                    counted.right += u32::from(chosen(before, &segment.start)? == Some(expected));
                }
                (_, None) => counted.alone += 1,
                (None, _) => {}
            }
            last = expected;
        }
        let shown = &self.files[demonstration].demonstration;
        if let Some(last) = last.filter(|_| shown.carried_to_end()) {
            counted.choices += 1;
            counted.right += u32::from(chosen(last, shown.final_state())? == Some(Place::End));
        }
        Ok(counted)
    }
}

impl Diagnosis {
    /// What these originals say about a model that was learned of them, before any correction. For each original a
    /// model is learned of the others.
    ///
    /// # Errors
    /// Where the method refuses the others of an original.
    pub fn of(
        method: &dyn Method,
        files: &[DemonstrationFile],
        learned: &dyn Learned,
        seed: u64,
    ) -> Result<Self, SituError> {
        let graph = learned.graph()?;
        let segments = files.iter().map(|file| by_reference_object(&file.demonstration)).collect();
        let seen = Seen { files, graph: &graph, segments };
        let calibrated = learned.calibrated();
        let scatter = calibrated.map_or(SCATTER, |calibrated| {
            let scatter = calibrated.calibration.scatter;
            scatter.free.position.max(scatter.contact.position)
        });
        let mut left_out = (files.len() > 1).then(LeftOut::default);
        for index in 0..files.len().min(MOST_LEFT_OUT) {
            let Some(all) = &mut left_out else { break };
            let others = files.iter().enumerate().filter(|(other, _)| *other != index);
            let others: Vec<_> = others.map(|(_, file)| file.demonstration.clone()).collect();
            let one = seen.choices(index, &*method.teach(&files[index].schema, &others, seed)?)?;
            all.choices += one.choices;
            all.right += one.right;
            all.alone += one.alone;
        }
        let of_one = graph.nodes.iter().filter(|node| node.segments.len() == 1);
        Ok(Self {
            calibrated,
            originals: files.len(),
            of_one: of_one.map(|node| (node.id, node.reference.to_string())).collect(),
            nodes: graph.nodes.len(),
            left_out,
            alone: seen.alone(ALONE * scatter),
        })
    }

    /// The choices of originals that were left out; `None` with a single one.
    pub fn left_out(&self) -> Option<LeftOut> {
        self.left_out
    }

    /// In words, a line each.
    pub fn text(&self) -> String {
        let mut text = String::from("what the originals say\n");
        if let Some(Calibrated { calibration, bounds, is_of_one }) = &self.calibrated {
            let [least, greatest] = bounds;
            let cut = calibration.cut;
            let of = match () {
                () if *is_of_one => "as always with one original: nothing was measured".to_owned(),
                () if cut <= *least => {
                    format!("at its least of {least}: the originals are more alike than is believed")
                }
                () if cut >= *greatest => {
                    format!("at its greatest of {greatest}: the originals differ so much that unlike segments may join")
                }
                () => format!("between its bounds of {least} and {greatest}"),
            };
            let _ = writeln!(text, "  the cut of the clustering: {cut:.2} nats a frame,\n    {of}");
            let scatter = &calibration.scatter;
            let clamp = if scatter.is_clamped { "; beyond what is believed of a teacher, so held to that" } else { "" };
            let _ = writeln!(
                text,
                "  the teacher's scatter: {} where the hand closes or opens,\n    {} elsewhere{clamp};\n    a prior of 2.0 cm and 9° counts as much as three pairs of keyframes",
                deviation(&scatter.contact),
                deviation(&scatter.free),
            );
        }
        match &self.left_out {
            None => text.push_str("  one original: show the task once more, so that it can be said what varies\n"),
            Some(LeftOut { choices, right, alone }) => {
                let _ = writeln!(
                    text,
                    "  the next primitive of an original that was left out: right in {right} of {choices} choices;\n    \
                     {alone} more are of primitives that no other original shows"
                );
            }
        }
        if self.originals > 1 {
            let named: Vec<String> = self.of_one.iter().map(|(id, object)| format!("{id} on {object}")).collect();
            let named = if named.is_empty() { String::new() } else { format!(": {}", named.join(", ")) };
            let _ = writeln!(text, "  primitives of one segment: {} of {}{named}", self.of_one.len(), self.nodes);
            let _ = writeln!(text, "  keyframes that are alone: {}", self.alone.len());
            for (name, keyframe, metres) in &self.alone {
                let _ =
                    writeln!(text, "    {name}, keyframes[{keyframe}]: {metres:.3} m from the nearest of the others");
            }
        }
        text
    }
}

fn deviation(deviation: &Deviation) -> String {
    let [x, y, z] = deviation.rotation.map(f64::to_degrees);
    format!("{:.1} cm and {x:.0}°, {y:.0}°, {z:.0}°", 100.0 * deviation.position)
}
