//! Profile files: what comes with the crate, and mistakes with file and line.

use std::path::Path;

use situ_teachers::{Noise, Pause, Profile, TeacherError};

const FILE: &str = "teachers/mine.toml";

/// A file of two profiles, the second in lines 8 to 12.
fn file(second: &str) -> String {
    format!(
        "# Two people. A comment may say [[profile]].\n\n[[profile]]\nname = \"careful\"\nanalysis = \"One.\"\n\
         contact = {{ position = 0.001 }}\n\n[[profile]]\nname = \"other\"\nanalysis = \"Two.\"\n{second}\n"
    )
}

fn refused(text: &str) -> (usize, String) {
    match Profile::parse(text, Path::new(FILE)) {
        Err(error @ TeacherError::File { line, .. }) => {
            let message = error.to_string();
            assert!(message.starts_with(&format!("{FILE}:{line}: ")), "{message}");
            (line, message)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_profiles_of_the_crate_are_read() {
    let profiles = Profile::builtin().unwrap();
    let names: Vec<&str> = profiles.iter().map(|profile| profile.name.as_str()).collect();
    assert_eq!(names, ["expert", "novice"]);
    assert!(profiles.iter().all(|profile| !profile.analysis.is_empty()));
    let expert = &profiles[0];
    assert_eq!((expert.contact, expert.free, expert.pause), Default::default());
    assert_eq!((expert.spurious, expert.missing, expert.stop_early), (0.0, 0.0, 0.0));
    let novice = &profiles[1];
    assert_eq!(novice.contact, Noise { position: 0.005, rotation: 2.0 });
    assert_eq!(novice.pause, Pause { rate: 0.1, seconds: 1.0 });
    assert_eq!(*novice, Profile::named("novice").unwrap());
    let message = Profile::named("nobody").unwrap_err().to_string();
    assert!(message.contains("`nobody`") && message.contains("expert, novice"), "{message}");
}

#[test]
fn a_file_is_read_and_what_it_leaves_out_is_nothing() {
    let folder = std::env::temp_dir().join(format!("situ-teachers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("mine.toml");
    std::fs::write(&path, file("missing = 1.0")).unwrap();
    let profiles = Profile::load(&path).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(profiles.len(), 2);
    assert_eq!(profiles[0].contact, Noise { position: 0.001, rotation: 0.0 });
    assert_eq!((profiles[1].missing, profiles[1].spurious), (1.0, 0.0));
    match Profile::load(&path) {
        Err(TeacherError::Read { path: named, .. }) => assert_eq!(named, path),
        other => panic!("{other:?}"),
    }
}

#[test]
fn mistakes_are_named_with_file_and_line() {
    // A wrong key or type: its own line. A number out of its range: the line of its profile.
    let cases = [
        ("clumsy = 0.1", 11, "clumsy"),
        ("free = { position = 0.01, turn = 2.0 }", 11, "turn"),
        ("spurious = \"often\"", 11, "string"),
        ("missing = 1.5", 8, "`missing` is 1.5, expected a rate from 0 to 1"),
        ("spurious = -0.1", 8, "`spurious` is -0.1"),
        ("stop_early = nan", 8, "`stop_early` is NaN"),
        ("pause = { rate = 2.0, seconds = 1.0 }", 8, "`pause.rate` is 2"),
        ("pause = { rate = 0.1, seconds = -1.0 }", 8, "`pause.seconds` is -1"),
        ("contact = { position = -0.01 }", 8, "`contact.position` is -0.01, expected a finite number, 0 or more"),
        ("free = { rotation = inf }", 8, "`free.rotation` is inf"),
    ];
    for (second, expected, names) in cases {
        let (line, message) = refused(&file(second));
        assert_eq!(line, expected, "{message}");
        assert!(message.contains(names), "{message}");
        assert!(expected != 8 || message.contains("profile `other`"), "{message}");
    }
    let (line, message) = refused(&file("").replace("\"other\"", "\"careful\""));
    assert!(line == 8 && message.contains("`careful` appears twice"), "{message}");
    // The same where the header is written in another way.
    let (line, _) = refused(&file("missing = 1.5").replace("\n[[profile]]", "\n[[ profile ]]"));
    assert_eq!(line, 8);
    let (line, message) = refused("[[profile]]\nname = \"x\"\n");
    assert!(line == 1 && message.contains("analysis"), "{line}: {message}");
    let (line, _) = refused("[[profile]]\nname = \"x\n");
    assert_eq!(line, 2);
}
