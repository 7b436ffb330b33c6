//! The methods by name.

use super::{Method, bp_ar_hmm, itmcd, keyframe_method, nearest, refinement};

/// Every method, in the order of the tables.
pub fn all() -> Vec<Box<dyn Method>> {
    let keyframe = keyframe_method::all().into_iter().map(|method| Box::new(method) as Box<dyn Method>);
    let retraining: [Box<dyn Method>; 3] =
        [Box::new(nearest::Nearest), Box::new(bp_ar_hmm::BpArHmm::default()), Box::new(itmcd::Itmcd::default())];
    keyframe.chain(retraining).chain(refinement::all()).collect()
}

/// The method of this name.
pub fn named(name: &str) -> Option<Box<dyn Method>> {
    all().into_iter().find(|method| method.name() == name)
}

/// The method whose model of the original task decides that the task is taught. It is one for all methods: otherwise
/// what a method is given would depend on the methods that happen to run beside it.
pub fn standard() -> Box<dyn Method> {
    Box::new(keyframe_method::NO_UPDATE)
}

/// The method that makes one model at once of all that a keyframe automaton was ever taught.
pub fn pooled() -> Box<dyn Method> {
    Box::new(keyframe_method::JOINT)
}
