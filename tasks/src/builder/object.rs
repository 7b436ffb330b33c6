//! What is there, and where it starts: `[[object]]`, `[beads]` and `[[magnet]]`.

use situ_sim::{Beads, Magnet, Mobility, Object, Pose, SimError, World, pose_at};

use super::check::Builder;
use super::layers::Located;
use super::names::Names;
use crate::error::TaskError;
use crate::file::{BeadsFile, MagnetFile, ObjectFile};
use crate::key::KeyPath;
use crate::placement::{Placed, Start};
use crate::setting::Setting;
use crate::start;
use crate::vocabulary::Role;

impl Builder<'_> {
    pub(super) fn objects(&self, files: &Located<'_, ObjectFile>) -> Result<Vec<Placed>, TaskError> {
        let mut placed = Vec::new();
        let mut world = World::new();
        for (key, object) in files {
            let start = self.start(&key.field("start"), &object.start, &placed)?;
            let body = object.body();
            // The physics knows more rules than are worth repeating here, so it is asked.
            world
                .add(Object { symmetry: None, ..body.clone() }, Pose::identity())
                .map_err(|e| self.document.error(&key.field("shape"), e.to_string()))?;
            if body.symmetry.is_some() {
                let added = World::new().add(body.clone(), Pose::identity());
                added.map_err(|e| self.document.error(&key.field("symmetry"), e.to_string()))?;
            }
            self.material(&key.field("start"), &body, &start)?;
            placed.push(Placed { body, start });
        }
        Ok(placed)
    }

    /// Whether the factors of mass and friction are possible, for whatever is drawn.
    fn material(&self, key: &KeyPath, body: &Object, start: &Start) -> Result<(), TaskError> {
        if start.mass.is_some() && body.mobility == Mobility::Fixed {
            let expected = format!("`{}` is fixed and has no mass; expected one that moves", body.name);
            return self.wrong(&key.field("mass"), expected);
        }
        for (field, range) in [("mass", start.mass), ("friction", start.friction)] {
            let (key, Some([low, high])) = (key.field(field), range) else { continue };
            if !(low > 0.0 && low <= high) {
                let expected = format!("[{low}, {high}]: expected factors above 0 as [least, largest]");
                return self.wrong(&key, expected);
            }
            for factor in [low, high] {
                let [mass, friction] = if field == "mass" { [factor, 1.0] } else { [1.0, factor] };
                let added = World::new().add(body.clone().with_material(mass, friction), Pose::identity());
                added.map_err(|e| self.document.error(&key, format!("times {factor}: {e}")))?;
            }
        }
        Ok(())
    }

    pub(super) fn start(&self, key: &KeyPath, start: &Start, before: &[Placed]) -> Result<Start, TaskError> {
        for (name, range) in [("x", start.x), ("y", start.y), ("yaw", start.yaw)] {
            if range[0] > range[1] {
                return self
                    .wrong(&key.field(name), format!("[{}, {}]: expected [least, largest]", range[0], range[1]));
            }
        }
        if let Some(on) = &start.on
            && !before.iter().any(|placed| &placed.body.name == on)
        {
            return self.wrong(
                &key.field("on"),
                format!("`{on}` is not there yet; expected an object listed before this one"),
            );
        }
        if let Some(apart) = start.apart {
            self.check_positive(&key.field("apart"), apart)?;
        }
        Ok(start.clone())
    }

    pub(super) fn beads(&self, key: &KeyPath, file: &BeadsFile, names: &Names) -> Result<(String, Beads), TaskError> {
        self.check_name(&key.field("container"), &file.container, Role::Body, names)?;
        self.check_name(&key.field("container"), &file.container, Role::Container, names)?;
        if file.count == 0 {
            return self.wrong(&key.field("count"), "0: expected at least one bead");
        }
        for (name, value) in [("radius", file.radius), ("density", file.density)] {
            self.check_positive(&key.field(name), value)?;
        }
        for (name, value) in [("friction", file.friction), ("angular_damping", file.angular_damping)] {
            self.check_not_negative(&key.field(name), value)?;
        }
        let beads = Beads {
            count: file.count,
            radius: file.radius,
            density: file.density,
            friction: file.friction,
            angular_damping: file.angular_damping,
        };
        Ok((file.container.clone(), beads))
    }

    pub(super) fn magnet(&self, key: &KeyPath, file: &MagnetFile, names: &Names) -> Result<Magnet, TaskError> {
        self.check_name(&key.field("a"), &file.a, Role::Body, names)?;
        self.check_name(&key.field("b"), &file.b, Role::Body, names)?;
        self.check_positive(&key.field("force"), file.force)?;
        self.check_positive(&key.field("range"), file.range)?;
        let seat = pose_at(file.seat, Default::default());
        Ok(Magnet { a: file.a.clone(), b: file.b.clone(), seat, force: file.force, range: file.range })
    }

    /// Whether the objects find places that are apart, in a few draws. An episode whose objects do not is refused when
    /// it starts.
    pub(super) fn check_starts(&self, files: &Located<'_, ObjectFile>, setting: &Setting) -> Result<(), TaskError> {
        /// Draws: regions that overlap by a quarter or more are found nine times in ten.
        const DRAWS: u64 = 8;
        for seed in 0..DRAWS {
            let wrong = match start::check_places(setting, seed) {
                Ok(()) => continue,
                Err(error) => error,
            };
            let object = match &wrong {
                TaskError::Overlap { second: object, .. } | TaskError::Crowded { object, .. } => object,
                TaskError::World {
                    source: SimError::BadPose { object, .. } | SimError::BadValue { object, .. },
                    ..
                } => object,
                _ => return self.wrong(&KeyPath::default().field("object"), wrong.to_string()),
            };
            let of = |name: &str| files.iter().find(|(_, file)| file.name == *name).map(|(key, _)| key);
            // The hand is placed by the file, too.
            let key =
                of(object).map_or_else(|| KeyPath::default().field("gripper").field("at"), |key| key.field("start"));
            return self.wrong(&key, wrong.to_string());
        }
        Ok(())
    }
}
