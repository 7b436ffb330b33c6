//! Shards that do not go together are refused with what is wrong, and nothing is written; those that do are merged,
//! however many there are, whatever their folder is called, and as often as one likes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use situ_bench::external::Methods;
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::Identity;
use situ_bench::shard::Shard;
use situ_tasks::Registry;
use situ_teachers::Roster;
use tempfile::TempDir;

use crate::sweep::{done, protocol, refused, same, text};

/// Two shards of a protocol, in a folder with a name that shells stumble over, and the whole.
struct Sweep {
    folder: TempDir,
    protocol: String,
}

impl Sweep {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let protocol = protocol(folder.path());
        let sweep = Self { folder, protocol };
        sweep.run("whole", &[]);
        ["1/2", "2/2"].iter().for_each(|shard| sweep.run("two shards, été", &["--shard", shard]));
        sweep
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, out: &str, more: &[&str]) {
        done(&[&["run", "--protocol", &self.protocol, "--out", text(&self.at(out))], more].concat());
    }

    /// The shards, copied to a new place.
    fn copy(&self, name: &str) -> PathBuf {
        for shard in ["shard-1-of-2", "shard-2-of-2"] {
            let (from, to) = (self.at("two shards, été").join(shard), self.at(name).join(shard));
            fs::create_dir_all(&to).unwrap();
            for file in ["manifest.toml", "protocol.toml", "ledger.jsonl"] {
                fs::copy(from.join(file), to.join(file)).unwrap();
            }
        }
        self.at(name)
    }

    /// Merges these folders, which is refused with these words, and leaves nothing behind.
    fn refused(&self, folders: &[&Path], words: &[&str]) {
        let out = self.at("refused");
        let folders: Vec<&str> = folders.iter().map(|folder| text(folder)).collect();
        let said = refused(&[&["merge"], &folders[..], &["--out", text(&out)]].concat());
        assert!(words.iter().all(|word| said.contains(word)) && !out.exists(), "{words:?}: {said}");
    }
}

fn edit(path: &Path, from: &str, to: &str) {
    let before = fs::read_to_string(path).unwrap();
    let after = before.replacen(from, to, 1);
    assert_ne!(before, after, "{from} stands in {}", path.display());
    fs::write(path, after).unwrap();
}

#[test]
fn what_is_merged_is_merged_again_and_never_replaced() {
    let sweep = Sweep::new();
    let (shards, merged) = (sweep.at("two shards, été"), sweep.at("two shards, été/merged"));
    let merge = ["merge", text(&shards), "--out", text(&merged)];
    assert!(done(&merge).contains("80 records of 2 shards"));
    same(&sweep.at("whole"), &merged);
    let before = fs::read(merged.join("manifest.toml")).unwrap();
    // The folder that it is in holds the shards, too: it used to be taken for one of them.
    done(&merge);
    assert_eq!(fs::read(merged.join("manifest.toml")).unwrap(), before);
    // A merge that was broken off is finished.
    fs::remove_file(merged.join("t4.md")).unwrap();
    done(&merge);
    same(&sweep.at("whole"), &merged);
    // A shard that is named twice is one, and what is merged is a whole.
    let one = shards.join("shard-1-of-2");
    let twice = ["merge", text(&shards), text(&one), "--out", text(&merged)];
    assert!(done(&twice).contains("of 2 shards"));
    done(&["merge", text(&merged), "--out", text(&sweep.at("again"))]);
    same(&sweep.at("whole"), &sweep.at("again"));
    fs::remove_dir_all(&merged).unwrap();
    for out in [shards.join("shard-1-of-2"), sweep.at("whole")] {
        let said = refused(&["merge", text(&shards), "--out", text(&out)]);
        assert!(said.contains("is there already and says something else: give another --out"), "{said}");
    }
    // A table of a stranger used to be replaced where no ledger stood beside it.
    fs::create_dir(sweep.at("mine")).unwrap();
    fs::write(sweep.at("mine/t4.md"), "mine").unwrap();
    refused(&["merge", text(&shards), "--out", text(&sweep.at("mine"))]);
    assert_eq!(fs::read_dir(sweep.at("mine")).unwrap().count(), 1);
}

#[test]
fn more_shards_than_there_is_to_do_make_the_whole() {
    let sweep = Sweep::new();
    (1..=23).for_each(|number| sweep.run("many", &["--shard", &format!("{number}/23")]));
    assert_eq!(fs::read_to_string(sweep.at("many/shard-23-of-23/ledger.jsonl")).unwrap(), "", "it has nothing to do");
    done(&["merge", text(&sweep.at("many")), "--out", text(&sweep.at("merged"))]);
    same(&sweep.at("whole"), &sweep.at("merged"));
    let said = refused(&[
        "run",
        "--protocol",
        &sweep.protocol,
        "--out",
        text(&sweep.at("many")),
        "--shard",
        "1/1",
        "--resume",
    ]);
    assert!(said.contains("/23, and this is 1/1"), "{said}");
}

#[test]
fn shards_that_do_not_go_together_are_refused() {
    let sweep = Sweep::new();
    let of = |shards: &Path, number: u32, file: &str| shards.join(format!("shard-{number}-of-2")).join(file);
    sweep.refused(&[&sweep.at("two shards, été/shard-1-of-2")], &["of 2 shards these are missing: 2"]);
    sweep.refused(&[&sweep.at("two shards, été"), &sweep.at("whole")], &["differ in their number of shards"]);
    sweep.refused(&[&sweep.at("small.toml")], &["small.toml: cannot be read"]);
    sweep.refused(&[&sweep.at("nowhere")], &["nowhere: cannot be read"]);
    fs::create_dir(sweep.at("empty")).unwrap();
    sweep.refused(&[&sweep.at("empty")], &["no ledger.jsonl, expected a shard or a folder of shards"]);

    let revision = sweep.copy("revision");
    edit(&of(&revision, 2, "manifest.toml"), "sources = \"", "sources = \"0");
    sweep.refused(&[&revision], &["shard-2-of-2", "are of different provenance", "--mixed"]);
    let mixed = sweep.at("mixed");
    done(&["merge", text(&revision), "--mixed", "--out", text(&mixed)]);
    assert!(fs::read_to_string(mixed.join("manifest.toml")).unwrap().contains("[[mixed]]"));
    assert!(fs::read_to_string(mixed.join("t4.md")).unwrap().contains("mixed"));

    for (name, from, to, words) in [
        ("seed", "first_seed = 1", "first_seed = 2", "differ in their protocol or its first seed"),
        ("plant", "plant = \"arm\"", "plant = \"hand\"", "differ in their plant"),
        ("key", "plant = ", "planet = ", "manifest.toml:4: "),
    ] {
        let shards = sweep.copy(name);
        edit(&of(&shards, 2, "manifest.toml"), from, to);
        sweep.refused(&[&shards], &[words, "shard-2-of-2"]);
    }
    let edited = sweep.copy("edited");
    edit(&of(&edited, 1, "protocol.toml"), "seeds = 5", "seeds = 4");
    sweep.refused(&[&edited], &["protocol.toml: not what made the ledger: expected the file with the SHA-256"]);
    let bare = sweep.copy("bare");
    fs::remove_file(of(&bare, 2, "manifest.toml")).unwrap();
    sweep.refused(&[&bare], &["shard-2-of-2/manifest.toml: not there"]);
    fs::copy(of(&bare, 1, "ledger.jsonl"), bare.join("ledger.jsonl")).unwrap();
    sweep.refused(&[&bare], &["has a ledger.jsonl, and so has"]);
}

#[test]
fn runs_that_are_missing_or_too_many_are_named_with_their_shard() {
    let sweep = Sweep::new();
    let of = |shards: &Path, number: u32| shards.join(format!("shard-{number}-of-2/ledger.jsonl"));
    let torn = sweep.copy("torn");
    let ledger = fs::read_to_string(of(&torn, 2)).unwrap();
    fs::write(of(&torn, 2), &ledger[..ledger.len() - 9]).unwrap();
    sweep.refused(&[&torn], &["1 of 80 runs are missing, expected all", "(shard 2/2)", "the line is dropped"]);
    fs::write(of(&torn, 2), "").unwrap();
    sweep.refused(&[&torn], &["40 of 80 runs are missing", "\n  and 30 more"]);
    sweep.run("torn", &["--shard", "2/2", "--resume"]);
    done(&["merge", text(&torn), "--out", text(&sweep.at("mended"))]);
    same(&sweep.at("whole"), &sweep.at("mended"));

    // A shard that also did another seed used to bring some of that seed's runs among those of all.
    let more = sweep.copy("more");
    sweep.run("more", &["--shard", "1/2", "--resume", "--seed", "9"]);
    sweep.refused(&[&more], &["runs are none of those that the manifest asks for", "seed 9"]);
}

/// The program, as a task of an array from 1 to 2.
fn in_array(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench"))
        .args(arguments)
        .envs([("SLURM_ARRAY_TASK_ID", "2"), ("SLURM_ARRAY_TASK_COUNT", "2"), ("SLURM_ARRAY_TASK_MIN", "1")])
        .output()
        .expect("the program is built with its tests")
}

#[test]
fn a_task_of_an_array_does_its_part_and_says_so() {
    let sweep = Sweep::new();
    let out = sweep.at("array");
    let run = ["run", "--protocol", &sweep.protocol, "--out", text(&out)];
    let output = in_array(&run);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("a task of a Slurm array: shard 2/2 (--shard 1/1"), "{said}");
    assert!(out.join("shard-2-of-2/ledger.jsonl").exists());
    // What is asked for counts before what the array says.
    assert!(in_array(&[&run[..], &["--shard", "1/2"]].concat()).status.success());
    done(&["merge", text(&out), "--out", text(&sweep.at("merged"))]);
    same(&sweep.at("whole"), &sweep.at("merged"));
    // A part is never what a whole is.
    let output = in_array(&[&run[..], &["--resume", "--check", text(&sweep.at("whole"))]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("shard 2/2 with --check"), "{said}");
    // Costs are compared with a baseline, so all are measured: a task of an array used to measure its part of them.
    let all = sweep.at("cost");
    let costs = ["cost", "--protocol", &sweep.protocol, "--without-instructions", "--out", text(&all)];
    let output = in_array(&costs);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let ledger = fs::read_to_string(all.join("ledger.jsonl")).unwrap();
    assert_eq!(ledger.lines().count(), 80);
}

/// What the page on clusters says of the number of shards: so many as teachers times seeds have each task once.
#[test]
fn as_many_shards_as_teachers_times_seeds_have_each_task_once() {
    let protocol = Protocol::find("paper").unwrap();
    let (registry, roster) = (Registry::builtin().unwrap(), Roster::builtin().unwrap());
    let all = u32::try_from(protocol.teachers.len()).unwrap() * u32::try_from(protocol.seeds).unwrap();
    let places =
        Plan::new(protocol.clone(), &Filter::default(), &registry, &roster, &Methods::builtin()).unwrap().places();
    for number in 1..=all {
        let shard = Shard::new(number, all).unwrap();
        let met: BTreeSet<_> = places.iter().filter(|(_, place)| shard.holds(**place)).collect();
        let runs = met.iter().filter_map(|(run, place)| match run {
            Identity::Run(key) => Some((key.task.clone(), (**place, key.teacher.clone(), key.seed))),
            Identity::Cost { .. } => None,
        });
        let groups: BTreeSet<_> = runs.collect();
        let tasks: Vec<&String> = groups.iter().map(|(task, _)| task).collect();
        assert_eq!(tasks, protocol.tasks.iter().collect::<Vec<_>>(), "shard {shard}");
    }
}
