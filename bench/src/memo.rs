//! What has been simulated already.
//!
//! The starts of an evaluation have no method in their names, so many methods meet the same ones. From the same start
//! the same primitives lead to the same state, bit for bit, whoever performs them. So they are simulated once: a model
//! that several methods share, the nodes that a correction did not touch, a failure that is looked at once more while a
//! teacher watches. What the memo holds decides how long a run takes, and nothing else.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use situ::segment::RelativeKeyframe;
use situ_tasks::Episode;
use situ_teachers::Shown;

use crate::ended::Ended;
use crate::error::BenchError;
use crate::spending::Steps;
use crate::starts::Starts;

/// Copies of episodes are kept up to so many bytes, in all memos of a room together. Beyond that nothing new is kept.
const ROOM: usize = 1 << 29;

/// The name of a start: the setting, the starts of the evaluation, and the rollout.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Beginning {
    /// The setting's label.
    pub setting: String,
    /// The starts.
    pub starts: Starts,
    /// The rollout.
    pub index: u32,
}

/// A primitive that is to be performed.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Its reference object.
    pub reference: Arc<str>,
    /// Its keyframes, in the frame of the reference object.
    pub keyframes: Vec<RelativeKeyframe>,
    /// The moments of the guard that a watching teacher still lets pass; `None` where nobody watches them.
    pub patience: Option<u32>,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Performed {
    /// Why it was not performed to its end, if it was not.
    pub ended: Option<Ended>,
    /// Whether the guard stopped a motion: then it matters whether a teacher watches.
    pub guarded: bool,
    /// The moments of the guard that a watching teacher let pass.
    pub missed: u32,
}

/// A primitive that was performed, and the state in which it left the episode.
struct Step {
    action: Action,
    performed: Performed,
    episode: Arc<Episode>,
    next: Vec<usize>,
}

/// All that was performed from one start.
#[derive(Default)]
struct Tree {
    /// `None` where the physics refused the start.
    start: Option<Option<Arc<Episode>>>,
    steps: Vec<Step>,
    first: Vec<usize>,
}

impl Tree {
    /// The bytes that its episodes take.
    fn bytes(&self) -> usize {
        let steps = self.steps.iter().map(|step| &step.episode);
        self.start.iter().flatten().chain(steps).map(|episode| episode.bytes()).sum()
    }

    /// The step that performs this after that.
    fn find(&self, after: Stand, action: &Action) -> Option<usize> {
        let next = match after {
            Stand::Start => &self.first,
            Stand::Step(index) => &self.steps[index].next,
            Stand::Off => return None,
        };
        let is_it = |step: &Step| {
            let same = step.action.reference == action.reference && step.action.keyframes == action.keyframes;
            same && (step.action.patience == action.patience || !step.performed.guarded)
        };
        next.iter().copied().find(|index| is_it(&self.steps[*index]))
    }
}

/// Where an episode stands in the memo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stand {
    Start,
    /// After this step.
    Step(usize),
    /// Beyond what there was room for.
    Off,
}

/// The room that memos share, however many threads there are.
#[derive(Debug, Default)]
pub struct Room {
    taken: AtomicUsize,
}

impl Room {
    /// Takes so many bytes, if there are so many left.
    fn take(&self, bytes: usize) -> bool {
        let is_room = self.taken.fetch_add(bytes, Ordering::Relaxed) + bytes <= ROOM;
        if !is_room {
            self.give_back(bytes);
        }
        is_room
    }

    fn give_back(&self, bytes: usize) {
        self.taken.fetch_sub(bytes, Ordering::Relaxed);
    }
}

/// What has been simulated already in the runs of one original task.
pub struct Memo<'a> {
    trees: Mutex<BTreeMap<Beginning, Arc<Mutex<Tree>>>>,
    shown: Mutex<BTreeMap<(Beginning, Stand, u32), Arc<Shown>>>,
    room: &'a Room,
}

/// An episode on its way, and where it stands in the memo.
pub struct Cursor<'a> {
    memo: &'a Memo<'a>,
    origin: Beginning,
    tree: Arc<Mutex<Tree>>,
    stand: Stand,
    episode: Arc<Episode>,
    /// Simulated steps that the memo had.
    replayed: u64,
}

/// A run that panicked while it held a part of the memo has changed nothing there by halves.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Memo<'a> {
    /// A memo that knows nothing yet, and takes its room here.
    pub fn new(room: &'a Room) -> Self {
        Self { trees: Mutex::default(), shown: Mutex::default(), room }
    }

    /// The episode of a start, made by `make` where it is new. `None` where the physics refused it.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn start(
        &self,
        origin: Beginning,
        make: impl FnOnce() -> Result<Option<Episode>, BenchError>,
    ) -> Result<Option<Cursor<'_>>, BenchError> {
        let tree = Arc::clone(locked(&self.trees).entry(origin.clone()).or_default());
        let mut trunk = locked(&tree);
        let (episode, replayed) = match &trunk.start {
            Some(episode) => (episode.clone(), episode.as_ref().map_or(0, |episode| episode.steps())),
            None => {
                let episode = make()?.map(Arc::new);
                if episode.as_ref().is_none_or(|episode| self.room.take(episode.bytes())) {
                    trunk.start = Some(episode.clone());
                }
                (episode, 0)
            }
        };
        drop(trunk);
        Ok(episode.map(|episode| Cursor { memo: self, origin, tree, stand: Stand::Start, episode, replayed }))
    }

    /// Forgets all that was simulated in a setting.
    pub fn forget(&self, setting: &str) {
        self.forget_where(&|beginning| beginning.setting == setting);
    }

    fn forget_where(&self, is_it: &dyn Fn(&Beginning) -> bool) {
        let mut bytes = 0;
        locked(&self.trees).retain(|beginning, tree| {
            let goes = is_it(beginning);
            bytes += if goes { locked(tree).bytes() } else { 0 };
            !goes
        });
        locked(&self.shown).retain(|(beginning, ..), _| !is_it(beginning));
        self.room.give_back(bytes);
    }
}

impl Drop for Memo<'_> {
    fn drop(&mut self) {
        self.forget_where(&|_| true);
    }
}

impl Cursor<'_> {
    /// The episode.
    pub fn episode(&self) -> &Episode {
        &self.episode
    }

    /// The steps of the episode: those that were simulated for it, and those that the memo had.
    pub fn steps(&self) -> Steps {
        Steps { simulated: self.episode.steps() - self.replayed, replayed: self.replayed }
    }

    /// Performs a primitive: by `perform`, where the memo does not have it.
    pub fn perform(&mut self, action: Action, perform: impl FnOnce(&mut Episode, &Action) -> Performed) -> Performed {
        let known = {
            let tree = locked(&self.tree);
            let index = tree.find(self.stand, &action);
            index.map(|index| (index, Arc::clone(&tree.steps[index].episode), tree.steps[index].performed.clone()))
        };
        if let Some((index, episode, performed)) = known {
            self.replayed += episode.steps() - self.episode.steps();
            (self.stand, self.episode) = (Stand::Step(index), episode);
            return performed;
        }
        let performed = perform(Arc::make_mut(&mut self.episode), &action);
        self.stand = self.keep(action, &performed);
        performed
    }

    /// Keeps what was just performed, if there is room; returns where the episode now stands.
    fn keep(&self, action: Action, performed: &Performed) -> Stand {
        if self.stand == Stand::Off || !self.memo.room.take(self.episode.bytes()) {
            return Stand::Off;
        }
        let mut tree = locked(&self.tree);
        let index = tree.steps.len();
        let (performed, episode) = (performed.clone(), Arc::clone(&self.episode));
        tree.steps.push(Step { action, performed, episode, next: Vec::new() });
        match self.stand {
            Stand::Step(before) => tree.steps[before].next.push(index),
            Stand::Start | Stand::Off => tree.first.push(index),
        }
        Stand::Step(index)
    }

    /// What a teacher shows from here at an attempt: by `show`, where the memo does not have it.
    ///
    /// # Errors
    /// Those of `show`.
    pub fn shown(
        &self,
        attempt: u32,
        show: impl FnOnce(Episode) -> Result<Shown, BenchError>,
    ) -> Result<Arc<Shown>, BenchError> {
        let key = (self.origin.clone(), self.stand, attempt);
        let is_known = self.stand != Stand::Off;
        if let (true, Some(shown)) = (is_known, locked(&self.memo.shown).get(&key)) {
            return Ok(Arc::clone(shown));
        }
        let shown = Arc::new(show((*self.episode).clone())?);
        if is_known {
            locked(&self.memo.shown).insert(key, Arc::clone(&shown));
        }
        Ok(shown)
    }
}

#[cfg(test)]
mod tests {
    use situ::demonstration::{Gripper, Pose};
    use situ_tasks::{Plant, Registry};

    use super::*;

    fn action(heights: &[f64], patience: Option<u32>) -> Action {
        let pose = |height: &f64| Pose::translation(0.0, 0.0, *height);
        let keyframe =
            |height: &f64| RelativeKeyframe { pose: pose(height), gripper: Gripper::Opening(0.06), hold: 0.1 };
        Action { reference: "red_1".into(), keyframes: heights.iter().map(keyframe).collect(), patience }
    }

    /// Performs the keyframes over the middle of the table, and says that the guard was met or was not.
    fn perform(episode: &mut Episode, action: &Action, guarded: bool) -> Performed {
        for keyframe in &action.keyframes {
            episode.perform(&keyframe.pose, None, keyframe.hold, &mut |_| {});
        }
        Performed { ended: None, guarded, missed: 0 }
    }

    #[test]
    fn what_was_performed_is_not_performed_again_and_nothing_else_is_taken_for_it() {
        let registry = Registry::builtin().unwrap().with_plant(Plant::Hand);
        let setting = registry.get("sort_blocks").unwrap().variation(None).unwrap();
        let room = Room::default();
        let memo = Memo::new(&room);
        let start = |known: bool| {
            let beginning = Beginning { setting: setting.label(), starts: Starts::Round(0), index: 0 };
            let make = || match known {
                false => Ok(Some(Episode::start(&setting, 1)?)),
                true => panic!("the start is known"),
            };
            memo.start(beginning, make).unwrap().unwrap()
        };
        let (over, under) = (action(&[0.3, 0.25], None), action(&[0.2], None));
        let mut first = start(false);
        for action in [&over, &under] {
            first.perform(action.clone(), |episode, action| perform(episode, action, true));
        }
        assert_eq!((first.steps().replayed, room.taken.load(Ordering::Relaxed) > 0), (0, true));
        let mut again = start(true);
        for action in [&over, &under] {
            again.perform(action.clone(), |_, _| panic!("it is known"));
        }
        assert_eq!((again.steps().simulated, again.steps().replayed), (0, first.episode().steps()));
        assert_eq!(again.episode().observe(), first.episode().observe());
        // Another primitive, another order, and a teacher who watches the guard are all new; and from what is known on,
        // the simulation goes on as if all of it had been simulated.
        let watched = action(&[0.3, 0.25], Some(0));
        let other = action(&[0.3, 0.24], None);
        for new in [&under, &watched, &other] {
            let (mut cursor, mut is_performed) = (start(true), false);
            cursor.perform(new.clone(), |episode, action| {
                is_performed = true;
                perform(episode, action, false)
            });
            let mut alone = Episode::start(&setting, 1).unwrap();
            perform(&mut alone, new, false);
            assert!(is_performed);
            assert_eq!(cursor.episode().observe(), alone.observe());
        }
        memo.forget(&setting.label());
        assert_eq!(room.taken.load(Ordering::Relaxed), 0, "the room is given back");
    }
}
