//! `show`: its files are pictures of the wanted size, the film moves, what is shown of a learned model is what `run`
//! did, and a name that nothing has is refused.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::small;

fn program(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder).output().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A PNG as its decoder sees it.
struct Decoded {
    size: [u32; 2],
    /// The pixels of each frame's own rectangle; one frame where it is not animated.
    frames: Vec<Vec<u8>>,
    /// How long the frames are shown, seconds.
    seconds: f64,
}

fn decoded(path: &Path) -> Decoded {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let size = [reader.info().width, reader.info().height];
    let count = reader.info().animation_control().map_or(1, |control| control.num_frames);
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let mut seconds = 0.0;
    let frames = (0..count).map(|_| {
        let frame = reader.next_frame(&mut pixels).unwrap();
        if let Some(control) = reader.info().frame_control() {
            seconds += f64::from(control.delay_num) / f64::from(control.delay_den);
        }
        pixels[..frame.buffer_size()].to_vec()
    });
    let frames = frames.collect();
    Decoded { size, frames, seconds }
}

/// A GIF as its decoder sees it: the size, what each frame leaves on the screen, and how long the frames are shown.
fn decoded_gif(path: &Path) -> ([u32; 2], Vec<Vec<u8>>, f64) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(BufReader::new(File::open(path).unwrap())).unwrap();
    let (width, height) = (usize::from(reader.width()), usize::from(reader.height()));
    let mut screen = vec![0; 3 * width * height];
    let (mut screens, mut seconds) = (Vec::new(), 0.0);
    while let Some(frame) = reader.read_next_frame().unwrap() {
        for (place, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let column = usize::from(frame.left) + place % usize::from(frame.width);
            let row = usize::from(frame.top) + place / usize::from(frame.width);
            screen[3 * (row * width + column)..][..3].copy_from_slice(&pixel[..3]);
        }
        seconds += f64::from(frame.delay) / 100.0;
        screens.push(screen.clone());
    }
    ([width as u32, height as u32], screens, seconds)
}

/// The number after these words in the printed text.
fn number_after(words: &str, text: &str) -> f64 {
    let rest = text.split(words).nth(1).unwrap_or_else(|| panic!("no `{words}` in\n{text}"));
    rest.trim_start().split([',', '\n']).next().unwrap().parse().unwrap()
}

#[test]
fn a_demonstration_and_a_failure_become_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["show", "sort_blocks/bump", "--failure", "--width", "48", "--height", "30", "--out", "a/b"];
    let output = program(&words, folder.path());
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let out = folder.path().join("a/b");
    let [demonstration, moments, failure, start, strip] =
        ["demonstration", "failure-strip", "failure", "start", "strip"]
            .map(|what| format!("sort_blocks-bump-{what}.png"));
    let gifs = [&demonstration, &failure].map(|name| name.replace(".png", ".gif"));
    assert_eq!(
        names(&out),
        [&gifs[0], &demonstration, &moments, &gifs[1], &failure, &start, &strip].map(String::as_str)
    );

    let start = decoded(&out.join(start));
    assert_eq!((start.size, start.frames.len()), ([96, 60], 1));
    let moments = decoded(&out.join(moments));
    let strip = decoded(&out.join(strip));
    for strip in [&strip, &moments] {
        assert_eq!((strip.size, strip.frames.len()), ([8 * 48 + 7 * 4, 30], 1));
    }
    assert_ne!(strip.frames[0], moments.frames[0], "the teacher's way and the original program's");
    let mut colors: Vec<&[u8]> = strip.frames[0].chunks(3).collect();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() > 20, "a picture of something");

    // The teacher picks the bumped object again and succeeds. The original program does not.
    assert!(printed.contains("pick_red_1, pick_red_1, place_red_1"), "{printed}");
    assert!(printed.contains("8 of 27 keyframes"), "{printed}");
    let [shown, failed] = printed.split_once("original program: ").map(|(shown, failed)| [shown, failed]).unwrap();
    assert!(shown.contains("the goal holds: yes") && failed.contains("the goal holds: no"), "{printed}");

    // A film runs three times as fast, and its last picture stays for a second.
    for (name, text) in [(demonstration, shown), (failure, failed)] {
        let film = decoded(&out.join(&name));
        assert_eq!(film.size, [48, 30]);
        assert!(film.frames.len() > 50, "{name}: {} frames", film.frames.len());
        let expected = number_after("simulated seconds", text) / 3.0 + 1.0;
        assert!((film.seconds - expected).abs() < 0.1, "{name}: {} s, {expected} s expected", film.seconds);
        let (size, screens, seconds) = decoded_gif(&out.join(name.replace(".png", ".gif")));
        assert_eq!((size, screens.len()), ([48, 30], film.frames.len()));
        assert!((seconds - film.seconds).abs() < 0.02, "{name}: {seconds} s as a GIF, {} s as a PNG", film.seconds);
    }
}

/// The part of the printed text about a piece.
fn part<'a>(printed: &'a str, of: &str) -> &'a str {
    let from = printed.find(&format!("\n{of}: ")).unwrap_or_else(|| panic!("no `{of}` in\n{printed}"));
    let rest = &printed[from + 1..];
    rest.match_indices('\n').nth(1).map_or(rest, |(end, _)| &rest[..end])
}

/// The rows of the caption in a picture of 240 × 150.
fn band(screen: &[u8]) -> &[u8] {
    &screen[3 * 240 * (150 - 27)..]
}

/// The ledger of a run and the pictures of the same run agree: in how often the model succeeds before and after, in why
/// the teacher steps in, and in the edit. The files can be decoded, move for as long as they should, and are captioned.
#[test]
fn a_learned_model_is_shown_as_it_was_run() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), small::physics(r#"["situ"]"#)).unwrap();
    let same =
        ["--protocol", "small.toml", "--variation", "cover", "--method", "situ", "--seed", "7", "--plant", "hand"];
    let run = program(&[&["run", "--task", "sort_blocks", "--out", "runs"], &same[..]].concat(), folder.path());
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let small = ["--width", "240", "--height", "150"];
    let show = |more: &[&str]| {
        let output = program(&[&["show", "sort_blocks"], &same[..], &small, more].concat(), folder.path());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let printed = show(&["--out", "pictures"]);

    let ledger = fs::read_to_string(folder.path().join("runs/ledger.jsonl")).unwrap();
    let record: Value = serde_json::from_str(ledger.lines().next().unwrap()).unwrap();
    let rate = |key: &str| format!("{}/{}", record[key]["successes"], record[key]["rollouts"]);
    let [before, after, original, retained] = ["before", "after", "original_rate", "retained"].map(rate);
    let said = format!(
        "the changed task before {before}, after {after}; the original one before {original}, after {retained}; \
         corrections 1"
    );
    assert!(printed.contains(&said), "{said}\n{printed}");
    let correction = &record["corrections"][0];
    let correction = format!("{}, edit: {}", correction["failure"].as_str().unwrap(), correction["edit_made"]);
    let [trigger, edit] = correction.split_once(", edit: ").map(|(trigger, edit)| [trigger, edit]).unwrap();
    let [failed, shown, corrected] = ["before", "correction 1", "after"].map(|piece| part(&printed, piece));
    assert!(shown.contains(trigger) && shown.contains(edit.trim_matches('"')), "{correction}\n{shown}");
    assert!(failed.contains("the goal holds: no") && !failed.contains("cover"), "{failed}");
    assert!(corrected.contains("after: cover_grasp, cover_place"), "{corrected}");

    let out = folder.path().join("pictures");
    let stem = "sort_blocks-cover-situ-expert-7";
    let pieces = ["before", "correction-1", "after"];
    let expected =
        pieces.iter().flat_map(|piece| ["-strip.png", ".png", ".gif"].map(|end| format!("{stem}-{piece}{end}")));
    let mut expected: Vec<String> = expected.collect();
    expected.sort();
    assert_eq!(names(&out), expected);
    for (piece, text) in pieces.iter().zip([failed, shown, corrected]) {
        let film = decoded(&out.join(format!("{stem}-{piece}.png")));
        let (size, screens, seconds) = decoded_gif(&out.join(format!("{stem}-{piece}.gif")));
        assert_eq!((film.size, size, screens.len()), ([240, 150], [240, 150], film.frames.len()));
        let expected = number_after("simulated seconds", text) / 3.0 + 1.0;
        for seconds in [film.seconds, seconds] {
            assert!((seconds - expected).abs() < 0.1, "{piece}: {seconds} s, {expected} s expected");
        }
        let bands: Vec<&[u8]> = screens.iter().map(|screen| band(screen)).collect();
        let is_ink = |band: &&[u8]| band.chunks_exact(3).filter(|pixel| pixel[0] > 200).count() > 40;
        assert!(bands.iter().all(is_ink), "{piece}: every picture has a caption");
        let mut different = bands.clone();
        different.sort();
        different.dedup();
        assert!(different.len() > 20, "{piece}: captions tell the time and what is under way");
        assert_ne!(screens[0][..3 * 240 * 120], screens[screens.len() / 2][..3 * 240 * 120], "{piece} moves");
    }
}

/// Without captions, the world is where they would be.
#[test]
fn a_demonstration_has_the_captions_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let shown = |more: &[&str]| {
        let words = ["show", "press", "--plant", "hand", "--width", "240", "--height", "150"];
        let output = program(&[&words, more].concat(), folder.path());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let (_, screens, _) = decoded_gif(&folder.path().join("pictures/press-demonstration.gif"));
        let is_dark = |pixel: &&[u8]| pixel.iter().all(|part| *part < 60);
        let dark = screens.iter().map(|screen| band(screen).chunks_exact(3).filter(is_dark).count());
        (dark.min().unwrap(), String::from_utf8(output.stdout).unwrap())
    };
    let ((plain, said), (captioned, seen)) = (shown(&[]), shown(&["--captions"]));
    assert!(plain < 1000 && captioned > 4000, "{plain} and {captioned} dark pixels in the band");
    assert!(!said.contains("seen from") && seen.contains("seen from"), "{seen}");
}

#[test]
fn where_nothing_fails_it_is_said_and_the_success_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), small::physics(r#"["situ"]"#)).unwrap();
    let words = ["show", "sort_blocks/low_bins", "--method", "situ", "--protocol", "small.toml", "--plant", "hand"];
    let output = program(&[&words[..], &["--width", "48", "--height", "30"]].concat(), folder.path());
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(printed.contains("Nothing fails in 2 rollouts, so nothing is corrected."), "{printed}");
    assert!(part(&printed, "not corrected").contains("the goal holds: yes"), "{printed}");
    let stem = "sort_blocks-low_bins-situ-expert-1-success";
    let expected = ["-strip.png", ".gif", ".png"].map(|end| format!("{stem}{end}"));
    assert_eq!(names(&folder.path().join("pictures")), expected);
}

#[test]
fn a_folder_is_not_replaced_and_then_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("out/press-strip.png")).unwrap();
    let words = ["show", "press", "--plant", "hand", "--width", "48", "--height", "30"];
    let output = program(&[&words[..], &["--out", "out"]].concat(), folder.path());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("press-strip.png: a folder, expected a file or a new name"), "{error}");
    assert_eq!(names(&folder.path().join("out")), ["press-strip.png"]);
    // A file is no folder to write to.
    fs::write(folder.path().join("file"), "precious").unwrap();
    let output = program(&[&words[..], &["--out", "file"]].concat(), folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_to_string(folder.path().join("file")).unwrap(), "precious");
}

#[test]
fn names_that_nothing_has_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &[&str]); 11] = [
        (&["sort_blocks/flood"], &["flood", "cover", "bump", "high_bins", "low_bins"]),
        (&["iron"], &["iron", "pour", "sort_blocks"]),
        (&["pour", "--teacher", "wizard"], &["wizard", "expert", "novice"]),
        (&["pour", "--failure"], &["--failure", "TASK/VARIATION", "lid", "bump"]),
        (&["pour/lid", "--variation", "bump"], &["--variation bump", "pour/lid"]),
        (&["pour", "--method", "situ"], &["--method", "`pour`", "TASK/VARIATION", "lid"]),
        (&["pour/lid", "--method", "magic"], &["magic", "situ", "rebuild"]),
        (&["pour/lid", "--method", "no_update"], &["no_update", "takes no corrections", "situ"]),
        (&["pour/lid", "--method", "situ", "--failure"], &["--failure", "--method"]),
        (&["pour/lid", "--protocol", "quick"], &["--method"]),
        (&["pour/lid", "--method", "situ", "--protocol", "no_such"], &["no_such", "quick"]),
    ];
    for (words, said) in cases {
        let output = program(&[&["show"], words].concat(), folder.path());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(said.iter().all(|word| error.contains(word)), "{error}");
        assert!(names(folder.path()).is_empty());
    }
}

/// An interrupt in the middle of the teaching ends it, and the folder that was made for the pictures is gone.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/pictures");
    let mut show = Command::new(env!("CARGO_BIN_EXE_situ-bench"))
        .args(["show", "scoop/cover", "--method", "situ", "--out", "deep/pictures"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    while !out.exists() {
        assert!(show.try_wait().unwrap().is_none(), "it has not begun");
        std::thread::yield_now();
    }
    // It takes far longer than this, and by now it listens.
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(Command::new("kill").args(["-INT", &show.id().to_string()]).status().unwrap().success());
    assert_eq!(show.wait().unwrap().code(), Some(130));
    assert!(names(folder.path()).is_empty());
}
