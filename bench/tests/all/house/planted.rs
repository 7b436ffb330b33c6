//! Small workspaces with one fault each: every rule finds its own.

use crate::house::figures::{Figures, figures, twin_names};
use crate::house::lines::read;
use crate::house::tree::House;

fn house(files: &[(&str, &str)]) -> House {
    House::of(files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect())
}

/// The figures of the crate `hut`.
fn hut(files: &[(&str, &str)]) -> Figures {
    let files: Vec<(String, &str)> = files.iter().map(|(path, text)| (format!("hut/{path}"), *text)).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (path.as_str(), *text)).collect();
    figures(&house(&files)).remove(0)
}

fn ties(files: &[(&str, &str)]) -> Vec<String> {
    hut(files).circles.into_iter().flat_map(|(_, ties)| ties).collect()
}

#[test]
fn two_files_that_know_each_other_are_a_circle() {
    let lib = ("src/lib.rs", "mod door;\nmod wall;\n");
    let door = ("src/door.rs", "use crate::wall::Wall;\npub struct Door(pub Wall);\n");
    let knowing = ("src/wall.rs", "pub struct Wall;\nfn opens() { let _: Option<super::door::Door> = None; }\n");
    let expected = ["hut/src/door.rs -> hut/src/wall.rs: Wall", "hut/src/wall.rs -> hut/src/door.rs: Door"];
    assert_eq!(ties(&[lib, door, knowing]), expected);
    assert!(ties(&[lib, door, ("src/wall.rs", "pub struct Wall;\n")]).is_empty());
}

#[test]
fn a_circle_is_seen_through_macros_globs_names_that_are_handed_on_and_main() {
    let lib = ("src/lib.rs", "mod roof;\nmod room;\npub use room::wall::Wall;\n");
    let room = ("src/room/mod.rs", "pub(crate) mod wall;\npub use wall::*;\n");
    let roof = ("src/roof.rs", "pub const SLOPE: f64 = 1.0;\nfn lie(wall: crate::Wall) {}\n");
    let wall = ("src/room/wall.rs", "pub struct Wall;\nfn say() { println!(\"{}\", crate::roof::SLOPE) }\n");
    let expected = ["hut/src/roof.rs -> hut/src/room/wall.rs: Wall", "hut/src/room/wall.rs -> hut/src/roof.rs: SLOPE"];
    assert_eq!(ties(&[lib, room, roof, wall]), expected);
    let by_room = ("src/roof.rs", "use crate::room::Wall as Plain;\npub const SLOPE: f64 = 1.0;\n");
    assert_eq!(ties(&[lib, room, by_room, wall]), expected);
    let by_glob = ("src/roof.rs", "use super::room::wall::{self, *};\npub const SLOPE: f64 = 1.0;\n");
    assert!(ties(&[lib, room, by_glob, wall])[0].starts_with("hut/src/roof.rs -> hut/src/room/wall.rs"));
    let main = ("src/main.rs", "mod roof;\nmod room;\n");
    assert_eq!(ties(&[main, room, by_room, wall]), expected);
}

#[test]
fn a_parent_and_its_child_are_a_circle_where_each_uses_the_other() {
    let child = ("src/room/wall.rs", "use super::Height;\npub struct Wall(pub Height);\n");
    let lib = ("src/lib.rs", "mod room;\n");
    let hands_on = ("src/room/mod.rs", "mod wall;\npub use wall::Wall;\npub struct Height;\n");
    assert!(ties(&[lib, hands_on, child]).is_empty());
    let takes = ("src/room/mod.rs", "mod wall;\nuse wall::Wall;\npub struct Height;\nstruct Room(Wall);\n");
    assert_eq!(ties(&[lib, takes, child]).len(), 2);
    let both = ("src/room/mod.rs", "mod wall;\npub use wall::Wall;\npub struct Height;\nstruct Room(Wall);\n");
    assert_eq!(ties(&[lib, both, child]).len(), 2);
    let by_path = ("src/room.rs", "mod wall;\npub struct Height;\nfn build() { wall::raise(); }\n");
    assert_eq!(ties(&[lib, by_path, child]).len(), 2);
}

#[test]
fn tests_make_no_circle() {
    let lib = ("src/lib.rs", "mod door;\nmod wall;\n");
    let door = ("src/door.rs", "use crate::wall::Wall;\npub struct Door(pub Wall);\n");
    let wall = ("src/wall.rs", "pub struct Wall;\n#[cfg(test)]\nmod tests { use crate::door::Door; }\n");
    assert!(ties(&[lib, door, wall]).is_empty());
}

#[test]
fn a_wide_comment_is_found_and_a_wide_text_is_not() {
    let wide = "x".repeat(118);
    let rust = format!(
        "// {wide}\nconst A: &str = \"// {wide}\";\nconst B: u8 = 1; /* {wide}\n{wide}xxx */\n/// {wide}\nconst C: u8 = 2;\n"
    );
    let found = hut(&[("src/lib.rs", ""), ("src/a.rs", &rust)]).comments;
    let at = |line: usize, columns: usize| format!("hut/src/a.rs:{line} ({columns} columns)");
    assert_eq!(found, [at(1, 121), at(3, 138), at(4, 124), at(5, 122)]);
    let toml = format!("a = \"# {wide}\"\n# {wide}\n");
    let prose = format!("| {wide}xxx |\n```\n{wide}xxx\n```\n{wide}xxx\n");
    let found = hut(&[("src/lib.rs", ""), ("a.toml", &toml), ("b.py", &format!("#{wide}xx")), ("c.md", &prose)]);
    assert_eq!(found.comments, ["hut/b.py:1 (121 columns)"]);
    assert_eq!(found.prose, ["hut/c.md:5 (121 columns)"]);
}

#[test]
fn a_line_is_code_or_a_comment_or_both_or_neither() {
    let text = "//! a\n\nlet a = '\"'; // b\nlet b: &'a str = r#\"\n// no\n\"#;\nlet c = '\\''; let d = b'/';\n/* /* */\n*/ x\n";
    let seen: Vec<(bool, bool)> = read("a.rs", text).iter().map(|line| (line.code, line.comment)).collect();
    let code = (true, false);
    let comment = (false, true);
    assert_eq!(seen, [comment, (false, false), (true, true), code, code, code, code, comment, (true, true)]);
}

#[test]
fn lines_of_code_are_counted_without_tests_and_comments() {
    let text = "/// A.\npub fn a() {\n\n    // b\n}\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n";
    let found = hut(&[("src/lib.rs", text), ("tests/a.rs", "fn a() {}\n")]);
    assert_eq!((found.code, found.files), (2, 1));
}

#[test]
fn a_long_function_is_found_and_one_of_tests_apart() {
    let function = |lines: usize| format!("fn f() {{\n{}}}\n", "a();\n".repeat(lines - 2));
    let method = format!("struct A;\nimpl A {{\n#[inline]\n{}}}\n", function(61));
    let (fits, long) = (function(60), function(61));
    let tests = format!("#[cfg(test)]\nmod tests {{\n{long}}}\n");
    let found = hut(&[("src/lib.rs", "mod a;"), ("src/a.rs", &(fits + &method + &tests)), ("tests/b.rs", &long)]);
    assert_eq!(found.long, ["hut/src/a.rs:64 f (61 lines, 0 arguments)"]);
    assert_eq!(found.long_tests.len(), 2);
}

#[test]
fn seven_arguments_are_found_and_self_is_none() {
    let text = "trait T {\n fn a(&self, a: u8, b: u8, c: u8, d: u8, e: u8, f: u8);\n\
                fn b(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8);\n}\n";
    assert_eq!(hut(&[("src/lib.rs", text)]).wide, ["hut/src/lib.rs:3 b (1 lines, 7 arguments)"]);
}

#[test]
fn a_public_type_name_that_stands_twice_is_found_and_a_private_one_is_not() {
    let hut = "pub struct Door;\npub enum Wall {}\nstruct Roof;\n#[cfg(test)]\nmod tests { pub struct Floor; }\n";
    let barn = "mod inner { pub type Door = u8; }\npub trait Floor { type Wall; }\npub(crate) struct Wall;\npub struct Roof;\n";
    let found = twin_names(&house(&[("hut/src/lib.rs", hut), ("barn/src/lib.rs", barn), ("barn/tests/a.rs", hut)]));
    assert_eq!(found, ["Door: barn/src/lib.rs, hut/src/lib.rs"]);
}
