//! `import` and `export`: the example of a recording keyframe by keyframe; mistakes in mappings; damaged recordings;
//! and exports that come back as they were.
//!
//! A mistake must be answered with file, line and key, or with row and column, with exit status 2 and nothing written.
//! No bytes may make it panic.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use proptest::prelude::*;
use proptest::test_runner::{TestCaseResult, TestRunner};
use serde_json::{Value, json};
use situ::demonstration::{Gripper, Keyframe};
use situ_bench::demonstration_file::DemonstrationFile;
use situ_bench::export::{Exported, lerobot, mcap};
use situ_bench::import::{Imported, Mapping, import, import_bytes};

use crate::soak;

const CSV: &str = include_str!("../../examples/recording/saucer.csv");
const MAPPING: &str = include_str!("../../examples/recording/saucer.toml");
const PAGE: &str = include_str!("../../docs/import.md");
/// Cases of a property, where it is not soaked.
const CASES: u32 = 128;

fn mapping(text: &str) -> Mapping {
    Mapping::parse(text, Path::new("map.toml")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn imported(csv: &str, text: &str) -> Imported {
    import_bytes(csv.as_bytes(), Path::new("saucer.csv"), &mapping(text)).unwrap_or_else(|error| panic!("{error}"))
}

fn parsed(imported: &Imported) -> Vec<Value> {
    imported.demonstrations.iter().map(|(_, text)| serde_json::from_str(text).unwrap()).collect()
}

/// The message of a refusal, which is one plain line.
fn refusal(csv: &str, text: &str) -> String {
    let mapping = match Mapping::parse(text, Path::new("map.toml")) {
        Ok(mapping) => mapping,
        Err(error) => return plain(&error),
    };
    plain(&import_bytes(csv.as_bytes(), Path::new("saucer.csv"), &mapping).expect_err(text))
}

fn plain(error: &situ_bench::error::BenchError) -> String {
    let message = error.to_string();
    assert_eq!(error.exit_status(), 2, "{message}");
    assert!(!message.chars().any(char::is_control) && message.len() < 4000, "{message:?}");
    message
}

fn program(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder).output().unwrap()
}

/// Reference, gripper and position of each keyframe.
fn keyframes(demonstration: &Value) -> Vec<(String, Value, [f64; 3])> {
    let keyframes = demonstration["keyframes"].as_array().unwrap().iter();
    let position = |of: &Value| serde_json::from_value(of["gripper_pose"]["position"].clone()).unwrap();
    keyframes
        .map(|each| (each["reference"].as_str().unwrap().to_owned(), each["gripper"].clone(), position(each)))
        .collect()
}

#[test]
fn the_example_keyframe_by_keyframe() {
    let imported = imported(CSV, MAPPING);
    let all = parsed(&imported);
    let names: Vec<&str> = all.iter().map(|each| each["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["saucer-0", "saucer-1", "saucer-2-correction-1"]);
    let (open, close) = (json!({"open": 0.08}), json!({"close": 20.0}));
    let expected = [
        ("cup", &open, [0.5, 0.15, 0.25]),
        ("cup", &close, [0.5, 0.15, 0.07]),
        ("cup", &close, [0.5, 0.15, 0.27]),
        ("saucer", &close, [0.45, -0.2, 0.23]),
        ("saucer", &open, [0.45, -0.2, 0.06]),
        ("saucer", &open, [0.45, -0.2, 0.26]),
    ];
    for (found, (reference, gripper, position)) in keyframes(&all[0]).iter().zip(expected) {
        assert_eq!((found.0.as_str(), &found.1), (reference, gripper), "{}", imported.report);
        assert!((0..3).all(|axis| (found.2[axis] - position[axis]).abs() < 1e-9), "{:?} {position:?}", found.2);
    }
    assert_eq!((keyframes(&all[0]).len(), keyframes(&all[1]).len(), keyframes(&all[2]).len()), (6, 6, 3));
    for each in &all {
        assert_eq!((each["version"].as_u64(), each["half_turn"].as_str()), (Some(2), Some("z")));
        let keyframes = each["keyframes"].as_array().unwrap();
        for world in keyframes.iter().map(|keyframe| &keyframe["world"]).chain([&each["final_world"]]) {
            let objects: Vec<&String> = world["objects"].as_object().unwrap().keys().collect();
            assert_eq!(objects, ["cup", "saucer"], "all worlds have the same objects");
            assert!(world["hand"].is_object() && world["opening"].is_f64());
        }
    }
    // The world before a motion is the one after what was done at the keyframe before: the cup is in the hand.
    let lift = &all[0]["keyframes"][2]["world"];
    assert_eq!((&lift["objects"]["cup"]["position"], &lift["opening"]), (&json!([0.5, 0.15, 0.05]), &json!(0.06)));
    assert_eq!(lift["hand"]["position"], json!([0.5, 0.15, 0.07]));
    let placed = &all[0]["final_world"]["objects"]["cup"]["position"];
    assert_eq!(placed, &json!([0.45, -0.2, 0.04]));
    // The attempt had taken the cup and was under way to the saucer of the original.
    let stop = |segment: u32| json!({"demonstration": "saucer-0", "segment": segment});
    assert_eq!((&all[2]["after"], &all[2]["interrupted"]), (&stop(0), &stop(1)));
    assert_eq!((&all[0]["after"], &all[2]["kind"]), (&Value::Null, &json!("corrective")));
    let longest = imported.report.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|columns| columns <= 100), "{longest:?} columns\n{}", imported.report);
}

/// The columns of the CSV with the real part of the quaternion last.
fn real_part_last() -> String {
    let moved = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[5..9].rotate_left(1);
        cells.join(",") + "\n"
    };
    CSV.lines().map(moved).collect()
}

#[test]
fn the_order_of_a_quaternion_is_said_and_makes_no_other_difference() {
    let unsaid = refusal(CSV, &MAPPING.replace("quaternion_order = \"wxyz\"\n", ""));
    for part in
        ["map.toml:12: ", "gripper.quaternion", "`quaternion_order`", "\"wxyz\" (the real part first", "\"xyzw\""]
    {
        assert!(unsaid.contains(part), "{part} in {unsaid}");
    }
    // A recording whose columns stand in the other order, and a mapping that says so.
    let other = MAPPING.replace("[\"qw\", \"qx\", \"qy\", \"qz\"]", "[\"qx\", \"qy\", \"qz\", \"qw\"]");
    let other = other.replace("\"wxyz\"", "\"xyzw\"");
    assert_eq!(imported(&real_part_last(), &other), imported(CSV, MAPPING));
    // A pose may have an order of its own.
    let own = MAPPING
        .replace("quaternion_order = \"wxyz\"\n", "")
        .replace("[gripper]", "[gripper]\nquaternion_order = \"wxyz\"");
    assert_eq!(imported(CSV, &own), imported(CSV, MAPPING));
}

#[test]
fn units_and_other_forms_of_a_rotation_give_the_same() {
    // The hand looks down, turned about the vertical: roll pi, yaw twice the angle between qx and qy.
    let mut rows = CSV.lines();
    let mut csv = rows.next().unwrap().to_owned() + ",roll,pitch,yaw\n";
    for row in rows {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let mut words: Vec<String> = row.split(',').map(str::to_owned).collect();
        for cell in (2..5).chain(9..16) {
            words[cell] = (cells[cell] * 1000.0).to_string();
        }
        words[1] = (cells[1] * 1000.0).to_string();
        let yaw = 2.0 * cells[7].atan2(cells[6]).to_degrees();
        csv += &format!("{},180,0,{yaw}\n", words.join(","));
    }
    let text = MAPPING
        .replace("quaternion = [\"qw\", \"qx\", \"qy\", \"qz\"]", "roll_pitch_yaw = [\"roll\", \"pitch\", \"yaw\"]")
        .replace("quaternion_order = \"wxyz\"\n", "")
        .replace("unit = \"m\"", "unit = \"mm\"")
        .replace("0.065", "65.0")
        .replace("0.075", "75.0")
        .replace("[columns]", "[units]\nlength = \"mm\"\nangle = \"deg\"\ntime = \"ms\"\n\n[columns]");
    let (one, other) = (parsed(&imported(CSV, MAPPING)), parsed(&imported(&csv, &text)));
    for (one, other) in one.iter().zip(&other) {
        for (one, other) in keyframes(one).iter().zip(keyframes(other)) {
            assert_eq!((&one.0, &one.1), (&other.0, &other.1));
            assert!((0..3).all(|axis| (one.2[axis] - other.2[axis]).abs() < 1e-9));
        }
        let turns = |of: &Value| -> Vec<f64> {
            let all = of["keyframes"].as_array().unwrap().iter();
            all.flat_map(|each| serde_json::from_value::<[f64; 4]>(each["gripper_pose"]["quaternion"].clone()).unwrap())
                .collect()
        };
        let pairs = turns(one).into_iter().zip(turns(other)).collect::<Vec<_>>();
        for quaternion in pairs.chunks(4) {
            let dot: f64 = quaternion.iter().map(|(one, other)| one * other).sum();
            assert!(dot.abs() > 1.0 - 1e-6, "{quaternion:?}");
        }
    }
}

#[test]
fn every_mistake_of_a_mapping_has_a_line_and_a_key() {
    let change = |from: &str, to: &str| {
        assert!(MAPPING.contains(from), "{from}");
        refusal(CSV, &MAPPING.replacen(from, to, 1))
    };
    let add = |text: &str| refusal(CSV, &format!("{MAPPING}\n{text}"));
    let said = [
        (change("time = \"t\"", "time = \"clock\""), "map.toml:7: ", "columns.time", "no column `clock`"),
        (change("[\"x\", \"y\"", "[\"x\", \"Y\""), "map.toml:12: ", "gripper.position[1]", "no column `Y`"),
        (change("time = \"t\"\n", ""), "map.toml:6: ", "columns", "`time`"),
        (change("time =", "clock ="), "map.toml:7: ", "clock", "unknown field"),
        (change("\"wxyz\"", "\"zyxw\""), "map.toml:3: ", "quaternion_order", "expected `wxyz` or `xyzw`"),
        (change("orientation = \"none\"\n", ""), "map.toml:22: ", "objects.cup", "expected one of `quaternion`"),
        (change("position = [\"x\", \"y\", \"z\"]\n", ""), "map.toml:11: ", "gripper", "expected one of `position`"),
        (change("close_below = 0.065\n", ""), "map.toml:17: ", "opening.unit", "`close_below` and `open_above`"),
        (change("close_below = 0.065", "close_below = 0.08"), "map.toml:18: ", "opening.close_below", "no more than"),
        (change("force = 20.0", "force = -1.0"), "map.toml:20: ", "opening.force", "0 or more"),
        (change("force = 20.0", "force = nan"), "map.toml:20: ", "opening.force", "finite"),
        (add("[keyframes]\nmetres = 0.0"), "map.toml:31: ", "keyframes.metres", "above 0"),
        (
            add("[narrations]\npour = \"pot\""),
            "map.toml:31: ",
            "narrations.pour",
            "no object `pot`: expected one of cup, saucer",
        ),
        (add("[[override]]\ndemonstration = \"saucer-0\""), "map.toml:30: ", "override[0]", "`keyframe`"),
        (
            add("[[override]]\ndemonstration = \"saucer-0\"\nkeyframe = 6"),
            "map.toml:32: ",
            "override[0].keyframe",
            "expected 0 to 5",
        ),
        (
            add("[[override]]\ndemonstration = \"saucer-0\"\ntime = 1.0"),
            "map.toml:32: ",
            "override[0].time",
            "expected one of 0.90, 1.90",
        ),
        (
            add("[[override]]\ndemonstration = \"tea\"\nkeyframe = 0"),
            "map.toml:31: ",
            "override[0].demonstration",
            "expected one of saucer-0",
        ),
        (add("[[episodes]]\nepisode = 7"), "map.toml:31: ", "episodes[0].episode", "expected one of 0, 1, 2"),
        (add("[[episodes]]\nepisode = 2\nafter = 2"), "map.toml:30: ", "episodes[0]", "has 2 segments"),
        (add("[[episodes]]\nepisode = 2\nfollows = \"tea\""), "map.toml:30: ", "episodes[0]", "no original `tea`"),
        (add("[[episodes]]\nepisode = 1\nkind = \"corrective\""), "map.toml:30: ", "episodes[0]", "expected `after`"),
    ];
    for (message, line, key, problem) in &said {
        for part in [line, key, problem] {
            assert!(message.contains(part), "`{part}` in `{message}`");
        }
    }
}

#[test]
fn every_mistake_of_a_recording_has_a_row_and_a_column() {
    let line = |number: usize, from: &str, to: &str| {
        let lines = CSV.lines().enumerate().map(|(index, line)| {
            let changed = if index + 1 == number { line.replacen(from, to, 1) } else { line.to_owned() };
            changed + "\n"
        });
        refusal(&lines.collect::<String>(), MAPPING)
    };
    for (message, expected) in [
        (line(2, "0.4000", "nan"), "saucer.csv: line 2, column `x`: `nan`: expected a finite number"),
        (line(2, "0.4000", "inf"), "line 2, column `x`: `inf`"),
        (line(2, "0.4000", ""), "line 2, column `x`: ``"),
        (line(2, "0.4000", "1e9"), "line 2, column `x`: expected at most 1000000 metres"),
        (line(4, "0,0.2", "0,0.0"), "line 4, column `t`: 0 after 0.1"),
        (line(5, ",0.0000", ",0.0000,1"), "line 5: 18 cells: expected 17"),
        (line(62, "1,", "0,"), "line 62, column `t`: 0 after 5.9"),
        (line(130, "2,", "0,"), "line 130, column `episode`: episode `0` goes on after another"),
        (line(1, "qw", "qx"), "line 1: two columns are called `qx`"),
        (refusal("", MAPPING), "saucer.csv: no row"),
        (refusal("a,b\n", MAPPING), "saucer.csv: no row"),
        (refusal("PAR1", MAPPING), "expected the folder of the dataset"),
        (refusal("\u{89}x", MAPPING), "no row"),
    ] {
        assert!(message.contains(expected), "`{expected}` in `{message}`");
    }
    let zero = CSV.replacen("0.0000,1.0000,0.0000,0.0000", "0,0,0,0", 1);
    assert!(refusal(&zero, MAPPING).contains("a quaternion of length 0: expected length 1"));
    // A byte-order mark and the line ends of other systems are none.
    let odd = format!("\u{feff}{}", CSV.replace('\n', "\r\n"));
    assert_eq!(imported(&odd, &format!("\u{feff}{MAPPING}")), imported(CSV, MAPPING));
}

#[test]
fn the_mapping_has_the_last_word() {
    let text = format!(
        "{MAPPING}
[[episodes]]
episode = 0
name = \"first\"

[[episodes]]
episode = 2
corrections = [\"moved\"]
follows = \"saucer-1\"
interrupted = \"none\"
carried_to_end = false

[[override]]
demonstration = \"first\"
keyframe = 2
reference = \"cup\"
narration = \"take\"

[[override]]
demonstration = \"first\"
time = 0.90
leave_out = true
"
    );
    let all = parsed(&imported(CSV, &text));
    let references: Vec<String> = keyframes(&all[0]).into_iter().map(|keyframe| keyframe.0).collect();
    assert_eq!(references, ["cup", "cup", "saucer", "saucer", "saucer"]);
    assert_eq!((&all[0]["name"], &all[0]["keyframes"][1]["narration"]), (&json!("first"), &json!("take")));
    assert_eq!(all[2]["after"], json!({"demonstration": "saucer-1", "segment": 0}));
    assert_eq!((&all[2]["name"], &all[2]["carried_to_end"]), (&json!("moved"), &json!(false)));
    assert!(all[2].get("interrupted").is_none());
    // Marks count where they are said, and nothing else does.
    let marked: String = CSV
        .lines()
        .enumerate()
        .map(|(line, row)| {
            format!(
                "{row},{}\n",
                if line == 0 {
                    "mark"
                } else if [11, 12, 70, 160].contains(&line) {
                    "true"
                } else {
                    ""
                }
            )
        })
        .collect();
    let all = parsed(&imported(&marked, &MAPPING.replace("[columns]", "[columns]\nmark = \"mark\"")));
    assert_eq!(all.iter().map(|each| keyframes(each).len()).collect::<Vec<_>>(), [1, 1, 1]);
    let unmarked = marked.replace("true", "false").replacen("false", "true", 1);
    let message = refusal(&unmarked, &MAPPING.replace("[columns]", "[columns]\nmark = \"mark\""));
    assert!(message.contains("columns.mark") && message.contains("no frame of `saucer-1` is marked"), "{message}");
}

#[test]
fn the_program_writes_all_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("saucer.csv"), CSV).unwrap();
    fs::write(folder.path().join("map.toml"), MAPPING).unwrap();
    fs::write(folder.path().join("bad.csv"), CSV.replacen("0.4000", "?", 1)).unwrap();
    let words = |csv: &'static str| ["import", csv, "--mapping", "map.toml", "--out", "shown"];
    let refused = program(&words("bad.csv"), folder.path());
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!((refused.status.code(), folder.path().join("shown").exists()), (Some(2), false), "{said}");
    assert!(said.contains("bad.csv: line 2, column `x`: `?`"), "{said}");
    let looked = program(&words("saucer.csv")[..4], folder.path());
    assert!(looked.status.success() && !folder.path().join("shown").exists());
    let written = program(&words("saucer.csv"), folder.path());
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let mut names: Vec<String> = fs::read_dir(folder.path().join("shown"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["saucer-0.json", "saucer-1.json", "saucer-2-correction-1.json"]);
}

/// The example demonstrations of the repository, the correction last.
fn demonstrations(folder: &str) -> Vec<DemonstrationFile> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(folder);
    let read = |name: &str| DemonstrationFile::read(&folder.join(name)).unwrap();
    let mut all: Vec<DemonstrationFile> = ["serve-1.json", "serve-2.json", "lid-first.json"].map(read).into();
    // The same correction after a segment, with words.
    let text = fs::read_to_string(folder.join("lid-first.json")).unwrap();
    let later = text
        .replacen("\"lid-first\"", "\"lid-later\"", 1)
        .replacen(
            "\"after\": null",
            "\"after\": {\"demonstration\": \"serve-2\", \"segment\": 0}, \
             \"interrupted\": {\"demonstration\": \"serve-2\", \"segment\": 1}",
            1,
        )
        .replacen("\"gripper\": 0.2,", "\"gripper\": 0.2, \"announced\": true, \"narration\": \"take the lid\",", 1);
    all.push(DemonstrationFile::parse(later, Path::new("later.json")).unwrap());
    all
}

/// Writes an export into a folder and imports it with its own mapping.
fn back(exported: &Exported, recording: &Path) -> Imported {
    for (path, content) in &exported.files {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
    import(&[recording.to_owned()], &mapping(&exported.mapping)).unwrap_or_else(|error| panic!("{error}"))
}

/// Whether a demonstration came back, to so many metres and so on.
fn is_same(file: &DemonstrationFile, back: &Value, slack: f64) {
    let demonstration = &file.demonstration;
    let name = demonstration.name();
    assert_eq!(back["name"].as_str(), Some(&**name));
    assert_eq!(back["carried_to_end"].as_bool(), Some(demonstration.carried_to_end()), "{name}");
    let instance = |of: &Option<situ_bench::demonstration_file::Instance>| serde_json::to_value(of).unwrap();
    assert_eq!(back["after"], instance(&file.before.after), "{name}");
    assert_eq!(back.get("interrupted").unwrap_or(&Value::Null), &instance(&file.before.interrupted), "{name}");
    let keyframes = back["keyframes"].as_array().unwrap();
    assert_eq!(keyframes.len(), demonstration.keyframes().len(), "{name}");
    let near = |value: &Value, expected: f64| {
        assert!((value.as_f64().unwrap() - expected).abs() <= slack, "{name}: {value} {expected}")
    };
    let pose = |value: &Value, expected: &situ::demonstration::Pose| {
        let (at, turned) = (expected.translation.vector, expected.rotation);
        (0..3).for_each(|axis| near(&value["position"][axis], at[axis]));
        [turned.w, turned.i, turned.j, turned.k]
            .iter()
            .enumerate()
            .for_each(|(part, own)| near(&value["quaternion"][part], *own));
    };
    for (world, back) in
        file.worlds.iter().zip(keyframes.iter().map(|back| &back["world"]).chain([&back["final_world"]]))
    {
        world.objects.iter().for_each(|(object, expected)| pose(&back["objects"][object], expected));
        pose(&back["hand"], &world.hand);
    }
    for (back, keyframe) in keyframes.iter().zip(demonstration.keyframes()) {
        let Keyframe { reference, reference_pose, gripper_pose, gripper, hold, announced, narration, .. } = keyframe;
        assert_eq!(back["reference"].as_str(), Some(&**reference), "{name}");
        assert_eq!(back["narration"].as_str(), narration.as_deref(), "{name}");
        assert_eq!(back["announced"].as_bool().unwrap_or(false), *announced, "{name}");
        pose(&back["gripper_pose"], gripper_pose);
        pose(&back["world"]["objects"][&**reference], reference_pose);
        near(&back["hold"], *hold);
        let command = match gripper {
            Gripper::Opening(_) => &back["gripper"],
            Gripper::Open(_) => &back["gripper"]["open"],
            Gripper::Close(_) => &back["gripper"]["close"],
        };
        near(command, gripper.value());
    }
}

#[test]
fn what_is_exported_comes_back() {
    for examples in ["demonstrations", "poses"] {
        comes_back(&demonstrations(examples));
    }
}

fn comes_back(files: &[DemonstrationFile]) {
    let folder = tempfile::tempdir().unwrap();
    let (dataset, file) = (folder.path().join("dataset"), folder.path().join("all.mcap"));
    let exports =
        [(mcap(files, &file).unwrap(), &file, 0.0), (lerobot(files, "serve", &dataset).unwrap(), &dataset, 1e-6)];
    for (exported, recording, slack) in exports {
        let all = parsed(&back(&exported, recording));
        assert_eq!(all.len(), files.len());
        for (file, back) in files.iter().zip(&all) {
            is_same(file, back, slack);
        }
        // The same again gives the same bytes.
        let again = if slack > 0.0 { lerobot(files, "serve", &dataset) } else { mcap(files, &file) };
        assert_eq!(again.unwrap(), exported);
    }
}

#[test]
fn an_attempt_without_marks_is_found_on_its_original() {
    let folder = tempfile::tempdir().unwrap();
    let (files, file) = (demonstrations("demonstrations"), folder.path().join("all.mcap"));
    let mut exported = mcap(&files, &file).unwrap();
    // What the mapping says of the stop is left out, so that it is looked for.
    let said = |line: &&str| !line.starts_with("after") && !line.starts_with("interrupted");
    exported.mapping = exported.mapping.lines().filter(said).map(|line| format!("{line}\n")).collect();
    let all = parsed(&back(&exported, &file));
    assert_eq!(all[2]["after"], Value::Null, "the person led from the start");
    assert_eq!(all[3]["after"], json!({"demonstration": "serve-2", "segment": 0}));
}

#[test]
fn other_recordings_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let (files, file) = (demonstrations("demonstrations"), folder.path().join("all.mcap"));
    let exported = mcap(&files, &file).unwrap();
    back(&exported, &file);
    let refused = |from: &str, to: &str| {
        assert!(exported.mapping.contains(from), "{from} in {}", exported.mapping);
        let mapping = mapping(&exported.mapping.replacen(from, to, 1));
        plain(&import(std::slice::from_ref(&file), &mapping).unwrap_err())
    };
    let other = refused("topic = \"/gripper\"", "topic = \"/hand\"");
    assert!(other.contains("the topics /demonstration, /gripper, /objects"), "{other}");
    let other = refused("frame = \"cup\"", "frame = \"cap\"");
    assert!(other.contains("objects.cup.topic") && other.contains("no pose of this topic"), "{other}");
    let dataset = folder.path().join("dataset");
    let exported = lerobot(&files, "serve", &dataset).unwrap();
    back(&exported, &dataset);
    let info = fs::read_to_string(dataset.join("meta/info.json")).unwrap();
    fs::write(dataset.join("meta/info.json"), info.replace("v3.0", "v2.1")).unwrap();
    let old = plain(&import(std::slice::from_ref(&dataset), &mapping(&exported.mapping)).unwrap_err());
    assert!(old.contains("info.json") && old.contains("`v2.1`: expected a dataset of version 3"), "{old}");
    let mapped = exported.mapping.replacen("observation.state.x", "observation.state.u", 1);
    fs::write(dataset.join("meta/info.json"), info).unwrap();
    let missing = plain(&import(&[dataset], &mapping(&mapped)).unwrap_err());
    assert!(missing.contains("gripper.position[0]") && missing.contains("observation.state.x"), "{missing}");
}

/// Runs a check on whatever `strategy` makes.
fn holds<S: Strategy>(strategy: S, check: impl Fn(&S::Value)) {
    let mut runner = TestRunner::new(soak::config(CASES));
    let result = runner.run(&strategy, |value| -> TestCaseResult {
        check(&value);
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}\nagain with SITU_SEED={}", soak::seed()));
}

/// Bytes with some of them changed, and perhaps cut off.
fn damaged(bytes: &[u8], changes: &[(prop::sample::Index, u8)], cut: Option<prop::sample::Index>) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (place, byte) in changes {
        let place = place.index(bytes.len());
        bytes[place] = *byte;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut.index(bytes.len()));
    }
    bytes
}

fn changes() -> impl Strategy<Value = (Vec<(prop::sample::Index, u8)>, Option<prop::sample::Index>)> {
    (prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6), any::<Option<prop::sample::Index>>())
}

#[test]
fn no_bytes_make_it_panic() {
    let any_csv = mapping(MAPPING);
    let path = Path::new("file");
    holds(prop::collection::vec(any::<u8>(), 0..300), |bytes| {
        for magic in [&b""[..], b"\x89MCAP0\r\n", b"PAR1"] {
            let _ = import_bytes(&[magic, bytes].concat(), path, &any_csv).map_err(|error| plain(&error));
        }
    });
    let few: String = CSV.lines().take(30).map(|line| format!("{line}\n")).collect();
    holds(changes(), |(changes, cut)| {
        let bytes = damaged(few.as_bytes(), changes, *cut);
        let _ = import_bytes(&bytes, path, &any_csv).map_err(|error| plain(&error));
        let text = damaged(MAPPING.as_bytes(), changes, *cut);
        let mapping = String::from_utf8(text).ok().and_then(|text| Mapping::parse(&text, path).ok());
        let _ = mapping.map(|mapping| import_bytes(few.as_bytes(), path, &mapping).map_err(|error| plain(&error)));
    });
    let files = &demonstrations("demonstrations")[..1];
    let exported = mcap(files, path).unwrap();
    let mcap_mapping = mapping(&exported.mapping);
    holds(changes(), |(changes, cut)| {
        let bytes = damaged(&exported.files[0].1, changes, *cut);
        let _ = import_bytes(&bytes, path, &mcap_mapping).map_err(|error| plain(&error));
    });
}

/// The length of a record within a compressed chunk was believed: so much memory was asked for, and the program ended.
#[test]
fn a_damaged_length_asks_for_no_memory() {
    let length = (1_u64 << 62).to_le_bytes();
    // A frame of Zstandard with one raw block: a message record of that length.
    let block = [&[5_u8][..], &length].concat();
    let frame = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 9, 0x49, 0, 0][..], &block].concat();
    let sizes = [&[0; 16][..], &9_u64.to_le_bytes(), &[0; 4], &4_u32.to_le_bytes(), b"zstd"].concat();
    let chunk = [&sizes[..], &(frame.len() as u64).to_le_bytes(), &frame].concat();
    let header = [&[1_u8][..], &8_u64.to_le_bytes(), &[0; 8]].concat();
    let file = [b"\x89MCAP0\r\n", &header[..], &[6], &(chunk.len() as u64).to_le_bytes(), &chunk].concat();
    let refused = plain(&import_bytes(&file, Path::new("file.mcap"), &mapping(MAPPING)).unwrap_err());
    assert!(refused.starts_with("file.mcap: "), "{refused}");
}

/// The crate that reads Parquet files may panic. That is caught, so that only a message on standard error is left.
#[test]
fn no_damaged_dataset_makes_it_panic() {
    let folder = tempfile::tempdir().unwrap();
    let dataset: PathBuf = folder.path().join("dataset");
    let exported = lerobot(&demonstrations("demonstrations")[..1], "serve", &dataset).unwrap();
    back(&exported, &dataset);
    let mapping = mapping(&exported.mapping);
    for (file, content) in &exported.files {
        holds(changes(), |(changes, cut)| {
            fs::write(file, damaged(content, changes, *cut)).unwrap();
            let _ = import(std::slice::from_ref(&dataset), &mapping).map_err(|error| plain(&error));
        });
        fs::write(file, content).unwrap();
    }
}

/// The keys that a table of the mapping knows, from the refusal of one that it does not.
fn known_keys(table: &str) -> Vec<String> {
    let rest = "[gripper]\ntopic = \"/t\"\n[objects.a]\ntopic = \"/t\"\n";
    let text = if table.is_empty() { format!("zz = 1\n{rest}") } else { format!("{rest}{table}\nzz = 1\n") };
    let message = Mapping::parse(&text, Path::new("map.toml")).unwrap_err().to_string();
    assert!(message.contains("unknown field `zz`"), "{table}: {message}");
    let (_, list) = message.split_once("expected").unwrap();
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_page_has_every_key() {
    let tables = [
        ("", "## The mapping"),
        ("[units]", "### Units"),
        ("[columns]", "### Columns"),
        ("[objects.b]", "### Poses"),
        ("[objects.b.fixed]", "### Poses"),
        ("[opening]", "### Opening"),
        ("[keyframes]", "### Tolerances"),
        ("[[episodes]]", "### Episodes"),
        ("[[override]]", "### Overrides"),
    ];
    for (table, heading) in tables {
        let (_, section) = PAGE.split_once(&format!("{heading}\n")).expect(heading);
        let section = section.split("\n#").next().unwrap();
        let known = known_keys(table);
        assert!(known.len() > 1, "{table}");
        for key in &known {
            let is_row =
                section.contains(&format!("\n| `{key}` |")) || table.contains("fixed") && section.contains(key);
            assert!(is_row, "{heading} lacks `{key}`");
        }
        if !table.contains("fixed") {
            let rows = section.lines().filter(|line| line.starts_with("| `")).count();
            assert_eq!(rows, known.len(), "{heading} has a row that is no key of {known:?}");
        }
    }
}

/// The ten minutes of the page: a recording, its demonstrations, a model.
#[test]
fn what_is_imported_is_learned() {
    let folder = tempfile::tempdir().unwrap();
    let program = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).current_dir(folder.path()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    fs::write(folder.path().join("saucer.csv"), CSV).unwrap();
    fs::write(folder.path().join("saucer.toml"), MAPPING).unwrap();
    program(&["import", "saucer.csv", "--mapping", "saucer.toml", "--out", "saucer"]);
    let names = ["saucer/saucer-0.json", "saucer/saucer-1.json", "saucer/saucer-2-correction-1.json"];
    let printed = program(&["learn", names[0], names[1], "--correct", names[2]]);
    for line in ["format version 2\n", "nodes 2\n", "z0 on cup, segments 2", "correction saucer-2-correction-1: "] {
        assert!(printed.contains(line), "{line} in\n{printed}");
    }
}

/// Units and orders that are probably wrong are said, and nothing is refused for them.
#[test]
fn what_looks_like_a_mistake_is_said() {
    let said = |from: &str, to: &str| {
        assert!(MAPPING.contains(from), "{from}");
        imported(CSV, &MAPPING.replacen(from, to, 1)).report
    };
    let sound = imported(CSV, MAPPING).report;
    assert!(!sound.contains("doubtful") && sound.contains("points along (0.00, 0.00, -1.00)"), "{sound}");
    let turned = said("quaternion_order = \"wxyz\"", "quaternion_order = \"xyzw\"");
    assert!(turned.contains("points along (0.00, 0.30, -0.96)"), "{turned}");
    // Lines that end as on Windows are counted as editors count them.
    let mut lines: Vec<String> = CSV.lines().map(str::to_owned).collect();
    lines[3] = lines[3].replacen(",0.2,", ",soon,", 1);
    let broken = lines.join("\r\n");
    assert!(refusal(&broken, MAPPING).contains("line 4"), "{}", refusal(&broken, MAPPING));
}

/// Objects that a recording has none of are features all the same, and an override may be about all demonstrations.
#[test]
fn a_task_may_have_more_objects_and_an_override_all_demonstrations() {
    let more = format!(
        "task_objects = [\"cup\", \"lid\", \"saucer\"]\n{MAPPING}\n[[override]]\nkeyframe = 0\nreference = \"saucer\"\n"
    );
    let all = imported(CSV, &more);
    for (name, text) in &all.demonstrations {
        let file = DemonstrationFile::parse(text.clone(), Path::new("file")).unwrap();
        assert!(file.schema.features().iter().any(|feature| feature.name == "seen(lid)"), "{name}");
        assert_eq!(&*file.demonstration.keyframes()[0].reference, "saucer", "{name}");
    }
    let missing = format!("task_objects = [\"cup\", \"lid\"]\n{MAPPING}");
    assert!(refusal(CSV, &missing).contains("`saucer` has a pose below"));
}
