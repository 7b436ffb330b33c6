//! Files of triangles that a task file names: `shape.mesh`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path};

use sha2::{Digest, Sha256};
use situ_sim::{Mesh, MeshFormat, Shape};

use crate::error::TaskError;
use crate::file::{ObjectFile, TaskFile};
use crate::key::{Document, KeyPath};

/// The largest file that is read, in bytes.
const MOST_BYTES: u64 = 16 << 20;

/// Reads the meshes of a task file, which are in the folder of that file or below it. Returns the SHA-256 of each file
/// that was read, in hexadecimal digits, by its name.
pub(crate) fn read(
    content: &mut TaskFile,
    document: &Document<'_>,
    folder: &Path,
) -> Result<BTreeMap<String, String>, TaskError> {
    let mut hashes = BTreeMap::new();
    let root = KeyPath::default();
    let mut lists: Vec<(KeyPath, &mut Vec<ObjectFile>)> = vec![(root.field("object"), &mut content.object)];
    for (i, variation) in content.variation.iter_mut().enumerate() {
        lists.push((root.field("variation").index(i).field("object"), &mut variation.object));
    }
    for (key, objects) in lists {
        for (i, object) in objects.iter_mut().enumerate() {
            if let Shape::Mesh(mesh) = &mut object.shape {
                let key = key.index(i).field("shape").field("mesh").field("file");
                let hash = read_one(mesh, folder).map_err(|expected| document.error(&key, expected))?;
                hashes.insert(mesh.file.clone(), hash);
            }
        }
    }
    Ok(hashes)
}

/// Reads one mesh. Returns the SHA-256 of its file, or what is wrong.
fn read_one(mesh: &mut Mesh, folder: &Path) -> Result<String, String> {
    let name = mesh.file.clone();
    let Some(format) = MeshFormat::of(&name) else {
        return Err(format!("`{name}`: expected a file that ends in .obj or .stl"));
    };
    // What a task is must not depend on what lies elsewhere.
    if !Path::new(&name).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(format!("`{name}`: expected a file in the folder of this one, or below it"));
    }
    let path = folder.join(&name);
    let unreadable = |error: std::io::Error| format!("cannot read {}: {error}", path.display());
    let about = fs::metadata(&path).map_err(unreadable)?;
    if !about.is_file() || about.len() > MOST_BYTES {
        return Err(format!("`{name}`: expected a file of at most {} MiB", MOST_BYTES >> 20));
    }
    let bytes = fs::read(&path).map_err(unreadable)?;
    mesh.read(&bytes, format).map_err(|error| format!("`{name}`: {error}"))?;
    Ok(Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}
