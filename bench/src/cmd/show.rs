//! `show`: pictures of a task, of a teacher's demonstration, and of the original program failing on a variation.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use situ::demonstration::Kind;
use situ_sim::{Film, Image, World};
use situ_tasks::{Episode, Setting, script};
use situ_teachers::{Shown, Teacher, convert};

use crate::cmd::library::Library;
use crate::error::BenchError;
use crate::files;
use crate::pictures::{self, FILM_SPEED, PixelSize, Shooting, Track};

/// Makes pictures of a task and of a teacher's demonstration of it.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "For pour/lid it writes pour-lid-start.png, pour-lid-strip.png (some of the keyframes, in \
        order), and pour-lid-demonstration.png, an animated PNG that a browser plays. Every run gives the same \
        pictures.

Examples:
  situ-bench show pour
  situ-bench show pour/lid --failure --out pictures
  situ-bench show sort_blocks/cover --teacher novice --seed 3 --width 240 --height 150"
)]
pub struct Show {
    /// The task, with a variation or without.
    #[arg(value_name = "TASK[/VARIATION]")]
    pub task: String,
    /// Decides where things stand, and what an erring teacher does.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// The teacher's profile.
    #[arg(long, default_value = "expert")]
    pub teacher: String,
    /// Also a strip and a film of the original task's program, which knows nothing of the variation. They are called
    /// `failure` where the program fails, and `original` where it reaches the goal.
    #[arg(long)]
    pub failure: bool,
    /// The folder to write to.
    #[arg(long, value_name = "DIR", default_value = "pictures")]
    pub out: PathBuf,
    /// Width in pixels of the film and of each picture of the strip. The picture of the start is twice as wide.
    #[arg(long, default_value_t = 480, value_parser = clap::value_parser!(u32).range(16..=1920))]
    pub width: u32,
    /// Height in pixels, in the same way.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(16..=1920))]
    pub height: u32,
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
}

/// The files that are to be written, and the text that is to be printed about them.
#[derive(Default)]
struct Album {
    stem: String,
    files: Vec<(PathBuf, Vec<u8>)>,
    said: Vec<String>,
}

impl Album {
    fn add(&mut self, show: &Show, what: &str, bytes: Vec<u8>, about: &str) {
        let path = show.out.join(format!("{}-{what}.png", self.stem));
        self.said.push(format!("{}  {} kB, {about}\n", path.display(), bytes.len().div_ceil(1000)));
        self.files.push((path, bytes));
    }

    fn add_image(&mut self, show: &Show, what: &str, image: &Image, about: &str) -> Result<(), BenchError> {
        let about = format!("{} × {}, {about}", image.width, image.height);
        self.add(show, what, image.png()?, &about);
        Ok(())
    }

    fn add_film(&mut self, show: &Show, what: &str, film: &Film, about: &str) -> Result<(), BenchError> {
        let frames = film.frames();
        let about = format!(
            "{} × {}, {about}: an animated PNG of {frames} frames, {FILM_SPEED} times as fast",
            show.width, show.height
        );
        self.add(show, what, film.png()?, &about);
        Ok(())
    }
}

impl Show {
    /// Makes the pictures, writes them, and returns the text that is to be printed.
    ///
    /// # Errors
    /// A name that nothing has, an episode that cannot start, [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        let setting = self.setting()?;
        let teacher = Teacher::new(self.library.roster()?.get(&self.teacher)?.clone());
        if self.failure && setting.variation.is_none() {
            return Err(BenchError::Argument(format!(
                "--failure: `{}` is the original task, expected TASK/VARIATION",
                self.task
            )));
        }
        let mut album = Album { stem: pictures::stem(&setting), ..Album::default() };
        self.demonstration(&setting, &teacher, &mut album)?;
        if self.failure {
            self.original(&setting, &mut album)?;
        }
        fs::create_dir_all(&self.out).map_err(|source| BenchError::Write { path: self.out.clone(), source })?;
        files::write_all(&album.files)?;
        Ok(album.said.concat())
    }

    fn size(&self) -> PixelSize {
        [self.width, self.height]
    }

    fn setting(&self) -> Result<Arc<Setting>, BenchError> {
        let (task, variation) = match self.task.split_once('/') {
            Some((task, variation)) => (task, Some(variation)),
            None => (self.task.as_str(), None),
        };
        Ok(self.library.registry()?.get(task)?.variation(variation)?)
    }

    /// Pictures of the start and of the teacher's demonstration.
    fn demonstration(&self, setting: &Arc<Setting>, teacher: &Teacher, album: &mut Album) -> Result<(), BenchError> {
        let schema = convert::schema(setting)?;
        let start = Episode::start(setting, self.seed)?;
        let perform = |observer: &mut dyn FnMut(&World)| -> Result<(Shown, Episode), BenchError> {
            let mut episode = start.clone();
            let shown =
                teacher.demonstrate(&setting.label(), Kind::Original, &schema, &mut episode, self.seed, observer)?;
            Ok((shown, episode))
        };
        let mut track = Track::new(&start);
        let (shown, episode) = perform(&mut |world| track.see(world))?;
        let keyframes = shown.demonstration.iter().flat_map(|demonstration| demonstration.keyframes());
        let rests = track.rests(keyframes.map(|keyframe| &keyframe.gripper_pose));
        let chosen = pictures::even_selection(&rests);
        let mut shooting = Shooting::new(&track, &start, self.size(), &chosen);
        perform(&mut |world| shooting.see(world))?;
        let (film, strip) = shooting.finish()?;
        album.add_image(self, "start", &pictures::start(&track, &start, self.size()), "the start")?;
        if !chosen.is_empty() {
            let about = format!("{} of {} keyframes", chosen.len(), shown.effort.keyframes);
            album.add_image(self, "strip", &strip, &about)?;
        }
        album.add_film(self, "demonstration", &film, "the demonstration")?;
        let mut said = format!("teacher {}: {}\n", self.teacher, shown.skills.join(", "));
        let _ = writeln!(
            said,
            "  keyframes {}, simulated seconds {:.1}, metres {:.2}, the goal holds: {}",
            shown.effort.keyframes,
            shown.effort.seconds,
            shown.effort.metres,
            yes_or_no(episode.succeeded())
        );
        album.said.push(said);
        Ok(())
    }

    /// Pictures of the original program, which fails or does not.
    fn original(&self, setting: &Arc<Setting>, album: &mut Album) -> Result<(), BenchError> {
        let start = Episode::start(setting, self.seed)?;
        let mut track = Track::new(&start);
        let mut episode = start.clone();
        let record = script::original(&mut episode, &mut |world| track.see(world));
        let chosen = pictures::even_selection(&track.steps());
        let mut shooting = Shooting::new(&track, &start, self.size(), &chosen);
        script::original(&mut start.clone(), &mut |world| shooting.see(world));
        let (film, strip) = shooting.finish()?;
        // A program that succeeds is not called a failure.
        let name = if episode.succeeded() { "original" } else { "failure" };
        let about = format!("{} moments of the original program, evenly spaced", chosen.len());
        album.add_image(self, &format!("{name}-strip"), &strip, &about)?;
        album.add_film(self, name, &film, "the original program, which knows nothing of the variation")?;
        let mut said = format!("original program: {}\n", record.skills.join(", "));
        let _ = writeln!(
            said,
            "  keyframes {}, motions stopped by a contact {}, aborted {}, simulated seconds {:.1}, metres {:.2}, \
             the goal holds: {}",
            record.keyframes,
            record.guarded,
            record.aborted,
            episode.seconds(),
            episode.path(),
            yes_or_no(episode.succeeded())
        );
        album.said.push(said);
        Ok(())
    }
}

fn yes_or_no(holds: bool) -> &'static str {
    if holds { "yes" } else { "no" }
}
