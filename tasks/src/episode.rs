//! An episode: a world, a setting, and the events that have happened. No other place of this crate moves a hand.

use std::sync::Arc;

use situ_sim::{GripperCommand, MAX_OPENING, MotionEnd, Pose, Snapshot, TABLE, World};

use crate::error::TaskError;
use crate::event::Happening;
use crate::intervention::Intervention;
use crate::measure::is_held;
use crate::moment::Moment;
use crate::predicate::Predicate;
use crate::setting::Setting;
use crate::sight::Sight;
use crate::skill::Skill;
use crate::start;
use crate::view::View;

/// How long the hand takes hold of what has been dropped, in seconds. The fingers need 0.27 s for their stroke.
const GRIP_SECONDS: f64 = 0.5;

/// A hand that has to rise by more than this goes up first and then over, in metres. On a straight way, what it holds
/// would scrape along the wall that it has to get over.
pub const RISE_FIRST: f64 = 0.05;

/// One attempt at a setting, from a start that the seed decides. A copy goes on exactly as the original does, bit for
/// bit.
#[derive(Clone)]
pub struct Episode {
    setting: Arc<Setting>,
    world: World,
    fired: Vec<bool>,
    began: f64,
    path: f64,
    /// What the camera has seen, if there is one.
    sight: Option<Sight>,
}

/// An episode put aside.
#[derive(Clone, Debug)]
pub struct EpisodeSnapshot {
    setting: Arc<Setting>,
    world: Snapshot,
    fired: Vec<bool>,
    began: f64,
    path: f64,
    sight: Option<Sight>,
}

impl Episode {
    /// Puts the objects at random places in their regions, fills, lets all settle, and checks the premise.
    ///
    /// # Errors
    /// [`TaskError::Crowded`], [`TaskError::Premise`], or [`TaskError::World`] where the physics refuses the scene.
    pub fn start(setting: &Arc<Setting>, seed: u64) -> Result<Episode, TaskError> {
        let world = start::world(setting, seed)?;
        let fired = vec![false; setting.events.len()];
        let began = world.time();
        let sight = setting.perception.map(|_| Sight::new(seed));
        let mut episode = Episode { setting: Arc::clone(setting), world, fired, began, path: 0.0, sight };
        episode.look();
        Ok(episode)
    }

    /// The setting.
    pub fn setting(&self) -> &Arc<Setting> {
        &self.setting
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world as it is, and as a person sees it.
    pub fn view(&self) -> View<'_> {
        self.setting.view(&self.world)
    }

    /// The world as the robot sees it: by its camera, where the setting has one.
    pub fn seen(&self) -> View<'_> {
        self.setting.seen(&self.world, self.sight.as_ref())
    }

    /// The camera takes a picture.
    fn look(&mut self) {
        if let Some((sight, perception)) = self.sight.as_mut().zip(self.setting.perception) {
            sight.look(&perception, &self.world);
        }
    }

    /// The observed state: raw physical units, one value for each feature of the setting's schema.
    pub fn observe(&self) -> Vec<f64> {
        self.setting.schema.observe(self.seen())
    }

    /// The frame that keyframes on an object are relative to, as the robot sees it: the object's origin and heading,
    /// with z vertical. Of a role it is the frame of the object that fills it. None if the object is not there, or has
    /// not been seen, or nothing fills the role.
    pub fn reference_pose(&self, name: &str) -> Option<Pose> {
        let seen = self.seen();
        seen.reference_frame(seen.object(name)?)
    }

    /// The same as a person sees it, who is never mistaken.
    pub fn true_reference_pose(&self, name: &str) -> Option<Pose> {
        let view = self.view();
        view.reference_frame(view.object(name)?)
    }

    /// Moves the hand to `target` (pose of the TCP, world frame), gives the gripper its command and waits until
    /// it has obeyed (at most half a second), then waits `hold` seconds. `observer` sees each step.
    ///
    /// The way is straight. Only a rise of more than [`RISE_FIRST`] without a turn goes up first and then over. If the
    /// guard stops the motion, the gripper command and the wait still follow. If the motion is aborted or cannot be
    /// made, nothing follows.
    pub fn perform(
        &mut self,
        target: &Pose,
        gripper: Option<GripperCommand>,
        hold: f64,
        observer: &mut dyn FnMut(&World),
    ) -> MotionEnd {
        let mut last = self.world.tcp().translation.vector;
        let mut way = 0.0;
        let mut watch = |world: &World| {
            let now = world.tcp().translation.vector;
            way += (now - last).norm();
            last = now;
            observer(world);
        };
        let end = match above(&self.world.tcp(), target) {
            // If the arm cannot go up first, it goes as it can.
            Some(corner) => match self.world.move_hand(corner, &mut watch) {
                MotionEnd::Reached | MotionEnd::OutOfReach | MotionEnd::NoPlan => {
                    self.world.move_hand(*target, &mut watch)
                }
                stopped => stopped,
            },
            None => self.world.move_hand(*target, &mut watch),
        };
        if end.goes_on() {
            if let Some(command) = gripper {
                self.world.grip(command, &mut watch);
            }
            // Longer than the task may take makes no difference, and would keep everybody waiting.
            self.world.hold(hold.min(self.setting.time_limit), &mut watch);
        }
        self.path += way;
        self.look();
        end
    }

    /// Says that the hand has reached keyframe `index` (from 0) of a primitive on `reference`. Events that wait for
    /// this keyframe happen now, each once.
    ///
    /// A push happens at its very keyframe. A drop happens there, or at the first later keyframe at which the object
    /// hangs free in the hand. So a primitive that was learned with one keyframe more is still interrupted in the air,
    /// and not while the hand closes on the table.
    pub fn reached_keyframe(&mut self, reference: &str, index: usize) {
        let setting = Arc::clone(&self.setting);
        let mut has_happened = false;
        for (k, event) in setting.events.iter().enumerate() {
            let is_now = match &event.happening {
                Happening::Push { .. } => index == event.keyframe,
                Happening::Drop { object } => index >= event.keyframe && self.hangs(object),
            };
            if self.fired[k] || event.reference != reference || !is_now {
                continue;
            }
            self.fired[k] = true;
            has_happened = true;
            match &event.happening {
                // Names and durations were checked with the file. A push that the physics refuses does not happen.
                Happening::Push { object, by } => {
                    if self.world.push(object, *by, event.seconds).is_ok() {
                        self.world.settle(event.seconds);
                    }
                }
                Happening::Drop { .. } => {
                    let command = self.world.gripper();
                    self.world.command(GripperCommand::Open(MAX_OPENING));
                    self.world.settle(event.seconds);
                    self.world.command(command);
                    self.world.settle(GRIP_SECONDS);
                }
            }
        }
        if has_happened {
            self.look();
        }
    }

    /// Whether an object is held and touches nothing but the hand.
    fn hangs(&self, object: &str) -> bool {
        let mut others = self.world.objects().chain([TABLE]);
        is_held(&self.world, object) && !others.any(|other| self.world.touching(object, other))
    }

    /// How many of the setting's events have happened.
    pub fn events_fired(&self) -> usize {
        self.fired.iter().filter(|fired| **fired).count()
    }

    /// Whether a condition holds now, in the world as it is.
    pub fn holds(&self, predicate: &Predicate) -> bool {
        predicate.holds(self.view())
    }

    /// Whether the goal is achieved now.
    pub fn succeeded(&self) -> bool {
        self.is_sound() && self.holds(&self.setting.goal)
    }

    /// The competent teacher's next skill, by a teleo-reactive choice: the first whose `when` holds and whose `until`
    /// does not.
    pub fn next_skill(&self) -> Option<&Skill> {
        self.setting.skills.iter().find(|skill| self.holds(&skill.when) && !self.holds(&skill.until))
    }

    /// The intervention by which a watching teacher stops the robot at this moment of a primitive on `reference`, if
    /// there is one. For teaching alone.
    pub fn intervention(&self, moment: Moment, reference: &str) -> Option<&Intervention> {
        self.setting.interventions.iter().find(|intervention| {
            intervention.moment == moment
                && intervention.reference.as_ref().is_none_or(|name| name == reference)
                && self.holds(&intervention.when)
        })
    }

    /// Simulated seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.world.time() - self.began
    }

    /// Steps of the physics since the world was made, those in which it settled among them.
    pub fn steps(&self) -> u64 {
        self.world.steps()
    }

    /// About how many bytes a copy takes.
    pub fn bytes(&self) -> usize {
        self.world.bytes()
    }

    /// Metres that the hand has travelled.
    pub fn path(&self) -> f64 {
        self.path
    }

    /// Whether the time limit has passed.
    pub fn finished_out_of_time(&self) -> bool {
        self.seconds() > self.setting.time_limit
    }

    /// Whether the numbers of the physics are still sound. If they are not, the run is spoilt, and that is no failure
    /// of the robot.
    pub fn is_sound(&self) -> bool {
        self.world.is_finite()
    }

    /// Puts the present state aside.
    pub fn snapshot(&self) -> EpisodeSnapshot {
        EpisodeSnapshot {
            setting: Arc::clone(&self.setting),
            world: self.world.snapshot(),
            fired: self.fired.clone(),
            began: self.began,
            path: self.path,
            sight: self.sight.clone(),
        }
    }

    /// An episode that goes on from the snapshot, bit for bit.
    pub fn restore(snapshot: &EpisodeSnapshot) -> Episode {
        Episode {
            setting: Arc::clone(&snapshot.setting),
            world: World::restore(&snapshot.world),
            fired: snapshot.fired.clone(),
            began: snapshot.began,
            path: snapshot.path,
            sight: snapshot.sight.clone(),
        }
    }
}

/// The pose at which a motion turns from up to over, if it does.
fn above(from: &Pose, to: &Pose) -> Option<Pose> {
    /// A motion that turns the hand by more than this is more than a rise, in radians.
    const TURN: f64 = 0.35;
    let rise = to.translation.z - from.translation.z;
    let sine = (from.rotation.inverse() * to.rotation).imag().norm();
    let turns = 2.0 * libm::asin(sine.min(1.0)) > TURN;
    (rise > RISE_FIRST && !turns).then(|| {
        let mut corner = *from;
        corner.translation.z = to.translation.z;
        corner
    })
}

impl std::fmt::Debug for Episode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Episode {{ {}, {:.2} s, {:.2} m }}", self.setting.label(), self.seconds(), self.path)
    }
}
