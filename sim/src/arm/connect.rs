//! RRT-Connect (Kuffner and LaValle 2000): two trees grow towards each other, and the way through them is made shorter.

use nalgebra::SVector;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A tree grows by so much in a step, radians (norm over all joints).
const STEP: f64 = 0.2;
/// A way between two points is looked at once in so many radians. A hand at the end of the arm moves by 2 cm at the
/// most in between, about a finger's width.
const RESOLUTION: f64 = 0.02;

/// The space in which a way is sought.
pub(crate) struct Space<'a, const N: usize> {
    /// The least value of each coordinate.
    pub(crate) lower: SVector<f64, N>,
    /// The greatest.
    pub(crate) upper: SVector<f64, N>,
    /// Whether a point may be on a way.
    pub(crate) is_free: &'a dyn Fn(&SVector<f64, N>) -> bool,
}

struct Tree<const N: usize> {
    points: Vec<SVector<f64, N>>,
    parents: Vec<usize>,
}

impl<const N: usize> Tree<N> {
    fn new(roots: &[SVector<f64, N>]) -> Tree<N> {
        Tree { points: roots.to_vec(), parents: (0..roots.len()).collect() }
    }

    fn nearest(&self, to: &SVector<f64, N>) -> usize {
        let distances = self.points.iter().map(|point| (point - to).norm_squared());
        distances
            .enumerate()
            .reduce(|best, next| if next.1 < best.1 { next } else { best })
            .map_or(0, |(index, _)| index)
    }

    /// From a point back to its root.
    fn back(&self, mut index: usize) -> Vec<SVector<f64, N>> {
        let mut way = vec![self.points[index]];
        while self.parents[index] != index {
            index = self.parents[index];
            way.push(self.points[index]);
        }
        way
    }

    /// Grows straight towards a point until it is there or something is in the way. Returns the index of the last
    /// point, and whether it is there.
    fn grow(&mut self, space: &Space<'_, N>, to: &SVector<f64, N>, most_steps: usize) -> (usize, bool) {
        let mut at = self.nearest(to);
        for _ in 0..most_steps {
            let way = to - self.points[at];
            let length = way.norm();
            if length == 0.0 {
                return (at, true);
            }
            let next = if length <= STEP { *to } else { self.points[at] + way * (STEP / length) };
            if !space.is_clear(&self.points[at], &next) {
                return (at, false);
            }
            self.points.push(next);
            self.parents.push(at);
            at = self.points.len() - 1;
        }
        (at, self.points[at] == *to)
    }
}

impl<const N: usize> Space<'_, N> {
    fn draw(&self, rng: &mut ChaCha8Rng) -> SVector<f64, N> {
        SVector::from_fn(|axis, _| self.lower[axis] + (self.upper[axis] - self.lower[axis]) * rng.random::<f64>())
    }

    /// Whether the straight way is free. Its first point is not looked at.
    pub(crate) fn is_clear(&self, from: &SVector<f64, N>, to: &SVector<f64, N>) -> bool {
        let way = to - from;
        let pieces = libm::ceil(way.norm() / RESOLUTION).max(1.0) as usize;
        (1..=pieces).all(|piece| (self.is_free)(&(from + way * (piece as f64 / pieces as f64))))
    }

    /// A free way from `start` to one of `goals`, both among its points. None where the budget of iterations is used
    /// up.
    pub(crate) fn connect(
        &self,
        start: &SVector<f64, N>,
        goals: &[SVector<f64, N>],
        iterations: usize,
        rng: &mut ChaCha8Rng,
    ) -> Option<Vec<SVector<f64, N>>> {
        if goals.is_empty() {
            return None;
        }
        let mut trees = [Tree::new(&[*start]), Tree::new(goals)];
        for iteration in 0..iterations {
            let [first, second] = &mut trees;
            let (one, other) = if iteration % 2 == 0 { (first, second) } else { (second, first) };
            let drawn = self.draw(rng);
            let before = one.points.len();
            let (grown, _) = one.grow(self, &drawn, 1);
            if one.points.len() == before {
                continue;
            }
            let target = one.points[grown];
            let (met, reached) = other.grow(self, &target, usize::MAX);
            if reached {
                let (from_start, from_goal) = if iteration % 2 == 0 {
                    (trees[0].back(grown), trees[1].back(met))
                } else {
                    (trees[0].back(met), trees[1].back(grown))
                };
                // The point at which they met is in both.
                return Some(from_start.into_iter().rev().chain(from_goal.into_iter().skip(1)).collect());
            }
        }
        None
    }

    /// Cuts corners: two places on the way are drawn at random, and joined straight where that is free.
    pub(crate) fn shorten(
        &self,
        mut way: Vec<SVector<f64, N>>,
        attempts: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<SVector<f64, N>> {
        for _ in 0..attempts {
            if way.len() < 3 {
                break;
            }
            let mut place = || {
                let at = rng.random::<f64>() * (way.len() - 1) as f64;
                let index = (at as usize).min(way.len() - 2);
                (index, way[index] + (way[index + 1] - way[index]) * (at - index as f64))
            };
            let (one, other) = (place(), place());
            let ((low, from), (high, to)) = if one.0 <= other.0 { (one, other) } else { (other, one) };
            if low < high
                && self.is_clear(&way[low], &from)
                && self.is_clear(&from, &to)
                && self.is_clear(&to, &way[high + 1])
            {
                way.splice(low + 1..=high, [from, to]);
            }
        }
        way
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use rand::SeedableRng;
    use std::collections::VecDeque;

    /// Discs in the unit square, by seed.
    fn discs(seed: u64, count: usize) -> Vec<(Vector2<f64>, f64)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || rng.random::<f64>() * 4.0;
        (0..count).map(|_| (Vector2::new(draw(), draw()), 0.2 + 0.15 * draw())).collect()
    }

    fn is_free(discs: &[(Vector2<f64>, f64)], grown: f64, point: &Vector2<f64>) -> bool {
        discs.iter().all(|(center, radius)| (point - center).norm() > radius + grown)
    }

    /// Whether the two corners of the square are joined on a grid. It is an oracle that knows nothing of trees.
    fn joined_on_a_grid(discs: &[(Vector2<f64>, f64)], grown: f64) -> bool {
        const CELLS: i32 = 200;
        let point = |x: i32, y: i32| Vector2::new(f64::from(x), f64::from(y)) * (4.0 / f64::from(CELLS));
        let free = |x: i32, y: i32| {
            (0..=CELLS).contains(&x) && (0..=CELLS).contains(&y) && is_free(discs, grown, &point(x, y))
        };
        let mut seen = vec![false; ((CELLS + 1) * (CELLS + 1)) as usize];
        let mut queue = VecDeque::from([(0, 0)]);
        while let Some((x, y)) = queue.pop_front() {
            if (x, y) == (CELLS, CELLS) {
                return true;
            }
            for (x, y) in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
                if free(x, y) && !std::mem::replace(&mut seen[(y * (CELLS + 1) + x) as usize], true) {
                    queue.push_back((x, y));
                }
            }
        }
        false
    }

    #[test]
    fn a_way_is_found_where_a_grid_has_one_and_none_where_it_has_none() {
        let (start, goal) = (Vector2::zeros(), Vector2::repeat(4.0));
        let (mut open, mut shut) = (0, 0);
        for seed in 0..120 {
            let discs = discs(seed, 14);
            if !is_free(&discs, 0.1, &start) || !is_free(&discs, 0.1, &goal) {
                continue;
            }
            let free = |point: &Vector2<f64>| is_free(&discs, 0.0, point);
            let space = Space { lower: start, upper: goal, is_free: &free };
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let way = space.connect(&start, &[goal], 4000, &mut rng);
            // With room to spare a way must be found; where even a point cannot pass, none may be.
            if joined_on_a_grid(&discs, 0.08) {
                open += 1;
                let way = way.unwrap_or_else(|| panic!("seed {seed}: there is a way"));
                let short = space.shorten(way.clone(), 60, &mut rng);
                for way in [&way, &short] {
                    assert_eq!((way[0], way[way.len() - 1]), (start, goal));
                    assert!(way.windows(2).all(|pair| space.is_clear(&pair[0], &pair[1])), "seed {seed}");
                }
                let length = |way: &[Vector2<f64>]| way.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
                assert!(length(&short) <= length(&way) + 1e-9 && length(&short) >= (goal - start).norm() - 1e-9);
            } else if !joined_on_a_grid(&discs, -0.03) {
                shut += 1;
                assert!(way.is_none(), "seed {seed}: there is no way");
            }
        }
        assert!(open >= 20 && shut >= 5, "{open} open, {shut} shut");
    }

    #[test]
    fn a_seed_is_a_way() {
        let discs = [(Vector2::repeat(2.0), 1.0)];
        let free = |point: &Vector2<f64>| is_free(&discs, 0.0, point);
        let space = Space { lower: Vector2::zeros(), upper: Vector2::repeat(4.0), is_free: &free };
        let way = |seed| {
            space.connect(&Vector2::zeros(), &[Vector2::repeat(4.0)], 4000, &mut ChaCha8Rng::seed_from_u64(seed))
        };
        assert_eq!(way(1), way(1));
        assert_ne!(way(1), way(2));
    }
}
