//! Meshes: triangles of a file, read as convex parts.
//!
//! The engine is fast and sound with convex parts alone. So each group of an OBJ file (`o` or `g`) is taken as the
//! convex hull of its corners, and a whole STL file, which has no groups, as one. A hull fills every hollow: a cup of
//! one group would be a solid plug. So each face is measured against the hull of its group, and a group whose faces lie
//! deeper in it than a tolerance is refused. Whoever makes the mesh knows best how to cut it into convex groups.
//! Cutting it here was tried: the engine's decomposition leaves parts that overlap by 8 mm, and beads fell through.

use std::io::Cursor;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use rapier3d::geometry::{ConvexPolyhedron, SharedShape};
use serde::Deserialize;

use crate::error::SimError;
use crate::frame::{Pose, from_engine_vector, to_engine_vector};
use crate::object::{Convex, MAX_SIZE, Object, Outline, Part};
use crate::shape::number::positive;

/// The most corners of a group. A hull of more takes seconds to find.
const MOST_CORNERS: usize = 20_000;
/// The most corners of a hull: each contact looks at them.
const MOST_HULL_CORNERS: usize = 256;
/// The largest tolerance, metres.
const MOST_TOLERANCE: f64 = 0.1;
/// A group is flat if its corners scatter by less than this about a plane, metres.
const FLAT: f64 = 1e-4;

/// The corners of a convex part: metres, in the object's frame.
pub type Corners = Arc<[[f64; 3]]>;

/// How the triangles of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ: groups begin with `o` or `g`.
    Obj,
    /// STL, as text or binary.
    Stl,
}

impl MeshFormat {
    /// The format that a file's name says, by how it ends.
    pub fn of(file: &str) -> Option<MeshFormat> {
        let (_, ending) = file.rsplit_once('.')?;
        match ending.to_ascii_lowercase().as_str() {
            "obj" => Some(MeshFormat::Obj),
            "stl" => Some(MeshFormat::Stl),
            _ => None,
        }
    }
}

/// A mesh from a file, as convex parts. Frame: that of the file, with z up.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// The file with the triangles, relative to the file that names it.
    pub file: String,
    /// Metres for each unit of the file: 0.001 for millimetres.
    #[serde(default = "metres", deserialize_with = "positive")]
    pub scale: f64,
    /// How deep a face may lie in the hull of its group, in metres.
    #[serde(default = "millimetre", deserialize_with = "positive")]
    pub tolerance: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// The convex parts: none until the file has been read ([`Mesh::read`]).
    #[serde(skip)]
    pub parts: Vec<Corners>,
}

fn metres() -> f64 {
    1.0
}

fn millimetre() -> f64 {
    0.001
}

/// The triangles of one group: corners in metres.
struct Group {
    name: String,
    triangles: Vec<[Vector3<f64>; 3]>,
}

impl Mesh {
    /// Takes the parts from the bytes of the file.
    ///
    /// # Errors
    /// [`SimError::Mesh`]: the bytes are of another format, or a group has no face, is flat, too large, of too many
    /// corners, or not convex.
    pub fn read(&mut self, bytes: &[u8], format: MeshFormat) -> Result<(), SimError> {
        if self.tolerance > MOST_TOLERANCE {
            return refuse("", format!("tolerance {}: expected at most {MOST_TOLERANCE} m", self.tolerance));
        }
        let groups = match format {
            MeshFormat::Obj => obj(bytes, self.scale)?,
            MeshFormat::Stl => stl(bytes, self.scale)?,
        };
        if groups.is_empty() {
            return refuse("", "expected at least one face".to_owned());
        }
        self.parts = groups.iter().map(|group| group.hull(self.tolerance)).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// The mesh as an object, which has no parts and is refused where the file has not been read.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let corners = self.parts.iter().flat_map(|part| part.iter());
        let outline = corners.fold(Outline { top: f64::NEG_INFINITY, reach: 0.0 }, |outline, [x, y, z]| Outline {
            top: outline.top.max(*z),
            reach: outline.reach.max(libm::hypot(*x, *y)),
        });
        let part = |corners: &Corners| {
            Part::new(Convex::Hull { corners: Arc::clone(corners) }, Pose::identity(), self.density, self.friction)
        };
        Object::new(name, self.parts.iter().map(part).collect(), outline)
    }
}

fn refuse<T>(group: &str, problem: String) -> Result<T, SimError> {
    let place = if group.is_empty() { String::new() } else { format!("group `{group}`: ") };
    Err(SimError::Mesh { problem: format!("{place}{problem}") })
}

fn obj(bytes: &[u8], scale: f64) -> Result<Vec<Group>, SimError> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // Materials say nothing about the shape.
    let read = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| Ok(Default::default()));
    let (models, _) = read.or_else(|error| refuse("", format!("expected an OBJ file: {error}")))?;
    let group = |model: tobj::Model| {
        let mesh = model.mesh;
        let corner = |index: &u32| {
            let at = 3 * *index as usize;
            let numbers = mesh.positions.get(at..at + 3)?;
            Some(Vector3::from_fn(|axis, _| scale * f64::from(numbers[axis])))
        };
        let triangles = mesh.indices.chunks_exact(3).filter_map(|triangle| {
            let [a, b, c] = triangle else { return None };
            Some([corner(a)?, corner(b)?, corner(c)?])
        });
        Group { triangles: triangles.collect(), name: model.name }
    };
    Ok(models.into_iter().map(group).filter(|group| !group.triangles.is_empty()).collect())
}

fn stl(bytes: &[u8], scale: f64) -> Result<Vec<Group>, SimError> {
    let mut reader = Cursor::new(bytes);
    let wrong = |error: std::io::Error| SimError::Mesh { problem: format!("expected an STL file: {error}") };
    let mut triangles = Vec::new();
    for triangle in stl_io::create_stl_reader(&mut reader).map_err(wrong)? {
        let corners = triangle.map_err(wrong)?.vertices;
        triangles.push(corners.map(|corner| Vector3::from_fn(|axis, _| scale * f64::from(corner[axis]))));
    }
    Ok(if triangles.is_empty() { Vec::new() } else { vec![Group { name: String::new(), triangles }] })
}

impl Group {
    /// The corners of the convex hull.
    fn hull(&self, tolerance: f64) -> Result<Corners, SimError> {
        let corners: Vec<Vector3<f64>> = self.triangles.iter().flatten().copied().collect();
        let count = corners.len() / 3;
        if count > MOST_CORNERS {
            return refuse(&self.name, format!("{count} faces: expected at most {MOST_CORNERS}"));
        }
        if corners.iter().any(|corner| corner.norm().is_nan() || corner.norm() > MAX_SIZE) {
            let problem = format!(
                "a corner is more than {} m away: expected `scale` to make metres of the file's unit",
                MAX_SIZE
            );
            return refuse(&self.name, problem);
        }
        if thickness(&corners) < FLAT {
            return refuse(&self.name, "it is flat: expected a body".to_owned());
        }
        let points: Vec<_> = corners.iter().map(to_engine_vector).collect();
        let hull = SharedShape::convex_hull(&points);
        let Some(hull) = hull.as_ref().and_then(|hull| hull.as_convex_polyhedron()) else {
            return refuse(&self.name, "no convex hull can be found: expected a body".to_owned());
        };
        let count = hull.points().len();
        if count > MOST_HULL_CORNERS {
            return refuse(&self.name, format!("its hull has {count} corners: expected at most {MOST_HULL_CORNERS}"));
        }
        let depth = self.deepest(hull);
        if depth > tolerance {
            let problem = format!(
                "a face lies {:.1} mm inside the convex hull: expected convex groups, or a `tolerance` of more than that",
                1e3 * depth
            );
            return refuse(&self.name, problem);
        }
        Ok(hull.points().iter().map(|point| from_engine_vector(*point).into()).collect())
    }

    /// How deep the faces lie in a hull at most, by their middles and the middles of their edges: metres.
    fn deepest(&self, hull: &ConvexPolyhedron) -> f64 {
        let (points, adjacent) = (hull.points(), hull.vertices_adj_to_face());
        let planes: Vec<(Vector3<f64>, Vector3<f64>)> = hull
            .faces()
            .iter()
            .map(|face| {
                let corner = points[adjacent[face.first_vertex_or_edge as usize] as usize];
                (from_engine_vector(face.normal), from_engine_vector(corner))
            })
            .collect();
        let depth = |point: Vector3<f64>| {
            planes.iter().map(|(normal, corner)| normal.dot(&(corner - point))).fold(f64::INFINITY, f64::min)
        };
        let middles = self
            .triangles
            .iter()
            .flat_map(|[a, b, c]| [(a + b + c) / 3.0, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]);
        middles.map(depth).fold(0.0, f64::max)
    }
}

/// How far points scatter about the plane that is nearest to them: a standard deviation, metres.
fn thickness(points: &[Vector3<f64>]) -> f64 {
    let count = points.len().max(1) as f64;
    let middle = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    libm::sqrt((scatter / count).symmetric_eigenvalues().min().max(0.0))
}
