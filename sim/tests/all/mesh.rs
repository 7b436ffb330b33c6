//! Meshes: what is read of OBJ and STL files, what is refused, and whether a mesh behaves as the body that it shows.

use std::fmt::Write;

use situ_sim::{Mesh, MeshFormat, Pose, SimError, Snapshot, World};

use crate::common::{bits, block, standing};

/// The corners of a box of these half extents at a place, and its faces of four corners, from outside.
fn cuboid(half: [f64; 3], at: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[usize; 4]>) {
    let corner =
        |k: usize| [0, 1, 2].map(|axis| at[axis] + if (k >> axis) & 1 == 1 { half[axis] } else { -half[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), faces.to_vec())
}

/// An OBJ file of boxes, one group each, or all in one.
fn obj(boxes: &[([f64; 3], [f64; 3])], one_group: bool) -> String {
    let mut text = String::from("mtllib colours.mtl\n");
    let mut before = 0;
    for (index, (half, at)) in boxes.iter().enumerate() {
        if index == 0 || !one_group {
            writeln!(text, "g box_{index}").unwrap();
        }
        let (corners, faces) = cuboid(*half, *at);
        corners.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
        for face in faces {
            let [a, b, c, d] = face.map(|corner| 1 + before + corner);
            writeln!(text, "f {a} {b} {c} {d}").unwrap();
        }
        before += corners.len();
    }
    text
}

/// The triangles of a box.
fn triangles(half: [f64; 3], at: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let (corners, faces) = cuboid(half, at);
    let fan = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    faces.into_iter().flat_map(fan).map(|triangle| triangle.map(|corner| corners[corner])).collect()
}

fn ascii_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::from("solid box\n");
    for triangle in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        triangle.iter().for_each(|[x, y, z]| writeln!(text, "vertex {x} {y} {z}").unwrap());
        text.push_str("endloop\nendfacet\n");
    }
    (text + "endsolid box\n").into_bytes()
}

fn binary_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        let numbers = [0.0; 3].into_iter().chain(triangle.iter().flatten().copied());
        bytes.extend(numbers.flat_map(|number| (number as f32).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn mesh() -> Mesh {
    Mesh { file: "a.obj".to_owned(), scale: 1.0, tolerance: 0.001, density: 1000.0, friction: 0.6, parts: Vec::new() }
}

fn read(bytes: &[u8], format: MeshFormat) -> Result<Mesh, SimError> {
    let mut mesh = mesh();
    mesh.read(bytes, format)?;
    Ok(mesh)
}

const HALF: [f64; 3] = [0.03, 0.02, 0.01];

#[test]
fn each_way_to_write_a_box_is_the_box() {
    let boxed = triangles(HALF, [0.0; 3]);
    let mut in_millimetres = Mesh { scale: 0.001, ..mesh() };
    in_millimetres.read(obj(&[(HALF.map(|half| 1e3 * half), [0.0; 3])], false).as_bytes(), MeshFormat::Obj).unwrap();
    for mesh in [
        read(obj(&[(HALF, [0.0; 3])], false).as_bytes(), MeshFormat::Obj).unwrap(),
        read(&ascii_stl(&boxed), MeshFormat::Stl).unwrap(),
        read(&binary_stl(&boxed), MeshFormat::Stl).unwrap(),
        in_millimetres,
    ] {
        assert_eq!((mesh.parts.len(), mesh.parts[0].len()), (1, 8));
        let (mut world, mut other) = (World::new(), World::new());
        world.add(mesh.object("box"), standing(0.1, 0.0, 0.0105, 0.4)).unwrap();
        other.add(block("box", HALF, 1000.0, 0.6), standing(0.1, 0.0, 0.0105, 0.4)).unwrap();
        let outline = world.object("box").unwrap().outline;
        assert!((outline.top - HALF[2]).abs() < 1e-6 && (outline.reach - libm::hypot(HALF[0], HALF[1])).abs() < 1e-6);
        let masses = [&world, &other].map(|world| world.mass("box").unwrap());
        assert!((masses[0] / masses[1] - 1.0).abs() < 1e-4, "{masses:?}");
        for world in [&mut world, &mut other] {
            world.settle(1.0);
        }
        let (off, turned) = crate::common::apart(&world.pose("box").unwrap(), &other.pose("box").unwrap());
        assert!(off < 2e-4 && turned < 2e-3, "{off} m, {turned} rad");
    }
}

/// A box on edge, a ball in a trough of three groups: a hollow between groups stays one.
#[test]
fn groups_are_parts_of_their_own() {
    let walls = [
        ([0.06, 0.04, 0.005], [0.0, 0.0, 0.005]),
        ([0.005, 0.04, 0.03], [0.055, 0.0, 0.03]),
        ([0.005, 0.04, 0.03], [-0.055, 0.0, 0.03]),
    ];
    let trough = read(obj(&walls, false).as_bytes(), MeshFormat::Obj).unwrap();
    assert_eq!(trough.parts.len(), 3);
    let mut world = World::new();
    world.add(trough.object("trough").fixed(), standing(0.0, 0.0, 0.0, 0.0)).unwrap();
    world.add(block("cube", [0.02; 3], 1000.0, 0.6), standing(0.0, 0.0, 0.06, 0.3)).unwrap();
    world.settle(1.0);
    let low = world.pose("cube").unwrap().translation.z;
    assert!((low - 0.03).abs() < 1e-3, "it lies on the floor of the trough, and not at {low} m");
    let mut again =
        World::restore(&serde_json::from_str::<Snapshot>(&serde_json::to_string(&world.snapshot()).unwrap()).unwrap());
    for world in [&mut world, &mut again] {
        world.push("cube", [0.0, 0.05, 0.02], 0.3).unwrap();
        world.settle(0.6);
    }
    assert_eq!(bits(&world), bits(&again));
    // One group of all three is no convex body: its hull would be a plug.
    let error = read(obj(&walls, true).as_bytes(), MeshFormat::Obj).unwrap_err().to_string();
    assert!(error.contains("group `box_0`") && error.contains("inside the convex hull"), "{error}");
    let mut filled = Mesh { tolerance: 0.06, ..mesh() };
    filled.read(obj(&walls, true).as_bytes(), MeshFormat::Obj).unwrap();
    assert_eq!(filled.parts.len(), 1, "a plug, for those who say that they want one");
}

#[test]
fn what_is_no_mesh_is_refused() {
    let flat = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let far = obj(&[([3.0; 3], [0.0; 3])], false);
    let odd = obj(&[(HALF, [0.0; 3])], false).replacen("0.03", "nan", 1);
    for (bytes, format, expected) in [
        (&b""[..], MeshFormat::Obj, "at least one face"),
        (b"v 0 0 0\n", MeshFormat::Obj, "at least one face"),
        (b"v 0 0\nf 1 2 3\n", MeshFormat::Obj, "expected an OBJ file"),
        (b"f 7 8 9\n", MeshFormat::Obj, "expected an OBJ file"),
        (flat.as_bytes(), MeshFormat::Obj, "it is flat"),
        (far.as_bytes(), MeshFormat::Obj, "expected `scale`"),
        (odd.as_bytes(), MeshFormat::Obj, "expected"),
        (b"solid\nfacet", MeshFormat::Stl, "expected an STL file"),
        (&[0; 84], MeshFormat::Stl, "at least one face"),
        (&[255; 90], MeshFormat::Stl, "expected an STL file"),
    ] {
        let error = read(bytes, format).unwrap_err();
        assert!(matches!(error, SimError::Mesh { .. }) && error.to_string().contains(expected), "{expected}: {error}");
    }
    let unread = World::new().add(mesh().object("mesh"), Pose::identity()).unwrap_err();
    assert!(unread.to_string().contains("1 to 72 parts"), "{unread}");
    assert_eq!(
        ["a.obj", "b/A.STL", "c.ply", "obj"].map(MeshFormat::of),
        [Some(MeshFormat::Obj), Some(MeshFormat::Stl), None, None]
    );
}
