//! One weight at a time against all at once (Bajcsy et al. 2018), in a simulation of a person who pushes a robot.
//!
//! Some of twelve weights are wrong. The person corrects the plan as long as a feature is off by more than a quarter of
//! its range, at most four times. Every correction also changes, a little, every feature that was not meant to change.
//! There are two persons:
//!
//! - The person of the paper *means one feature*, the one that is most off. Then one weight at a time wins, as
//!   published, because it ignores the unintended changes. The published margin is greatest if *several* weights are
//!   wrong. Here that depends on the unintended change. With a little of it, the margin grows with the number of wrong
//!   weights. With much of it, the margin shrinks: all-at-once mainly harms the weights that were right.
//! - The other person *shows all of it at once*, as a corrective demonstration does. If one weight is wrong, one at a
//!   time still wins. If several are wrong, its last error is smaller, but it needs one correction per wrong weight,
//!   and its regret is greater. So the published direction does not hold for demonstrations.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::refinement::cost_weights::RANGES;
use situ::method::refinement::cost_weights::{FEATURES, Features, Physical};
use situ::random::{standard_normal, stream};

const DRAWS: u64 = 400;
const CORRECTIONS: usize = 4;
/// What a person tolerates, in ranges.
const TOLERATED: f64 = 0.25;
/// The deviation of what was not meant to change, in ranges: 2 cm and 0.05 rad; 4 cm and 0.1 rad.
const UNINTENDED: [f64; 2] = [0.1, 0.2];
/// A difference must be this many standard errors away from 0.
const CERTAIN: f64 = 5.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Person {
    MeansOne,
    ShowsAll,
}

/// The length of the error of the weights after the corrections, in ranges; and the regret, which is the mean over the
/// corrections of half the squared length.
fn run(seed: u64, person: Person, wrong: usize, unintended: f64, one_at_a_time: bool) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "physical corrections"));
    let mut wanted: Features = [0.0; FEATURES];
    while wanted.iter().filter(|value| **value != 0.0).count() < wrong {
        let size = rng.random_range(0.4..1.0) * if rng.random() { 1.0 } else { -1.0 };
        let feature = rng.random_range(0..FEATURES);
        wanted[feature] = size * RANGES[feature];
    }
    let mut weights: Features = [0.0; FEATURES];
    let squared = |weights: &Features| -> f64 {
        (0..FEATURES).map(|feature| ((weights[feature] + wanted[feature]) / RANGES[feature]).powi(2)).sum()
    };
    let mut regret = 0.0;
    for _ in 0..CORRECTIONS {
        let planned = weights.map(|weight| -weight);
        let off = |feature: &usize| ((wanted[*feature] - planned[*feature]) / RANGES[*feature]).abs();
        let most = (0..FEATURES).max_by(|left, right| off(left).total_cmp(&off(right))).unwrap();
        // The noise is drawn even if it is not used, so that both rules meet the same person.
        let noise: Features = std::array::from_fn(|feature| unintended * RANGES[feature] * standard_normal(&mut rng));
        if off(&most) > TOLERATED {
            let meant = |feature: usize| person == Person::ShowsAll || feature == most;
            let shown: Features = std::array::from_fn(|feature| {
                noise[feature] + if meant(feature) { wanted[feature] } else { planned[feature] }
            });
            let rule = Physical { ranges: &RANGES, gain: 1.0, limit: 2.0, one_at_a_time };
            rule.correct(&mut weights, &shown, &planned);
        }
        regret += 0.5 * squared(&weights) / CORRECTIONS as f64;
    }
    (squared(&weights).sqrt(), regret)
}

/// All at once minus one at a time: the mean over draws and its standard error, for the last error and for the regret.
fn margins(person: Person, wrong: usize, unintended: f64) -> [(f64, f64); 2] {
    let runs = |one_at_a_time| (0..DRAWS).map(move |seed| run(seed, person, wrong, unintended, one_at_a_time));
    let pairs: Vec<_> = runs(true).zip(runs(false)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let margin = |part: fn(&(f64, f64)) -> f64| {
        let (one, all): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(one, all)| (part(one), part(all))).unzip();
        let differences: Vec<f64> = one.iter().zip(&all).map(|(one, all)| all - one).collect();
        let centre = mean(&differences);
        let variance = differences.iter().map(|value| (value - centre).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
        print!("  one {:.3} all {:.3}", mean(&one), mean(&all));
        (centre, (variance / DRAWS as f64).sqrt())
    };
    print!("{person:?}, {wrong} wrong, unintended {unintended}: error");
    let error = margin(|run| run.0);
    print!(", regret");
    let regret = margin(|run| run.1);
    println!("; margins {:.3} ± {:.3}, {:.3} ± {:.3}", error.0, error.1, regret.0, regret.1);
    [error, regret]
}

fn above((mean, deviation): (f64, f64), floor: f64) -> bool {
    mean - CERTAIN * deviation > floor
}

#[test]
fn one_at_a_time_wins_where_one_is_meant_at_a_time() {
    for unintended in UNINTENDED {
        let [one, two, four] = [1, 2, 4].map(|wrong| margins(Person::MeansOne, wrong, unintended));
        for [error, regret] in [one, two, four] {
            assert!(above(error, 0.0) && above(regret, 0.0), "{unintended}: {error:?} {regret:?}");
        }
        let (least, greatest) = if unintended == UNINTENDED[0] { (one[0], four[0]) } else { (four[0], one[0]) };
        let joint = (greatest.0 - least.0, greatest.1.hypot(least.1));
        assert!(above(joint, 0.0), "{unintended}: {one:?} {four:?}");
    }
}

#[test]
fn all_at_once_has_less_regret_where_several_are_shown_at_once() {
    for unintended in UNINTENDED {
        for margin in margins(Person::ShowsAll, 1, unintended) {
            assert!(above(margin, 0.0), "{unintended}: {margin:?}");
        }
        let [error, (regret, deviation)] = margins(Person::ShowsAll, 4, unintended);
        assert!(above(error, 0.0), "{unintended}: {error:?}");
        assert!(above((-regret, deviation), 0.0), "{unintended}: {regret} ± {deviation}");
    }
}
