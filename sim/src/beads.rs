//! Beads: small balls that stand for what is poured, and where they lie before they have settled.

use serde::{Deserialize, Serialize};

use crate::error::{SimError, within};
use crate::object::Interior;

/// Distance between the centres of beads laid out, in radii: just apart, so that nothing is pressed together.
const SPACING: f64 = 2.1;
/// Distance of the laid-out beads from the floor and the walls, in radii beyond touching.
const CLEARANCE: f64 = 0.1;
/// The most beads in one container; a step with that many takes milliseconds.
const MAX_BEADS: usize = 2000;

/// A number of equal balls. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Beads {
    /// How many.
    pub count: usize,
    /// Radius.
    pub radius: f64,
    /// Density.
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Rate at which spinning dies away, 1/s. The engine has no rolling friction: a bead without damping rolls for
    /// ever.
    pub angular_damping: f64,
}

impl Beads {
    /// `count` beads of 12 mm, as heavy as water, as measured for the pouring task.
    pub fn new(count: usize) -> Beads {
        Beads { count, radius: 0.006, density: 1000.0, friction: 0.4, angular_damping: 2.0 }
    }

    /// Says what is wrong with a bead's properties, if anything.
    pub(crate) fn check(&self, container: &str) -> Result<(), SimError> {
        within(container, "a bead's radius must be 1 mm to 5 cm", &[self.radius], 1e-3, 5e-2)?;
        within(container, "a bead's density must be 1 to 30000 kg/m³", &[self.density], 1.0, 3e4)?;
        within(container, "friction must be 0 to 5", &[self.friction], 0.0, 5.0)?;
        within(container, "damping must be 0 to 1000 1/s", &[self.angular_damping], 0.0, 1e3)
    }

    /// Centres of the beads in the container's frame, metres: layers of a hexagonal lattice from the floor up, every
    /// second layer shifted.
    ///
    /// # Errors
    /// A property of the beads is impossible, or they do not fit below the rim.
    pub(crate) fn layout(&self, container: &str, interior: &Interior) -> Result<Vec<[f64; 3]>, SimError> {
        self.check(container)?;
        within(container, "there may be 0 to 2000 beads", &[self.count as f64], 0.0, MAX_BEADS as f64)?;
        let pitch = SPACING * self.radius;
        let row_pitch = pitch * 0.5 * libm::sqrt(3.0);
        let margin = (1.0 + CLEARANCE) * self.radius;
        let mut centers = Vec::with_capacity(self.count);
        let mut z = interior.floor() + margin;
        let mut layer = 0;
        while z + self.radius <= interior.height() && centers.len() < self.count {
            let (reach_x, reach_y) = match *interior {
                Interior::Cone { .. } => {
                    let lower = interior.radius_at(z - self.radius).min(interior.radius_at(z));
                    (lower - margin, lower - margin)
                }
                Interior::Box { half_x, half_y, .. } => (half_x - margin, half_y - margin),
            };
            let fits = |x: f64, y: f64| match interior {
                Interior::Cone { .. } => reach_x >= 0.0 && x * x + y * y <= reach_x * reach_x,
                Interior::Box { .. } => x.abs() <= reach_x && y.abs() <= reach_y,
            };
            let shift = if layer % 2 == 0 { 0.0 } else { row_pitch * 2.0 / 3.0 };
            let rows = libm::ceil(reach_y.max(0.0) / row_pitch) as i64;
            let columns = libm::ceil(reach_x.max(0.0) / pitch) as i64;
            for row in -rows..=rows {
                for column in -columns..=columns {
                    let y = row as f64 * row_pitch + shift;
                    let x = (column as f64 + if row % 2 == 0 { 0.0 } else { 0.5 }) * pitch;
                    if fits(x, y) && centers.len() < self.count {
                        centers.push([x, y, z]);
                    }
                }
            }
            z += pitch;
            layer += 1;
        }
        if centers.len() < self.count {
            return Err(SimError::DoesNotFit { object: container.to_owned(), asked: self.count, room: centers.len() });
        }
        Ok(centers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beads_are_laid_out_apart_and_inside() {
        let interior = Interior::Cone { bottom_radius: 0.04, top_radius: 0.05, floor: 0.005, height: 0.1 };
        let beads = Beads::new(120);
        let centers = beads.layout("cup", &interior).unwrap();
        assert_eq!(centers.len(), 120);
        for (i, a) in centers.iter().enumerate() {
            let wall = interior.radius_at(a[2] - beads.radius) - libm::hypot(a[0], a[1]);
            assert!(wall >= beads.radius && a[2] - beads.radius >= 0.005);
            for b in &centers[..i] {
                let distance = libm::sqrt((0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum());
                assert!(distance > 2.0 * beads.radius);
            }
        }
        assert!(matches!(
            Beads::new(1500).layout("cup", &interior),
            Err(SimError::DoesNotFit { asked: 1500, room, .. }) if room < 1500 && room > 100
        ));
    }
}
