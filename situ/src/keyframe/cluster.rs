//! Agglomerative clustering by average linkage (decision D8).

/// Stands for a distance that is infinite or not a number. It is far above any divergence, and finite, so the averages
/// of the linkage stay numbers.
const NEVER: f64 = 1e200;
/// A height above this is an average over at least one pair that must never be merged. [`Dendrogram::cut`] never merges
/// at such a height.
const NEVER_HEIGHT: f64 = 1e150;

/// The merges of an agglomerative clustering, the lowest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Dendrogram {
    members: usize,
    /// The two clusters that are merged, and the height. A cluster below `members` is a single member; cluster
    /// `members + i` is the result of merge `i`.
    merges: Vec<(usize, usize, f64)>,
}

/// Average linkage (UPGMA) of `n` members.
///
/// `distances` is condensed: (0,1), (0,2), …, (0,n−1), (1,2), …; these are n(n−1)/2 numbers. An infinite distance, or
/// one that is not a number, means that the two are never in one cluster at any cut. O(n²).
///
/// The clusters do not depend on the order of the members unless two averages tie. If they tie, the earlier pair merges
/// first.
///
/// # Panics
/// If `distances` has another length.
pub fn average_linkage(distances: &[f64], n: usize) -> Dendrogram {
    assert_eq!(distances.len(), n * n.saturating_sub(1) / 2, "condensed distances of {n} members");
    let mut condensed: Vec<f64> =
        distances.iter().map(|distance| if distance.is_finite() { *distance } else { NEVER }).collect();
    let merges = match n {
        0 | 1 => Vec::new(),
        _ => kodama::linkage(&mut condensed, n, kodama::Method::Average)
            .steps()
            .iter()
            .map(|step| (step.cluster1, step.cluster2, step.dissimilarity))
            .collect(),
    };
    Dendrogram { members: n, merges }
}

impl Dendrogram {
    /// The heights of the merges, the lowest first. A height is the mean distance between the members of the two
    /// clusters.
    pub fn heights(&self) -> impl Iterator<Item = f64> {
        self.merges.iter().map(|(_, _, height)| if *height < NEVER_HEIGHT { *height } else { f64::INFINITY })
    }

    /// One label per member. Two members have the same label if they are merged at a height of at most `tau`. Labels
    /// count from 0 in the order of their first members.
    pub fn cut(&self, tau: f64) -> Vec<usize> {
        let mut cluster: Vec<Vec<usize>> = (0..self.members).map(|member| vec![member]).collect();
        let mut leader: Vec<usize> = (0..self.members).collect();
        for (merge, height) in self.merges.iter().zip(self.heights()) {
            let mut joined = core::mem::take(&mut cluster[merge.0]);
            joined.append(&mut cluster[merge.1]);
            if height.is_finite() && height <= tau {
                let first = joined.iter().map(|member| leader[*member]).min().unwrap_or_default();
                for member in &joined {
                    leader[*member] = first;
                }
            }
            cluster.push(joined);
        }
        let mut names = vec![usize::MAX; self.members];
        let mut next = 0;
        let mut labels = Vec::with_capacity(self.members);
        for first in leader {
            if names[first] == usize::MAX {
                names[first] = next;
                next += 1;
            }
            labels.push(names[first]);
        }
        labels
    }
}
