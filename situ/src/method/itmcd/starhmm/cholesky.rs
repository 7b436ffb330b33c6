//! A small dense Cholesky factorisation of any size; its sums have a fixed order.

use crate::vector::dot;

/// Factors a symmetric positive definite matrix (row-major, n × n, lower triangle read) in place into L, with L Lᵀ = m.
/// False if it is not positive definite; the matrix is then overwritten in part.
pub(crate) fn factor(matrix: &mut [f64], n: usize) -> bool {
    for row in 0..n {
        let (above, own) = matrix.split_at_mut(row * n);
        for column in 0..row {
            let pivot = &above[column * n..column * n + column + 1];
            own[column] = (own[column] - dot(&own[..column], &pivot[..column])) / pivot[column];
        }
        let rest = own[row] - dot(&own[..row], &own[..row]);
        if !(rest.is_finite() && rest > 0.0) {
            return false;
        }
        own[row] = libm::sqrt(rest);
    }
    true
}

/// Solves L Lᵀ x = b in place.
pub(crate) fn solve(factor: &[f64], n: usize, b: &mut [f64]) {
    for row in 0..n {
        let own = &factor[row * n..row * n + row + 1];
        b[row] = (b[row] - dot(&own[..row], &b[..row])) / own[row];
    }
    for row in (0..n).rev() {
        let own = &factor[row * n..row * n + row + 1];
        b[row] /= own[row];
        let value = b[row];
        for (below, weight) in b[..row].iter_mut().zip(own) {
            *below -= weight * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::{factor, solve};
    use crate::random::standard_normal;

    /// A Aᵀ + 1 of a random A, and a random b: L Lᵀ is the matrix, and the matrix times the solution is b.
    #[test]
    fn the_factor_and_the_solution_multiply_back() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for n in 0..8 {
            let a: Vec<f64> = (0..n * n).map(|_| standard_normal(&mut rng)).collect();
            let cell = |row: usize, column: usize| -> f64 {
                let product: f64 = (0..n).map(|k| a[row * n + k] * a[column * n + k]).sum();
                product + if row == column { 1.0 } else { 0.0 }
            };
            let matrix: Vec<f64> = (0..n * n).map(|at| cell(at / n, at % n)).collect();
            let mut lower = matrix.clone();
            assert!(factor(&mut lower, n));
            let b: Vec<f64> = (0..n).map(|_| standard_normal(&mut rng)).collect();
            let mut x = b.clone();
            solve(&lower, n, &mut x);
            for row in 0..n {
                for column in 0..=row {
                    let product: f64 = (0..=column).map(|k| lower[row * n + k] * lower[column * n + k]).sum();
                    assert!((product - matrix[row * n + column]).abs() < 1e-12, "{n}: {row} {column}");
                }
                let product: f64 = (0..n).map(|column| matrix[row * n + column] * x[column]).sum();
                assert!((product - b[row]).abs() < 1e-11, "{n}: {product} is not {}", b[row]);
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        for matrix in [[0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 2.0, 4.0], [1.0, 2.0, 2.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0]] {
            assert!(!factor(&mut matrix.clone(), 2), "{matrix:?}");
        }
    }
}
