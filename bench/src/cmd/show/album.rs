//! The files that are to be written, and what is to be printed about them.

use std::path::PathBuf;

use situ_sim::{Film, Image};

use crate::caption::PixelSize;
use crate::error::BenchError;
use crate::performance::Performance;
use crate::pictures::{self, FILM_SPEED, Look};

/// A performance that becomes a strip and a film.
pub(super) struct Piece<'a> {
    /// The last part of the film's name.
    pub(super) film: String,
    /// The last part of the strip's name.
    pub(super) strip: String,
    /// What is filmed.
    pub(super) about: String,
    /// Which moments the strip has.
    pub(super) moments: String,
    /// What is printed after the files.
    pub(super) said: String,
    pub(super) performance: Performance<'a>,
}

/// Files and text, in order.
pub(super) struct Album {
    folder: PathBuf,
    /// The first part of all names.
    stem: String,
    size: PixelSize,
    pub(super) files: Vec<(PathBuf, Vec<u8>)>,
    pub(super) said: Vec<String>,
}

impl Album {
    pub(super) fn new(folder: PathBuf, stem: String, size: PixelSize) -> Self {
        Self { folder, stem, size, files: Vec::new(), said: Vec::new() }
    }

    fn add(&mut self, what: &str, bytes: Vec<u8>, about: &str) {
        let path = self.folder.join(format!("{}-{what}", self.stem));
        self.said.push(format!("{}  {} kB, {about}\n", path.display(), bytes.len().div_ceil(1000)));
        self.files.push((path, bytes));
    }

    pub(super) fn add_image(&mut self, what: &str, image: &Image, about: &str) -> Result<(), BenchError> {
        let about = format!("{} × {}, {about}", image.width, image.height);
        self.add(&format!("{what}.png"), image.png()?, &about);
        Ok(())
    }

    fn add_film(&mut self, what: &str, film: &Film, about: &str, is_plain: bool) -> Result<(), BenchError> {
        let ([width, height], frames, seconds) = (self.size, film.frames(), film.seconds());
        let about = |kind: &str| {
            format!(
                "{width} × {height}, {about}: {kind} of {frames} frames and {seconds:.1} s, {FILM_SPEED} times as fast"
            )
        };
        let png = if is_plain { film.png()? } else { film.sparse_png()? };
        self.add(&format!("{what}.png"), png, &about("an animated PNG"));
        self.add(&format!("{what}.gif"), film.gif()?, &about("a GIF"));
        Ok(())
    }

    /// Films a piece. Nothing is added to an album by halves.
    pub(super) fn add_piece(&mut self, piece: &Piece<'_>, look: &Look) -> Result<(), BenchError> {
        let stills = pictures::even_selection(&piece.performance.moments);
        let (film, strip) = pictures::shoot(&piece.performance, look, &stills)?;
        if !stills.is_empty() {
            self.add_image(&piece.strip, &strip, &piece.moments)?;
        }
        self.add_film(&piece.film, &film, &piece.about, look.is_plain())?;
        self.said.push(piece.said.clone());
        Ok(())
    }
}

pub(super) fn yes_or_no(holds: bool) -> &'static str {
    if holds { "yes" } else { "no" }
}
