//! What the program writes, and where: nothing that is no file is replaced, nothing is lost where the disk is full, and
//! what a stranger's name holds stays on its line.
#![cfg(unix)]

use std::fs::{self, Permissions};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;

use situ_bench::ledger;

use crate::small;

const PROGRAM: &str = env!("CARGO_BIN_EXE_situ-bench");

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/demonstrations/serve-1.json")
}

fn program(arguments: &[&str], folder: &Path) -> Output {
    Command::new(PROGRAM).args(arguments).current_dir(folder).output().unwrap()
}

/// By a shell, for what it alone can set up. `$0` is the program.
fn shell(script: &str, folder: &Path) -> Output {
    Command::new("bash").args(["-c", script, PROGRAM]).current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn learn(out: &str, folder: &Path) -> Output {
    program(&["learn", example().to_str().unwrap(), "--out", out], folder)
}

#[test]
fn only_files_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(learn("model.json", folder.path()).status.success());
    let model = fs::read(at("model.json")).unwrap();
    // A link stays one, and so does what a file permits.
    fs::write(at("real.json"), "store").unwrap();
    symlink("real.json", at("link.json")).unwrap();
    fs::set_permissions(at("real.json"), Permissions::from_mode(0o600)).unwrap();
    assert!(learn("link.json", folder.path()).status.success());
    assert!(fs::symlink_metadata(at("link.json")).unwrap().is_symlink());
    assert_eq!(fs::metadata(at("real.json")).unwrap().permissions().mode() & 0o777, 0o600);
    let without_command = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        text.lines().filter(|line| !line.contains("\"made_by\"")).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(without_command(&fs::read(at("real.json")).unwrap()), without_command(&model));
    // A pipe with a reader is written to, and one without is refused.
    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    let output = learn("pipe", folder.path());
    assert!(output.status.code() == Some(2) && said(&output).contains("a pipe that nobody reads"), "{}", said(&output));
    let pipe = at("pipe");
    let reader = thread::spawn(move || fs::read(pipe).unwrap());
    // Until the reader has opened it, it is refused.
    while !learn("pipe", folder.path()).status.success() {}
    assert_eq!(without_command(&reader.join().unwrap()), without_command(&model));
    assert!(fs::symlink_metadata(at("pipe")).unwrap().file_type().is_fifo());
    // Whoever may make a device has one of one's own here.
    if Command::new("mknod").arg(at("null")).args(["c", "1", "3"]).output().is_ok_and(|made| made.status.success()) {
        assert!(learn("null", folder.path()).status.success());
        assert!(fs::symlink_metadata(at("null")).unwrap().file_type().is_char_device());
    }
    // An input is one however its path is spelt, and a folder is no file.
    fs::copy(example(), at("serve-1.json")).unwrap();
    let before = fs::read(at("serve-1.json")).unwrap();
    symlink("serve-1.json", at("alias.json")).unwrap();
    for out in ["serve-1.json", "./serve-1.json", "../x/serve-1.json", "alias.json", "."] {
        fs::create_dir_all(at("x")).unwrap();
        let out = out.replace("../x", "x/..");
        let output = program(&["learn", "serve-1.json", "--out", &out], folder.path());
        assert_eq!(output.status.code(), Some(2), "{out}: {}", said(&output));
        assert_eq!(fs::read(at("serve-1.json")).unwrap(), before, "{out}");
    }
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().contains(".part")), "{left:?}");
}

#[test]
fn what_a_path_holds_stays_on_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\ninjected [label=x];\n.json";
    fs::copy(example(), folder.path().join(name)).unwrap();
    let output = program(&["learn", name, "--dot", "m.dot", "--out", "m.json"], folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let dot = fs::read_to_string(folder.path().join("m.dot")).unwrap();
    assert!(dot.contains("a\\ninjected") && !dot.lines().any(|line| line.starts_with("injected")), "{dot}");
}

/// A protocol of many short runs; the folder of what it makes when nothing is in the way.
fn whole(folder: &Path) {
    let text = small::costs(r#"["situ", "rebuild"]"#).replace("nodes = [10]\nseeds = 1", "nodes = [10, 12]\nseeds = 4");
    fs::write(folder.join("p.toml"), text).unwrap();
    let output = program(&["run", "--protocol", "p.toml", "--out", "whole"], folder);
    assert!(output.status.success(), "{}", said(&output));
}

fn records(path: &Path) -> String {
    let records = ledger::Canonical::from(ledger::read(path).unwrap().records);
    ledger::text(&records.iter().map(situ_bench::record::Record::without_times).collect::<Vec<_>>())
}

/// A disk that is full at any moment: the error says where, and with room again nothing is lost.
#[test]
fn a_full_disk_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    whole(folder.path());
    let size = fs::metadata(folder.path().join("whole/ledger.jsonl")).unwrap().len();
    let mut full = 0;
    for blocks in 0..=size.div_ceil(1024) {
        // No file may grow beyond so many blocks of 1024 bytes. Without the signal that this sends, a write fails.
        let run = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" run --protocol p.toml --out out --resume");
        let output = shell(&run, folder.path());
        if output.status.success() {
            break;
        }
        full += 1;
        let said = said(&output);
        assert!(
            output.status.code() == Some(1) && said.contains("out/") && said.contains("cannot be written"),
            "{said}"
        );
    }
    assert!(full > 2, "the disk was full {full} times");
    let output = program(&["run", "--protocol", "p.toml", "--out", "out", "--resume"], folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let of = |name: &str| records(&folder.path().join(name).join("ledger.jsonl"));
    assert_eq!(of("out"), of("whole"));
}

/// A folder that nobody may write into, an output nobody takes, and standard error that is full.
#[test]
fn what_cannot_be_written_is_said() {
    let folder = tempfile::tempdir().unwrap();
    whole(folder.path());
    // Not even the superuser makes a folder here.
    let output = program(&["run", "--protocol", "p.toml", "--out", "/proc/self/out"], folder.path());
    assert!(output.status.code() == Some(1) && said(&output).contains("/proc/self/out"), "{}", said(&output));
    let closed = folder.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, Permissions::from_mode(0o500)).unwrap();
    if fs::write(closed.join("probe"), "").is_err() {
        let output = program(&["run", "--protocol", "p.toml", "--out", "closed/out"], folder.path());
        assert!(output.status.code() == Some(1) && said(&output).contains("closed/out"), "{}", said(&output));
    }
    fs::set_permissions(&closed, Permissions::from_mode(0o700)).unwrap();
    let output = shell("exec \"$0\" tables whole/ledger.jsonl --table cost >/dev/full", folder.path());
    assert!(matches!(output.status.code(), Some(1 | 2)), "{output:?}");
    for arguments in ["run --protocol nowhere.toml", "run --protocol p.toml --out again"] {
        let output = shell(&format!("exec \"$0\" {arguments} 2>/dev/full"), folder.path());
        assert!(matches!(output.status.code(), Some(0 | 2)), "{arguments}: {output:?}");
    }
}

/// An interrupt ends the program with 130, however long the piece of work under way would go on.
#[test]
fn an_interrupt_is_heard_in_the_middle_of_anything() {
    let folder = tempfile::tempdir().unwrap();
    let text = small::costs(r#"["rebuild"]"#).replace("nodes = [10]", "nodes = [100000]");
    fs::write(folder.path().join("long.toml"), text).unwrap();
    let mut run = Command::new(PROGRAM)
        .args(["run", "--protocol", "long.toml", "--out", "out"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Its automaton takes far longer than this.
    thread::sleep(std::time::Duration::from_secs(1));
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    assert!(!folder.path().join("out").exists(), "nothing came of it, and nothing stays");
}
