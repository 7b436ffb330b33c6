//! `import`: demonstration files of recordings.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::error::BenchError;
use crate::files;
use crate::import::{Imported, Mapping, import};

/// The end of the long help: a mapping in short.
const MAPPING: &str = r#"A mapping is a small TOML file. It says where things are:

  quaternion_order = "wxyz"        or "xyzw"; must be said, is never guessed
  half_turn = "z"                  half a turn about the hand's z is one grasp
  task_objects = ["cup", "lid", "table"]   also what only others have met
  [columns]
  time = "t"                       seconds ([units] says otherwise)
  episode = "episode"              where one file holds several
  intervention = "human"           not 0 while a person corrects
  [gripper]
  position = ["x", "y", "z"]
  quaternion = ["qw", "qx", "qy", "qz"]
  [opening]
  column = "grip"                  a share of the stroke, 0 closed to 1 open
  [objects.cup]
  position = ["cup_x", "cup_y", "cup_z"]
  orientation = "none"
  [objects.table]
  fixed = {position = [0.5, 0.0, 0.0]}

In a LeRobot dataset a column is observation.state[0], or observation.state.x
where the dataset names its parts. In an MCAP file a pose is a topic
(topic = "/hand") and a number is topic and path ("/gripper.width").
All keys: bench/docs/import.md.

Keyframes are where a column marks them; else where the gripper closes and
opens, and where the way between bends. Each is printed with its reference
object and the reason. [[override]] in the mapping changes one
(in all demonstrations, where it names none):

  [[override]]
  demonstration = "tea-0"
  keyframe = 3
  reference = "saucer"

Examples:
  situ-bench import tea.csv --mapping tea.toml --out tea
  situ-bench import my_dataset --mapping arm.toml --out tea
  situ-bench import monday.mcap tuesday.mcap --mapping arm.toml --out tea
  situ-bench learn tea/tea-0.json tea/tea-1.json"#;

/// Turns recordings into demonstration files.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = MAPPING)]
pub struct Import {
    /// Recordings: CSV files, MCAP files, or folders of LeRobot datasets (version 3).
    #[arg(required = true, value_name = "RECORDING")]
    pub recordings: Vec<PathBuf>,
    /// Where in the recordings things are.
    #[arg(long, value_name = "MAPPING.toml")]
    pub mapping: PathBuf,
    /// The folder of the demonstration files, one for each demonstration. Without it they are only shown.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl Import {
    /// Imports, writes the demonstration files, all or none, and returns the text that is to be printed.
    ///
    /// # Errors
    /// Where the mapping or a recording is wrong: nothing is written then. [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        let mapping = Mapping::read(&self.mapping)?;
        let Imported { demonstrations, report } = import(&self.recordings, &mapping)?;
        let Some(folder) = &self.out else {
            return Ok(format!("{report}\nNothing was written: --out DIR names a folder.\n"));
        };
        let outputs: Vec<(PathBuf, String)> = demonstrations
            .into_iter()
            .map(|(name, text)| (folder.join(format!("{}.json", file_name(&name))), text))
            .collect();
        let made = !folder.exists();
        fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.clone(), source })?;
        let inputs: Vec<&Path> = self.recordings.iter().map(PathBuf::as_path).chain([&*self.mapping]).collect();
        files::write_beside(&inputs, &outputs).inspect_err(|_| {
            if made {
                // One that something stands in stays.
                let _ = fs::remove_dir(folder);
            }
        })?;
        let number = outputs.len();
        Ok(format!("{report}\n{number} demonstration files in {}\n", folder.display()))
    }
}

/// A name as that of a file: what has a meaning in a path is a line.
fn file_name(name: &str) -> String {
    let plain = |letter: char| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' };
    let name: String = name.chars().map(plain).collect();
    if name.starts_with('.') { format!("_{name}") } else { name }
}
