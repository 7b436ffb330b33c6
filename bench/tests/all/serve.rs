//! `serve`: the protocol from one end to the other, with everything that is no request.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};
use situ_bench::demonstration_file::DemonstrationFile;

/// A process that serves. It is ended where a test fails, too.
struct Served {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    asked: u64,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_situ-bench"))
            .arg("serve")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take(), BufReader::new(child.stdout.take().unwrap()));
        Self { child, to, from, asked: 0 }
    }

    /// The answer to any line.
    fn line(&mut self, line: &[u8]) -> Value {
        let to = self.to.as_mut().unwrap();
        to.write_all(line).unwrap();
        to.write_all(b"\n").unwrap();
        to.flush().unwrap();
        let mut answer = String::new();
        self.from.read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap_or_else(|error| panic!("{error}: {answer:?}"))
    }

    fn ask(&mut self, mut request: Value) -> Value {
        self.asked += 1;
        request["id"] = self.asked.into();
        let mut answer = self.line(request.to_string().as_bytes());
        assert_eq!(answer.as_object_mut().unwrap().remove("id"), Some(self.asked.into()), "{answer}");
        answer
    }

    /// The answer to a request that can be done.
    fn done(&mut self, request: Value) -> Value {
        let answer = self.ask(request.clone());
        assert!(answer.get("error").is_none(), "{request}: {answer}");
        answer
    }

    /// The problem of a request that cannot.
    fn refused(&mut self, request: Value) -> String {
        let answer = self.ask(request.clone());
        answer["error"].as_str().unwrap_or_else(|| panic!("{request}: {answer}")).to_owned()
    }

    /// Whether the process ends well once its input does.
    fn ends(mut self) -> bool {
        self.to = None;
        self.child.wait().unwrap().success()
    }
}

/// A keyframe of a demonstration as a request.
fn keyframe(keys: &Value) -> Value {
    let pose = &keys["gripper_pose"];
    json!({"do": "move", "position": pose["position"], "quaternion_wxyz": pose["quaternion"], "gripper": keys["gripper"],
           "hold": keys["hold"]})
}

fn reset(task: &str, variation: Option<&str>, seed: u64) -> Value {
    json!({"do": "reset", "task": task, "variation": variation, "seed": seed})
}

#[test]
fn a_session_from_hello_to_bye() {
    let mut served = Served::start(&[]);
    let hello = served.done(json!({"do": "hello", "protocol": 1}));
    assert_eq!((&hello["protocol"], &hello["plant"]), (&json!(1), &json!("arm")));
    let tasks = served.done(json!({"do": "tasks"}));
    let stack = tasks["tasks"].as_array().unwrap().iter().find(|task| task["task"] == "stack").unwrap();
    assert!(stack["variations"].as_array().unwrap().iter().any(|own| own["edit"] == "node-modification"), "{stack}");

    let begun = served.done(reset("stack", None, 1));
    assert_eq!(served.done(json!({"do": "observe"})), begun);
    assert_eq!(begun["features"], stack["features"]);
    let [state, scaled] = ["state", "scaled"].map(|key| begun[key].as_array().unwrap());
    for ((value, scaled), feature) in state.iter().zip(scaled).zip(begun["features"].as_array().unwrap()) {
        let expected = value.as_f64().unwrap() / feature["scale"].as_f64().unwrap();
        assert_eq!(scaled.as_f64(), Some(expected), "{feature}");
    }
    let shown = served.done(json!({"do": "demonstrate"}));
    assert_eq!((&shown["clean"], &shown["solved"]), (&json!(true), &json!(true)));
    assert_eq!(served.done(json!({"do": "observe"})), begun, "who shows something moves nothing");
    let text = shown["demonstration"].to_string();
    let file = DemonstrationFile::parse(text, Path::new("shown.json")).unwrap();
    let keyframes = shown["demonstration"]["keyframes"].as_array().unwrap().clone();
    assert_eq!(file.demonstration.keyframes().len(), keyframes.len());
    assert_eq!(keyframes[0]["state"], begun["state"]);

    assert_eq!(served.done(json!({"do": "is_solved"})), json!({"solved": false}));
    for (index, keys) in keyframes.iter().enumerate() {
        let gone = served.done(keyframe(keys));
        assert!(gone["aborted"] == json!(false), "keyframe {index}: {gone}");
    }
    assert_eq!(served.done(json!({"do": "is_solved"})), json!({"solved": true}));
    // Where all is done there is nothing to correct.
    let nothing = served.done(json!({"do": "correct"}));
    assert_eq!((&nothing["demonstration"], &nothing["clean"]), (&Value::Null, &json!(false)));
    assert_eq!(served.done(json!({"do": "bye"})), json!({}));
    assert!(served.ends());
}

/// A correction begins where the episode stands, and leads to the goal.
#[test]
fn a_correction_is_from_here() {
    let mut served = Served::start(&["--plant", "hand"]);
    served.done(reset("sort_blocks", Some("cover"), 2));
    let about = json!({"reference": "red_1", "keyframe": 0});
    let gone = served.done(json!({"do": "move", "position": [0.0, 0.0, 0.2], "quaternion_wxyz": [1, 0, 0, 0],
                                  "gripper": {"close": 10}, "about": about}));
    assert_eq!((&gone["end"], &gone["about"]), (&json!("reached"), &about));
    let here = served.done(json!({"do": "observe"}));
    let corrected = served.done(json!({"do": "correct"}));
    let demonstration = &corrected["demonstration"];
    assert_eq!((&demonstration["kind"], &corrected["clean"]), (&json!("corrective"), &json!(true)), "{corrected}");
    assert_eq!(demonstration["keyframes"][0]["state"], here["state"]);
    assert_eq!(served.done(json!({"do": "correct"})), corrected, "the same again");
    let stop = json!({"do": "watch", "reference": "red_1", "moment": "after"});
    assert!(served.done(stop).get("stop").is_some());
    for keys in demonstration["keyframes"].as_array().unwrap() {
        served.done(keyframe(keys));
    }
    assert_eq!(served.done(json!({"do": "is_solved"})), json!({"solved": true}));
}

/// Where nobody says which primitive a keyframe is of, somebody bumps into things, and things slip, at the keyframes at
/// which they do so in a rollout. The mat under the pitcher used to be taken for the pitcher.
#[test]
fn events_happen_when_they_are_due() {
    let mut served = Served::start(&["--plant", "hand"]);
    let cases = [("pour", "bump", "pitcher", 0), ("sort_blocks", "drop", "red_1", 2), ("stack", "drop", "top", 2)];
    for (task, variation, reference, index) in cases {
        for seed in 0..4 {
            served.done(reset(task, Some(variation), seed));
            let shown = served.done(json!({"do": "demonstrate"}));
            let keyframes = shown["demonstration"]["keyframes"].as_array().unwrap();
            let due = keyframes.iter().position(|keys| keys["reference"] == reference).unwrap() + index;
            for (place, keys) in keyframes.iter().enumerate().take(due + 1) {
                let gone = served.done(keyframe(keys));
                let events = u64::from(place >= due);
                assert_eq!(gone["observation"]["events"], events, "{task}/{variation}, seed {seed}, keyframe {place}");
            }
        }
    }
}

/// The page and the long help have every word that there is.
#[test]
fn every_request_is_explained() {
    let mut served = Served::start(&[]);
    let said = served.refused(json!({"do": "what"}));
    let words: Vec<&str> = said.split("one of ").nth(1).unwrap().split(", ").collect();
    let page = include_str!("../../docs/serve.md");
    let help = Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(["serve", "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    assert_eq!(words.len(), 14, "{words:?}");
    for word in words {
        assert!(page.contains(&format!("\n| `{word}` | ")), "{word} is not in bench/docs/serve.md");
        assert!(help.lines().any(|line| line.split_whitespace().next() == Some(word)), "{word} is not in the help");
    }
}

/// A restored world and the original one give identical observations for identical keyframes: in the same process,
/// which has kept it, and in another, which does all of it once more.
#[test]
fn a_snapshot_is_restored_bit_for_bit() {
    let mut served = Served::start(&[]);
    served.done(reset("stack", Some("drop"), 4));
    let shown = served.done(json!({"do": "demonstrate"}));
    let keyframes = shown["demonstration"]["keyframes"].as_array().unwrap().clone();
    let (first, rest) = keyframes.split_at(keyframes.len() / 2);
    for keys in first {
        served.done(keyframe(keys));
    }
    let kept = served.done(json!({"do": "snapshot"}))["snapshot"].clone();
    let restore = json!({"do": "restore", "snapshot": kept});
    let here = served.done(json!({"do": "observe"}));
    let gone: Vec<Value> = rest.iter().map(|keys| served.done(keyframe(keys))).collect();
    assert_eq!(served.done(restore.clone()), here);
    let again: Vec<Value> = rest.iter().map(|keys| served.done(keyframe(keys))).collect();
    assert_eq!(again, gone);
    let mut other = Served::start(&[]);
    assert_eq!(other.done(restore.clone()), here);
    let elsewhere: Vec<Value> = rest.iter().map(|keys| other.done(keyframe(keys))).collect();
    assert_eq!(elsewhere, gone);
    // What another program would make of it is not taken for it.
    let mut hand = Served::start(&["--plant", "hand"]);
    assert!(hand.refused(restore).contains("expected one of the same program"));
}

#[test]
fn a_picture_is_answered_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("now.png");
    let mut served = Served::start(&["--plant", "hand"]);
    assert!(served.refused(json!({"do": "picture"})).contains("expected `reset`"));
    served.done(reset("press", None, 1));
    let answer = served.done(json!({"do": "picture", "width": 32, "height": 20, "format": "rgb"}));
    assert_eq!(answer["rgb"].as_str().unwrap().len(), 32 * 20 * 4);
    assert!(served.done(json!({"do": "picture", "width": 32, "height": 20}))["png"].is_string());
    served.done(json!({"do": "picture", "width": 32, "height": 20, "path": path.to_str().unwrap()}));
    let decoder = png::Decoder::new(BufReader::new(std::fs::File::open(&path).unwrap()));
    assert_eq!(decoder.read_info().unwrap().info().size(), (32, 20));
    assert!(served.refused(json!({"do": "picture", "width": 1_000_000})).contains("expected 16 to 1920"));
    let nowhere = folder.path().join("nowhere/now.png");
    assert!(served.refused(json!({"do": "picture", "path": nowhere.to_str().unwrap()})).contains("cannot be written"));
}

/// Whatever a line holds, it is answered, the next one is, too, and the episode is as it was.
#[test]
fn what_is_no_request_is_answered() {
    let mut served = Served::start(&["--plant", "hand"]);
    let unmoved = json!({"do": "move", "position": [0, 0, 0.3], "quaternion_wxyz": [1, 0, 0, 0]});
    assert!(served.refused(unmoved.clone()).contains("expected `reset`"), "a move before a reset");
    let before = served.done(reset("press", None, 3));
    let moved = |key: &str, value: Value| {
        let mut request = unmoved.clone();
        request[key] = value;
        request
    };
    let refused = [
        (reset("pours", None, 1), "the known tasks are bread_box, clear_table"),
        (reset("press", Some("lid"), 1), "it has shutter"),
        (json!({"do": "reset", "task": "press", "seed": 1, "teacher": "nobody"}), "expert"),
        (json!({"do": "reset", "task": "press", "seed": -1}), "`reset`, key `seed`"),
        (json!({"do": "reset", "task": "press"}), "missing field `seed`"),
        (moved("position", json!([0, 0, 1e300])), "expected at most 2 either way"),
        (moved("position", json!([0, 0])), "key `position"),
        (moved("quaternion_wxyz", json!([0, 0, 0, 0])), "expected length 1 (order w, x, y, z)"),
        (moved("gripper", json!(1.5)), "an opening from 0 (closed) to 1 (open)"),
        (moved("gripper", json!({"close": -1})), "a force of 0 to"),
        (moved("hold", json!(-1)), "expected 0 to"),
        (
            moved("about", json!({"reference": "teapot", "keyframe": 0})),
            "no object is called `teapot`: expected one of",
        ),
        (moved("speed", json!(1)), "unknown field `speed`"),
        (json!({"do": "watch", "reference": "green", "moment": "later"}), "unknown variant `later`"),
        (json!({"do": "restore", "snapshot": "{}"}), "missing field"),
        (json!({"do": "restore", "snapshot": "nothing"}), "expected the text that `snapshot` gave"),
        (json!({"do": "dance"}), "`do` is one of hello, tasks"),
        (json!({"do": "hello", "protocol": 2}), "this program speaks 1"),
    ];
    for (request, expected) in refused {
        let problem = served.refused(request.clone());
        assert!(problem.contains(expected), "{request}: {problem}");
    }
    let deep = "[".repeat(5000);
    let lines: [(&[u8], &str); 8] = [
        (b"hello", "expected one JSON object"),
        (b"[1]", "expected a JSON object"),
        (b"\xff\xfe", "expected UTF-8"),
        (br#"{"do": "observe", "do": "bye"}"#, "stands there twice"),
        (br#"{"do": "move", "position": [NaN, 0, 0]}"#, "no NaN"),
        (br#"{"do": "move", "position": [1e999, 0, 0]}"#, "number out of range"),
        (br#"{"id": {}, "do": "observe"}"#, "key `id`"),
        (deep.as_bytes(), "expected one JSON object"),
    ];
    for (line, expected) in lines {
        let answer = served.line(line);
        assert!(
            answer["id"].is_null() && answer["error"].as_str().is_some_and(|said| said.contains(expected)),
            "{answer}"
        );
    }
    assert!(served.line(&vec![b'x'; (16 << 20) + 7])["error"].as_str().unwrap().contains("a line of at most"));
    assert_eq!(served.done(json!({"do": "observe"})), before, "as it was");
    assert_eq!(served.line(br#"{"id": "mine", "do": "is_solved"}"#), json!({"id": "mine", "solved": false}));
    assert!(served.ends());
}

/// An episode has an end: its limit of time, or so many keyframes.
#[test]
fn an_episode_ends_at_its_limit() {
    let mut served = Served::start(&["--plant", "hand"]);
    served.done(reset("press", None, 3));
    let far = json!({"do": "move", "position": [0, 0, 0.3], "quaternion_wxyz": [1, 0, 0, 0], "hold": 1e6});
    let gone = served.done(far.clone());
    assert_eq!((&gone["end"], &gone["observation"]["truncated"]), (&json!("reached"), &json!(true)));
    assert!(served.refused(far).contains("the episode is over: its limit of 18 simulated seconds"));
    served.done(reset("press", None, 3));
    assert_eq!(served.done(json!({"do": "observe"}))["truncated"], json!(false));
}

/// The user's interrupt ends a request that takes long, and the program says so.
#[cfg(unix)]
#[test]
fn an_interrupt_is_obeyed() {
    let mut served = Served::start(&[]);
    served.done(reset("press", None, 3));
    let status = Command::new("kill").args(["-INT", &served.child.id().to_string()]).status().unwrap();
    assert!(status.success());
    assert_eq!(served.child.wait().unwrap().code(), Some(130));
}
