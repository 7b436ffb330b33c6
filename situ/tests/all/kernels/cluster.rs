//! Average linkage against its definition.

use proptest::prelude::*;
use situ::keyframe::cluster::average_linkage;

fn at(n: usize, row: usize, column: usize) -> usize {
    let (low, high) = (row.min(column), row.max(column));
    low * n - low * (low + 1) / 2 + high - low - 1
}

/// Merges the two clusters whose members are nearest on average, until none are at most `tau` apart. Every average is
/// computed anew from the distances. Returns labels in order of first members, and the heights of the merges.
fn brute_force(distances: &[f64], n: usize, tau: f64) -> (Vec<usize>, Vec<f64>) {
    let mut clusters: Vec<Vec<usize>> = (0..n).map(|member| vec![member]).collect();
    let mut heights = Vec::new();
    loop {
        let mut best = (f64::INFINITY, 0, 0);
        for left in 0..clusters.len() {
            for right in left + 1..clusters.len() {
                let mut sum = 0.0;
                for a in &clusters[left] {
                    sum += clusters[right].iter().map(|b| distances[at(n, *a, *b)]).sum::<f64>();
                }
                let average = sum / (clusters[left].len() * clusters[right].len()) as f64;
                if average < best.0 {
                    best = (average, left, right);
                }
            }
        }
        if best.0 > tau || best.0 == f64::INFINITY {
            break;
        }
        heights.push(best.0);
        let taken = clusters.remove(best.2);
        clusters[best.1].extend(taken);
    }
    let first = |member: usize| {
        clusters.iter().find(|cluster| cluster.contains(&member)).and_then(|cluster| cluster.iter().min())
    };
    (names(&(0..n).map(|member| *first(member).expect("in a cluster")).collect::<Vec<_>>()), heights)
}

/// Labels in order of first appearance.
fn names(labels: &[usize]) -> Vec<usize> {
    let mut seen = Vec::new();
    labels
        .iter()
        .map(|label| {
            seen.iter().position(|other| other == label).unwrap_or_else(|| {
                seen.push(*label);
                seen.len() - 1
            })
        })
        .collect()
}

/// The distances are continuous, so that no two averages tie. Some pairs must never merge.
fn distances() -> impl Strategy<Value = (usize, Vec<f64>)> {
    (1_usize..=9).prop_flat_map(|n| {
        let distance = prop_oneof![12 => 0.0..20.0, 1 => Just(f64::INFINITY)];
        (Just(n), prop::collection::vec(distance, n * (n - 1) / 2))
    })
}

proptest! {
    #[test]
    fn merges_are_those_of_the_definition((n, distances) in distances(), tau in 0.0..25.0_f64) {
        let (labels, heights) = brute_force(&distances, n, tau);
        // A height within rounding of the cut could fall on either side.
        let (_, all) = brute_force(&distances, n, f64::MAX);
        prop_assume!(all.iter().all(|height: &f64| (height - tau).abs() > 1e-9));
        let dendrogram = average_linkage(&distances, n);
        prop_assert_eq!(dendrogram.cut(tau), labels);
        let found: Vec<f64> = dendrogram.heights().filter(|height| *height <= tau).collect();
        prop_assert_eq!(found.len(), heights.len());
        for (found, expected) in found.iter().zip(&heights) {
            prop_assert!((found - expected).abs() < 1e-11);
        }
    }

    #[test]
    fn the_order_of_the_members_does_not_matter(
        (n, distances) in distances(),
        tau in 0.0..25.0_f64,
        seed in any::<u64>(),
    ) {
        let (_, all) = brute_force(&distances, n, f64::MAX);
        prop_assume!(all.iter().all(|height: &f64| (height - tau).abs() > 1e-9));
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by_key(|member| (*member as u64 + 1).wrapping_mul(seed | 1).rotate_left(17));
        let mut shuffled = vec![0.0; distances.len()];
        for row in 0..n {
            for column in row + 1..n {
                shuffled[at(n, row, column)] = distances[at(n, order[row], order[column])];
            }
        }
        let own = average_linkage(&distances, n).cut(tau);
        let moved: Vec<usize> = order.iter().map(|member| own[*member]).collect();
        prop_assert_eq!(average_linkage(&shuffled, n).cut(tau), names(&moved));
    }
}

#[test]
fn infinite_and_undefined_distances_never_merge() {
    for never in [f64::INFINITY, f64::NAN] {
        // 0 and 1 are near, and 2 is near 0, but 2 must not be with 1.
        let dendrogram = average_linkage(&[1.0, 2.0, never], 3);
        assert_eq!(dendrogram.cut(1e100), [0, 0, 1]);
        assert_eq!(dendrogram.cut(f64::INFINITY), [0, 0, 1]);
        assert_eq!(dendrogram.cut(f64::NAN), [0, 1, 2]);
    }
}

#[test]
fn none_one_and_two() {
    assert!(average_linkage(&[], 0).cut(1.0).is_empty());
    assert_eq!(average_linkage(&[], 1).cut(1.0), [0]);
    assert_eq!(average_linkage(&[1.0], 2).cut(1.0), [0, 0], "the cut itself is inside");
    assert_eq!(average_linkage(&[1.0], 2).cut(0.999), [0, 1]);
    assert_eq!(average_linkage(&[-0.5], 2).cut(0.0), [0, 0], "a cross-likelihood can be below 0");
}
