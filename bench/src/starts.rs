//! Which starts an evaluation is from.

/// The starts of an evaluation. No name holds the method, so every method meets the same ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Starts {
    /// Those of a round. They decide whether another demonstration is asked for, and the teacher corrects from them.
    Round(u32),
    /// Those by which nothing is ever decided: what is published is from them.
    Fresh,
}

impl Starts {
    /// Names the stream of a draw at a rollout: its purpose, and the numbers that tell it from others of that purpose.
    pub(crate) fn stream(self, purpose: &str, index: u32) -> (String, Vec<u32>) {
        match self {
            Self::Round(round) => (purpose.to_owned(), vec![round, index]),
            Self::Fresh => (format!("{purpose}-fresh"), vec![index]),
        }
    }
}
