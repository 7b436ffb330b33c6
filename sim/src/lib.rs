//! Rapier behind nouns of the table: world, gripper, planner, beads, snapshot, camera.
