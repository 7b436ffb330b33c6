//! References by role, from a task file to a corrected robot: a second ball is the same reference, so a robot that was
//! taught with one ball needs an edge, and no primitive for another ball.

use std::path::Path;

use situ::edit::Edit;
use situ_bench::external::Methods;
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::{Outcome, Record};
use situ_tasks::Registry;
use situ_teachers::Roster;

use crate::run::run;
use crate::small;

#[test]
fn a_robot_that_knows_one_ball_needs_an_edge_for_the_second() {
    let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tasks/tests/data");
    let registry = Registry::default().with_dir(&tasks).unwrap();
    let text = small::physics(r#"["situ", "no_update"]"#).replace("sort_blocks", "balls");
    let protocol = Protocol::parse(&text, Path::new("roles.toml")).unwrap();
    let filter = Filter { variations: vec!["second".to_owned()], ..Filter::default() };
    let plan = Plan::new(protocol, &filter, &registry, &Roster::builtin().unwrap(), &Methods::builtin()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let records = run(&plan, &folder.path().join("ledger.jsonl"), 1).unwrap();
    let of = |method: &str| {
        let mut runs = records.iter().filter_map(Record::single_run);
        runs.find(|run| run.key.method == method).unwrap_or_else(|| panic!("no run of {method}"))
    };
    assert_eq!(of("no_update").after.unwrap().successes, 0, "the original model stops after one ball");
    let corrected = of("situ");
    assert_eq!((&corrected.outcome, corrected.corrections.len()), (&Outcome::Reached, 1));
    let after = corrected.after.unwrap();
    assert_eq!(after.successes, after.rollouts, "{after:?}");
    let made = &corrected.corrections[0];
    assert_eq!((made.edit_made, made.nodes_added), (Edit::EdgeAddition, 0), "{made:?}");
}
