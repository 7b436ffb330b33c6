//! Single movement primitives.

use nalgebra::Vector2;
use situ::method::bp_ar_hmm::dmp::Dmp;

/// A bow from (0, 0) to (0.4, 0.2) m, from rest to rest (minimum jerk), in points at even times.
fn bow(points: usize) -> Vec<Vector2<f64>> {
    (0..points)
        .map(|index| {
            let t = index as f64 / (points - 1) as f64;
            let share = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
            Vector2::new(0.4 * share, 0.2 * share + 0.1 * (share * core::f64::consts::PI).sin())
        })
        .collect()
}

#[test]
fn what_was_taught_is_reproduced_and_a_moved_goal_is_reached() {
    let taught = bow(41);
    let dmp = Dmp::fit(std::slice::from_ref(&taught));
    let (start, goal) = (taught[0], taught[40]);
    let points = dmp.rollout(&start, &goal);
    // 200 steps over the same time: five per point.
    let worst = taught.iter().enumerate().map(|(index, point)| (points[5 * index] - point).norm()).fold(0.0, f64::max);
    println!("greatest deviation {worst:.5} m");
    assert!(worst < 0.003, "it leaves what it was taught by {worst} m");
    assert!((points[points.len() - 1] - goal).norm() < 1e-3, "it ends at {}", points[points.len() - 1]);
    let moved = goal + Vector2::new(-0.1, 0.15);
    let points = dmp.rollout(&start, &moved);
    let missed = (points[points.len() - 1] - moved).norm();
    println!("a moved goal missed by {missed:.6} m");
    assert!(missed < 1e-3, "a moved goal is missed by {missed} m");
    // The taught shape leads there, not a straight line: the bow is still above the chord.
    let middle = points[100] - (start + moved) / 2.0;
    let across = Vector2::new(-(moved - start).y, (moved - start).x).normalize();
    assert!(middle.dot(&across) > 0.05, "the bow is lost: {}", middle.dot(&across));
}

#[test]
fn two_that_mirror_each_other_make_the_one_between() {
    let up = bow(41);
    let down: Vec<Vector2<f64>> = up.iter().map(|point| Vector2::new(point.x, point.x - point.y)).collect();
    let points = Dmp::fit(&[up.clone(), down]).rollout(&up[0], &up[40]);
    let worst = points.iter().map(|point| (point.y - 0.5 * point.x).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
}
