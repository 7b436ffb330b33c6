//! The harness of the benchmark of learning from corrective demonstrations, and its program `situ-bench`.
//!
//! The way of the data, once round: a task file becomes a world ([`situ_tasks::Episode`]). A teacher shows the task in
//! it ([`situ_teachers::Teacher`], [`teaching`]). A method makes a task model of what was shown
//! ([`situ::method::Method`]), and [`mod@rollout`] executes the model in a changed world ([`evaluation`]). From the
//! snapshot of a failure the teacher gives a [`mod@correction`]. A [`session`] does that until the model succeeds or
//! the budget is used up, and a [`runner`] does all sessions of a [`plan`]. Each is a [`record`] of the [`ledger`], and
//! the [`tables`] are projections of those. The [`manifest`] beside a ledger says what made it. What updates cost is
//! measured on [`synthetic`] automata ([`cost`]) and held against baselines by the [`gate`].
//!
//! How to add a method, a task, a teacher or a table: [`extending`]; a method in another language: [`methods_page`],
//! [`external`]. A task from nothing, step by step: [`tutorial`]. All keys of a task file: [`task_files`]. The tasks in
//! one's own loop: [`serve_page`], [`serve`]. A task model on a robot of one's own: [`robot`]; its recordings:
//! [`import_page`], [`mod@import`], [`mod@export`].

pub mod archive;
pub mod asked;
pub mod behaviour_tree;
pub mod calibration;
pub mod caption;
pub mod chart;
pub mod cmd;
pub mod conditions;
pub mod content;
pub mod correction;
pub mod correction_record;
pub mod cost;
pub mod demonstration_file;
pub mod diagnosis;
pub mod digest;
pub mod earlier;
pub mod ended;
pub mod error;
pub mod evaluation;
pub mod executor;
#[doc = include_str!("../docs/extending.md")]
#[doc = "```"]
#[doc = include_str!("../examples/method.rs")]
#[doc = "```"]
pub mod extending {}
pub mod export;
pub mod external;
pub mod files;
pub mod gate;
pub mod grade;
pub mod held_out;
pub mod import;
#[doc = include_str!("../docs/import.md")]
pub mod import_page {}
mod json_lines;
pub mod kept_model;
pub mod ledger;
pub mod lesson;
pub mod lock;
pub mod machine;
pub mod manifest;
pub mod memo;
#[doc = include_str!("../docs/methods.md")]
pub mod methods_page {}
pub mod observer;
pub mod own_cost;
pub mod performance;
pub mod pictures;
pub mod plan;
pub mod program;
pub mod protocol;
pub mod provenances;
pub mod record;
pub mod rerun;
pub mod retrieval;
pub mod rollout;
pub mod runner;
#[cfg(test)]
mod sample;
pub mod serve;
#[doc = include_str!("../docs/serve.md")]
pub mod serve_page {}
pub mod session;
pub mod shard;
pub mod shown;
pub mod spending;
pub mod starts;
pub mod stats;
pub mod stop;
pub mod strict_json;
mod stride;
pub mod synthetic;
pub mod tables;
pub mod tally;
pub mod teaching;
#[doc = include_str!("../docs/robot.md")]
pub mod robot {}
#[doc = include_str!("../docs/task-files.md")]
pub mod task_files {}
#[doc = include_str!("../docs/tutorial.md")]
pub mod tutorial {}
pub mod track;
pub mod tuition;
pub mod untouched;
pub mod view;
pub mod visible;
pub mod witness;
