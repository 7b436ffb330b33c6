//! What this program was built of. What cannot be known is [`UNKNOWN`].

use std::path::Path;

pub(crate) mod checkout;

/// What is said of something that cannot be known.
pub const UNKNOWN: &str = "unknown";
/// The SHA-256 of all files that the program was built of, `Cargo.lock` among them, in hexadecimal digits. Where two
/// programs have the same, they are of the same code, whether it was committed or not.
pub const SOURCES: &str = env!("SITU_SOURCES");
/// The SHA-256 of `Cargo.lock`, in hexadecimal digits.
pub const LOCK: &str = env!("SITU_LOCK");
/// The compiler, in its own words.
pub const TOOLCHAIN: &str = env!("SITU_TOOLCHAIN");
/// The target triple.
pub const TARGET: &str = env!("SITU_TARGET");

/// The last commit that changed the program's sources, followed by `, changed` where the files were not those of the
/// commit; `unknown` outside a repository. Commits of results, tests and prose make no other program.
///
/// A commit is no reason to build the program again. So the workspace is asked once more: while it holds the files that
/// the program was built of, its revision is the program's. Where they have changed, or are not on this machine, what
/// counts is the revision when the program was built.
pub fn revision() -> String {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let is_built_of = checkout::sources(root).is_some_and(|sources| sources == SOURCES);
    let now = if is_built_of { checkout::revision(root) } else { None };
    now.unwrap_or_else(|| env!("SITU_REVISION").to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::process::Command;

    use super::*;

    #[test]
    fn every_file_of_the_program_counts_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        assert_eq!(checkout::sources(root), None, "no file");
        let write = |name: &str, text: &str| {
            fs::create_dir_all(root.join(name).parent().unwrap()).unwrap();
            fs::write(root.join(name), text).unwrap();
            checkout::sources(root).expect("some files")
        };
        let first = write("situ/src/deep/a.rs", "a");
        for (name, text) in [("situ/src/deep/a.rs", "b"), ("situ/src/deep/b.rs", ""), ("Cargo.lock", "")] {
            assert_ne!(write(name, text), first, "{name}");
        }
        let all = checkout::sources(root).unwrap();
        for name in ["results/quick/t1.md", "README.md", "bench/tests/all/a.rs", "situ/src/.a.rs.swp"] {
            assert_eq!(write(name, "a"), all, "{name}");
        }
    }

    /// A revision is the last commit that changed the program. An archive has none, wherever it is unpacked.
    #[test]
    fn a_revision_is_the_last_commit_of_the_program() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let git = |words: &[&str]| {
            let identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"];
            let output = Command::new("git").arg("-C").arg(root).args(identity).args(words).output();
            output.map(|output| String::from_utf8(output.stdout).unwrap().trim().to_owned())
        };
        if git(&["init", "--quiet"]).is_err() {
            eprintln!("there is no git here: nothing is tested");
            return;
        }
        let commit = |name: &str, text: &str| {
            fs::create_dir_all(root.join(name).parent().unwrap()).unwrap();
            fs::write(root.join(name), text).unwrap();
            git(&["add", "--all"]).unwrap();
            git(&["commit", "--quiet", "--message", name]).unwrap();
            git(&["rev-parse", "HEAD"]).unwrap()
        };
        assert_eq!(checkout::revision(root), None, "no commit");
        let first = commit("tasks/src/a.rs", "1");
        assert_eq!(checkout::revision(root).as_ref(), Some(&first));
        let second = commit("results/t1.md", "1");
        assert!(first != second && checkout::revision(root).as_ref() == Some(&first), "results are no program");
        fs::write(root.join("results/t1.md"), "2").unwrap();
        assert_eq!(checkout::revision(root).as_ref(), Some(&first), "nor are changed ones");
        fs::write(root.join("tasks/src/b.rs"), "").unwrap();
        assert_eq!(checkout::revision(root), Some(format!("{first}, changed")), "a file that no commit has");
        let third = commit("tasks/src/a.rs", "2");
        assert_eq!(checkout::revision(root), Some(third));
        assert_eq!(checkout::revision(&root.join("tasks")), None, "an archive inside another repository");
    }
}
