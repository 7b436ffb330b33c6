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
