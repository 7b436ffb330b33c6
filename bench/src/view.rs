//! From where a performance is looked at: the viewpoint from which the least of what matters is hidden.

use nalgebra::{Rotation3, Vector3};
use situ_sim::{Camera, FRONT, HAND, World};
use situ_tasks::Setting;

use crate::track::Track;

/// A viewpoint: its name, how far it is turned about the table from the front, degrees, counter-clockwise seen from
/// above, and how high it is beside that of the front.
struct Viewpoint {
    name: &'static str,
    turn: f64,
    rise: f64,
}

/// The viewpoints, the most usual first. Higher ones see into what has walls, and less of what stands in a row. None is
/// behind the table, where the arm would stand before all else.
const VIEWPOINTS: [Viewpoint; 8] = [
    Viewpoint { name: "from the front", turn: 0.0, rise: 1.0 },
    Viewpoint { name: "from the right", turn: 35.0, rise: 1.0 },
    Viewpoint { name: "from the left", turn: -35.0, rise: 1.0 },
    Viewpoint { name: "from the front and high", turn: 0.0, rise: 2.0 },
    Viewpoint { name: "from the far right", turn: 70.0, rise: 1.0 },
    Viewpoint { name: "from the far left", turn: -70.0, rise: 1.0 },
    Viewpoint { name: "from the right and high", turn: 35.0, rise: 2.0 },
    Viewpoint { name: "from the left and high", turn: -35.0, rise: 2.0 },
];

/// A view hides no more than another where it shows less by at most this part: nobody would see the difference.
const SAME: f64 = 0.01;

impl Viewpoint {
    /// The direction from the table to the camera.
    fn direction(&self) -> [f64; 3] {
        let [x, y, z] = FRONT;
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), self.turn.to_radians()) * Vector3::new(x, y, 0.0);
        [turned.x, turned.y, z * self.rise]
    }
}

/// A camera, and what its view is called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraView {
    /// The camera.
    pub camera: Camera,
    /// The name of its viewpoint.
    pub name: &'static str,
}

impl CameraView {
    /// The view from the front. `aspect` is the picture's width over its height.
    pub fn front(tracks: &[&Track], aspect: f64) -> Self {
        Self::of(&VIEWPOINTS[0], tracks, aspect)
    }

    /// The view from which most is seen of these things, on the average over the things and over the performances'
    /// moments. Of views that are as good as each other, it is the most usual. `hand` is the name of the gripper.
    pub fn clearest(tracks: &[&Track], things: &[&str], aspect: f64) -> Self {
        let moments = || tracks.iter().flat_map(|track| track.samples());
        let views = VIEWPOINTS.map(|viewpoint| {
            let view = Self::of(&viewpoint, tracks, aspect);
            (view, seen(&view.camera, moments(), things))
        });
        let most = views.iter().map(|(_, seen)| *seen).fold(0.0, f64::max);
        views.into_iter().find(|(_, seen)| *seen >= most - SAME).map(|(view, _)| view).expect("one of them is the best")
    }

    fn of(viewpoint: &Viewpoint, tracks: &[&Track], aspect: f64) -> Self {
        let boxes: Vec<_> = tracks.iter().flat_map(|track| track.boxes()).copied().collect();
        Self { camera: Camera::around(&boxes, viewpoint.direction(), aspect), name: viewpoint.name }
    }
}

/// The part of these things that is seen, on the average over them and over the moments.
fn seen<'a>(camera: &Camera, moments: impl Iterator<Item = &'a World>, things: &[&str]) -> f64 {
    let parts = moments.flat_map(|world| camera.sight(world, things)).filter_map(|sight| sight.part());
    let (sum, count) = parts.fold((0.0, 0), |(sum, count), part| (sum + part, count + 1));
    sum / f64::from(count.max(1))
}

/// The things that matter in a setting: the objects that its skills and those of the original task refer to, and the
/// gripper.
pub fn things(setting: &Setting) -> Vec<&str> {
    let mut things = Vec::new();
    for skill in setting.original_skills.iter().chain(&setting.skills) {
        if !things.contains(&skill.reference.as_str()) {
            things.push(&skill.reference);
        }
    }
    things.push(HAND);
    things
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Arc;

    use situ_tasks::{Episode, Plant, Registry};

    use super::*;

    /// A cube on the table, and a wall of this half size and at this place.
    fn episode(half: [f64; 3], [x, y]: [f64; 2]) -> Episode {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            r#"
name = "hidden"
analysis = "A wall stands beside a cube."
time_limit = 60.0
premise = "not(held(cube))"
goal = "held(cube)"
observe = ["opening()", "offset(gripper, cube)"]

[gripper]
at = [0.0, 0.0, 0.30]
open = 0.08

[[object]]
name = "cube"
shape.block = {{ half = [0.02, 0.02, 0.02], density = 1000, friction = 0.6 }}
color = [250, 0, 0]
start = {{ x = [0.0, 0.001], y = [0.0, 0.001], z = 0.02 }}

[[object]]
name = "wall"
shape.block = {{ half = {half:?}, density = 1000, friction = 0.6 }}
fixed = true
start = {{ x = [{x}, {x}], y = [{y}, {y}], z = {} }}

[[skill]]
name = "pick"
reference = "cube"
when = "not(held(cube))"
until = "held(cube)"
keyframes = [{{ at = [0.0, 0.0, 0.1], open = 0.08 }}]
"#,
            half[2]
        );
        fs::write(folder.path().join("hidden.toml"), text).unwrap();
        let registry = Registry::builtin().unwrap().with_dir(folder.path()).unwrap().with_plant(Plant::Hand);
        let setting: Arc<_> = registry.get("hidden").unwrap().variation(None).unwrap();
        Episode::start(&setting, 1).unwrap()
    }

    fn chosen(episode: &Episode) -> CameraView {
        let track = Track::new(episode);
        let view = CameraView::clearest(&[&track], &things(episode.setting()), 1.6);
        assert_eq!(view, CameraView::clearest(&[&track], &things(episode.setting()), 1.6), "the same again");
        view
    }

    #[test]
    fn a_view_that_hides_an_object_is_not_taken() {
        let part =
            |view: &CameraView, episode: &Episode| view.camera.sight(episode.world(), &["cube"])[0].part().unwrap();
        // Far behind the cube a wall hides nothing, and the usual view stays.
        let free = episode([0.1, 0.01, 0.05], [0.0, 0.2]);
        assert_eq!(things(free.setting()), ["cube", HAND]);
        assert_eq!(chosen(&free).name, "from the front");
        // In front of it, it hides the cube from the front. The picture, which is made in another way, says the same.
        let hidden = episode([0.04, 0.01, 0.05], [0.0, -0.06]);
        let (front, clear) = (CameraView::front(&[&Track::new(&hidden)], 1.6), chosen(&hidden));
        assert!(part(&front, &hidden) < 0.1, "{}", part(&front, &hidden));
        assert!(part(&clear, &hidden) > 0.9, "{}: {}", clear.name, part(&clear, &hidden));
        let reds = |view: &CameraView| {
            let image = view.camera.render(hidden.world(), 160, 100);
            image.rgb.chunks_exact(3).filter(|pixel| pixel[0] > 60 && pixel[1] < 30 && pixel[2] < 30).count()
        };
        assert!(reds(&clear) > 10 * (reds(&front) + 1), "{} and {} pixels", reds(&clear), reds(&front));
    }
}
