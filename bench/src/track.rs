//! The track of a performance: where things go, so that one camera has all of it in view.

use situ_sim::{DT, Pose, World};
use situ_tasks::Episode;

/// Steps between two looks at where things are. In so many steps, things move by less than a centimetre.
const LOOK_EVERY: usize = 16;
/// The most worlds that are kept to see what hides what: a moment in each part of a performance, and few enough for the
/// memory.
const MOST_SAMPLES: usize = 16;

/// Where things go in a performance, the hand's pose after each step, and some moments of it.
pub struct Track {
    names: Vec<String>,
    boxes: Vec<[[f64; 3]; 2]>,
    hand: Vec<Pose>,
    /// Worlds at every so many-th look.
    samples: Vec<World>,
    sample_every: usize,
    looks: usize,
    /// Seconds of the episode, and steps of its world, at the beginning.
    began: (f64, u64),
    /// Steps of the world at the end.
    ended: u64,
}

impl Track {
    /// The track of a performance that begins here.
    pub fn new(episode: &Episode) -> Self {
        let names = episode.setting().objects.iter().map(|placed| placed.body.name.clone());
        let mut track = Self {
            names: names.chain([situ_sim::HAND.to_owned()]).collect(),
            boxes: Vec::new(),
            hand: Vec::new(),
            samples: Vec::new(),
            sample_every: 1,
            looks: 0,
            began: (episode.seconds(), episode.steps()),
            ended: episode.steps(),
        };
        track.look(episode.world());
        track
    }

    /// Takes note of a step.
    pub fn see(&mut self, world: &World) {
        self.hand.push(world.tcp());
        self.ended = world.steps();
        if self.hand.len().is_multiple_of(LOOK_EVERY) {
            self.look(world);
        }
    }

    fn look(&mut self, world: &World) {
        self.boxes.extend(self.names.iter().filter_map(|name| world.bounds(name)));
        if self.looks.is_multiple_of(self.sample_every) {
            self.samples.push(world.clone());
        }
        self.looks += 1;
        if self.samples.len() > MOST_SAMPLES {
            let mut index = 0..;
            self.samples.retain(|_| index.next().is_some_and(|index: usize| index.is_multiple_of(2)));
            self.sample_every *= 2;
        }
    }

    /// The boxes in which things were, metres, world frame.
    pub fn boxes(&self) -> &[[[f64; 3]; 2]] {
        &self.boxes
    }

    /// Moments of the performance, evenly spaced, the beginning among them.
    pub fn samples(&self) -> &[World] {
        &self.samples
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

    /// The number of steps that were seen.
    pub fn len(&self) -> usize {
        self.hand.len()
    }

    /// Whether nothing moved.
    pub fn is_empty(&self) -> bool {
        self.hand.is_empty()
    }

    /// The steps, counted from 1.
    pub fn steps(&self) -> Vec<usize> {
        (1..=self.hand.len()).collect()
    }

    /// Steps of the physics from the beginning to now, those that nobody saw among them.
    pub fn elapsed(&self, world: &World) -> u64 {
        world.steps() - self.began.1
    }

    /// Steps of the physics from the beginning to the end.
    pub fn duration(&self) -> u64 {
        self.ended - self.began.1
    }

    /// Simulated seconds since the start of the episode.
    pub fn seconds(&self, world: &World) -> f64 {
        self.began.0 + self.elapsed(world) as f64 * DT
    }
}

#[cfg(test)]
mod tests {
    use situ_tasks::{Plant, Registry};

    use super::*;

    #[test]
    fn a_track_keeps_even_moments_and_knows_the_time() {
        let registry = Registry::builtin().unwrap().with_plant(Plant::Hand);
        let setting = registry.get("press").unwrap().variation(None).unwrap();
        let mut episode = Episode::start(&setting, 3).unwrap();
        let mut track = Track::new(&episode);
        let begun = episode.steps();
        for height in [0.3, 0.2, 0.3, 0.2, 0.3] {
            let pose = Pose::translation(0.0, 0.0, height);
            episode.perform(&pose, None, 1.0, &mut |world| track.see(world));
        }
        assert!(track.len() > MOST_SAMPLES * LOOK_EVERY, "{} steps", track.len());
        assert!((MOST_SAMPLES / 2..=MOST_SAMPLES).contains(&track.samples().len()));
        let steps: Vec<u64> = track.samples().iter().map(World::steps).collect();
        let gaps: Vec<u64> = steps.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps[0] == begun && gaps.iter().all(|gap| *gap == gaps[0]), "{gaps:?}");
        assert_eq!(track.duration(), episode.steps() - begun);
        assert!((track.seconds(episode.world()) - episode.seconds()).abs() < 1e-9);
    }
}
