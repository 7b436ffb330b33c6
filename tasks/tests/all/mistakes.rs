//! A mistake in a task file is reported with file, line and key, and with what was expected.

use std::path::Path;

use situ_tasks::{Registry, Task, TaskError};

const POUR: &str = include_str!("../../library/pour.toml");
const DRAWER: &str = include_str!("../../library/drawer.toml");
const BALLS: &str = include_str!("../data/balls.toml");
const CHEST: &str = include_str!("../data/chest.toml");
const JAR: &str = include_str!("../data/jar.toml");

/// As [`reports_in`] of `pour.toml`.
#[track_caller]
fn reports(from: &str, to: &str, line_of: &str, key: &str, expected: &str) {
    reports_in(POUR, from, to, line_of, key, expected);
}

/// Parses a file with the first `from` replaced by `to`, and checks the report. `line_of` is a piece of the line that
/// must be named.
#[track_caller]
fn reports_in(file: &str, from: &str, to: &str, line_of: &str, key: &str, expected: &str) {
    assert!(file.contains(from), "the file has no `{from}`");
    let text = file.replacen(from, to, 1);
    let place = text.find(line_of).expect("the line that must be named");
    let wanted = 1 + text[..place].matches('\n').count();
    match Task::parse(&text, Path::new("folder/mine.toml")) {
        Err(error @ TaskError::File { .. }) => {
            let message = error.to_string();
            assert!(message.starts_with(&format!("folder/mine.toml:{wanted}: `{key}`: ")), "line {wanted}: {message}");
            assert!(message.contains(expected), "{expected}: {message}");
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("`{to}` was accepted"),
    }
}

#[test]
fn words_and_types() {
    reports("time_limit = 30.0", "time_limit = \"long\"", "time_limit", "time_limit", "expected f64");
    reports("time_limit = 30.0", "time_limit = 30.0\ncolour = 3", "colour", "colour", "unknown field `colour`");
    reports("[beads]\n", "[beads\n", "[beads", "[beads", "expected `]`");
    reports("radius = 0.0075", "radius = nan", "radius = nan", "beads.radius", "finite");
    reports("edit = \"node-addition\"", "edit = \"node\"", "edit = \"node\"", "variation[0].edit", "`node-addition`");
    reports("moment = \"before\"", "moment = \"later\"", "\"later\"", "variation[0].intervention[0].moment", "`guard`");
    reports("name = \"mat\"\nshape.mat", "name = \"mat\"\nshape.rug", "shape.rug", "object[0].shape.rug", "`mat`");
    reports("[[skill]]\nname = \"grasp\"\n", "[[skill]]\n", "[[skill]]", "skill[0]", "missing field `name`");
}

#[test]
fn names() {
    reports("name = \"pour\"", "name = \"Pour it\"", "Pour it", "name", "small letters");
    reports("name = \"bowl\"", "name = \"pitcher\"", "name = \"pitcher\"\ncolor", "object[2].name", "exists already");
    reports("name = \"bowl\"", "name = \"gripper\"", "name = \"gripper\"", "object[2].name", "reserved");
    reports(
        "reference = \"bowl\"",
        "reference = \"pot\"",
        "\"pot\"",
        "skill[1].reference",
        "expected one of bowl, mat, pitcher",
    );
    reports(
        "until = \"held(pitcher)\"",
        "until = \"holds(pitcher)\"",
        "\"holds(",
        "skill[0].until",
        "expected one of held(a)",
    );
    reports("until = \"held(pitcher)\"", "until = \"held(lid)\"", "held(lid)", "skill[0].until", "no object `lid`");
    reports(
        "until = \"held(pitcher)\"",
        "until = \"held(pitcher\"",
        "held(pitcher\"",
        "skill[0].until",
        "in column 13",
    );
    reports(
        "until = \"held(pitcher)\"",
        "until = \"on(pitcher, tabel)\"",
        "tabel",
        "skill[0].until",
        "expected `table` or one of bowl, mat, pitcher",
    );
    reports(
        "until = \"held(pitcher)\"",
        "until = \"at_least(2, held(pitcher), held(lid))\"",
        "at_least",
        "skill[0].until",
        "no object `lid`",
    );
    reports(
        "until = \"held(pitcher)\"",
        "until = \"at_least(2, held(pitcher))\"",
        "at_least",
        "skill[0].until",
        "expected a whole number from 1 to 1",
    );
    reports("    \"seen(lid)\"", "    \"seen(cap)\"", "seen(cap)", "observe[9]", "no object `cap`");
    reports(
        "container = \"pitcher\"",
        "container = \"mat\"",
        "container = \"mat\"",
        "beads.container",
        "is no container",
    );
    reports(
        "start = { on = \"pitcher\"",
        "start = { on = \"pot\"",
        "on = \"pot\"",
        "variation[0].object[0].start.on",
        "listed before",
    );
    reports(
        "[[\"grasp\", \"grasp\"]]",
        "[[\"grasp\", \"grab\"]]",
        "\"grab\"",
        "variation[1].accepts_edges[0]",
        "no skill `grab`",
    );
    reports(
        "name = \"vase\"",
        "name = \"bump\"",
        "name = \"bump\"\nedit = \"node-m",
        "variation[2].name",
        "exists already",
    );
    reports(
        "name = \"vase\"",
        "name = \"original\"",
        "name = \"original\"\nedit = \"node-m",
        "variation[2].name",
        "called so",
    );
}

#[test]
fn sequences() {
    let key = "sequence[0].variations";
    reports("[\"lid\", \"bump\", \"vase\"]", "[\"lid\"]", "[\"lid\"]", key, "at least two");
    let from = "variations = [\"lid\", \"bump\"";
    reports(
        from,
        "variations = [\"lid\", \"lid\"",
        "\"lid\", \"lid\"",
        "sequence[0].variations[1]",
        "expected a change",
    );
    reports(
        from,
        "variations = [\"original\", \"lid\"",
        "\"original\", \"lid\"",
        "sequence[0].variations[0]",
        "expected a change",
    );
    reports(
        from,
        "variations = [\"lid\", \"cap\"",
        "\"lid\", \"cap\"",
        "sequence[0].variations[1]",
        "one of lid, bump, vase, stand, original",
    );
    reports("name = \"kitchen\"", "name = \"The kitchen\"", "The kitchen", "sequence[0].name", "small letters");
}

#[test]
fn numbers() {
    reports("inner_radius = 0.040", "inner_radius = -0.04", "-0.04", "object[1].shape.cup.inner_radius", "more than 0");
    reports("sides = 16", "sides = 2", "sides = 2", "object[1].shape.cup.sides", "3 to 64 sides");
    reports("x = [-0.21, -0.11]", "x = [-0.11, -0.21]", "-0.11, -0.21", "object[1].start.x", "[least, largest]");
    reports("close = 30", "close = 3000", "close = 3000", "skill[0].keyframes[1].close", "at most 60 newtons");
    reports("open = 0.06 },", "open = 0.06, close = 3 },", "close = 3 ", "skill[0].keyframes[0].close", "not both");
    reports("hold = 1.0", "hold = -1.0", "hold = -1.0", "skill[1].keyframes[3].hold", "0 or more");
    reports("filled(bowl, 0.8), at", "filled(bowl, 80), at", "filled(bowl, 80)", "goal", "fraction from 0 to 1");
    reports("keyframe = 0", "keyframe = 7", "keyframe = 7", "variation[1].event[0].after.keyframe", "less than 3");
    reports("count = 30", "count = 0", "count = 0", "beads.count", "at least one bead");
}

#[test]
fn things_that_start_inside_each_other() {
    let bowl = "start = { x = [0.11, 0.21], y = [-0.05, 0.05], yaw = [-0.52, 0.52] }";
    reports(
        bowl,
        "start = { x = [-0.16, -0.16], y = [0.0, 0.0] }",
        "start = { x = [-0.16, -0.16], y = [0.0, 0.0] }\n[object.shape",
        "object[2].start",
        "inside each other",
    );
    reports("at = [-0.05, 0.0, 0.30]", "at = [-0.16, 0.0, 0.08]", "at = [-0.16", "gripper.at", "`pitcher` and `hand`");
}

#[test]
fn joints_and_guard() {
    let reports = |from: &str, to: &str, key: &str, expected: &str| reports_in(DRAWER, from, to, to, key, expected);
    reports("parent = \"cabinet\"", "parent = \"cupboard\"", "joint[0].parent", "expected one of block, cabinet");
    reports("parent = \"cabinet\"", "parent = \"block\"", "joint[0].parent", "listed before `drawer`");
    let fixed = DRAWER.replacen("name = \"drawer\"\nstart", "name = \"drawer\"\nfixed = true\nstart", 1);
    let marked = "object = \"drawer\" # this one";
    reports_in(&fixed, "object = \"drawer\"", marked, marked, "joint[0].object", "one that moves");
    reports("axis = [-1.0, 0.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "joint[0].axis", "a direction");
    reports("travel = 0.195", "travel = -0.195", "joint[0].travel", "more than 0");
    reports("friction = 3.0", "friction = -3.0", "joint[0].friction", "0 or more");
    reports("value = 0.03", "value = 0.3", "variation[4].joint[0].value", "expected 0 to 0.195");
    reports("damping = 120.0", "dampening = 120.0", "variation[1].joint[0].dampening", "unknown field");
    reports("rise = 60.0", "rise = 0.0", "guard.rise", "more than 0");
    reports("abort = 150.0", "abort = 50.0", "guard.abort", "at least `rise`, 60 newtons");
    reports("solver_iterations = 12", "solver_iterations = 0", "solver_iterations", "expected 1 to 64");
    reports("not(open(drawer, 0.02)), not(inside", "not(open(block, 0.02)), not(inside", "premise", "does not slide");
    reports(
        "not(open(drawer, 0.02)), not(inside",
        "not(open(drawer)), not(inside",
        "premise",
        "open(a, positive metres)",
    );
    reports("\"joint(drawer)\"", "\"joint(cabinet)\"", "observe[1]", "expected the object of a `[[joint]]`");
    let knob = "fin_z = 0.055\nknob = 3";
    reports_in(
        DRAWER,
        "fin_z = 0.055",
        knob,
        "knob = 3",
        "object[2].shape.drawer.knob",
        "unknown field `knob`, expected one of `inner`, `height`",
    );
    reports("base = 0.045", "base = -0.045", "object[1].shape.cabinet.base", "more than 0");
    // What the physics alone knows is reported, too.
    reports("[[joint]]", "[[joint]]\nspring = 1e9", "joint[0]", "a slide's spring must be");
    let second = "[[joint]]\nobject = \"drawer\" # again\nparent = \"cabinet\"\naxis = [0, 0, 1]\ntravel = 0.1\nfriction = 0\n\n[[skill]]";
    reports_in(DRAWER, "[[skill]]", second, "# again", "joint[1].object", "slides already");
}

#[test]
fn events() {
    let event = "variation[1].event[0]";
    let (push, by) = ("push = \"pitcher\"", "by = [0.0, 0.08, 0.0]");
    let pushed = &format!("{push}\n{by}");
    let key = |name: &str| format!("{event}.{name}");
    reports(push, "push = \"cat\"", "\"cat\"", &key("push"), "no object `cat`");
    reports(pushed, "drop = \"cat\"", "\"cat\"", &key("drop"), "no object `cat`");
    reports(pushed, push, push, &key("push"), "expected `by`");
    reports(pushed, by, by, &key("by"), "only beside `push`");
    reports(pushed, &format!("drop = \"pitcher\"\n{by}"), by, &key("by"), "only beside `push`");
    reports(by, &format!("{by}\ndrop = \"pitcher\""), "drop = ", &key("drop"), "not both");
    reports(pushed, "", "[[variation.event]]", event, "`push` with `by`, or `drop`");
    reports("seconds = 0.5", "seconds = -1.0", "seconds = -1.0", &key("seconds"), "more than 0");
}

#[test]
fn a_variation_changes_what_its_edit_says() {
    let declared = |variation: &str| format!("name = \"{variation}\"\nedit = \"");
    for (variation, edit, wrong, index, expected) in [
        ("lid", "node-addition", "node-modification", 0, "replace some of the original"),
        ("bump", "edge-addition", "node-addition", 1, "one skill of a new name"),
        ("vase", "node-modification", "none", 2, "no change of the skills"),
        ("stand", "none", "edge-addition", 3, "`accepts_edges`"),
    ] {
        let (from, to) = (declared(variation) + edit, declared(variation) + wrong);
        let line = to.clone();
        let text = POUR.replacen(&from, &to, 1);
        let key = format!("variation[{index}].edit");
        match Task::parse(&text, Path::new("f")) {
            Err(TaskError::File { line: found, key: at, expected: said, .. }) => {
                let place = text.find(&line).expect("the variation") + line.len();
                assert_eq!((found, at), (1 + text[..place].matches('\n').count(), key));
                assert!(said.contains(expected), "{said}");
            }
            other => panic!("{variation} as {wrong}: {other:?}"),
        }
    }
}

#[test]
fn unknown_names_list_the_known_ones() {
    let registry = Registry::builtin().expect("the library is sound");
    let message = registry.get("poor").expect_err("unknown").to_string();
    assert!(
        message.contains("`poor`")
            && message.contains("bread_box, clear_table, drawer, lunch, pour, press, scoop, sort_blocks, stack, tray"),
        "{message}"
    );
    let message = registry.get("pour").and_then(|task| task.variation(Some("cap"))).expect_err("unknown").to_string();
    assert!(message.contains("lid, bump, vase, stand"), "{message}");
}

#[test]
fn a_folder_of_tasks_is_added_and_names_must_differ() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("more_tasks");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("mine.toml"), POUR.replacen("name = \"pour\"", "name = \"mine\"", 1)).expect("written");
    let builtin = || Registry::builtin().expect("the library is sound");
    let registry = builtin().with_dir(&folder).expect("a task of another name");
    assert_eq!(
        registry.names().collect::<Vec<_>>(),
        [
            "bread_box",
            "clear_table",
            "drawer",
            "lunch",
            "mine",
            "pour",
            "press",
            "scoop",
            "sort_blocks",
            "stack",
            "tray"
        ]
    );
    assert!(builtin().with_dir(&folder.join("nowhere")).is_err_and(|error| error.to_string().contains("nowhere")));
    std::fs::write(folder.join("mine.toml"), POUR).expect("written");
    assert!(matches!(builtin().with_dir(&folder), Err(TaskError::DuplicateTask { name, .. }) if name == "pour"));
}

#[test]
fn roles_and_counts() {
    let balls = |from: &str, to: &str, line_of: &str, key: &str, expected: &str| {
        reports_in(BALLS, from, to, line_of, key, expected);
    };
    let done = "done = \"inside(it, bin)\"";
    balls(done, "done = \"inside(ball_1, bin)\"", "done = ", "role[0].done", "expected a condition about `it`");
    balls(done, "done = \"inside(it, pot)\"", "done = ", "role[0].done", "no object `pot`");
    balls(done, "done = \"near(it, ball, 0.1)\"", "done = ", "role[0].done", "`ball` is a role; expected `it`");
    balls("name = \"ball\"\n", "name = \"bin\"\n", "role = \"ball\"", "object[1].role", "no role `ball`; expected bin");
    balls(
        "role = \"ball\"\n",
        "role = \"cube\"\n",
        "role = \"cube\"",
        "object[1].role",
        "no role `cube`; expected ball",
    );
    balls("role = \"ball\"\n", "", "name = \"ball\"", "role[0].name", "no object has `role = \"ball\"`");
    balls("name = \"ball_1\"", "name = \"ball\"", "name = \"ball\"\ndone", "role[0].name", "is an object already");
    balls("name = \"ball_1\"", "name = \"it\"", "done = ", "role[0].done", "an object is called `it`");
    let premise = "all(each(ball, on(it, table))";
    balls(premise, "all(each(bal, on(it, table))", "premise", "premise", "no role `bal`");
    balls(premise, "all(each(ball, on(ball_1, table))", "premise", "premise", "expected a condition about `it`");
    balls(premise, "all(each(ball)", "premise", "premise", "expected `each(role, condition about it)`");
    balls("\"at_least(1, ", "\"at_least(2, ", "goal", "goal", "expected a whole number from 1 to 1");
    balls(
        "reference = \"ball\"",
        "reference = \"balls\"",
        "reference = \"balls\"",
        "skill[0].reference",
        "expected one of ball_1, bin, ball",
    );
}

#[test]
fn material_symmetry_and_perception() {
    let balls = |from: &str, to: &str, key: &str, expected: &str| reports_in(BALLS, from, to, "mass = ", key, expected);
    balls("mass = [0.7, 1.4]", "mass = [1.4, 0.7]", "object[1].start.mass", "[least, largest]");
    balls("mass = [0.7, 1.4]", "mass = [0.0, 0.7]", "object[1].start.mass", "factors above 0");
    balls("mass = [0.7, 1.4]", "mass = [0.7, 40.0]", "object[1].start.mass", "density must be");
    balls("friction = [0.8, 1.2]", "friction = [0.8, 20.0]", "object[1].start.friction", "friction must be 0 to 5");
    let fixed = "start = { x = [0.18, 0.22], y = [-0.02, 0.02] }";
    let mass = "start = { x = [0.18, 0.22], y = [-0.02, 0.02], mass = [0.5, 1.0] }";
    reports_in(BALLS, fixed, mass, "mass = [0.5", "object[0].start.mass", "is fixed and has no mass");
    let rolling = "rolling_friction = 2.0";
    reports_in(
        BALLS,
        "rolling_friction = 0.02",
        rolling,
        rolling,
        "object[1].shape",
        "rolling friction must be 0 to 1",
    );
    let jar = |from: &str, to: &str, key: &str, expected: &str| reports_in(JAR, from, to, to, key, expected);
    jar("symmetry = {}", "symmetry = { fold = 1 }", "object[1].symmetry", "2 to 360");
    jar("symmetry = {}", "symmetry = { axis = [0.0, 0.0, 0.0] }", "object[1].symmetry", "must not be zero");
    jar("position = 0.001", "position = 0.2", "perception.position", "expected a deviation of 0 to 0.1 metres");
    jar("rotation = 0.01", "rotation = -0.01", "perception.rotation", "expected a deviation of 0 to 0.5 radians");
    jar("eye = [0.0, -0.9, 0.8]", "eye = [0.0, -0.9, 0.0]", "perception.eye", "above the table");
    let nothing = JAR.replace("position = 0.001\nrotation = 0.01\n", "");
    let (from, to) = ("eye = [0.0, -0.9, 0.8]\n", "position = 0.0\n");
    reports_in(&nothing, from, to, "[perception]", "perception", "expected `position`, `rotation` or `eye`");
}

#[test]
fn hinges() {
    let chest = |from: &str, to: &str, line_of: &str, key: &str, expected: &str| {
        reports_in(CHEST, from, to, line_of, key, expected);
    };
    chest("travel = 1.8", "travel = 3.5", "[[hinge]]", "hinge[0]", "travel must be 0.01 to 3 rad");
    chest("travel = 1.8", "travel = 0.0", "travel", "hinge[0].travel", "more than 0");
    chest("travel = 1.8", "travel = 1.8\nvalue = 2.0", "value", "hinge[0].value", "expected 0 to 1.8");
    chest("friction = 0.08", "friction = -0.08", "friction = -0.08", "hinge[0].friction", "0 or more");
    chest("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "axis", "hinge[0].axis", "expected a direction");
    chest("parent = \"chest\"", "parent = \"lid\"", "parent = \"lid\"", "hinge[0].parent", "listed before");
    chest("parent = \"chest\"", "parent = \"box\"", "parent", "hinge[0].parent", "no object `box`");
    chest("\"angle(lid)\"", "\"angle(chest)\"", "angle(chest)", "observe[1]", "does not turn");
    chest(
        "until = \"turned(lid, 1.0)\"",
        "until = \"turned(chest, 1.0)\"",
        "turned(chest",
        "skill[0].until",
        "does not turn",
    );
    let twice = "[[hinge]]\nobject = \"lid\"\nparent = \"chest\"\nat = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\n\
                 travel = 1.0\nfriction = 0.1\n\n# The grasp";
    chest(
        "# The grasp",
        twice,
        "object = \"lid\"\nparent = \"chest\"\nat = [0.0, 0.0, 0.0]",
        "hinge[1].object",
        "turns already",
    );
    let slides = "[[joint]]\nobject = \"lid\"\nparent = \"chest\"\naxis = [1.0, 0.0, 0.0]\ntravel = 0.1\nfriction = 0.1\n\n[[hinge]]";
    chest(
        "[[hinge]]",
        slides,
        "object = \"lid\"\nparent = \"chest\"\nat",
        "hinge[0].object",
        "slides, by a `[[joint]]`",
    );
    let push = "[[event]]\nname = \"push\"\nafter = { reference = \"lid\", keyframe = 0 }\npush = \"lid\"\n\
                by = [0.1, 0.0, 0.0]\nseconds = 1.0\n\n[[variation]]";
    chest("[[variation]]", push, "push = \"lid\"", "event[0].push", "turns on a hinge");
}

#[test]
fn meshes() {
    let figure = include_str!("../data/figure.toml");
    let wrong = |to: &str, expected: &str| {
        reports_in(figure, "file = \"figure.obj\"", to, to, "object[1].shape.mesh.file", expected);
    };
    wrong("file = \"figure.ply\"", "ends in .obj or .stl");
    wrong("file = \"../figure.obj\"", "in the folder of this one");
    wrong("file = \"/figure.obj\"", "in the folder of this one");
    wrong("file = \"figure.obj\"", "cannot read folder/figure.obj");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let read = |from: &str, to: &str| {
        Task::parse(&figure.replacen(from, to, 1), &folder.join("figure.toml")).map_err(|error| error.to_string())
    };
    assert!(read("", "").is_ok());
    let far = read("scale = 0.001", "scale = 1.0").expect_err("30 m");
    assert!(far.contains("figure.toml:20: `object[1].shape.mesh.file`: ") && far.contains("expected `scale`"), "{far}");
    let loose = read("scale = 0.001", "scale = 0.001, tolerance = 0.2").expect_err("too loose");
    assert!(loose.contains("expected at most 0.1 m"), "{loose}");
}
