//! What happens by itself during an episode: a push, or a drop.

/// Something that happens once, after the hand has reached a keyframe of a primitive on some object.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its name.
    pub name: String,
    /// The reference object of the primitive.
    pub reference: String,
    /// The index (from 0) of the keyframe that must have been reached. A drop also waits until the object hangs free in
    /// the hand.
    pub keyframe: usize,
    /// What happens.
    pub happening: Happening,
    /// How many seconds it takes. The hand stands still meanwhile.
    pub seconds: f64,
}

/// What happens in an [`Event`].
#[derive(Debug, Clone, PartialEq)]
pub enum Happening {
    /// Somebody bumps into an object, which slides over the table.
    Push {
        /// The object that is pushed.
        object: String,
        /// How far, in metres, world frame.
        by: [f64; 3],
    },
    /// An object slips from the hand: the gripper opens all the way and, when the object has fallen, closes on nothing.
    /// Afterwards the command in force is the same as before, as it is after a real slip. Only the opening shows that
    /// the hand is empty.
    Drop {
        /// The object that is dropped.
        object: String,
    },
}

impl Happening {
    /// The object that it happens to.
    pub fn object(&self) -> &str {
        match self {
            Happening::Push { object, .. } | Happening::Drop { object } => object,
        }
    }
}
