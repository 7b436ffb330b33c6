//! `check` finds mistakes of a task. It names one in the file by file, line and key, and a false claim by setting and
//! seed.

use std::path::Path;
use std::process::{Command, Output};

/// The tutorial's task: sound, small, and with a variation of each kind but one.
const TIDY: &str = include_str!("../../examples/tutorial/tasks/tidy.toml");

fn check(folder: &Path, seeds: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_situ-bench"));
    command.args(["check", "--tasks"]).arg(folder).args(["--seeds", seeds]).args(arguments).output().unwrap()
}

/// The exit status and the output of `check` from two seeds for the tutorial's task with one piece replaced.
fn checked(from: &str, to: &str, arguments: &[&str]) -> (Option<i32>, String) {
    checked_from("2", from, to, arguments)
}

/// The same from so many seeds.
fn checked_from(seeds: &str, from: &str, to: &str, arguments: &[&str]) -> (Option<i32>, String) {
    assert!(TIDY.contains(from), "the file has no `{from}`");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tidy.toml"), TIDY.replacen(from, to, 1)).unwrap();
    let output = check(folder.path(), seeds, arguments);
    let said = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    (output.status.code(), said)
}

#[test]
fn a_claim_that_is_not_true_is_told_with_setting_and_seed() {
    let (status, said) = checked("by = [0.0, 0.10, 0.0]", "by = [0.0, 0.001, 0.0]", &["tidy"]);
    assert_eq!(status, Some(1), "{said}");
    let wrong: Vec<&str> = said.lines().filter(|line| line.starts_with("wrong: ")).collect();
    assert!(wrong.iter().all(|line| line.contains("tidy/bump: ")) && !wrong.is_empty(), "{said}");
    assert!(
        wrong[0].contains("original script fails") && wrong[0].contains("0 of 2") && wrong[0].contains("seed 0"),
        "{said}"
    );

    // The hand closes above the carton: nobody can do that.
    let (status, said) = checked("at = [0.0, 0.0, 0.03], close", "at = [0.0, 0.0, 0.13], close", &["tidy/far"]);
    assert!(status == Some(1) && said.contains("wrong: tidy/far: the competent script succeeds in 0 of 2"), "{said}");

    let (status, said) = checked("time_limit = 40.0", "time_limit = 8.0", &["tidy"]);
    assert!(status == Some(1) && said.contains("within 0.7 of the time limit"), "{said}");

    let premise = "premise = \"all(upright(carton), not(held(carton)))\"";
    let (status, said) = checked(premise, "premise = \"held(carton)\"", &["tidy"]);
    assert!(status == Some(1) && said.contains("wrong: tidy, seed 0: ") && said.contains("held(carton)"), "{said}");

    let goal = "goal = \"all(at(carton, coaster, 0.03), upright(carton))\"";
    let (status, said) = checked(goal, "goal = \"upright(carton)\"", &["tidy"]);
    assert!(status == Some(1) && said.contains("the goal holds at the start"), "{said}");
}

#[test]
fn a_sound_task_has_nothing_wrong() {
    let (status, said) = checked("name = \"tidy\"", "name = \"tidier\"", &["tidier/bump", "tidier"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("10/10 [") && !said.contains("wrong"), "five settings, two seeds: {said}");
    let (status, said) = checked("name = \"tidy\"", "name = \"tidier\"", &["tidier/bumps"]);
    assert!(status == Some(2) && said.contains("`bumps`") && said.contains("occupied, bump, far"), "{said}");
}

/// Six seeds are the fewest by which the sign-flip test can say anything.
#[test]
fn a_control_must_hold_for_what_was_learned() {
    let start = "start = { x = [0.22, 0.30], y = [-0.05, 0.05] }";
    let arguments = ["tidy/far", "--teacher", "expert"];
    let (status, said) = checked_from("6", start, start, &arguments);
    assert!(status == Some(0) && said.contains("6/6 [") && said.contains("| tidy/far  |      6 |"), "{said}");
    assert!(said.contains("0.000 [0.000, 0.000]") && !said.contains("Corrections"), "{said}");

    let bump = "[[variation.event]]\nname = \"bump\"\nafter = { reference = \"carton\", keyframe = 0 }\npush = \"carton\"\n\
                by = [0.0, 0.10, 0.0]\nseconds = 0.5";
    let (status, said) = checked_from("6", start, &format!("{start}\n\n{bump}"), &arguments);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("wrong: tidy/far: needs no edit, and a learned model succeeds less often"), "{said}");
    assert!(said.contains("p = 0.031"), "2 of the 64 vectors of signs are as far off: {said}");
}

#[test]
fn a_teacher_who_cannot_show_a_task_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("teachers.toml");
    let wild =
        "[[profile]]\nname = \"wild\"\nanalysis = \"Reaches far beside everything.\"\ncontact = { position = 0.5 }\n";
    std::fs::write(&file, wild).unwrap();
    let arguments = ["tidy/bump", "--teachers", file.to_str().unwrap(), "--teacher", "wild"];
    let (status, said) = checked(
        "name = \"tidy\"",
        "name = \"tidier\"",
        &["tidier/bump"].iter().chain(&arguments[1..]).copied().collect::<Vec<_>>(),
    );
    assert_eq!(status, Some(1), "{said}");
    for what in ["a whole demonstration", "a correction"] {
        assert!(said.contains(&format!("wrong: tidier/bump: the teacher gives up {what} in 2 of 2 starts")), "{said}");
    }
    let (status, said) = checked("name = \"tidy\"", "name = \"tidier\"", &["--teacher", "wilder"]);
    assert!(status == Some(2) && said.contains("`wilder`") && said.contains("expert, novice, person"), "{said}");
}

#[test]
fn a_change_that_no_feature_shows_is_not_shown() {
    let row = |said: &str, of: &str| said.lines().find(|line| line.contains(of)).unwrap_or_default().to_owned();
    let (status, said) = checked_from("12", "name = \"tidy\"", "name = \"tidier\"", &["tidier", "--visible"]);
    assert_eq!(status, Some(0), "{said}");
    let (added, retried) = (row(&said, "tidier/occupied"), row(&said, "tidier/bump"));
    assert!(added.contains("after `start`: `take_away`, not `pick`") && added.contains("`seen(cube)`"), "{said}");
    assert!(retried.contains("after `pick`: `pick`, not `place`") && retried.contains("|     12 | 1.000 |"), "{said}");
    assert!([added, retried].iter().all(|row| row.ends_with("yes |")), "{said}");
    assert!(said.contains("2 of 2 variations") && !said.contains("tidier/far"), "{said}");

    let cube = "    \"seen(cube)\",\n    \"offset(cube, coaster)\",\n    \"offset(gripper, cube)\",\n";
    let (status, said) = checked_from("12", cube, "", &["tidy/occupied", "--visible"]);
    assert!(status == Some(0) && row(&said, "tidy/occupied").ends_with(" no |"), "{said}");
}

/// A mistake in a task file: the text that is replaced, the text in its place, a piece of the line that must be named,
/// the key, and what was expected.
type Mistake = (&'static str, &'static str, &'static str, &'static str, &'static str);

const MISTAKES: [Mistake; 32] = [
    // Keys that are missing, unknown or given twice.
    ("time_limit = 40.0\n", "", "name = \"tidy\"", "(the file)", "missing field `time_limit`"),
    ("reference = \"carton\"\nwhen", "when", "[[skill]]", "skill[0]", "missing field `reference`"),
    (
        "start = { x = [0.18, 0.18], y = [0.24, 0.24] }\n",
        "",
        "[[object]]\nname = \"side\"",
        "object[1]",
        "missing field `start`",
    ),
    ("start = { x = [0.18, 0.18], y", "start = { y", "start = { y = [0.24", "object[1].start", "missing field `x`"),
    (
        "friction = 0.6 }\ncolor = [90",
        "frictoin = 0.6 }\ncolor = [90",
        "frictoin",
        "object[2].shape.block.frictoin",
        "unknown field `frictoin`, expected one of `half`, `density`, `friction`",
    ),
    ("open = 0.06\n", "open = 0.06\nopen = 0.07\n", "open = 0.07", "open", "duplicate key"),
    ("[gripper]", "[gripper", "[gripper", "[gripper", "expected `]`"),
    // Wrong types.
    ("time_limit = 40.0", "time_limit = \"long\"", "time_limit", "time_limit", "expected f64"),
    (
        "half = [0.02, 0.02, 0.05]",
        "half = [0.02, 0.02]",
        "half = [0.02, 0.02]",
        "object[2].shape.block.half",
        "an array of length 3",
    ),
    (
        "contact = true },\n    { at = [0.0, 0.0, 0.18]",
        "contact = 1 },\n    { at = [0.0, 0.0, 0.18]",
        "contact = 1",
        "skill[0].keyframes[1].contact",
        "expected a boolean",
    ),
    ("color = [90, 140, 110]", "color = [90, 140, 1100]", "1100", "object[2].color[2]", "expected u8"),
    // Numbers that cannot be.
    ("density = 400", "density = -400", "density = -400", "object[2].shape.block.density", "more than 0"),
    ("density = 400", "density = nan", "density = nan", "object[2].shape.block.density", "finite"),
    (
        "friction = 0.6 }\ncolor = [90",
        "friction = -0.6 }\ncolor = [90",
        "friction = -0.6",
        "object[2].shape",
        "friction must be 0 to 5",
    ),
    (
        "half = [0.02, 0.02, 0.05]",
        "half = [0.02, 0.0, 0.05]",
        "0.02, 0.0, 0.05",
        "object[2].shape.block.half",
        "more than 0",
    ),
    (
        "close = 25, contact = true },\n    { at = [0.0, 0.0, 0.18]",
        "close = 250, contact = true },\n    { at = [0.0, 0.0, 0.18]",
        "close = 250",
        "skill[0].keyframes[1].close",
        "at most 60 newtons",
    ),
    (
        "open = 0.08 },\n    { at = [0.0, 0.0, 0.03]",
        "open = 0.8 },\n    { at = [0.0, 0.0, 0.03]",
        "open = 0.8 ",
        "skill[0].keyframes[0].open",
        "0 to 0.08 metres",
    ),
    ("x = [-0.21, -0.11]", "x = [-0.11, -0.21]", "-0.11, -0.21", "object[2].start.x", "[least, largest]"),
    ("time_limit = 40.0", "time_limit = 0.0", "time_limit = 0.0", "time_limit", "more than 0"),
    ("seconds = 0.5", "seconds = inf", "seconds = inf", "variation[1].event[0].seconds", "finite"),
    // Starts.
    (
        "x = [-0.21, -0.11], y = [-0.05, 0.05], yaw = [-0.5, 0.5], z = 0.05",
        "x = [-0.21, -0.11], y = [-0.05, 0.05], yaw = [-0.5, 0.5], z = 0.02",
        "z = 0.02 }\n\n[[skill",
        "object[2].start",
        "`table` and `carton` start 30.0 mm inside each other",
    ),
    (
        "start = { on = \"coaster\"",
        "start = { on = \"carton\"",
        "start = { on = \"carton\"",
        "variation[0].object[0].start",
        "inside each other",
    ),
    (
        "start = { on = \"coaster\"",
        "start = { on = \"saucer\"",
        "on = \"saucer\"",
        "variation[0].object[0].start.on",
        "listed before",
    ),
    ("at = [0.0, 0.0, 0.30]", "at = [0.0, 0.0, -0.30]", "-0.30", "gripper.at[2]", "more than 0"),
    // Names and conditions.
    ("until = \"held(carton)\"", "until = \"grasped(carton)\"", "grasped", "skill[0].until", "expected one of held(a)"),
    (
        "until = \"held(carton)\"",
        "until = \"held(box)\"",
        "held(box)",
        "skill[0].until",
        "expected one of carton, coaster, side",
    ),
    (
        "goal = \"all(at(carton, coaster, 0.03), upright",
        "goal = \"all(at(carton, coaster), upright",
        "at(carton, coaster)",
        "goal",
        "positive metres",
    ),
    (
        "goal = \"all(at(carton",
        "goal = \"all(inside(carton, side), at(carton",
        "inside(carton, side)",
        "goal",
        "is no container",
    ),
    ("    \"tilt(carton)\",", "    \"colour(carton)\",", "colour", "observe[4]", "unknown feature"),
    (
        "name = \"bump\"\nedit",
        "name = \"occupied\"\nedit",
        "name = \"occupied\"\nedit = \"edge",
        "variation[1].name",
        "exists already",
    ),
    (
        "[[\"pick\", \"pick\"]]",
        "[[\"pick\", \"grab\"]]",
        "\"grab\"",
        "variation[1].accepts_edges[0]",
        "no skill `grab`",
    ),
    (
        "edit = \"none\"",
        "edit = \"node-modification\"",
        "edit = \"node-modification\"",
        "variation[2].edit",
        "replace some of the original",
    ),
];

#[test]
fn a_mistake_in_a_file_is_told_with_file_line_and_key() {
    let mut wrong = Vec::new();
    for (from, to, line_of, key, expected) in MISTAKES {
        let (status, said) = checked(from, to, &[]);
        let text = TIDY.replacen(from, to, 1);
        let place = text.find(line_of).unwrap_or_else(|| panic!("no `{line_of}`"));
        let line = 1 + text[..place].matches('\n').count();
        let told = said.contains(&format!("tidy.toml:{line}: `{key}`: ")) && said.contains(expected);
        if status != Some(2) || !told {
            wrong.push(format!("{from} → {to}\n  expected line {line}, `{key}`, {expected}\n  {status:?}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), MISTAKES.len(), wrong.join("\n"));
}
