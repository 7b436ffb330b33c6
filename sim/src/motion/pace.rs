//! The pace of a motion: as fast as the hand may go where it is far from everything, slow where it may touch something.

use crate::step::DT;

/// The hand's largest speed near things, m/s.
pub const CONTACT_SPEED: f64 = 0.25;
/// The hand's largest rate of turning there, and anywhere with a load that can spill: rad/s.
pub const CONTACT_TURN: f64 = 1.5;
/// The hand's largest speed anywhere, m/s.
pub const MAX_SPEED: f64 = 1.0;
/// The hand's largest rate of turning anywhere, rad/s.
pub const MAX_TURN: f64 = 3.0;

/// The hand's acceleration near things, and anywhere with a load that can spill: m/s². It reaches its speed near things
/// in 0.15 s.
const CONTACT_ACCELERATION: f64 = CONTACT_SPEED / 0.15;
/// The hand's acceleration away from things, m/s². Also what it counts on to slow down before it touches something.
const ACCELERATION: f64 = 8.0;
/// A thing at this distance is near, metres.
const NEAR: f64 = 0.02;

/// The distance from everything at which the hand may go at its largest speed, metres.
pub(crate) const FAR: f64 = NEAR + (MAX_SPEED * MAX_SPEED - CONTACT_SPEED * CONTACT_SPEED) / (2.0 * ACCELERATION);

/// A piece of a route, which is gone at one limit of speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// The hand's way, metres.
    pub(crate) way: f64,
    /// The hand's turn, radians.
    pub(crate) turn: f64,
    /// Seconds that the slowest joint needs; 0 without an arm.
    pub(crate) joints: f64,
    /// How far the hand and its load are from what they may touch, metres.
    pub(crate) clearance: f64,
    /// Whether the load can spill.
    pub(crate) spills: bool,
}

impl Piece {
    /// What is to be gone: the way, or the turn or the joints' part as a way, where that takes longer near things.
    /// Metres.
    fn size(&self) -> f64 {
        self.way.max(self.turn * (CONTACT_SPEED / CONTACT_TURN)).max(self.joints * CONTACT_SPEED)
    }

    /// The largest speed, m/s of the size. It is the speed near things where nothing more can be said. Further off it
    /// is the speed from which the hand can slow down to that one before it touches something.
    fn limit(&self) -> f64 {
        let away = (self.clearance - NEAR).max(0.0);
        let speed = libm::sqrt(CONTACT_SPEED * CONTACT_SPEED + 2.0 * self.acceleration() * away).min(MAX_SPEED);
        let at_most = |speed: f64, seconds: f64| if seconds > 0.0 { speed.min(self.size() / seconds) } else { speed };
        let turn = if self.spills { CONTACT_TURN } else { MAX_TURN };
        at_most(at_most(speed, self.turn / turn), self.joints)
    }

    /// The largest acceleration, m/s² of the size. It is the acceleration and not the speed that makes a load spill.
    fn acceleration(&self) -> f64 {
        if self.clearance > NEAR && !self.spills { ACCELERATION } else { CONTACT_ACCELERATION }
    }
}

/// A piece with its course in time: speeding up evenly, going evenly, slowing down evenly.
#[derive(Debug, Clone, Copy)]
struct Leg {
    /// When it begins, seconds.
    begins: f64,
    /// Its size, metres.
    size: f64,
    /// The speeds at its beginning, in its middle and at its end, m/s.
    speeds: [f64; 3],
    acceleration: f64,
    /// Seconds of its three parts.
    seconds: [f64; 3],
}

impl Leg {
    fn new(begins: f64, piece: &Piece, ends: [f64; 2]) -> Leg {
        let (size, acceleration) = (piece.size(), piece.acceleration());
        let [from, to] = ends;
        let reached = libm::sqrt(0.5 * (from * from + to * to) + acceleration * size);
        let middle = reached.min(piece.limit()).max(from).max(to);
        let changing = (2.0 * middle * middle - from * from - to * to) / (2.0 * acceleration);
        let even = (size - changing).max(0.0);
        let seconds = [
            (middle - from) / acceleration,
            if middle > 0.0 { even / middle } else { 0.0 },
            (middle - to) / acceleration,
        ];
        Leg { begins, size, speeds: [from, middle, to], acceleration, seconds }
    }

    /// The part of the piece that is done after so many seconds from its beginning, from 0 to 1.
    fn done(&self, time: f64) -> f64 {
        let [from, middle, to] = self.speeds;
        let [speeding, even, slowing] = self.seconds;
        let gone = if time < speeding {
            (from + 0.5 * self.acceleration * time) * time
        } else if time < speeding + even {
            0.5 * (from + middle) * speeding + middle * (time - speeding)
        } else {
            let left = (speeding + even + slowing - time).max(0.0);
            self.size - (to + 0.5 * self.acceleration * left) * left
        };
        (gone / self.size).clamp(0.0, 1.0)
    }
}

/// The course of a route in time. The hand rests at both ends, and each piece keeps its limits of speed and
/// acceleration.
///
/// It is the shortest such course: one pass forwards over the pieces keeps to the acceleration, one backwards to the
/// braking.
#[derive(Debug, Clone)]
pub(crate) struct Pace {
    /// The pieces that are not empty, each with its index.
    legs: Vec<(usize, Leg)>,
    /// Seconds in all.
    duration: f64,
    /// Steps in all.
    pub(crate) steps: usize,
}

impl Pace {
    /// The course over these pieces.
    pub(crate) fn new(pieces: &[Piece]) -> Pace {
        let pieces: Vec<(usize, &Piece)> = pieces.iter().enumerate().filter(|(_, piece)| piece.size() > 0.0).collect();
        let reached = |from: f64, piece: &Piece| libm::sqrt(from * from + 2.0 * piece.acceleration() * piece.size());
        let mut speeds = vec![0.0; pieces.len() + 1];
        for (k, (_, piece)) in pieces.iter().enumerate() {
            let next = pieces.get(k + 1).map_or(0.0, |(_, next)| next.limit());
            speeds[k + 1] = reached(speeds[k], piece).min(piece.limit()).min(next);
        }
        for (k, (_, piece)) in pieces.iter().enumerate().rev() {
            speeds[k] = reached(speeds[k + 1], piece).min(speeds[k]);
        }
        let mut duration = 0.0;
        let legs = pieces.iter().zip(speeds.windows(2)).map(|((index, piece), ends)| {
            let leg = Leg::new(duration, piece, [ends[0], ends[1]]);
            duration += leg.seconds.iter().sum::<f64>();
            (*index, leg)
        });
        let legs = legs.collect();
        Pace { legs, duration, steps: libm::ceil(duration / DT) as usize }
    }

    /// Where the hand is after so many steps: the index of the piece, and the part of it that is done, from 0 to 1.
    pub(crate) fn at(&self, step: usize) -> (usize, f64) {
        let time = self.duration * step as f64 / self.steps.max(1) as f64;
        let next = self.legs.partition_point(|(_, leg)| leg.begins <= time);
        self.legs.get(next.saturating_sub(1)).map_or((0, 0.0), |(index, leg)| (*index, leg.done(time - leg.begins)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn piece() -> impl Strategy<Value = Piece> {
        let none_or = |most: f64| prop_oneof![1 => Just(0.0), 4 => 1e-5..most];
        let sizes = (none_or(0.02), none_or(0.1), none_or(0.1), none_or(0.3), any::<bool>());
        sizes.prop_map(|(way, turn, joints, clearance, spills)| Piece { way, turn, joints, clearance, spills })
    }

    /// The place after each step, in metres of the pieces' sizes; the size of all.
    fn places(pieces: &[Piece]) -> (Vec<f64>, f64) {
        let pace = Pace::new(pieces);
        let before = |index: usize| pieces[..index].iter().map(Piece::size).sum::<f64>();
        let place = |step| {
            let (index, part) = pace.at(step);
            before(index) + part * pieces[index].size()
        };
        ((0..=pace.steps).map(place).collect(), before(pieces.len()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_pace_goes_all_the_way_within_every_limit(pieces in prop::collection::vec(piece(), 1..40)) {
            let pace = Pace::new(&pieces);
            let (places, size) = places(&pieces);
            prop_assert!(places[0].abs() < 1e-12 && (places[pace.steps] - size).abs() < 1e-9);
            // Between two steps the hand may pass a limit only if one of the pieces that it passes over allows it.
            for step in 0..pace.steps {
                let (first, last) = (pace.at(step).0, pace.at(step + 1).0);
                let limit = pieces[first..=last].iter().map(Piece::limit).fold(0.0, f64::max);
                let speed = (places[step + 1] - places[step]) / DT;
                prop_assert!((-1e-9..=limit + 1e-9).contains(&speed), "{speed} m/s where {limit} are allowed");
            }
            let change = places.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]).abs() / (DT * DT));
            prop_assert!(change.fold(0.0, f64::max) <= ACCELERATION + 1e-6);
        }
    }

    #[test]
    fn a_pace_is_as_short_as_its_limits_allow() {
        let seconds = |pieces: &[Piece]| Pace::new(pieces).duration;
        let line = |way: f64, clearance: f64| Piece { way, turn: 0.0, joints: 0.0, clearance, spills: false };
        // From rest to rest, over a way so short that the largest speed is never reached, and over a longer one.
        let near = (0.0, CONTACT_SPEED, CONTACT_ACCELERATION);
        let far = (1.0, MAX_SPEED, ACCELERATION);
        for (way, (clearance, speed, acceleration)) in [(0.01, near), (0.5, near), (0.1, far), (2.0, far)] {
            let ramp = speed * speed / acceleration;
            let least =
                if way < ramp { 2.0 * f64::sqrt(way / acceleration) } else { way / speed + speed / acceleration };
            assert!((seconds(&[line(way, clearance)]) - least).abs() < 1e-12);
            // In how many pieces the way is given does not matter.
            assert!((seconds(&vec![line(way / 64.0, clearance); 64]) - least).abs() < 1e-9);
        }
        assert_eq!(Pace::new(&[line(0.0, 0.0)]).steps, 0);
        assert_eq!(Pace::new(&[]).at(0), (0, 0.0));
    }
}
