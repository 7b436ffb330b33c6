//! `show`: pictures of a task, of a teacher's demonstration, of the original program failing on a variation, and of a
//! learned model before and after it is corrected.

mod album;
mod learned;

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use situ::demonstration::Kind;
use situ::method::Method;
use situ_sim::World;
use situ_tasks::{Episode, Setting, Task, script};
use situ_teachers::{Shown, Teacher, convert};

use self::album::{Album, Piece, yes_or_no};
use crate::caption::PixelSize;
use crate::cmd::library::{Carrier, Library, OwnMethods};
use crate::cmd::terminal::{self, Signs};
use crate::cmd::traces;
use crate::error::BenchError;
use crate::external;
use crate::files;
use crate::performance::Performance;
use crate::pictures::{self, Look};
use crate::protocol::Protocol;
use crate::rerun::Rerun;
use crate::track::Track;
use crate::view;

/// Makes pictures and films: of a task and of a teacher's demonstration of it, or, with --method, of what a learned
/// model does before and after it is corrected.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "For pour/lid it writes pour-lid-start.png, pour-lid-strip.png (some of the keyframes, in \
        order), and pour-lid-demonstration.png and .gif: an animated PNG, which a browser plays, and a GIF, which \
        everything plays. With --failure also the original program.

With --method it does the run that `run` does with that task, variation, method, teacher and seed, and shows the first \
        failure that is corrected (`before`), each correction from where the teacher steps in (`correction-1` and so \
        on), and the corrected model from the same start (`after`). Where nothing fails, it says so and shows a \
        success. The record of the run is printed.

Films are three times as fast as the simulated world. With --method or --captions, a caption says the skill in the \
        teacher's word (or node and reference object, where the teacher has none), the simulated time, the keyframe, \
        how probable a primitive was when it was chosen, and how it ended; and of some viewpoints the one is taken from \
        which the least is hidden of the gripper and of the objects that the skills are about: all pictures are from \
        there. Every run of the program gives the same pictures.

Examples:
  situ-bench show pour
  situ-bench show pour/lid --failure --captions --out pictures
  situ-bench show sort_blocks/cover --teacher novice --seed 3 --width 240 --height 150
  situ-bench show drawer/pin --method situ --seed 1"
)]
pub struct Show {
    /// The task, with a variation or without.
    #[arg(value_name = "TASK[/VARIATION]")]
    pub task: String,
    /// The variation, where it does not stand with the task.
    #[arg(long, value_name = "NAME")]
    pub variation: Option<String>,
    /// A method that takes corrections: what its model does before and after it is corrected.
    #[arg(long, value_name = "NAME", conflicts_with = "failure")]
    pub method: Option<String>,
    /// The protocol by which it is taught and corrected, a built-in one or a file. `quick` where it is not given.
    #[arg(long, value_name = "NAME|FILE", requires = "method")]
    pub protocol: Option<String>,
    /// Decides where things stand, and what an erring teacher does: with --method, the seed of the run, as in `run`. 0
    /// where it is not given; with --method, the protocol's first.
    #[arg(long)]
    pub seed: Option<u64>,
    /// The teacher's profile. `expert` where it is not given; with --method, the protocol's first.
    #[arg(long, value_name = "NAME")]
    pub teacher: Option<String>,
    /// Also a strip and a film of the original task's program, which knows nothing of the variation. They are called
    /// `failure` where the program fails, and `original` where it reaches the goal.
    #[arg(long)]
    pub failure: bool,
    /// Captions, and the viewpoint from which the least is hidden. With --method that is always so.
    #[arg(long)]
    pub captions: bool,
    /// The folder to write to. Files of former pictures are replaced there; what is no file is not.
    #[arg(long, value_name = "DIR", default_value = "pictures")]
    pub out: PathBuf,
    /// Width in pixels of the film and of each picture of the strip. The picture of the start is twice as wide. What
    /// is too small for a caption has none.
    #[arg(long, default_value_t = 480, value_parser = clap::value_parser!(u32).range(16..=1920))]
    pub width: u32,
    /// Height in pixels, in the same way, with the caption.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(16..=1920))]
    pub height: u32,
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
}

/// The teacher who demonstrates where no other is named.
const DEMONSTRATOR: &str = "expert";
/// The protocol by which a method is taught where no other is named, as in `run`.
const PROTOCOL: &str = "quick";

impl Show {
    /// Makes the pictures, writes them, and returns the text that is to be printed.
    ///
    /// # Errors
    /// A name that nothing has, an episode that cannot start, [`BenchError::Stopped`], [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        // What nothing can come of is refused before there is a folder.
        let setting = self.setting()?;
        let methods = self.own.known()?;
        let method = self.method.as_deref().map(|name| learned::method(name, &methods)).transpose()?;
        if self.failure && setting.variation.is_none() {
            return Err(self.no_variation("--failure")?);
        }
        if method.is_some() && setting.variation.is_none() {
            return Err(self.no_variation("--method")?);
        }
        let new = traces::make(&self.out)?;
        let last = new.clone();
        let interrupted = terminal::interrupt_flag(BenchError::Stopped, move || {
            external::end_all();
            traces::remove_empty(&last);
        });
        methods.heed(&interrupted);
        let album = match method {
            Some(method) => self.learned(&setting, &*method, &interrupted),
            None => self.demonstrated(&setting, &interrupted),
        };
        let said = album.and_then(|album| files::write_all(&album.files).map(|()| album.said.concat()));
        if said.is_err() {
            traces::remove_empty(&new);
        }
        said.map_err(|error| if matches!(error, BenchError::Interrupted) { BenchError::Stopped } else { error })
    }

    fn size(&self) -> PixelSize {
        [self.width, self.height]
    }

    fn has_captions(&self) -> bool {
        self.captions || self.method.is_some()
    }

    /// The names of task and variation.
    fn names(&self) -> Result<(&str, Option<&str>), BenchError> {
        let (task, variation) = match self.task.split_once('/') {
            Some((task, variation)) => (task, Some(variation)),
            None => (self.task.as_str(), None),
        };
        match (variation, self.variation.as_deref()) {
            (Some(one), Some(other)) if one != other => {
                Err(BenchError::Argument(format!("--variation {other}: `{}` names another, expected one", self.task)))
            }
            (one, other) => Ok((task, one.or(other))),
        }
    }

    fn setting(&self) -> Result<Arc<Setting>, BenchError> {
        let (task, variation) = self.names()?;
        Ok(self.library.registry()?.get(task)?.variation(variation)?)
    }

    /// The error where an option needs a variation and there is none.
    fn no_variation(&self, option: &str) -> Result<BenchError, BenchError> {
        let registry = self.library.registry()?;
        let variations: Vec<&str> = registry.get(self.names()?.0).map(Task::variations)?.collect();
        Ok(BenchError::Argument(format!(
            "{option}: `{}` is the original task, expected TASK/VARIATION with one of {}",
            self.task,
            variations.join(", ")
        )))
    }

    /// How pictures are looked at: with captions all from one viewpoint, so that they can be compared; else each plain.
    fn look(&self, pieces: &[Piece<'_>], setting: &Setting) -> Vec<Look> {
        let tracks: Vec<&Track> = pieces.iter().map(|piece| &piece.performance.track).collect();
        if !self.has_captions() {
            return tracks.into_iter().map(|track| Look::plain(track, self.size())).collect();
        }
        vec![Look::clearest(&tracks, &view::things(setting), self.size()); pieces.len()]
    }

    /// Films the pieces. `begin` puts first what comes before them.
    fn album(
        &self,
        stem: String,
        (pieces, setting): (&[Piece<'_>], &Setting),
        interrupted: &AtomicBool,
        begin: impl FnOnce(&mut Album, &Look) -> Result<(), BenchError>,
    ) -> Result<Album, BenchError> {
        let mut album = Album::new(self.out.clone(), stem, self.size());
        let signs = Signs::of(pieces.len());
        signs.at("choosing the viewpoint");
        let looks = self.look(pieces, setting);
        begin(&mut album, &looks[0])?;
        for (piece, look) in pieces.iter().zip(&looks) {
            if interrupted.load(Ordering::Relaxed) {
                return Err(BenchError::Stopped);
            }
            signs.at(&format!("filming {}", piece.film));
            album.add_piece(piece, look)?;
            signs.finished();
        }
        signs.end();
        if self.has_captions() {
            album.said.push(format!("seen {}\n", looks[0].viewpoint()));
        }
        Ok(album)
    }

    /// Pictures of a learned model before and after it is corrected.
    fn learned(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        interrupted: &AtomicBool,
    ) -> Result<Album, BenchError> {
        let protocol = Protocol::find(self.protocol.as_deref().unwrap_or(PROTOCOL))?;
        let protocol = if self.library.plant == Carrier::Hand { protocol.without_arm() } else { protocol };
        // What the pooled model would do is not shown, and has no part in anything that is.
        let protocol = Protocol { pooled: Vec::new(), ..protocol };
        let Some(teacher) = self.teacher.as_ref().or(protocol.teachers.first()) else {
            return Err(BenchError::Argument(format!(
                "--protocol {}: it names no teacher, expected --teacher NAME",
                protocol.name
            )));
        };
        let teacher = Teacher::new(self.library.roster()?.get(teacher)?.clone());
        let registry = self.library.registry()?;
        let original = registry.get(&setting.task)?.variation(None)?;
        let signs = Signs::of(1);
        let rerun = Rerun {
            protocol: &protocol,
            teacher: &teacher,
            seed: self.seed.unwrap_or(protocol.first_seed),
            original: &original,
            setting,
            schema: &convert::schema(&original)?,
            interrupted,
            progress: &signs,
        };
        let story = rerun.story(method)?;
        signs.finished();
        signs.end();
        let pieces = learned::pieces(&rerun, &story)?;
        let head = format!(
            "{}: method {}, teacher {}, seed {}, protocol {}\n",
            setting.label(),
            method.name(),
            teacher.profile().name,
            rerun.seed,
            protocol.name
        );
        let begin = |album: &mut Album, _: &Look| {
            album.said.push(head);
            Ok(())
        };
        let mut album = self.album(learned::stem(&rerun, method), (&pieces, setting), interrupted, begin)?;
        album.said.push(learned::verdict(&rerun, &story));
        Ok(album)
    }

    /// Pictures of the start, of a teacher's demonstration, and of the original program where it is wanted.
    fn demonstrated(&self, setting: &Arc<Setting>, interrupted: &AtomicBool) -> Result<Album, BenchError> {
        let name = self.teacher.as_deref().unwrap_or(DEMONSTRATOR);
        let teacher = Teacher::new(self.library.roster()?.get(name)?.clone());
        let start = Episode::start(setting, self.seed.unwrap_or_default())?;
        let mut pieces = vec![self.demonstration(&start, teacher)?];
        if self.failure {
            pieces.push(original(&start));
        }
        let begin = |album: &mut Album, look: &Look| album.add_image("start", &look.start(&start), "the start");
        self.album(pictures::stem(setting), (&pieces, setting), interrupted, begin)
    }

    /// A teacher's demonstration.
    fn demonstration(&self, start: &Episode, teacher: Teacher) -> Result<Piece<'static>, BenchError> {
        let (setting, seed) = (start.setting().clone(), self.seed.unwrap_or_default());
        let schema = convert::schema(&setting)?;
        let name = teacher.profile().name.clone();
        let first = start.clone();
        let perform = move |observer: &mut dyn FnMut(&World)| -> Result<(Shown, bool), BenchError> {
            let (label, mut episode) = (setting.label(), first.clone());
            let shown = teacher.demonstrate(&label, Kind::Original, &schema, &mut episode, seed, observer)?;
            Ok((shown, episode.succeeded()))
        };
        let mut track = Track::new(start);
        let (shown, is_goal) = perform(&mut |world| track.see(world))?;
        let again = move |observer: &mut dyn FnMut(&World)| perform(observer).map(drop);
        let performance = Performance::shown((start.clone(), track), &name, (&shown, is_goal), Box::new(again));
        let mut said = format!("teacher {name}: {}\n", shown.skills.join(", "));
        let effort = &shown.effort;
        let _ = writeln!(
            said,
            "  keyframes {}, simulated seconds {:.1}, metres {:.2}, the goal holds: {}",
            effort.keyframes,
            effort.seconds,
            effort.metres,
            yes_or_no(is_goal)
        );
        let stills = pictures::even_selection(&performance.moments).len();
        Ok(Piece {
            film: "demonstration".to_owned(),
            strip: "strip".to_owned(),
            about: "the demonstration".to_owned(),
            moments: format!("{stills} of {} keyframes", effort.keyframes),
            said,
            performance,
        })
    }
}

/// The original program, which fails or does not.
fn original(start: &Episode) -> Piece<'static> {
    let mut episode = start.clone();
    let mut track = Track::new(start);
    let record = script::original(&mut episode, &mut |world| track.see(world));
    let is_goal = episode.succeeded();
    let first = start.clone();
    let again = move |observer: &mut dyn FnMut(&World)| {
        script::original(&mut first.clone(), observer);
        Ok(())
    };
    let about = "the original program, which knows nothing of the variation".to_owned();
    let title = "original program";
    let performance = Performance::silent((start.clone(), track), title, is_goal, Box::new(again));
    // A program that succeeds is not called a failure.
    let name = if is_goal { "original" } else { "failure" };
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
        yes_or_no(is_goal)
    );
    let stills = pictures::even_selection(&performance.moments).len();
    Piece {
        film: name.to_owned(),
        strip: format!("{name}-strip"),
        about,
        moments: format!("{stills} moments of the original program, evenly spaced"),
        said,
        performance,
    }
}
