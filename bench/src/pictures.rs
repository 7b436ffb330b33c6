//! Pictures of a performance: of its start, of chosen moments side by side, and of all of it as a film.
//!
//! The first time of a [`Performance`] tells where things go, so that one camera has all of it in view. Then it is done
//! once more, and the moments that are wanted are rendered, and no others.

use std::collections::BTreeSet;

use rayon::prelude::*;
use situ_sim::{Film, Image, SimError, World};
use situ_tasks::{Episode, Setting};

use crate::caption::{Band, PixelSize};
use crate::error::BenchError;
use crate::performance::Performance;
use crate::track::Track;
use crate::view::CameraView;

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

/// Worlds that are rendered at a time: enough to keep all processors busy, and few enough for the memory.
const BATCH: usize = 16;

/// At most eight of the moments, evenly chosen, the first and the last among them.
pub fn even_selection(moments: &[usize]) -> Vec<usize> {
    let wanted = moments.len().min(MOST_STILLS);
    let index = |nth: usize| (nth * (moments.len() - 1) + (wanted - 1) / 2) / (wanted - 1).max(1);
    (0..wanted).map(|nth| moments[index(nth)]).collect()
}

/// How performances are looked at.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    view: CameraView,
    size: PixelSize,
    band: Option<Band>,
    is_plain: bool,
}

impl Look {
    /// Pictures of this size, from the viewpoint from which most is seen of these things, with captions where there is
    /// room for them.
    pub fn clearest(tracks: &[&Track], things: &[&str], size: PixelSize) -> Self {
        let band = Band::of(size);
        let height = size[1] - band.map_or(0, Band::height);
        let view = CameraView::clearest(tracks, things, f64::from(size[0]) / f64::from(height));
        Self { view, size, band, is_plain: false }
    }

    /// Pictures of this size from the front, without captions.
    pub fn plain(track: &Track, size: PixelSize) -> Self {
        let view = CameraView::front(&[track], f64::from(size[0]) / f64::from(size[1]));
        Self { view, size, band: None, is_plain: true }
    }

    /// Whether it is from the front and without captions, wherever that hides something.
    pub fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// The name of the viewpoint.
    pub fn viewpoint(&self) -> &'static str {
        self.view.name
    }

    /// The height that the world is given in a picture.
    fn height(&self) -> u32 {
        self.size[1] - self.band.map_or(0, Band::height)
    }

    /// The start of an episode, twice as wide and high as the world in other pictures.
    pub fn start(&self, episode: &Episode) -> Image {
        self.view.camera.render(episode.world(), 2 * self.size[0], 2 * self.height())
    }
}

/// Does a performance once more, and films it. Returns the film, and a strip of the pictures after each of these steps.
///
/// # Errors
/// Those of the performance; [`BenchError::Picture`] where the film could not be made.
pub fn shoot(performance: &Performance<'_>, look: &Look, stills_at: &[usize]) -> Result<(Film, Image), BenchError> {
    let mut shooting = Shooting::new(performance, look, stills_at);
    performance.again(&mut |world| shooting.see(world))?;
    Ok(shooting.finish()?)
}

/// Renders the wanted moments.
struct Shooting<'a> {
    performance: &'a Performance<'a>,
    look: &'a Look,
    /// Steps between two pictures of the film.
    every: usize,
    stills_at: BTreeSet<usize>,
    step: usize,
    /// Pictures that the film has by now, those that stand still among them.
    filmed: u64,
    waiting: Vec<(World, Wanted)>,
    film: Film,
    stills: Vec<Image>,
    refused: Option<SimError>,
}

/// The purposes for which a world is rendered.
#[derive(Clone, Copy)]
struct Wanted {
    step: usize,
    /// For the film, which first shows the picture before for so many more pictures' time.
    film: Option<u16>,
    still: bool,
}

impl<'a> Shooting<'a> {
    fn new(performance: &'a Performance<'a>, look: &'a Look, stills_at: &[usize]) -> Self {
        let steps_a_second = libm::round(1.0 / situ_sim::DT) as usize;
        let every = (steps_a_second / usize::from(FILM_RATE)).max(performance.track.len().div_ceil(MOST_FRAMES - 1));
        let mut shooting = Self {
            performance,
            look,
            every,
            stills_at: stills_at.iter().copied().collect(),
            step: 0,
            filmed: 0,
            waiting: Vec::new(),
            film: Film::new(lasts(every, steps_a_second)),
            stills: Vec::new(),
            refused: None,
        };
        shooting.take(performance.start.world());
        shooting
    }

    /// Takes the pictures of a step, if any are wanted.
    fn see(&mut self, world: &World) {
        self.step += 1;
        self.take(world);
    }

    fn take(&mut self, world: &World) {
        let is_filmed = self.step.is_multiple_of(self.every) || self.step == self.performance.track.len();
        let film = is_filmed.then(|| self.wait(world));
        let wanted = Wanted { step: self.step, film, still: self.stills_at.contains(&self.step) };
        if wanted.film.is_some() || wanted.still {
            self.waiting.push((world.clone(), wanted));
        }
        if self.waiting.len() == BATCH {
            self.develop();
        }
    }

    /// How many pictures' time has passed unseen since the last picture of the film: somebody bumped into something,
    /// say, and time passed for which there is no picture.
    fn wait(&mut self, world: &World) -> u16 {
        let place = self.performance.track.elapsed(world) / self.every as u64;
        let unseen = place.saturating_sub(self.filmed);
        self.filmed += unseen + 1;
        u16::try_from(unseen).unwrap_or(u16::MAX)
    }

    fn develop(&mut self) {
        let [width, _] = self.look.size;
        let (look, Performance { track, captions, .. }) = (self.look, self.performance);
        let waiting = std::mem::take(&mut self.waiting);
        let images: Vec<(Image, Wanted)> = waiting
            .into_par_iter()
            .map(|(world, wanted)| {
                let image = look.view.camera.render(&world, width, look.height());
                let when = (wanted.step, track.seconds(&world));
                let image = look.band.map(|band| band.below(&image, captions, when)).unwrap_or(image);
                (image, wanted)
            })
            .collect();
        for (image, wanted) in images {
            if wanted.still {
                self.stills.push(image.clone());
            }
            let Some(unseen) = wanted.film else { continue };
            self.film.rest(unseen);
            if let Err(error) = self.film.push(image) {
                self.refused.get_or_insert(error);
            }
        }
    }

    /// The film and the strip.
    ///
    /// # Errors
    /// Where the film could not be made.
    fn finish(mut self) -> Result<(Film, Image), SimError> {
        self.develop();
        let rest = self.film.pictures_in(REST);
        self.film.rest(rest);
        match self.refused {
            Some(error) => Err(error),
            None => Ok((self.film, strip(&self.stills))),
        }
    }
}

/// How long a picture of a film is shown where there is one for so many steps, seconds as a fraction in lowest terms.
fn lasts(every: usize, steps_a_second: usize) -> [u16; 2] {
    let (mut above, mut below) = (every, steps_a_second * usize::from(FILM_SPEED));
    for factor in (2..=above.min(below)).rev() {
        if above.is_multiple_of(factor) && below.is_multiple_of(factor) {
            (above, below) = (above / factor, below / factor);
        }
    }
    [above, below].map(|number| u16::try_from(number).unwrap_or(u16::MAX))
}

/// Pictures side by side, in as many rows as it takes.
fn strip(stills: &[Image]) -> Image {
    let width = stills.first().map_or(1, |image| image.width).max(1);
    let most = (WIDEST_STRIP / width).max(1) as usize;
    let rows = stills.len().div_ceil(most).max(1);
    let columns = stills.len().div_ceil(rows).max(1);
    Image::below(&stills.chunks(columns).map(Image::beside).collect::<Vec<_>>())
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

    /// A long performance, of which there are fewer pictures a second, used to run faster than was said.
    #[test]
    fn a_film_keeps_the_time_whatever_its_rate() {
        assert_eq!(lasts(30, 240), [1, 24]);
        for every in 30..400 {
            let [above, below] = lasts(every, 240);
            let seconds = f64::from(above) / f64::from(below);
            assert!((seconds - every as f64 / 240.0 / f64::from(FILM_SPEED)).abs() < 1e-12);
            assert!((2..=above).all(|factor| above % factor > 0 || below % factor > 0), "{above}/{below}");
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
