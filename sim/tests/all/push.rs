//! Pushes: an object goes where it is pushed, with what is in it.

use crate::common::{pouring, standing};
use situ_sim::{Beads, SimError};

#[test]
fn a_pushed_pitcher_takes_its_beads_along() {
    let mut world = pouring(&Beads::new(60), standing(-0.16, 0.0, 0.0, 0.0), standing(0.16, 0.0, 0.0, 0.0));
    let (pitcher, bowl) = (world.pose("pitcher").unwrap(), world.pose("bowl").unwrap());
    world.push("pitcher", [0.03, -0.08, 0.0], 0.5).unwrap();
    let mut fastest: f64 = 0.0;
    world.hold(0.5, &mut |world| fastest = fastest.max(world.speed("pitcher").unwrap()));
    world.settle(0.5);
    let moved = world.pose("pitcher").unwrap().translation.vector - pitcher.translation.vector;
    assert!((moved - nalgebra::Vector3::new(0.03, -0.08, 0.0)).norm() < 1e-3, "moved by {moved}");
    assert_eq!(world.beads_inside("pitcher"), Some(60));
    assert!(world.speed("pitcher").unwrap() < 1e-3, "it has come to rest");
    // The path is of fifth order, so the top speed is 1.875 of the mean.
    let top = 1.875 * libm::hypot(0.03, 0.08) / 0.5;
    assert!((fastest - top).abs() < 0.02, "top speed {fastest} instead of {top}");
    let (still, _) = crate::common::apart(&bowl, &world.pose("bowl").unwrap());
    assert!(still < 1e-3, "the bowl was not pushed");
}

#[test]
fn impossible_pushes_are_refused() {
    let mut world = pouring(&Beads::new(1), standing(-0.16, 0.0, 0.0, 0.0), standing(0.16, 0.0, 0.0, 0.0));
    assert!(
        matches!(world.push("jug", [0.1, 0.0, 0.0], 0.5), Err(SimError::UnknownObject { object }) if object == "jug")
    );
    assert!(matches!(world.push("bowl", [f64::NAN, 0.0, 0.0], 0.5), Err(SimError::BadPose { .. })));
    assert!(matches!(world.push("bowl", [9.0, 0.0, 0.0], 0.5), Err(SimError::BadPose { .. })));
    for seconds in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(world.push("bowl", [0.1, 0.0, 0.0], seconds), Err(SimError::BadValue { .. })));
    }
}
