//! Pictures of a performance: of its start, of chosen moments side by side, and of all of it as a film.
//!
//! A performance is run twice, bit for bit alike. The first run tells where things go and when keyframes are reached,
//! so that one camera has all of it in view. The second run renders the moments that are wanted, and no others.

use std::collections::BTreeSet;

use rayon::prelude::*;
use situ_sim::{Camera, Film, Image, Pose, SimError, World};
use situ_tasks::{Episode, Setting};

/// Pictures of a film for each simulated second.
const FILM_RATE: u16 = 8;

/// How much faster than the simulated world a film runs.
pub const FILM_SPEED: u16 = 3;

/// How long the last picture of a film stays, seconds of the viewer's time.
const REST: u16 = 1;

/// The most pictures of a film. A longer performance is filmed at a lower rate, so that its file stays small.
const MOST_FRAMES: usize = 400;

/// The most pictures in a strip.
const MOST_STILLS: usize = 8;

/// The widest strip, in pixels. Pictures that do not fit go into further rows.
const WIDEST_STRIP: u32 = 2000;

/// Steps between two looks at where things are. In so many steps, things move by less than a centimetre.
const LOOK_EVERY: usize = 16;

/// Worlds that are rendered at a time: enough to keep all processors busy, and few enough for the memory.
const BATCH: usize = 16;

/// Pixels: width and height of a picture.
pub type PixelSize = [u32; 2];

/// The first run's message to the second: where things go, and the hand's pose after each step.
pub struct Track {
    names: Vec<String>,
    boxes: Vec<[[f64; 3]; 2]>,
    hand: Vec<Pose>,
}

impl Track {
    /// The track of a performance that begins here.
    pub fn new(episode: &Episode) -> Self {
        let names = episode.setting().objects.iter().map(|placed| placed.body.name.clone());
        let mut track =
            Self { names: names.chain([situ_sim::HAND.to_owned()]).collect(), boxes: Vec::new(), hand: Vec::new() };
        track.look(episode.world());
        track
    }

    /// Takes note of a step.
    pub fn see(&mut self, world: &World) {
        self.hand.push(world.tcp());
        if self.hand.len().is_multiple_of(LOOK_EVERY) {
            self.look(world);
        }
    }

    fn look(&mut self, world: &World) {
        self.boxes.extend(self.names.iter().filter_map(|name| world.bounds(name)));
    }

    /// The camera that has all of the performance in view.
    pub fn camera(&self, [width, height]: PixelSize) -> Camera {
        Camera::around(&self.boxes, f64::from(width) / f64::from(height))
    }

    /// The last step at which the hand rests at each of these poses, one after the other. Steps count from 1.
    pub fn rests<'a>(&self, poses: impl IntoIterator<Item = &'a Pose>) -> Vec<usize> {
        let mut from = 0;
        let rest = |pose: &Pose| {
            let first = from + self.hand[from..].iter().position(|hand| hand == pose)?;
            from = first + self.hand[first..].iter().take_while(|hand| *hand == pose).count();
            Some(from)
        };
        poses.into_iter().map_while(rest).collect()
    }

    /// The steps, counted from 1.
    pub fn steps(&self) -> Vec<usize> {
        (1..=self.hand.len()).collect()
    }

    /// Steps between two pictures of the film.
    fn film_every(&self) -> usize {
        let steps_a_second = libm::round(1.0 / situ_sim::DT) as usize;
        (steps_a_second / usize::from(FILM_RATE)).max(self.hand.len().div_ceil(MOST_FRAMES - 1))
    }
}

/// At most eight of the moments, evenly chosen, the first and the last among them.
pub fn even_selection(moments: &[usize]) -> Vec<usize> {
    let wanted = moments.len().min(MOST_STILLS);
    let index = |nth: usize| (nth * (moments.len() - 1) + (wanted - 1) / 2) / (wanted - 1).max(1);
    (0..wanted).map(|nth| moments[index(nth)]).collect()
}

/// The second run, which renders the wanted moments.
pub struct Shooting {
    camera: Camera,
    size: PixelSize,
    every: usize,
    stills_at: BTreeSet<usize>,
    step: usize,
    last: usize,
    waiting: Vec<(World, Wanted)>,
    film: Film,
    stills: Vec<Image>,
    refused: Option<SimError>,
}

/// The purposes for which a world is rendered.
#[derive(Clone, Copy)]
struct Wanted {
    film: bool,
    still: bool,
}

impl Shooting {
    /// A shooting that will film the performance that begins here, whose track is known, and take a still picture after
    /// each of these steps.
    pub fn new(track: &Track, episode: &Episode, size: PixelSize, stills_at: &[usize]) -> Self {
        let mut shooting = Self {
            camera: track.camera(size),
            size,
            every: track.film_every(),
            stills_at: stills_at.iter().copied().collect(),
            step: 0,
            last: track.hand.len(),
            waiting: Vec::new(),
            film: Film::new(FILM_RATE * FILM_SPEED),
            stills: Vec::new(),
            refused: None,
        };
        shooting.take(episode.world());
        shooting
    }

    /// Takes the pictures of a step, if any are wanted.
    pub fn see(&mut self, world: &World) {
        self.step += 1;
        self.take(world);
    }

    fn take(&mut self, world: &World) {
        let film = self.step.is_multiple_of(self.every) || self.step == self.last;
        let wanted = Wanted { film, still: self.stills_at.contains(&self.step) };
        if wanted.film || wanted.still {
            self.waiting.push((world.clone(), wanted));
        }
        if self.waiting.len() == BATCH {
            self.develop();
        }
    }

    fn develop(&mut self) {
        let [width, height] = self.size;
        let waiting = std::mem::take(&mut self.waiting);
        let images: Vec<(Image, Wanted)> = waiting
            .into_par_iter()
            .map(|(world, wanted)| (self.camera.render(&world, width, height), wanted))
            .collect();
        for (image, wanted) in images {
            if wanted.still {
                self.stills.push(image.clone());
            }
            if wanted.film
                && let Err(error) = self.film.push(image)
            {
                self.refused.get_or_insert(error);
            }
        }
    }

    /// The film and the strip.
    ///
    /// # Errors
    /// Where the film could not be made.
    pub fn finish(mut self) -> Result<(Film, Image), SimError> {
        self.develop();
        self.film.rest(REST * FILM_RATE * FILM_SPEED);
        match self.refused {
            Some(error) => Err(error),
            None => Ok((self.film, strip(&self.stills))),
        }
    }
}

/// Pictures side by side, in as many rows as it takes.
fn strip(stills: &[Image]) -> Image {
    let width = stills.first().map_or(1, |image| image.width).max(1);
    let most = (WIDEST_STRIP / width).max(1) as usize;
    let rows = stills.len().div_ceil(most).max(1);
    let columns = stills.len().div_ceil(rows).max(1);
    Image::below(&stills.chunks(columns).map(Image::beside).collect::<Vec<_>>())
}

/// The start of an episode, twice as wide and high as the other pictures.
pub fn start(track: &Track, episode: &Episode, size: PixelSize) -> Image {
    let [width, height] = size.map(|pixels| 2 * pixels);
    track.camera(size).render(episode.world(), width, height)
}

/// The names of the files of a setting's pictures, without the last part.
pub fn stem(setting: &Setting) -> String {
    setting.label().replace('/', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_selection_is_even_and_keeps_both_ends() {
        assert!(even_selection(&[]).is_empty());
        assert_eq!(even_selection(&[7]), [7]);
        let moments: Vec<usize> = (0..8).collect();
        assert_eq!(even_selection(&moments), moments);
        for count in 9..60 {
            let moments: Vec<usize> = (100..100 + count).collect();
            let chosen = even_selection(&moments);
            assert_eq!((chosen.len(), chosen[0], chosen[7]), (8, 100, 99 + count));
            let gaps: Vec<usize> = chosen.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(gaps.iter().max().unwrap() - gaps.iter().min().unwrap() <= 1, "{count}: {gaps:?}");
        }
    }

    #[test]
    fn a_strip_wraps_into_rows_of_one_length() {
        let size = |count: usize, width: u32| {
            let strip = strip(&vec![Image::plain(width, 30, [0; 3]); count]);
            [strip.width, strip.height]
        };
        assert_eq!(size(8, 480), [4 * 480 + 3 * 4, 2 * 30 + 4]);
        assert_eq!(size(5, 480), [3 * 480 + 2 * 4, 2 * 30 + 4]);
        assert_eq!(size(3, 480), [3 * 480 + 2 * 4, 30]);
        assert_eq!(size(2, 5000), [5000, 2 * 30 + 4]);
    }
}
