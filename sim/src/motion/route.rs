//! Routes of the hand: straight to a pose, or along a way that its arm has found.

use std::sync::Arc;

use crate::arm::{ArmModel, Configuration};
use crate::frame::{Pose, angle_of, between};
use crate::motion::obstacles::Obstacles;
use crate::motion::pace::Piece;

/// A piece of a straight way has at most so many metres.
const PIECE: f64 = 0.01;
/// It has at most so many radians of the hand's turn.
const PIECE_TURN: f64 = 0.06;
/// A piece of a way through the joints' angles turns each joint by at most this, radians.
const PIECE_JOINT: f64 = 0.05;

/// Where the hand and its arm are at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) tcp: Pose,
    /// The joints' angles, if there is an arm.
    pub(crate) configuration: Option<Configuration>,
}

/// What carries the hand from one place of a route to the next.
enum Carrier {
    /// The hand goes straight in position, spherical in rotation, and the arm follows, if there is one.
    Hand { from: Pose, to: Pose },
    /// The joints' angles go straight, and the hand goes where the arm takes it.
    Joints(Arc<ArmModel>),
}

/// A way from one place to another, in pieces.
pub(crate) struct Route {
    carrier: Carrier,
    /// The ends of the pieces; one more than there are pieces.
    places: Vec<Place>,
    /// Seconds that the slowest joint needs for each piece; 0 without an arm.
    joints: Vec<f64>,
}

/// The poses that cut the straight way to a pose into pieces, the first one left out.
pub(crate) fn straight(from: &Pose, to: &Pose) -> Vec<Pose> {
    let distance = (to.translation.vector - from.translation.vector).norm();
    let angle = angle_of(&(from.rotation.inverse() * to.rotation));
    let pieces = libm::ceil((distance / PIECE).max(angle / PIECE_TURN)).max(1.0) as usize;
    let pose = |piece| if piece == pieces { *to } else { between(from, to, piece as f64 / pieces as f64) };
    (1..=pieces).map(pose).collect()
}

impl Route {
    /// The straight way of a hand that nothing carries.
    pub(crate) fn free(from: Pose, to: Pose) -> Route {
        let tcps = std::iter::once(from).chain(straight(&from, &to));
        let places: Vec<Place> = tcps.map(|tcp| Place { tcp, configuration: None }).collect();
        let joints = vec![0.0; places.len() - 1];
        Route { carrier: Carrier::Hand { from, to }, places, joints }
    }

    /// The straight way, followed by an arm at these configurations: one at each end of a piece.
    pub(crate) fn followed(from: Pose, to: Pose, configurations: &[Configuration], model: &ArmModel) -> Route {
        let tcps = std::iter::once(from).chain(straight(&from, &to));
        let places = tcps.zip(configurations).map(|(tcp, at)| Place { tcp, configuration: Some(*at) }).collect();
        let joints = configurations.windows(2).map(|pair| model.seconds_between(&pair[0], &pair[1])).collect();
        Route { carrier: Carrier::Hand { from, to }, places, joints }
    }

    /// A way through configurations, which ends at the pose `to`.
    pub(crate) fn through(way: &[Configuration], to: Pose, model: &Arc<ArmModel>) -> Route {
        let mut configurations: Vec<Configuration> = way.iter().take(1).copied().collect();
        for pair in way.windows(2) {
            let turn = pair[1] - pair[0];
            let pieces = libm::ceil(turn.amax() / PIECE_JOINT).max(1.0) as usize;
            configurations.extend((1..=pieces).map(|piece| pair[0] + turn * (piece as f64 / pieces as f64)));
        }
        let joints = configurations.windows(2).map(|pair| model.seconds_between(&pair[0], &pair[1])).collect();
        let place = |at: &Configuration| Place { tcp: model.tcp(at), configuration: Some(*at) };
        let mut places: Vec<Place> = configurations.iter().map(place).collect();
        if let Some(last) = places.last_mut() {
            last.tcp = to;
        }
        Route { carrier: Carrier::Joints(Arc::clone(model)), places, joints }
    }

    /// The pieces, each with what the scene allows there.
    pub(crate) fn pieces(&self, obstacles: &Obstacles) -> Vec<Piece> {
        let clearances: Vec<f64> = self.places.iter().map(|place| obstacles.clearance(&place.tcp)).collect();
        let ends = self.places.windows(2).zip(clearances.windows(2));
        let piece = |((places, clearances), joints): ((&[Place], &[f64]), &f64)| Piece {
            way: (places[1].tcp.translation.vector - places[0].tcp.translation.vector).norm(),
            turn: angle_of(&(places[0].tcp.rotation.inverse() * places[1].tcp.rotation)),
            joints: *joints,
            clearance: clearances[0].min(clearances[1]),
            spills: obstacles.spills,
        };
        ends.zip(&self.joints).map(piece).collect()
    }

    /// Where it begins.
    pub(crate) fn start(&self) -> Place {
        self.places[0]
    }

    /// Where it ends.
    pub(crate) fn end(&self) -> Place {
        self.places[self.places.len() - 1]
    }

    /// The place when a part of a piece is done, from 0 to 1.
    pub(crate) fn at(&self, piece: usize, part: f64) -> Place {
        let Some([before, after]) = self.places.get(piece..piece + 2) else { return self.end() };
        let ends = before.configuration.zip(after.configuration);
        let configuration = ends.map(|(from, to)| from + (to - from) * part);
        let tcp = match (&self.carrier, configuration) {
            (Carrier::Joints(model), Some(configuration)) => model.tcp(&configuration),
            (Carrier::Hand { from, to }, _) => between(from, to, (piece as f64 + part) / self.joints.len() as f64),
            (Carrier::Joints(_), None) => after.tcp,
        };
        Place { tcp, configuration }
    }
}
