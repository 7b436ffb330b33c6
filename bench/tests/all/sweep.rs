//! A sweep loses nothing and never lies: over many processes, after a kill, and where two want one folder.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ_bench::ledger::{self, Canonical};
use situ_bench::lock::Lock;
use situ_bench::record::Record;
use situ_bench::tables;

use crate::small;

/// A protocol of many short runs, without physics.
pub(crate) fn protocol(folder: &Path) -> String {
    let text = small::costs(r#"["situ", "rebuild"]"#).replace("nodes = [10]\nseeds = 1", "nodes = [10, 12]\nseeds = 5");
    let path = folder.join("small.toml");
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn program(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench"))
        .args(arguments)
        .env_remove("SLURM_ARRAY_TASK_ID")
        .output()
        .expect("the program is built with its tests")
}

pub(crate) fn done(arguments: &[&str]) -> String {
    let output = program(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

pub(crate) fn refused(arguments: &[&str]) -> String {
    let output = program(arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    said
}

pub(crate) fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The canonical records of a folder, without their times.
pub(crate) fn records(folder: &Path) -> String {
    let records = Canonical::from(ledger::read(&folder.join("ledger.jsonl")).unwrap().records);
    ledger::text(&records.iter().map(Record::without_times).collect::<Vec<_>>())
}

/// Both folders hold the same records and the same tables, all but the times.
pub(crate) fn same(one: &Path, other: &Path) {
    assert_eq!(records(one), records(other));
    for name in tables::ALL.iter().flat_map(|table| table.names()) {
        let read = |folder: &Path| fs::read_to_string(folder.join(&name)).ok();
        match (read(one), read(other)) {
            (Some(own), Some(other)) => assert!(!tables::differs(&name, &own, &other), "{name}"),
            (own, other) => assert_eq!(own, other, "{name}"),
        }
    }
}

#[test]
fn shards_make_what_one_run_makes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let protocol = protocol(folder.path());
    let run = |out: &Path, more: &[&str]| done(&[&["run", "--protocol", &protocol, "--out", text(out)], more].concat());
    run(&at("whole"), &[]);
    for shards in [1, 3, 7] {
        let out = at(&format!("parts-{shards}"));
        (1..shards).for_each(|number| drop(run(&out, &["--shard", &format!("{number}/{shards}")])));
        let merged = at(&format!("merged-{shards}"));
        if shards > 1 {
            let said = refused(&["merge", text(&out), "--out", text(&merged)]);
            assert!(said.contains(&format!("of {shards} shards these are missing: {shards}")), "{said}");
        }
        run(&out, &["--shard", &format!("{shards}/{shards}")]);
        done(&["merge", text(&out), "--out", text(&merged)]);
        same(&at("whole"), &merged);
    }
    // Two shards that hold one run and disagree about it.
    let part = at("parts-3").join("shard-2-of-3/ledger.jsonl");
    let other = fs::read_to_string(at("parts-3").join("shard-1-of-3/ledger.jsonl")).unwrap();
    let line = other.lines().next().unwrap();
    let twice = fs::read_to_string(&part).unwrap() + line + "\n";
    fs::write(&part, &twice).unwrap();
    done(&["merge", text(&at("parts-3")), "--out", text(&at("agrees"))]);
    same(&at("whole"), &at("agrees"));
    fs::write(&part, twice.replace(line, &line.replace("\"hmm_fits\":", "\"hmm_fits\":9"))).unwrap();
    let said = refused(&["merge", text(&at("parts-3")), "--out", text(&at("disagrees"))]);
    assert!(said.contains("are records of the same run") && !at("disagrees").exists(), "{said}");
}

#[test]
fn a_killed_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    let protocol = protocol(folder.path());
    done(&["run", "--protocol", &protocol, "--out", text(&whole)]);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    for _ in 0..50 {
        let mut run = Command::new(env!("CARGO_BIN_EXE_situ-bench"))
            .args(["run", "--protocol", &protocol, "--out", text(&killed), "--resume"])
            .output_to_nowhere()
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(rng.random_range(0..60)));
        run.kill().unwrap();
        run.wait().unwrap();
    }
    done(&["run", "--protocol", &protocol, "--out", text(&killed), "--resume"]);
    same(&whole, &killed);
    assert!(!killed.join(".lock").exists(), "nothing stays behind");
}

/// Output that nobody reads.
trait ToNowhere {
    fn output_to_nowhere(&mut self) -> &mut Self;
}

impl ToNowhere for Command {
    fn output_to_nowhere(&mut self) -> &mut Self {
        self.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null())
    }
}

#[test]
fn of_two_that_want_one_folder_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let protocol = protocol(folder.path());
    fs::create_dir(&out).unwrap();
    let lock = Lock::take(&out).unwrap();
    let run = ["run", "--protocol", &protocol, "--out", text(&out), "--resume"];
    let said = refused(&run);
    assert!(said.contains(&format!("process {}", std::process::id())) && said.contains("--out"), "{said}");
    assert!(!out.join("ledger.jsonl").exists());
    drop(lock);
    done(&run);
}

/// Names, numbers and outputs of strangers: each is refused with its place and what would be right, and nothing stays.
#[test]
fn what_strangers_write_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let physics = small::physics(r#"["situ", "no_update"]"#);
    let cost = small::costs(r#"["situ"]"#);
    let cases = [
        (physics.replace("\"small\"", "\"..\""), "`name`: `..`: expected a name"),
        (physics.replace("\"small\"", "\"a\\nb\""), "`name`: `a\\nb`: expected a name"),
        (physics.replace("rollouts = 2", "rollouts = 4294967295"), "`rollouts`: 4294967295: expected 1 to"),
        (physics.replace("seeds = 1", "seeds = 4000000000"), "`seeds`: 4000000000: expected 1 to"),
        (physics.replace("originals = 2", "originals = 99999999999999999999"), "a number beyond 64 bits"),
        (physics.replace("\"no_update\"]", "\"situ\"]"), "`situ` stands there twice"),
        (physics.replace("[\"expert\"]", "[\"expert\", \"expert\"]"), "`expert` stands there twice"),
        (physics.replace("target = 0.5", "target = nan"), "expected a finite number"),
        (physics.replace("target = 0.5", "target = 1.5"), "`target`: 1.5: expected a rate"),
        (cost.replace("nodes = [10]", "nodes = [4294967295]"), "`cost[0].nodes[0]`: 4294967295: expected 10 to"),
        (cost.replace("nodes = [10]", "nodes = [10]\noriginals = [100000]"), "`cost[0].originals[0]`: 100000"),
        (
            cost.replace("nodes = [10]", "nodes = [10]\ncorrections = 4294967295"),
            "`cost[0].corrections`: 4294967295: expected 1 to",
        ),
        (cost.replace("nodes = [10]", "nodes = [100000]\noriginals = [1000]"), "expected nodes × originals of at most"),
        (cost.replace("nodes = [10]", "nodes = [10, 10]"), "it stands there twice"),
        (cost.replace("\"nodes\"", "\"a\\nb\""), "`cost[0].series`: `a\\nb`: expected a name of"),
        // An integer out of bounds is said before a key that nothing knows.
        (physics.replace("rollouts = 2", "rollouts = 0\nfrom_scratch = 1"), "`rollouts`: 0: expected 1 to"),
    ];
    for (index, (text_of, problem)) in cases.iter().enumerate() {
        let path = at(&format!("p{index}.toml"));
        fs::write(&path, text_of).unwrap();
        let said = refused(&["run", "--protocol", text(&path), "--out", text(&at("out"))]);
        assert!(said.contains(problem) && said.contains(&format!("p{index}.toml:")), "{problem}: {said}");
        assert!(!at("out").exists(), "{problem}");
    }
    // A byte-order mark is no mistake.
    fs::write(at("bom.toml"), format!("\u{feff}{cost}")).unwrap();
    done(&["run", "--protocol", text(&at("bom.toml")), "--out", text(&at("bom"))]);
    let teacher = "[[profile]]\nname = \"../../pwn\"\nanalysis = \"a\"\n";
    fs::write(at("teachers.toml"), teacher).unwrap();
    fs::write(at("p.toml"), &physics).unwrap();
    let said = refused(&[
        "run",
        "--protocol",
        text(&at("p.toml")),
        "--teachers",
        text(&at("teachers.toml")),
        "--teacher",
        "../../pwn",
        "--out",
        text(&at("out")),
    ]);
    assert!(said.contains("expected a name"), "{said}");
    let last = u64::MAX.to_string();
    fs::write(at("two.toml"), physics.replace("seeds = 1", "seeds = 2")).unwrap();
    let said = refused(&["run", "--protocol", text(&at("two.toml")), "--seed", &last, "--out", text(&at("out"))]);
    assert!(said.contains("expected at most") && !at("out").exists(), "{said}");
}

/// A name that the command line gives twice counts once.
#[test]
fn a_method_that_is_named_twice_runs_once() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let protocol = protocol(folder.path());
    done(&["run", "--protocol", &protocol, "--method", "situ", "--method", "situ", "--out", text(&out)]);
    let found = ledger::read(&out.join("ledger.jsonl")).unwrap().records;
    assert_eq!(
        found.len(),
        Canonical::from(found.clone()).iter().map(Record::identity).collect::<std::collections::BTreeSet<_>>().len()
    );
}
