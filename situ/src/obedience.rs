//! Obedience (decision D22): in the state in which something was shown, and after the primitive after which it was
//! shown, the model chooses what was shown.
//!
//! Two rules see to that. What corrections show supersedes what was shown before them in its place, where nothing
//! observed tells the two apart. Beyond that, single positives of a wrong choice are retired, as many as it takes.

use std::collections::BTreeSet;

use crate::demonstration::Kind;
use crate::error::SituError;
use crate::place::{Place, SampleId, SegmentId};
use crate::primitive::Learner;
use crate::state::State;
use crate::update::Update;
use crate::worlds::are_told_apart;

/// What was shown: after this place, in the state of this sample, that place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lesson {
    after: Place,
    state: SampleId,
    shown: Place,
}

impl<L: Learner> Update<'_, L> {
    /// Makes the model do what a correction has shown, each segment and END in their order. Where another place is
    /// chosen, the positives that made it so are retired: of that place those that a robot came to by the same way, the
    /// nearest first. They stay in the history, and a place keeps its last. Of two segments that contradict each other
    /// in states that look alike the later wins.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub(crate) fn obey(&mut self, demonstration: u32) -> Result<(), SituError> {
        let lessons = self.lessons(demonstration);
        for lesson in &lessons {
            self.supersede(*lesson)?;
            self.make_obey(*lesson, demonstration)?;
        }
        for (index, lesson) in lessons.iter().enumerate() {
            if self.chosen_in(*lesson) != Some(lesson.shown) {
                let later = &lessons[index + 1..];
                let is_aliased = later
                    .iter()
                    .any(|later| later.after == lesson.after && self.chosen_in(*lesson) == Some(later.shown));
                if is_aliased {
                    self.obedience.aliased += 1;
                } else {
                    self.obedience.disobeyed += 1;
                }
            }
        }
        Ok(())
    }

    fn lessons(&self, demonstration: u32) -> Vec<Lesson> {
        let history = &self.model.histories()[demonstration as usize];
        let starts = (0..).zip(&history.nodes).map(|(index, node)| {
            let state = SampleId::Start(SegmentId { demonstration, index });
            (state, Place::Node(*node))
        });
        let end = history.carried_to_end.then_some((SampleId::Final(demonstration), Place::End));
        let lesson = |(state, shown)| Some(Lesson { after: self.model.before(state)?, state, shown });
        starts.chain(end).filter_map(lesson).collect()
    }

    fn chosen_in(&self, lesson: Lesson) -> Option<Place> {
        self.model.most_probable_child(lesson.after, self.model.state(lesson.state)).map(|(place, _)| place)
    }

    /// Where corrections have shown this after this place, and demonstrations before them something else, and no
    /// feature tells the states of the one from those of the other, the newer holds, as with ways (decision D20): the
    /// positives of the other place are retired, all but the last.
    fn supersede(&mut self, lesson: Lesson) -> Result<(), SituError> {
        let through = |place: Place| -> Vec<SampleId> {
            let all = self.model.starts([place].into_iter()).into_iter();
            all.filter(|sample| self.model.before(*sample) == Some(lesson.after)).collect()
        };
        let newer = through(lesson.shown);
        let Some(first) = newer.iter().map(|sample| sample.demonstration()).min() else { return Ok(()) };
        if self.model.histories()[first as usize].kind == Kind::Original {
            return Ok(());
        }
        let others: Vec<Place> = self.model.children(lesson.after).filter(|child| *child != lesson.shown).collect();
        let mut superseded: Vec<(Place, SampleId)> = Vec::new();
        for other in others {
            let older: Vec<SampleId> =
                through(other).into_iter().filter(|sample| sample.demonstration() < first).collect();
            let states = |samples: &[SampleId]| -> Vec<&State> {
                samples.iter().map(|sample| self.model.state(*sample)).collect()
            };
            if !older.is_empty() && !are_told_apart(&states(&older), &states(&newer), self.learner.scales()) {
                superseded.extend(older.into_iter().map(|sample| (other, sample)));
            }
        }
        superseded.retain(|(place, sample)| self.model.retire(*place, *sample));
        self.obedience.retired += superseded.len() as u32;
        let places: BTreeSet<Place> = superseded.into_iter().map(|(place, _)| place).collect();
        self.model.fit_classifiers(self.learner, &places, &mut self.counters)
    }

    /// Retires what stands in the way of a lesson. Where it does not obey all the same, nothing stays retired for it.
    fn make_obey(&mut self, lesson: Lesson, demonstration: u32) -> Result<(), SituError> {
        let mut retired: Vec<(Place, SampleId)> = Vec::new();
        while let Some(chosen) = self.chosen_in(lesson).filter(|chosen| *chosen != lesson.shown) {
            let Some(sample) = self.to_retire(lesson, chosen, demonstration) else {
                retired.iter().for_each(|(place, sample)| self.model.reinstate(*place, *sample));
                let places = retired.into_iter().map(|(place, _)| place).collect();
                return self.model.fit_classifiers(self.learner, &places, &mut self.counters);
            };
            self.model.retire(chosen, sample);
            retired.push((chosen, sample));
            self.model.fit_classifiers(self.learner, &[chosen].into(), &mut self.counters)?;
        }
        self.obedience.retired += retired.len() as u32;
        Ok(())
    }

    /// The positive of the wrongly chosen place that is retired next: the nearest of those that came through the same
    /// place, what this correction itself shows last of all. `None` where the place has no other.
    fn to_retire(&self, lesson: Lesson, chosen: Place, demonstration: u32) -> Option<SampleId> {
        let positives = self.model.starts([chosen].into_iter());
        if positives.len() < 2 {
            return None;
        }
        let here = self.model.state(lesson.state);
        let scales = self.learner.scales();
        let distance = |sample: &SampleId| here.squared_distance(self.model.state(*sample), scales);
        let is_shown_now = |sample: &SampleId| sample.demonstration() == demonstration;
        let through = positives.into_iter().filter(|sample| self.model.before(*sample) == Some(lesson.after));
        through
            .map(|sample| (is_shown_now(&sample), distance(&sample), sample))
            .min_by(|left, right| left.0.cmp(&right.0).then(left.1.total_cmp(&right.1)).then(left.2.cmp(&right.2)))
            .map(|(_, _, sample)| sample)
    }
}
