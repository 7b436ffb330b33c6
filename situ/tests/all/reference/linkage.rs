//! Average linkage by its definition (decision D8).

/// One label per member. The two clusters that are nearest on average merge, until none are within the cut. Labels
/// count from 0 in the order of their first members.
pub(crate) fn labels(distances: &[Vec<f64>], cut: f64) -> Vec<usize> {
    let mut clusters: Vec<Vec<usize>> = (0..distances.len()).map(|member| vec![member]).collect();
    loop {
        let mut nearest = (f64::INFINITY, 0, 0);
        for right in 0..clusters.len() {
            for left in 0..right {
                let pairs = clusters[left].iter().flat_map(|a| clusters[right].iter().map(|b| distances[*a][*b]));
                let average = pairs.sum::<f64>() / (clusters[left].len() * clusters[right].len()) as f64;
                if average < nearest.0 {
                    nearest = (average, left, right);
                }
            }
        }
        let (average, left, right) = nearest;
        if average == f64::INFINITY || average > cut {
            break;
        }
        let joined = clusters.remove(right);
        clusters[left].extend(joined);
    }
    clusters.sort_by_key(|cluster| cluster.iter().min().copied());
    let holder = |member| clusters.iter().position(|cluster| cluster.contains(&member)).expect("each is in one");
    (0..distances.len()).map(holder).collect()
}
