//! The classifiers of a task model, fitted to its data.

use std::collections::BTreeSet;

use super::TaskModel;
use crate::error::SituError;
use crate::place::{Place, SampleId, Samples};
use crate::primitive::{Initiation, Learner};
use crate::trace::Counters;

impl<L: Learner> TaskModel<L> {
    /// Fits the classifier of each of these places to its samples (Update-Classifier, A2.19); START has none.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub fn fit_classifiers(
        &mut self,
        learner: &L,
        places: &BTreeSet<Place>,
        counters: &mut Counters,
    ) -> Result<(), SituError> {
        for place in places {
            let Some(samples) = self.samples(*place).filter(|samples| !samples.positives.is_empty()) else { continue };
            let classifier = self.fit_samples(learner, samples, counters)?;
            match place {
                Place::Node(id) => {
                    self.screen.set(*id, classifier.ball());
                    self.node_mut(*id)?.classifier = classifier;
                }
                _ => self.end_mut().classifier = Some(classifier),
            }
        }
        Ok(())
    }

    /// A classifier for these samples.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub fn fit_samples(
        &self,
        learner: &L,
        samples: &Samples,
        counters: &mut Counters,
    ) -> Result<L::Classifier, SituError> {
        let states = |ids: &BTreeSet<SampleId>| ids.iter().map(|id| self.state(*id)).collect::<Vec<_>>();
        learner.fit_classifier(&states(&samples.positives), &states(&samples.negatives), counters)
    }
}
