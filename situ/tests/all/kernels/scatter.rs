//! The teacher's scatter (decision D21), from teachers whose scatter is known.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Gripper, Pose};
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::pose::{Tangent, exp};
use situ::keyframe::scatter::{Deviation, Scatter, ScatterParameters};
use situ::primitive::Learner;
use situ::random::standard_normal;
use situ::segment::{RelativeKeyframe, Segment};
use situ::state::{Feature, Schema, State};
use situ::trace::Counters;

use crate::kernels::sample::pose_of;
use crate::reference::scatter::chi_squared;

const ORIGINALS: usize = 8;
const ROLES: usize = 24;
/// What the hand does at each keyframe of a role: it moves at two of them.
const COMMANDS: [Gripper; 5] =
    [Gripper::Open(0.08), Gripper::Close(20.0), Gripper::Close(20.0), Gripper::Open(0.08), Gripper::Open(0.08)];
const CONTACTS: usize = 2;
/// The share of segments with a needless keyframe.
const NEEDLESS: f64 = 0.2;
/// How far apart keyframes are, metres: no scatter makes one look like the next.
const STRIDE: f64 = 0.5;

/// A teacher: what it scatters at contacts, and elsewhere.
#[derive(Clone, Copy, Debug)]
struct Teacher {
    contact: Deviation,
    free: Deviation,
}

impl Teacher {
    /// The deviations at contacts, or elsewhere.
    fn deviation(&self, is_contact: bool) -> Deviation {
        if is_contact { self.contact } else { self.free }
    }

    fn keyframe(&self, mean: &Pose, index: usize, rng: &mut ChaCha8Rng) -> RelativeKeyframe {
        let Deviation { position, rotation } = self.deviation(index == 1 || index == 3);
        let noise =
            Tangent::from_fn(|axis, _| standard_normal(rng) * if axis < 3 { position } else { rotation[axis - 3] });
        RelativeKeyframe { pose: exp(mean, &noise), gripper: COMMANDS[index], hold: 0.0 }
    }

    /// So many originals of a task whose keyframes are turned in any way, and for each role how many segments of it
    /// have a needless keyframe.
    fn shows(&self, needless: f64, rng: &mut ChaCha8Rng) -> (Vec<Vec<Arc<Segment>>>, Vec<usize>) {
        let mut shown = vec![Vec::new(); ORIGINALS];
        let mut of_roles = Vec::new();
        for role in 0..ROLES {
            let mut angle = || rng.random_range(-1.5..1.5);
            let mean = |index: usize| pose_of([STRIDE * index as f64, 0.0, 0.0], [angle(), angle(), angle()]);
            let means: Vec<Pose> = (0..COMMANDS.len()).map(mean).collect();
            let mut with_needless = 0;
            for original in &mut shown {
                let mut keyframes: Vec<_> =
                    (0..).zip(&means).map(|(index, mean)| self.keyframe(mean, index, rng)).collect();
                if rng.random_bool(needless) {
                    let at = rng.random_range(1..=keyframes.len());
                    let beside = pose_of([STRIDE * at as f64, STRIDE, 0.0], [0.0; 3]);
                    keyframes.insert(at, RelativeKeyframe { pose: beside, ..keyframes[at - 1] });
                    with_needless += 1;
                }
                let reference: Arc<str> = format!("object-{role}").into();
                let start = State::new([0.0]);
                original.push(Arc::new(Segment { reference, start, keyframes, narration: Vec::new() }));
            }
            of_roles.push(with_needless);
        }
        (shown, of_roles)
    }
}

fn scatter_of(shown: &[Vec<Arc<Segment>>]) -> Scatter {
    let schema = Schema::new(vec![Feature { name: "x".to_owned(), scale: 1.0 }]).unwrap();
    let learner = KeyframeLearner::new(&schema, KeyframeParameters::default());
    let shown: Vec<&[Arc<Segment>]> = shown.iter().map(Vec::as_slice).collect();
    learner.calibrate(&shown, &mut Counters::default()).unwrap().scatter
}

/// Between what an estimate of a deviation has to be.
///
/// `keyframes` are the keyframes of a kind in a segment; `spoilt` is the share of their pairs whose partners are wrong,
/// at the most. The median of the others is then a quantile between (½ − spoilt)/(1 − spoilt) and ½/(1 − spoilt) of
/// them. The median of the distances between all pairs has an efficiency of 0.86 (Rousseeuw and Croux, JASA 1993), so
/// its relative standard error is 1/√(2 · 0.86 · N); N are the observations but one for each mean. The prior counts for
/// three pairs of thousands. Five standard errors are allowed.
fn bounds(deviation: f64, freedom: i32, keyframes: usize, spoilt: f64) -> (f64, f64) {
    let error = 5.0 / (2.0 * 0.86 * (ROLES * (ORIGINALS - 1) * keyframes) as f64).sqrt();
    let quantile = |share: f64| (chi_squared(freedom, share) / chi_squared(freedom, 0.5)).sqrt();
    let (low, high) = (quantile((0.5 - spoilt) / (1.0 - spoilt)), quantile(0.5 / (1.0 - spoilt)));
    (deviation * low * (1.0 - error), deviation * high * (1.0 + error))
}

/// Of two segments that both have a needless keyframe every partner may be wrong. One that has none has its partners in
/// any other.
fn spoilt(of_roles: &[usize], keyframes: usize, spoilt_keyframes: usize) -> f64 {
    let both: usize = of_roles.iter().map(|count| count * count.saturating_sub(1) / 2).sum();
    let all = ROLES * ORIGINALS * (ORIGINALS - 1) / 2;
    let wrong = (both * spoilt_keyframes) as f64;
    wrong / (wrong + ((all - both) * keyframes) as f64)
}

#[test]
fn a_known_scatter_is_found_about_each_axis_whatever_is_needless() {
    for seed in 0..12 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |low: f64, high: f64| rng.random_range(low..high);
        let mut deviation =
            || Deviation { position: draw(0.007, 0.03), rotation: [draw(0.08, 0.2), draw(0.08, 0.2), draw(0.08, 0.2)] };
        let teacher = Teacher { contact: deviation(), free: deviation() };
        let (shown, of_roles) = teacher.shows(NEEDLESS, &mut rng);
        assert!(of_roles.iter().any(|count| *count > 1), "nothing is spoilt");
        let found = scatter_of(&shown);
        assert!(!found.is_clamped);
        let free = COMMANDS.len() - CONTACTS;
        for (known, found, keyframes, spoilt) in [
            (teacher.contact, found.contact, CONTACTS, spoilt(&of_roles, CONTACTS, CONTACTS)),
            (teacher.free, found.free, free, spoilt(&of_roles, free, COMMANDS.len() + 1)),
        ] {
            let within = |what: &str, found: f64, known: f64, freedom: i32| {
                let (low, high) = bounds(known, freedom, keyframes, spoilt);
                assert!((low..=high).contains(&found), "{seed}: {what} {found}, between {low} and {high} of {known}");
            };
            within("metres", found.position, known.position, 3);
            for axis in 0..3 {
                // Two turns about the other axes, one after the other, are a turn about this one as well: half their
                // commutator, to the second order.
                let [one, other] = [known.rotation[(axis + 1) % 3], known.rotation[(axis + 2) % 3]];
                let turned = known.rotation[axis].hypot(0.5 * one * other);
                within("radians", found.rotation[axis], turned, 1);
            }
        }
    }
}

/// Nothing is believed to be steadier than the least or wilder than the greatest, and the estimate says so.
#[test]
fn what_is_clamped_is_said() {
    let ScatterParameters { least, greatest, .. } = ScatterParameters::default();
    let everywhere = |position: f64, rotation: f64| {
        let deviation = Deviation { position, rotation: [rotation; 3] };
        Teacher { contact: deviation, free: deviation }
    };
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut found = |teacher: Teacher| scatter_of(&teacher.shows(0.0, &mut rng).0);
    let clamped = |(position, rotation): (f64, f64)| {
        let Teacher { contact, free } = everywhere(position, rotation);
        Scatter { contact, free, is_clamped: true }
    };
    assert_eq!(found(everywhere(0.0, 0.0)), clamped(least), "a script without noise");
    let wild = found(everywhere(0.1, 0.1));
    assert_eq!((wild.contact.position, wild.free.position, wild.is_clamped), (greatest.0, greatest.0, true));
    // One axis alone is enough.
    let mut steady = everywhere(0.01, 0.1);
    steady.free.rotation[1] = 0.0;
    let steady = found(steady);
    assert_eq!((steady.free.rotation[1], steady.is_clamped), (least.1, true));
    assert!(steady.free.rotation[0] > least.1 && steady.contact.rotation[1] > least.1);
    assert!(!found(everywhere(0.01, 0.1)).is_clamped);
}

/// A single original tells nothing of its teacher: what was believed before stands.
#[test]
fn one_original_leaves_the_prior() {
    let believed = ScatterParameters::default().prior;
    let deviation = Deviation { position: 0.01, rotation: [0.1; 3] };
    let teacher = Teacher { contact: deviation, free: deviation };
    let (shown, _) = teacher.shows(NEEDLESS, &mut ChaCha8Rng::seed_from_u64(9));
    let found = scatter_of(&shown[..1]);
    for deviation in [found.contact, found.free] {
        let apart = deviation.rotation.map(|radians| (radians - believed.1).abs());
        assert!((deviation.position - believed.0).abs() < 1e-12 && apart.iter().all(|apart| *apart < 1e-12));
    }
    assert!(!found.is_clamped);
}
