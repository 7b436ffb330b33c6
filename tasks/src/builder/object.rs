//! What is there, and where it starts: `[[object]]`, `[beads]` and `[[magnet]]`.

use situ_sim::{Beads, Magnet, Pose, SimError, World, pose_at};

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
                .add(body.clone(), Pose::identity())
                .map_err(|e| self.document.error(&key.field("shape"), e.to_string()))?;
            placed.push(Placed { body, start });
        }
        Ok(placed)
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
        self.check_name(&key.field("a"), &file.a, Role::Object, names)?;
        self.check_name(&key.field("b"), &file.b, Role::Object, names)?;
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
