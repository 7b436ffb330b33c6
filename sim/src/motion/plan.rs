//! The plan of a motion: straight where the arm can follow, else by a way round.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::arm::connect::Space;
use crate::arm::{Arm, ArmModel, Configuration, Joint};
use crate::frame::Pose;
use crate::motion::obstacles::Obstacles;
use crate::motion::pace::Pace;
use crate::motion::route::{self, Route};
use crate::world::World;

/// A joint that would have to turn by more than this from one look to the next cannot follow, radians.
const JUMP: f64 = 0.35;
/// How many different configurations at the target are goals of the search.
const GOALS: usize = 3;
/// Two configurations nearer than this are one, radians.
const SAME: f64 = 1e-3;
/// The search is given up after so many iterations. It is a count and not a time, so the plan is the same on every
/// machine.
const ITERATIONS: usize = 3000;
/// How often the search tries to shorten the way that it has found.
const SHORTCUTS: usize = 80;

/// Why there is no way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unplanned {
    /// No angles within the joints' ranges put the hand there.
    OutOfReach,
    /// The arm can hold the hand there, but would run into something, there or on every way that was tried.
    NoPlan,
}

impl World {
    /// The hand's way to a pose, straight unless an arm carries it and cannot follow, and its course in time.
    pub(crate) fn plan(&mut self, to: Pose) -> Result<(Route, Pace), Unplanned> {
        let from = *self.hand.target();
        let seed = self.arm.as_mut().map_or(0, Arm::next_seed);
        let obstacles = Obstacles::new(self);
        let route = match &self.arm {
            Some(arm) => arm.route(&obstacles, from, to, seed)?,
            None => Route::free(from, to),
        };
        let pace = Pace::new(&route.pieces(&obstacles));
        Ok((route, pace))
    }
}

impl Arm {
    /// The hand's way: straight where the arm can follow, else round what is in the way.
    fn route(&self, obstacles: &Obstacles, from: Pose, to: Pose, seed: u64) -> Result<Route, Unplanned> {
        // On the straight way hand and load may touch things, since that is what they are there to do. The guard
        // watches over them.
        let is_followed = |configuration: &Configuration| obstacles.are_clear_of(&self.shells, configuration);
        if let Some(configurations) = self.follow(&from, &to, &is_followed) {
            return Ok(Route::followed(from, to, &configurations, &self.shells.model));
        }
        // A way round may lead anywhere, so there hand and load must touch nothing.
        let is_free = |configuration: &Configuration| obstacles.are_clear_of_all(&self.shells, configuration);
        let way = self.way_round(&to, seed, &is_free)?;
        Ok(Route::through(&way, to, &self.shells.model))
    }

    /// The arm's configurations on the straight way, if it can follow: none runs into anything, none is far from the
    /// last.
    fn follow(&self, from: &Pose, to: &Pose, is_free: &dyn Fn(&Configuration) -> bool) -> Option<Vec<Configuration>> {
        let mut configurations = vec![self.configuration];
        for target in route::straight(from, to) {
            let before = configurations[configurations.len() - 1];
            let next = self.shells.model.solve(&target, &before, &self.rest)?;
            if (next - before).amax() > JUMP || !is_free(&next) {
                return None;
            }
            configurations.push(next);
        }
        Some(configurations)
    }

    /// A way to the target through the joints' angles.
    fn way_round(
        &self,
        to: &Pose,
        seed: u64,
        is_free: &dyn Fn(&Configuration) -> bool,
    ) -> Result<Vec<Configuration>, Unplanned> {
        let mut found: Vec<Configuration> =
            self.shells.model.solutions(to, &self.configuration, &self.rest, seed).collect();
        if found.is_empty() {
            return Err(Unplanned::OutOfReach);
        }
        // The nearest to the rest come first: from there the arm can go on best. The sort is stable, so equals stay in
        // the order of the draws.
        found.sort_by(|a, b| (a - self.rest).norm_squared().total_cmp(&(b - self.rest).norm_squared()));
        let mut goals: Vec<Configuration> = Vec::new();
        for goal in found {
            if goals.len() < GOALS && goals.iter().all(|known| (known - goal).amax() > SAME) && is_free(&goal) {
                goals.push(goal);
            }
        }
        let (lower, upper) = bounds(&self.shells.model);
        let space = Space { lower, upper, is_free };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let way = space.connect(&self.configuration, &goals, ITERATIONS, &mut rng).ok_or(Unplanned::NoPlan)?;
        Ok(space.shorten(way, SHORTCUTS, &mut rng))
    }
}

/// The least and the greatest angles.
fn bounds(model: &ArmModel) -> (Configuration, Configuration) {
    let bound = |of: fn(&Joint) -> f64| Configuration::from_fn(|joint, _| of(&model.joints[joint]));
    (bound(|joint| joint.lower), bound(|joint| joint.upper))
}
