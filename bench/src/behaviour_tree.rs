//! A task model as a behaviour tree, in the XML of BehaviorTree.CPP 4, so that an engine of behaviour trees executes
//! what was learned and an editor of them shows it.
//!
//! The tree is the automaton. The blackboard holds the `place` that ran last. In a loop `ChooseNext` chooses among the
//! places that may follow it, and `ExecutePrimitive` does what was chosen; the loop ends at END. Both leaves are the
//! robot's own: what they need to know is what `situ-bench ask` answers ([`crate::asked`]). Where a primitive fails,
//! the choice is made again from the place before, at most [`ATTEMPTS`] times.

use std::collections::BTreeMap;
use std::fmt::Write;

use situ::graph::Graph;
use situ::place::Place;
use situ_tasks::name::one_line;

/// How often a step is tried before the tree fails.
pub const ATTEMPTS: u32 = 3;

/// What the robot has to bring, as editors of trees want it.
const LEAVES: &str = r#"  <TreeNodesModel>
    <Action ID="ChooseNext">
      <input_port name="after">the place that ran last</input_port>
      <input_port name="among">the places that may follow it, separated by semicolons</input_port>
      <output_port name="next">the likeliest of them in the state of the world</output_port>
    </Action>
    <Action ID="ExecutePrimitive">
      <input_port name="place">the primitive</input_port>
      <input_port name="reference">the object that it is about</input_port>
      <input_port name="ways">how many ways of doing it are known</input_port>
    </Action>
  </TreeNodesModel>
</root>
"#;

/// The XML of a model's automaton. `about` stands in a comment: what made it.
pub fn to_xml(graph: &Graph, about: &str) -> String {
    let mut children: BTreeMap<Place, Vec<String>> = BTreeMap::new();
    for (from, to) in &graph.edges {
        children.entry(*from).or_default().push(to.to_string());
    }
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut line = |depth: usize, text: &str| {
        let _ = writeln!(xml, "{}{text}", "  ".repeat(depth));
    };
    // Two hyphens would end a comment.
    line(0, &format!("<!-- {} -->", escaped(about).replace("--", "- -")));
    line(0, "<root BTCPP_format=\"4\" main_tree_to_execute=\"Task\">");
    line(1, "<BehaviorTree ID=\"Task\">");
    line(2, "<Sequence>");
    line(3, "<Script code=\"place := 'START'\"/>");
    line(3, "<ForceSuccess>");
    line(4, "<KeepRunningUntilFailure>");
    line(5, "<Sequence>");
    line(6, &format!("<RetryUntilSuccessful num_attempts=\"{ATTEMPTS}\">"));
    line(7, "<Sequence>");
    line(8, "<Fallback name=\"choose\">");
    for (from, among) in &children {
        line(9, &format!("<Sequence name=\"after {from}\">"));
        line(10, &format!("<ScriptCondition code=\"place == '{from}'\"/>"));
        line(10, &format!("<ChooseNext after=\"{from}\" among=\"{}\" next=\"{{next}}\"/>", among.join(";")));
        line(9, "</Sequence>");
    }
    line(8, "</Fallback>");
    line(8, "<Fallback name=\"do\">");
    line(9, "<ScriptCondition code=\"next == 'END'\"/>");
    for node in &graph.nodes {
        let (id, reference) = (node.id, escaped(&node.reference));
        line(9, &format!("<Sequence name=\"{id} on {reference}\">"));
        line(10, &format!("<ScriptCondition code=\"next == '{id}'\"/>"));
        let ways = node.paths.len();
        line(10, &format!("<ExecutePrimitive place=\"{id}\" reference=\"{reference}\" ways=\"{ways}\"/>"));
        line(9, "</Sequence>");
    }
    line(8, "</Fallback>");
    line(8, "<Script code=\"place := next\"/>");
    line(7, "</Sequence>");
    line(6, "</RetryUntilSuccessful>");
    line(6, "<ScriptCondition code=\"place != 'END'\"/>");
    line(5, "</Sequence>");
    line(4, "</KeepRunningUntilFailure>");
    line(3, "</ForceSuccess>");
    line(3, "<ScriptCondition code=\"place == 'END'\"/>");
    line(2, "</Sequence>");
    line(1, "</BehaviorTree>");
    xml + LEAVES
}

/// A text in XML, on one line.
fn escaped(text: &str) -> String {
    let text = one_line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&apos;")
}
