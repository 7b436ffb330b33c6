//! The pieces in the tutorial's text are its files, and what the text says of them is true.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn situ_bench(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder).output().unwrap()
}

#[test]
fn the_pieces_of_the_text_are_the_file() {
    let text = std::fs::read_to_string(root().join("bench/docs/tutorial.md")).unwrap();
    let pieces = text.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let file = std::fs::read_to_string(root().join("bench/examples/tutorial/tasks/tidy.toml")).unwrap();
    assert_eq!(pieces.collect::<Vec<_>>().join("\n"), file);
}

#[test]
fn the_commands_of_the_text_do_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(root().join("bench/docs/tutorial.md")).unwrap();
    let commands = text.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    for command in commands.lines() {
        let mut words: Vec<&str> = command.split_whitespace().skip(1).collect();
        let out = folder.path().join(words[0]);
        if words[0] == "check" {
            words.extend(["--seeds", "4"]);
        }
        words.extend(["--out", out.to_str().unwrap()]);
        if words[0] == "show" {
            words.extend(["--width", "32", "--height", "20"]);
        }
        let output = situ_bench(&words, &root());
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{command}: {said}{}", String::from_utf8_lossy(&output.stderr));
        match words[0] {
            "check" => assert!(said.contains("16/16") && !said.contains("wrong"), "{said}"),
            "show" => assert!(said.contains("the goal holds: yes") && said.contains("the goal holds: no"), "{said}"),
            _ => {
                assert!(said.starts_with("small: ") && said.lines().any(|line| line.starts_with("situ ")), "{said}");
                assert!(said.lines().count() <= 10 && said.lines().all(|line| line.chars().count() <= 100), "{said}");
            }
        }
    }
}
