//! `export`: demonstration files as an MCAP file or a LeRobot dataset.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use situ::demonstration::Kind;

use crate::demonstration_file::DemonstrationFile;
use crate::earlier::Earlier;
use crate::error::BenchError;
use crate::export::{Exported, lerobot, mcap};
use crate::files;

/// Turns demonstration files into a recording for other programs.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "mcap: one file, for Foxglove and others. The topics are /gripper
(foxglove.PoseInFrame), /objects (foxglove.FrameTransforms) and /demonstration,
all as JSON.

lerobot: a folder with a dataset of version 3, low-dimensional, without video. A
correction stands in one episode with its attempt, and `intervention` says of
each frame who leads. The attempt is played from the demonstration that the
correction names, up to the segment that ran last: nobody recorded the robot's.

Demonstration files have no clock: the hand goes at 0.25 m/s and 1 rad/s and
rests for the keyframe's `hold`, in 30 frames a second. `situ-bench import` reads
the export with the mapping that --mapping writes.

Examples:
  situ-bench export --format mcap --out tea.mcap tea-1.json tea-2.json
  situ-bench export --format lerobot --out tea tea-1.json --correct lid.json
  situ-bench export --format mcap --out a.mcap --mapping a.toml tea-1.json")]
pub struct Export {
    /// Original demonstrations: the task from its start.
    #[arg(required = true, value_name = "ORIGINAL.json")]
    pub originals: Vec<PathBuf>,
    /// Corrective demonstrations.
    #[arg(long, value_name = "CORRECTION.json", num_args = 1..)]
    pub correct: Vec<PathBuf>,
    /// What to write.
    #[arg(long, value_enum)]
    pub format: RecordingFormat,
    /// The file (mcap), or the new folder (lerobot).
    #[arg(long, value_name = "PATH")]
    pub out: PathBuf,
    /// Writes the mapping here by which `situ-bench import` reads the export.
    #[arg(long, value_name = "MAPPING.toml")]
    pub mapping: Option<PathBuf>,
    /// What a LeRobot dataset says its task is.
    #[arg(long, value_name = "WORDS", default_value = "the demonstrated task")]
    pub task: String,
}

/// A kind of recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RecordingFormat {
    /// An MCAP file with Foxglove's schemas, as JSON.
    Mcap,
    /// A LeRobot dataset of version 3.
    Lerobot,
}

impl Export {
    /// Exports, writes the files, all or none, and returns the text that is to be printed.
    ///
    /// # Errors
    /// Where a demonstration file is wrong, or the folder is there already: nothing is written then.
    /// [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        let mut demonstrations = Vec::new();
        for (paths, kind) in [(&self.originals, Kind::Original), (&self.correct, Kind::Corrective)] {
            for path in paths {
                let file = DemonstrationFile::read(path)?;
                file.check_kind(kind)?;
                demonstrations.push(file);
            }
        }
        let mut earlier = Earlier::default();
        for file in &demonstrations {
            earlier.stop(file)?;
        }
        let Exported { files: mut outputs, mapping, report } = match self.format {
            RecordingFormat::Mcap => mcap(&demonstrations, &self.out)?,
            RecordingFormat::Lerobot => lerobot(&demonstrations, &self.task, &self.out)?,
        };
        if let Some(path) = &self.mapping {
            outputs.push((path.clone(), mapping.into_bytes()));
        }
        let is_folder = self.format == RecordingFormat::Lerobot;
        if is_folder && self.out.exists() {
            let problem = format!("{}: is there already, expected the name of a new folder", self.out.display());
            return Err(BenchError::Argument(problem));
        }
        let inputs: Vec<&Path> = self.originals.iter().chain(&self.correct).map(PathBuf::as_path).collect();
        let written = self.folders(&outputs).and_then(|()| files::write_beside(&inputs, &outputs));
        if written.is_err() && is_folder {
            // It was not there before.
            let _ = fs::remove_dir_all(&self.out);
        }
        written.map(|()| format!("{}: {report}", self.out.display()))
    }

    /// Makes the folders of a dataset.
    fn folders(&self, outputs: &[(PathBuf, Vec<u8>)]) -> Result<(), BenchError> {
        let within = outputs.iter().filter_map(|(path, _)| path.parent()).filter(|path| path.starts_with(&self.out));
        for folder in within {
            fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.to_owned(), source })?;
        }
        Ok(())
    }
}
