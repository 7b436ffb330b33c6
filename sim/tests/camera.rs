//! Pictures show what is there, where it is, in its colour; files can be read back.

mod common;

use common::standing;
use situ_sim::{Beads, Camera, Cup, Image, Object, SimError, World, write_apng};

/// Whether a pixel is a shade of a colour: the same proportions, neither black nor brighter.
fn is_shade(pixel: [u8; 3], color: [u8; 3]) -> bool {
    let light = f64::from(pixel[0]) / f64::from(color[0]);
    let same = (0..3).all(|c| (f64::from(pixel[c]) - light * f64::from(color[c])).abs() <= 3.0);
    same && (0.3..=1.01).contains(&light)
}

fn from_above() -> Camera {
    Camera { eye: [0.0, 0.0, 1.0], target: [0.0, 0.0, 0.0], fov: 0.6 }
}

fn scene() -> World {
    let mut world = World::new();
    world.place_gripper(standing(-1.0, 0.0, 0.3, 0.0), 0.05);
    let cube = Object::block("cube", [0.03; 3], 1000.0, 0.5).with_color([200, 40, 60]);
    world.add(cube, standing(0.15, 0.10, 0.03, 0.0)).unwrap();
    world.add(Object::cup("bowl", &Cup::BOWL, None).with_color([60, 180, 40]), standing(-0.15, 0.0, 0.0, 0.0)).unwrap();
    world
}

/// Column and row of a point at height z for the camera above, looking down with +y up in the picture.
fn seen_from_above(point: [f64; 3], size: f64) -> (u32, u32) {
    let scale = 0.5 * size / libm::tan(0.3) / (1.0 - point[2]);
    ((0.5 * size + scale * point[0]) as u32, (0.5 * size - scale * point[1]) as u32)
}

#[test]
fn objects_have_their_colours_where_they_are() {
    let mut world = scene();
    let at = |image: &Image, point| {
        let (column, row) = seen_from_above(point, 240.0);
        image.pixel(column, row).unwrap()
    };
    // Also before the first step, when the engine itself has no tree yet.
    let image = from_above().render(&world, 240, 240);
    assert!(is_shade(at(&image, [0.15, 0.10, 0.06]), [200, 40, 60]));
    assert!(is_shade(at(&image, [0.14, 0.09, 0.06]), [200, 40, 60]));
    assert!(is_shade(at(&image, [-0.15, 0.0, 0.005]), [60, 180, 40]));
    let table = at(&image, [0.0, -0.2, 0.0]);
    assert!(!is_shade(table, [200, 40, 60]) && !is_shade(table, [60, 180, 40]));
    assert_ne!(at(&image, [0.025, -0.225, 0.0]), at(&image, [0.075, -0.225, 0.0]), "checks");

    // Beads cover the middle of the bowl's floor, and the cube is gone from where it was pushed away.
    world.fill("bowl", &Beads::new(60)).unwrap();
    world.push("cube", [0.0, -0.2, 0.0], 0.5).unwrap();
    world.settle(0.6);
    let image = from_above().render(&world, 240, 240);
    let bead = world.beads().into_iter().max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
    let color = at(&image, [bead[0], bead[1], bead[2] + 0.006]);
    assert!(!is_shade(color, [60, 180, 40]) && color[0] > color[2], "a bead, not the bowl: {color:?}");
    assert!(is_shade(at(&image, [0.15, -0.10, 0.06]), [200, 40, 60]));
    assert!(!is_shade(at(&image, [0.15, 0.10, 0.0]), [200, 40, 60]));
}

#[test]
fn pictures_are_written_and_read_back() {
    let world = scene();
    let image = Camera::default().render(&world, 64, 40);
    let strip = Image::beside(&[image.clone(), Image::plain(10, 20, [1, 2, 3])]);
    assert_eq!((strip.width, strip.height), (64 + 4 + 10, 40));
    assert_eq!(strip.pixel(5, 7), image.pixel(5, 7));
    assert_eq!(strip.pixel(68, 19), Some([1, 2, 3]));
    assert_eq!((strip.pixel(68, 20), strip.pixel(78, 0)), (Some([255; 3]), None));

    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join("strip.png");
    strip.write_png(&path).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels, strip.rgb);

    let film = folder.join("film.png");
    write_apng(&film, &[image.clone(), Image::plain(64, 40, [9; 3]), image.clone()], 100).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&film).unwrap())).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    for expected in [&image, &Image::plain(64, 40, [9; 3]), &image] {
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, expected.rgb);
    }

    let differing = write_apng(&film, &[image, strip], 100);
    assert!(matches!(differing, Err(SimError::Picture { reason, .. }) if reason.contains("size")));
    assert!(matches!(write_apng(&film, &[], 100), Err(SimError::Picture { .. })));
    let nowhere = Image::plain(1, 1, [0; 3]).write_png(folder.join("no/such/folder.png"));
    assert!(matches!(nowhere, Err(SimError::Picture { path, .. }) if path.contains("folder.png")));
}
