//! The pouring scene by its measured keyframes: grasp, pour, put.

use crate::common::{apart, grasp, pouring, put_back, standing, tilt};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ_sim::{Beads, World};

#[test]
fn beads_end_in_the_bowl_and_the_pitcher_on_its_mat() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut near = |x: f64| {
        let mut off = || rng.random_range(-0.05..0.05);
        let (x, y) = (x + off(), off());
        standing(x, y, 0.0, 10.0 * off())
    };
    for beads in [Beads::new(60), Beads::new(60), Beads { radius: 0.0075, ..Beads::new(30) }] {
        let (pitcher, bowl) = (near(-0.16), near(0.16));
        let mut world = pouring(&beads, pitcher, bowl);
        assert_eq!(world.beads_inside("pitcher"), Some(beads.count));
        let (moved, turned) = apart(&pitcher, &world.pose("pitcher").unwrap());
        assert!(moved < 0.001 && turned < 0.01, "the pitcher does not stand still: {moved} m, {turned} rad");

        let mut hardest: f64 = 0.0;
        let watch = &mut |world: &World| hardest = hardest.max(world.hand_force());
        grasp(&mut world, watch);
        let in_hand = |world: &World| world.tcp().inverse() * world.pose("pitcher").unwrap();
        let taken = in_hand(&world);
        assert_eq!(world.beads_inside("pitcher"), Some(beads.count));
        tilt(&mut world, watch);
        let (slip, twist) = apart(&taken, &in_hand(&world));
        assert!(slip < 0.003 && twist < 0.02, "the pitcher slipped {slip} m, {twist} rad");
        put_back(&mut world, watch);

        let poured = world.beads_inside("bowl").unwrap();
        assert!(poured * 12 >= beads.count * 11, "{poured} of {} beads in the bowl", beads.count);
        let (off, lean) = apart(&world.pose("mat").unwrap(), &world.pose("pitcher").unwrap());
        assert!(off < 0.01 && lean < 0.05, "the pitcher is {off} m off its mat and turned by {lean} rad");
        assert!(!world.touching("pitcher", "hand") && world.touching("pitcher", "table"));
        assert!(hardest < 30.0, "{hardest} N on the hand");
        assert!(world.is_finite());
    }
}
