//! Profile files: what comes with the crate, and mistakes with file and line.

use std::path::Path;

use situ_teachers::{Detour, Noise, Pause, Profile, Roster, TeacherError, Way};

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
fn the_profiles_of_the_crate_are_an_expert_a_novice_and_one_for_each_way_of_erring() {
    let roster = Roster::builtin().unwrap();
    assert!(roster.profiles().iter().all(|profile| !profile.analysis.is_empty()));
    let expert = roster.get("expert").unwrap();
    assert_eq!((expert.contact, expert.free), Default::default());
    assert!(Way::ALL.iter().all(|way| expert.rate(*way) == 0.0));
    let novice = roster.get("novice").unwrap();
    assert_eq!(novice.contact, Noise { position: 0.005, rotation: 2.0 });
    assert_eq!(novice.pause, Pause { rate: 0.1, seconds: 1.0 });
    for way in Way::ALL {
        let alone = roster.profiles().iter().find(|profile| {
            profile.rate(way) > 0.0 && Way::ALL.iter().all(|other| *other == way || profile.rate(*other) == 0.0)
        });
        assert!(alone.is_some(), "nobody errs in `{}` alone", way.name());
    }
    let message = roster.get("nobody").unwrap_err().to_string();
    assert!(message.contains("`nobody`") && message.contains("expert, novice, "), "{message}");
}

#[test]
fn a_file_adds_teachers_of_other_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, file("detour = { rate = 0.5, reach = 0.2 }")).unwrap();
    let roster = Roster::builtin().unwrap().with_file(&path).unwrap();
    assert_eq!(roster.get("other").unwrap().detour, Detour { rate: 0.5, reach: 0.2 });
    assert_eq!(roster.profiles().len(), Roster::builtin().unwrap().profiles().len() + 2);
    match roster.with_file(&path) {
        Err(TeacherError::DuplicateProfile { path: named, name }) => assert_eq!((named, &*name), (path, "careful")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_file_is_read_and_what_it_leaves_out_is_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, file("missing = 1.0")).unwrap();
    let roster = Roster::default().with_file(&path).unwrap();
    let profiles = roster.profiles();
    assert_eq!(profiles.len(), 2);
    assert_eq!(roster.text(&profiles[1].name), Some(&*file("missing = 1.0")));
    assert_eq!(profiles[0].contact, Noise { position: 0.001, rotation: 0.0 });
    assert_eq!((profiles[1].missing, profiles[1].spurious), (1.0, 0.0));
    let nowhere = folder.path().join("nowhere.toml");
    match Roster::default().with_file(&nowhere) {
        Err(TeacherError::Read { path: named, .. }) => assert_eq!(named, nowhere),
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
        ("stops_early = nan", 8, "`stops_early` is NaN"),
        ("wrong_reference = 2", 8, "`wrong_reference` is 2"),
        ("detour = { rate = 0.1, reach = 3.0 }", 8, "`detour.reach` is 3, expected 0 to 1 metres"),
        ("misaligned = { rate = -1.0, turn = 15.0 }", 8, "`misaligned.rate` is -1"),
        ("begins_early = 0.6\nbegins_late = 0.5", 8, "1.1 together, expected at most 1"),
        ("pause = { rate = 2.0, seconds = 1.0 }", 8, "`pause.rate` is 2"),
        ("pause = { rate = 0.1, seconds = -1.0 }", 8, "`pause.seconds` is -1"),
        ("contact = { position = -0.01 }", 8, "`contact.position` is -0.01, expected 0 to 1 metres"),
        ("grasp = { position = 0.01, freedom = 2 }", 11, "missing field `rotation`"),
        ("grasp = { position = 0.01, rotation = 9.0, freedom = 0 }", 8, "`grasp.freedom` is 0, expected 1 to 255"),
        ("grasp = { position = 0.01, rotation = 270.0, freedom = 2 }", 8, "`grasp.rotation` is 270, expected 0 to 180"),
        ("half_turn = 1.1", 8, "`half_turn` is 1.1, expected a rate from 0 to 1"),
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
