//! The smallest protocols, for tests that run the program.

/// The update cost of the smallest automaton, no physics; `methods` as TOML has a list. A run takes no time.
pub(crate) fn costs(methods: &str) -> String {
    let series = series(methods);
    format!(
        r#"
name = "small"
analysis = "The update cost of the smallest automaton: a test."
tasks = []
teachers = ["novice"]
methods = ["situ"]
seeds = 1
target = 0.9
rollouts = 1
confidence = 0.3
execution = "sample"

[budget]
least_originals = 3
originals = 3
demonstrations = 1
{series}"#
    )
}

/// One family, one expert, few rollouts: the least that a method is taught and corrected in.
pub(crate) fn physics(methods: &str) -> String {
    format!(
        r#"
name = "small"
analysis = "One family, one expert, few rollouts: a test."
tasks = ["sort_blocks"]
teachers = ["expert"]
methods = {methods}
joint = ["situ"]
seeds = 1
target = 0.5
rollouts = 2
confidence = 0.3
execution = "sample"

[budget]
least_originals = 2
originals = 2
demonstrations = 1
"#
    )
}

/// A series of update cost with one automaton.
pub(crate) fn series(methods: &str) -> String {
    format!("\n[[cost]]\nseries = \"nodes\"\nmethods = {methods}\nnodes = [10]\nseeds = 1\n")
}
