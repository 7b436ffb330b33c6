//! Coactive learning (Jain et al. 2013; Shivaswamy and Joachims 2012): the regret bound.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::refinement::Refine;
use situ::method::refinement::cost_weights::{CostWeights, Rule, coactive};
use situ::random::{standard_normal, stream};

use super::fixture::{apart, moved, pick, policy, segment};

const FEATURES: usize = 6;
const PLANS: usize = 20;
const ROUNDS: usize = 300;
const DRAWS: u64 = 100;

type Vector = [f64; FEATURES];

fn dot(left: &Vector, right: &Vector) -> f64 {
    left.iter().zip(right).map(|(left, right)| left * right).sum()
}

/// A vector in the ball of this radius.
fn in_ball(radius: f64, rng: &mut ChaCha8Rng) -> Vector {
    let direction: Vector = std::array::from_fn(|_| standard_normal(rng));
    let length = radius * rng.random::<f64>() / dot(&direction, &direction).sqrt();
    direction.map(|value| value * length)
}

/// The greatest ratio of the average regret to `2R‖w*‖/√T` over all T. `learn` moves the weights, and a teacher always
/// shows the best plan (α = 1).
fn worst_ratio(seed: u64, learn: impl Fn(&mut Vector, &Vector, &Vector)) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "coactive"));
    let radius = 0.1 + 3.0 * rng.random::<f64>();
    let truth = in_ball(5.0, &mut rng);
    let mut weights = [0.0; FEATURES];
    let (mut regret, mut worst) = (0.0, 0.0_f64);
    for round in 1..=ROUNDS {
        let plans: Vec<Vector> = (0..PLANS).map(|_| in_ball(radius, &mut rng)).collect();
        let best = |weights: &Vector| {
            plans.iter().max_by(|left, right| dot(weights, left).total_cmp(&dot(weights, right))).unwrap()
        };
        let (planned, shown) = (best(&weights), best(&truth));
        regret += dot(&truth, shown) - dot(&truth, planned);
        let bound = 2.0 * radius * dot(&truth, &truth).sqrt() / (round as f64).sqrt();
        worst = worst.max(regret / round as f64 / bound);
        learn(&mut weights, shown, planned);
    }
    worst
}

#[test]
fn the_average_regret_stays_below_its_bound_at_every_step() {
    let worst = (0..DRAWS).map(|seed| worst_ratio(seed, coactive)).fold(0.0, f64::max);
    println!("coactive: regret at most {worst:.3} of its bound over {DRAWS} draws of {ROUNDS} rounds");
    assert!(worst <= 1.0, "{worst}");
    // The test can fail: with the wrong sign no draw keeps the bound.
    let wrong = |weights: &mut Vector, shown: &Vector, planned: &Vector| coactive(weights, planned, shown);
    let least = (0..DRAWS).map(|seed| worst_ratio(seed, wrong)).fold(f64::INFINITY, f64::min);
    println!("coactive, wrong sign: at least {least:.3}");
    assert!(least > 1.0, "{least}");
}

/// What is shown a second time is planned already, so nothing moves; and what is shown otherwise moves the plan there.
#[test]
fn the_plan_goes_where_it_is_shown_and_stays() {
    let refiner = CostWeights { rule: Rule::Coactive };
    let originals = [segment(pick()), segment(pick())];
    let originals: Vec<_> = originals.iter().collect();
    let mut primitive = refiner.fit(&policy(&originals), &originals, &mut Default::default()).unwrap();
    let planned = |primitive: &_| -> Vec<_> {
        refiner.keyframes(primitive).into_iter().map(|refined| refined.mean.pose).collect()
    };
    for by in [[0.05, 0.0, 0.04], [0.05, 0.0, 0.04], [-0.03, 0.02, 0.0]] {
        // The contact alone is moved: it is the only one of its group.
        let mut shown = pick();
        shown[2] = moved(&shown[2], by);
        refiner.correct(&mut primitive, &segment(shown.clone()), &mut Default::default()).unwrap();
        let found = planned(&primitive);
        for (found, shown) in found.iter().zip(&shown) {
            assert!(apart(found, &shown.pose) < 1e-6, "{found} is not {}", shown.pose);
        }
    }
}
