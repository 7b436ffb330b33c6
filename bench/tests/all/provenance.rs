//! Where ledgers are from, by the program itself: the manifest of a run, ledgers that do not mix without being told,
//! and folders that have been overtaken. The hashes are held against those that `sha256sum` prints, where there is one.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::small;
use situ_bench::manifest::{Manifest, Provenance};

/// Runs the program in a folder.
pub(crate) fn program(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).current_dir(folder).output().unwrap()
}

/// What the program prints where it succeeds.
pub(crate) fn printed(folder: &Path, words: &[&str]) -> String {
    let output = program(folder, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The words of an error, with its exit status 2.
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = program(folder, words);
    assert_eq!(output.status.code(), Some(2), "{words:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn manifest(folder: &Path) -> Manifest {
    Manifest::read(&folder.join("manifest.toml")).unwrap().expect("a manifest")
}

/// Changes the provenance that a manifest names.
fn change(folder: &Path, change: impl FnOnce(&mut Provenance)) {
    let mut manifest = manifest(folder);
    change(&mut manifest.provenance);
    fs::write(folder.join("manifest.toml"), manifest.text()).unwrap();
}

/// The lines below the titles of tables in Markdown.
fn headings(markdown: &str) -> Vec<&str> {
    markdown.lines().filter(|line| line.starts_with("Protocol: ")).collect()
}

/// The hash by the system's own command; `None` where it has none.
fn sha256sum(path: &Path) -> Option<String> {
    let output = Command::new("sha256sum").arg(path).output().ok()?;
    Some(String::from_utf8(output.stdout).unwrap().split_whitespace().next()?.to_owned())
}

#[test]
fn a_manifest_says_what_made_the_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let protocol = small::costs(r#"["situ"]"#)
        .replace("tasks = []", "tasks = [\"press\", \"stool\"]")
        .replace("\"novice\"", "\"novice\", \"me\"");
    fs::write(folder.join("small.toml"), protocol).unwrap();
    fs::create_dir(folder.join("mine")).unwrap();
    let press = fs::read_to_string(root.join("tasks/library/press.toml")).unwrap();
    fs::write(folder.join("mine/stool.toml"), press.replace("name = \"press\"", "name = \"stool\"")).unwrap();
    fs::write(folder.join("me.toml"), "[[profile]]\nname = \"me\"\nanalysis = \"One.\"\n").unwrap();
    let words = "run --protocol small.toml --tasks mine --teachers me.toml --out made --task press --variation bump \
                 --method no_update --teacher novice";
    printed(folder, &words.split_whitespace().collect::<Vec<_>>());
    let made = manifest(&folder.join("made"));
    let Provenance { revision, sources, lock, toolchain, benchmark, methods: _ } = &made.provenance;
    assert_eq!((made.schema, made.plant.as_str(), &made.superseded), (2, "arm", &None));
    assert_eq!((made.protocol.first_seed, made.protocol.seeds), (Some(1), Some(1)));
    assert!(toolchain.starts_with("rustc ") && sources.len() == 64, "{made:?}");
    assert_eq!(made.machine.architecture, std::env::consts::ARCH);
    // In a repository the revision is one of its commits.
    if root.join(".git").exists() {
        let commit = revision.split(',').next().unwrap();
        let found = Command::new("git").arg("-C").arg(&root).args(["cat-file", "-t", commit]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&found.stdout).trim(), "commit", "{revision}");
    }
    if sha256sum(&root.join("Cargo.lock")).is_none() {
        eprintln!("there is no sha256sum here: the hashes are not compared");
        return;
    }
    let of = |path: &Path| sha256sum(path).unwrap();
    let teachers = [of(&folder.join("me.toml")), of(&root.join("synth_teachers/src/profiles.toml"))];
    let tasks = [of(&root.join("tasks/library/press.toml")), of(&folder.join("mine/stool.toml"))];
    assert_eq!(made.tasks.values().cloned().collect::<Vec<_>>(), tasks);
    assert_eq!(made.teachers.values().cloned().collect::<Vec<_>>(), teachers);
    assert_eq!(*lock, of(&root.join("Cargo.lock")));
    assert_eq!(made.protocol.hash, of(&folder.join("made/protocol.toml")));
    let version = format!(
        "schema 2\nprotocol {}\ntask press {}\ntask stool {}\nteacher me {}\nteacher novice {}\n",
        made.protocol.hash, tasks[0], tasks[1], teachers[0], teachers[1]
    );
    fs::write(folder.join("version"), version).unwrap();
    assert_eq!(*benchmark, of(&folder.join("version")));
}

/// Shards of one protocol mix. Another benchmark version, another program and a ledger without a manifest do not,
/// unless that is permitted; then every table says so.
#[test]
fn ledgers_of_different_provenance_do_not_mix_without_being_told() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("small.toml"), small::costs(r#"["situ"]"#)).unwrap();
    for (out, seed) in [("one", "1"), ("two", "2")] {
        printed(folder, &["run", "--protocol", "small.toml", "--seed", seed, "--out", out]);
    }
    let both = ["tables", "one/ledger.jsonl", "two/ledger.jsonl", "--table", "t4"];
    let permitted = [&both[..], &["--mixed"]].concat();
    let alone = headings(&printed(folder, &both[..2]))[0].to_owned();
    let words = |text: &str| text.split(" Records: ").next().unwrap().to_owned();
    let text = printed(folder, &both);
    let filled: Vec<&str> = headings(&text).into_iter().filter(|line| line.starts_with("Protocol: `small`")).collect();
    assert!(!filled.is_empty() && filled.iter().all(|line| line.contains(". Revision: `")), "{filled:#?}");
    assert_eq!(words(filled[0]).split_once(". ").unwrap().1, words(&alone).split_once(". ").unwrap().1);

    let two = folder.join("two");
    let whole = fs::read_to_string(two.join("manifest.toml")).unwrap();
    let mixed = |change_it: &dyn Fn(), differing: &[&str], said: &str| {
        change_it();
        let error = refused(folder, &both);
        let named = ["one/ledger.jsonl", "two/ledger.jsonl", "--mixed"];
        assert!(named.iter().chain(differing).all(|word| error.contains(word)), "{differing:?}: {error}");
        let text = printed(folder, &permitted);
        let headings = headings(&text);
        assert!(!headings.is_empty() && headings.iter().all(|line| line.contains(said)), "{said}: {headings:#?}");
        fs::write(two.join("manifest.toml"), &whole).unwrap();
    };
    let another = "0123456789abcdef0123456789abcdef01234567".to_owned();
    let edit = || {
        change(&two, |provenance| {
            (provenance.sources, provenance.revision) = ("77".repeat(32), another.clone());
        });
    };
    mixed(&edit, &["revision ", " and `0123456789ab`"], "Revisions, mixed: `0123456789ab`; `");
    let edit = || change(&two, |provenance| provenance.benchmark = "ab".repeat(32));
    mixed(&edit, &["benchmark version `"], "; of benchmark versions `");
    let remove = || fs::remove_file(two.join("manifest.toml")).unwrap();
    mixed(&remove, &["benchmark version `", " and unknown", "revision "], "; unknown");
}

/// One's own method beside ours: of one benchmark version, whatever the revisions, and the headings say which made
/// which. Runs that both have are no matter where they are the same.
#[test]
fn rows_of_ones_own_stand_beside_ours() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("small.toml"), small::costs(r#"["situ", "rebuild"]"#)).unwrap();
    for (out, methods) in [("ours", &["--method", "situ"][..]), ("mine", &["--method", "rebuild", "--method", "situ"])]
    {
        printed(folder, &[&["run", "--protocol", "small.toml", "--out", out][..], methods].concat());
    }
    let another = "0123456789abcdef0123456789abcdef01234567".to_owned();
    change(&folder.join("mine"), |provenance| {
        (provenance.sources, provenance.revision) = ("77".repeat(32), another);
    });
    let text = printed(folder, &["tables", "ours/ledger.jsonl", "mine/ledger.jsonl", "--table", "t4"]);
    let filled: Vec<&str> = headings(&text).into_iter().filter(|line| line.starts_with("Protocol: `small`")).collect();
    let said = |line: &&str| line.contains("Revisions, side by side: `0123456789ab` for `rebuild`; `");
    assert!(!filled.is_empty() && filled.iter().all(|line| said(line) && line.contains("for `situ`")), "{filled:#?}");
    assert!(text.contains("| rebuild |") && text.contains("| situ |"), "{text}");
}

#[test]
fn a_run_goes_on_with_its_own_ledger_alone() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("small.toml"), small::costs(r#"["situ"]"#)).unwrap();
    let begin = ["run", "--protocol", "small.toml", "--out", "runs"];
    let resume = [&begin[..], &["--resume"]].concat();
    printed(folder, &begin);
    let (runs, first) = (folder.join("runs"), manifest(&folder.join("runs")));
    printed(folder, &resume);
    assert_eq!(manifest(&runs), first);
    change(&runs, |provenance| provenance.sources = "77".repeat(32));
    let error = refused(folder, &resume);
    assert!(error.contains("runs/ledger.jsonl") && error.contains("revision") && error.contains("--mixed"), "{error}");
    let text = printed(folder, &[&resume[..], &["--mixed"]].concat());
    assert!(headings(&text).iter().all(|line| line.contains("Revisions, mixed: ")), "{text}");
    assert_eq!(manifest(&runs).mixed, [first.provenance]);
    // A ledger from before there were manifests.
    fs::remove_file(runs.join("manifest.toml")).unwrap();
    assert!(refused(folder, &resume).contains("unknown"));
    printed(folder, &[&resume[..], &["--mixed"]].concat());
    assert_eq!(manifest(&runs).mixed, [Provenance::unknown()]);
}

/// A mark stands in the manifest and in each table of the folder, and in each table that is made of its ledger: the
/// same bytes. A folder of an older program, whose ledger cannot be read any more, is marked as well.
#[test]
fn a_superseded_folder_says_so_in_every_table() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("small.toml"), small::costs(r#"["situ"]"#)).unwrap();
    printed(folder, &["run", "--protocol", "small.toml", "--out", "small"]);
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let supersede = |why: &str| printed(folder, &["supersede", "small", "--because", why]);
    supersede("For a test.");
    let said = supersede("The budget was another.");
    assert!(said.lines().count() > 1 && said.contains("t4.md"), "{said}");
    let made = printed(folder, &["tables", "small/ledger.jsonl", "--table", "t4"]);
    assert_eq!(made, read("small/t4.md"));
    let marked =
        |text: &str| headings(text).iter().all(|line| line.ends_with(" **Superseded**: The budget was another."));
    assert!(marked(&made) && !made.contains("For a test."), "{made}");

    fs::remove_file(folder.join("small/manifest.toml")).unwrap();
    fs::write(folder.join("small/ledger.jsonl"), read("small/ledger.jsonl").replace("\"schema\":2", "\"schema\":1"))
        .unwrap();
    let marked_file = read("small/t4.md");
    let old = marked_file.lines().map(|line| {
        let line = line.split(" **Superseded**").next().unwrap();
        let revision = line.find(". Revision: ").zip(line.find(". Records: "));
        revision.map_or_else(|| line.to_owned(), |(from, to)| line[..from].to_owned() + &line[to..]) + "\n"
    });
    fs::write(folder.join("small/t4.md"), old.collect::<String>()).unwrap();
    supersede("The budget was another.");
    let text = read("small/t4.md");
    assert!(
        marked(&text) && headings(&text).iter().all(|line| line.contains(". Revision: unknown. Records: ")),
        "{text}"
    );
    let unknown = manifest(&folder.join("small"));
    assert_eq!((unknown.schema, &unknown.provenance), (1, &Provenance::unknown()));
    assert_eq!(unknown.protocol.name, "small");
    for why in ["", "two\nlines"] {
        assert!(refused(folder, &["supersede", "small", "--because", why]).contains("one line"));
    }
}

/// A drawn sample of somebody's results is made anew. One run that was written by hand is found out, and a folder of
/// another benchmark version is refused.
#[test]
fn a_planted_run_is_found_out() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let protocol = small::physics(r#"["no_update", "nearest"]"#).replace("joint = [\"situ\"]\n", "");
    fs::write(folder.join("small.toml"), protocol).unwrap();
    let words = "run --protocol small.toml --plant hand --out made --variation bump --variation cover";
    printed(folder, &words.split_whitespace().collect::<Vec<_>>());
    let check = |seed: &str, sample: &str| {
        let arguments = ["check", "--results", "made", "--sample", sample, "--seed", seed];
        Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder).output().unwrap()
    };
    let said = |output: &std::process::Output| String::from_utf8_lossy(&output.stdout).into_owned();
    let sound = check("1", "2");
    assert!(sound.status.success() && said(&sound).matches("same  ").count() == 2, "{}", said(&sound));
    // One run, whose last rollout succeeded after all.
    let path = folder.join("made/ledger.jsonl");
    let ledger = fs::read_to_string(&path).unwrap();
    let (from, to) = ("\"after\":{\"successes\":0,\"once\":0,", "\"after\":{\"successes\":2,\"once\":2,");
    assert!(ledger.contains(from), "{ledger}");
    fs::write(&path, ledger.replacen(from, to, 1)).unwrap();
    let planted = check("1", "9");
    let text = said(&planted);
    assert!(planted.status.code() == Some(1) && text.matches("other  ").count() == 1, "{text}");
    assert!(text.contains("wrong: ") && text.contains("`after` is {\"once\":2"), "{text}");
    // Another version: the manifest says another task than the one that is known here.
    let manifest = fs::read_to_string(folder.join("made/manifest.toml")).unwrap();
    let other = manifest.replacen("sort_blocks = \"", "sort_blocks = \"00", 1).replacen(
        "benchmark = \"",
        "benchmark = \"00",
        1,
    );
    fs::write(folder.join("made/manifest.toml"), other).unwrap();
    let refused = check("1", "1");
    let text = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && text.contains("differs in the task `sort_blocks`"), "{text}");
}
