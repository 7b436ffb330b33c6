//! `show`: its files are pictures of the wanted size, the film moves, and a name that nothing has is refused.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Output};

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
    assert_eq!(names(&out), [&demonstration, &moments, &failure, &start, &strip].map(String::as_str));

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
        assert!((film.seconds - expected).abs() < 0.5, "{name}: {} s, {expected} s expected", film.seconds);
    }
}

#[test]
fn names_that_nothing_has_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &[&str]); 4] = [
        (&["sort_blocks/flood"], &["flood", "cover", "bump", "high_bins", "low_bins"]),
        (&["iron"], &["iron", "pour", "sort_blocks"]),
        (&["pour", "--teacher", "wizard"], &["wizard", "expert", "novice"]),
        (&["pour", "--failure"], &["--failure", "TASK/VARIATION"]),
    ];
    for (words, said) in cases {
        let output = program(&[&["show"], words].concat(), folder.path());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(said.iter().all(|word| error.contains(word)), "{error}");
        assert!(names(folder.path()).is_empty());
    }
}
