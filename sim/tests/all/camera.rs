//! Pictures show what is there, where it is, in its colour. Their files can be read back.

use crate::common::{BOWL, block, standing};
use situ_sim::{Beads, Camera, FRONT, Film, HAND, Image, Sight, SimError, World};

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
    let cube = block("cube", [0.03; 3], 1000.0, 0.5).with_color([200, 40, 60]);
    world.add(cube, standing(0.15, 0.10, 0.03, 0.0)).unwrap();
    world.add(BOWL.object("bowl").with_color([60, 180, 40]), standing(-0.15, 0.0, 0.0, 0.0)).unwrap();
    world
}

/// Column and row of a point at height z for the camera above, which looks down with +y up in the picture.
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
    // This holds also before the first step, when the engine itself has no tree yet.
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
fn pictures_are_encoded_and_read_back() {
    let world = scene();
    let image = Camera::default().render(&world, 64, 40);
    let strip = Image::beside(&[image.clone(), Image::plain(10, 20, [1, 2, 3])]);
    assert_eq!((strip.width, strip.height), (64 + 4 + 10, 40));
    assert_eq!(strip.pixel(5, 7), image.pixel(5, 7));
    assert_eq!(strip.pixel(68, 19), Some([1, 2, 3]));
    assert_eq!((strip.pixel(68, 20), strip.pixel(78, 0)), (Some([255; 3]), None));

    let column = Image::below(&[image.clone(), strip.clone()]);
    assert_eq!((column.width, column.height), (78, 40 + 4 + 40));
    assert_eq!((column.pixel(5, 7), column.pixel(68, 44 + 19)), (image.pixel(5, 7), Some([1, 2, 3])));

    let (mut reader, mut pixels) = decoded(&strip.png().unwrap());
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels, strip.rgb);
    assert!(matches!(Image::plain(0, 4, [0; 3]).png(), Err(SimError::Picture { .. })));
}

/// A reader of a PNG, and room for its largest frame.
fn decoded(bytes: &[u8]) -> (png::Reader<std::io::Cursor<Vec<u8>>>, Vec<u8>) {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes.to_vec())).read_info().unwrap();
    let room = vec![0; reader.output_buffer_size().unwrap()];
    (reader, room)
}

/// Puts each frame of a film in its place, where it is not transparent. Returns what is then seen, and for how long.
fn shown(bytes: &[u8]) -> Vec<(Image, u16)> {
    let (mut reader, mut pixels) = decoded(bytes);
    let mut image = Image::plain(reader.info().width, reader.info().height, [0; 3]);
    let frames = reader.info().animation_control().unwrap().num_frames;
    let frame = |_| {
        reader.next_frame(&mut pixels).unwrap();
        let control = *reader.info().frame_control().unwrap();
        let samples = reader.info().color_type.samples();
        let count = (control.width * control.height) as usize;
        for (place, pixel) in (0..).zip(pixels.chunks_exact(samples).take(count)) {
            let (x, y) = (control.x_offset + place % control.width, control.y_offset + place / control.width);
            if pixel.get(3) != Some(&0) {
                let at = 3 * (y * image.width + x) as usize;
                image.rgb[at..at + 3].copy_from_slice(&pixel[..3]);
            }
        }
        (image.clone(), control.delay_num)
    };
    (0..frames).map(frame).collect()
}

#[test]
fn a_film_shows_its_pictures() {
    let mut dot = Image::plain(64, 40, [9; 3]);
    dot.rgb[3 * (7 * 64 + 5)] = 200;
    let pictures = [Camera::default().render(&scene(), 64, 40), Image::plain(64, 40, [9; 3]), dot];
    let order = [0, 1, 1, 1, 2, 0];
    let mut film = Film::new([1, 24]);
    assert!(matches!(film.png(), Err(SimError::Picture { .. })));
    order.iter().for_each(|&index| film.push(pictures[index].clone()).unwrap());
    let refused = film.push(Image::plain(64, 41, [0; 3]));
    assert!(matches!(refused, Err(SimError::Picture { reason }) if reason.contains("size")));
    film.rest(48);
    // Pictures that stand still are one frame, shown for longer.
    let expected =
        [(0, 1), (1, 3), (2, 1), (0, 49)].map(|(index, times): (usize, u16)| (pictures[index].clone(), times));
    assert_eq!(film.frames(), expected.len());
    assert_eq!(shown(&film.png().unwrap()), expected);
    let sparse = film.sparse_png().unwrap();
    assert_eq!(shown(&sparse), expected);
    assert!((film.seconds() - 54.0 / 24.0).abs() < 1e-12);
}

/// Puts each frame of a GIF in its place. Returns what is then seen, and for how many hundredths of a second.
fn shown_as_gif(bytes: &[u8]) -> Vec<(Image, u16)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(bytes).unwrap();
    let mut image = Image::plain(reader.width().into(), reader.height().into(), [0; 3]);
    assert_eq!(reader.repeat(), gif::Repeat::Infinite);
    let mut frames = Vec::new();
    while let Some(frame) = reader.read_next_frame().unwrap() {
        for (place, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let (column, row) = (place % usize::from(frame.width), place / usize::from(frame.width));
            let (x, y) = (column + usize::from(frame.left), row + usize::from(frame.top));
            let at = 3 * (y * image.width as usize + x);
            image.rgb[at..at + 3].copy_from_slice(&pixel[..3]);
        }
        frames.push((image.clone(), frame.delay));
    }
    frames
}

/// The decoder shares no code with the encoder but the format. The colours are nearly right, the times exactly: the
/// nearest hundredth from the beginning on, whatever the rate.
#[test]
fn a_film_is_a_gif_as_well() {
    let mut world = scene();
    let mut film = Film::new([7, 90]);
    assert!(matches!(film.gif(), Err(SimError::Picture { .. })));
    let mut pictures = Vec::new();
    for _ in 0..12 {
        let picture = Camera::default().render(&world, 96, 60);
        (0..2).for_each(|_| film.push(picture.clone()).unwrap());
        pictures.push(picture);
        world.push("cube", [0.0, -0.015, 0.0], 0.1).unwrap();
        world.settle(0.2);
    }
    let bytes = film.gif().unwrap();
    assert_eq!(bytes, film.gif().unwrap(), "the same bytes");
    let shown = shown_as_gif(&bytes);
    assert_eq!(shown.len(), film.frames());
    let mut ends = 0;
    for (index, ((image, delay), picture)) in shown.iter().zip(&pictures).enumerate() {
        ends += u64::from(*delay);
        assert_eq!(ends as f64, (100.0 * 7.0 / 90.0 * 2.0 * (index + 1) as f64).round());
        let off: Vec<u8> = image.rgb.iter().zip(&picture.rgb).map(|(one, other)| one.abs_diff(*other)).collect();
        let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / off.len() as f64;
        assert!(mean < 2.0 && off.iter().all(|off| *off < 48), "picture {index}: {mean}, {:?}", off.iter().max());
    }
    assert!(matches!(lone(Image::plain(0, 4, [0; 3])).gif(), Err(SimError::Picture { .. })));
    assert_eq!(shown_as_gif(&lone(Image::plain(3, 2, [9; 3])).gif().unwrap()).len(), 1);
}

/// A film of one picture.
fn lone(image: Image) -> Film {
    let mut film = Film::new([1, 24]);
    film.push(image).unwrap();
    film
}

/// A wall stands in front of a cube, and beside another.
#[test]
fn what_something_else_hides_is_not_seen() {
    let mut world = World::new();
    world.place_gripper(standing(0.0, 0.0, 0.8, 0.0), 0.05);
    world.add(block("cube", [0.02; 3], 1000.0, 0.5), standing(0.0, 0.1, 0.02, 0.0)).unwrap();
    world.add(block("other", [0.02; 3], 1000.0, 0.5), standing(0.3, 0.1, 0.02, 0.0)).unwrap();
    world.add(block("wall", [0.1, 0.01, 0.1], 1000.0, 0.5), standing(0.0, 0.0, 0.1, 0.0)).unwrap();
    let from = |eye: [f64; 3]| {
        let camera = Camera { eye, target: [0.0, 0.1, 0.02], fov: 0.6 };
        camera.sight(&world, &["cube", "other", "wall", HAND, "nothing"])
    };
    let [cube, other, wall, hand, nothing] = from([0.0, -1.0, 0.1])[..] else { panic!("five things") };
    assert_eq!((cube.seen, cube.part()), (0, Some(0.0)));
    assert!([other, wall, hand].iter().all(|sight| sight.part() == Some(1.0)), "{other:?} {wall:?} {hand:?}");
    assert_eq!((nothing, nothing.part()), (Sight::default(), None));
    // From the side the cube is free, and from where the wall's edge is before it, half of it is.
    assert_eq!(from([1.0, 0.1, 0.5])[0].part(), Some(1.0));
    let half = from([-1.0, -0.9, 0.1])[0].part().unwrap();
    assert!((0.2..0.8).contains(&half), "{half}");
}

#[test]
fn a_camera_set_up_around_boxes_sees_them_all_and_is_as_near_as_that_allows() {
    // Small red cubes stand at the corners of a box, and there is nothing else. All of them are in the picture, and
    // none is cut off.
    let bounds = [[-0.3, -0.1, 0.0], [0.1, 0.25, 0.3]];
    for (width, height) in [(300, 200), (120, 240)] {
        let camera = Camera::around(&[bounds], FRONT, f64::from(width) / f64::from(height));
        let mut world = World::new();
        world.place_gripper(standing(-3.0, 0.0, 0.3, 0.0), 0.05);
        let mut seen = 0;
        for corner in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| bounds[(corner >> axis) & 1][axis]);
            let cube = block(format!("cube {corner}"), [0.004; 3], 1000.0, 0.5).with_color([250, 0, 0]);
            let mut world = world.clone();
            world.add(cube, standing(x, y, z.max(0.004), 0.0)).unwrap();
            let image = camera.render(&world, width, height);
            let red = |x: u32, y: u32| image.pixel(x, y).is_some_and(|[r, g, _]| r > 60 && g < 30);
            let reds: Vec<(u32, u32)> =
                (0..width).flat_map(|x| (0..height).map(move |y| (x, y))).filter(|&(x, y)| red(x, y)).collect();
            assert!(!reds.is_empty(), "corner {corner} is not in the picture");
            assert!(reds.iter().all(|&(x, y)| x > 0 && y > 0 && x + 1 < width && y + 1 < height));
            let edge = 0.06;
            let near = |at: u32, size: u32| f64::from(at.min(size - at)) < edge * f64::from(size);
            seen += usize::from(reds.iter().any(|&(x, y)| near(x, width) || near(y, height)));
        }
        assert!(seen >= 2, "{seen} corners are near an edge of the picture of {width} × {height}");
    }
    assert_eq!(Camera::around(&[], FRONT, 1.5), Camera::default());
}
