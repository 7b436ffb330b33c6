//! The tests of the harness from outside, in one program, but for the one that counts allocations.

mod broken;
mod changes;
mod check;
mod cost;
mod dependencies;
mod external;
mod house;
mod import;
mod kept;
mod learn;
mod outputs;
mod provenance;
mod published;
mod readme;
mod recorded;
mod roles;
mod run;
mod serve;
mod shards;
mod show;
mod small;
#[allow(dead_code, reason = "the tests of the learner use all of it")]
#[path = "../../../situ/tests/all/common/soak.rs"]
mod soak;
mod strangers;
mod sweep;
mod tutorial;
mod update_cost;
