//! The Cholesky factor of a matrix in blocks of eight columns.

use super::blocks::{Blocks, Eight, minus, plus, scaled, some_rows, times_each};
use crate::vector::{EIGHT, joined, loops};

/// U with m = Uᵀ U. In the blocks of the diagonal each row is divided by its pivot.
pub(super) struct Factor {
    blocks: Blocks,
    /// The inverse of each pivot, padded.
    inverses: Vec<f64>,
}

impl Factor {
    /// Allocates the factor of a matrix with so many rows.
    pub(super) fn new(size: usize) -> Self {
        let blocks = Blocks::zeros(size, size);
        Self { inverses: vec![0.0; blocks.rows()], blocks }
    }

    /// The matrix to be factored. Its upper triangle is to be written; [`Factor::factor`] overwrites it.
    pub(super) fn matrix(&mut self) -> &mut Blocks {
        &mut self.blocks
    }

    /// Adds a number to the first `count` elements of the diagonal, and sets the padding of the diagonal to 1.
    pub(super) fn add_to_diagonal(&mut self, count: usize, size: usize, number: f64) {
        for at in (0..count).chain(size..self.blocks.rows()) {
            let element = &mut self.blocks.block_mut(at / EIGHT)[at][at % EIGHT];
            *element = if at < count { *element + number } else { 1.0 };
        }
    }

    /// Factors the matrix. False if it is not positive definite.
    pub(super) fn factor(&mut self) -> bool {
        loops!(factor, self)
    }

    /// Solves Uᵀ U x = b in place; b is padded.
    pub(super) fn solve(&self, b: &mut [f64]) {
        loops!(solve, (self, b));
    }
}

#[inline(always)]
fn subtract(from: &mut [Eight], what: &[Eight; 4]) {
    for (from, what) in from.iter_mut().zip(what) {
        *from = minus(*from, *what);
    }
}

#[inline(always)]
fn factor(own: &mut Factor) -> bool {
    let count = own.blocks.blocks().len();
    for left in 0..count {
        let above = left * EIGHT;
        for right in left..count {
            let (left, right_above) = (&own.blocks.block(left)[..above], &own.blocks.block(right)[..above]);
            let (low, high) = (some_rows::<0, 4>(left, right_above), some_rows::<4, 4>(left, right_above));
            let rows = &mut own.blocks.block_mut(right)[above..above + EIGHT];
            subtract(&mut rows[..4], &low);
            subtract(&mut rows[4..], &high);
        }
        let Some(diagonal) = own.blocks.block_mut(left)[above..].first_chunk_mut::<EIGHT>() else { return false };
        let inverses = &mut own.inverses[above..above + EIGHT];
        if !factor_diagonal(diagonal, inverses) {
            return false;
        }
        let diagonal = *diagonal;
        for right in left + 1..count {
            let Some(rows) = own.blocks.block_mut(right)[above..].first_chunk_mut::<EIGHT>() else { return false };
            eliminate(&diagonal, inverses, rows);
        }
    }
    true
}

/// Factors a block of the diagonal. Each row is divided by its pivot.
#[inline(always)]
fn factor_diagonal(block: &mut [Eight; EIGHT], inverses: &mut [f64]) -> bool {
    for pivot in 0..EIGHT {
        let square = block[pivot][pivot];
        if !(square.is_finite() && square > 0.0) {
            return false;
        }
        let inverse = 1.0 / square;
        inverses[pivot] = libm::sqrt(inverse);
        let row = block[pivot];
        let divided = scaled(row, inverse);
        block[pivot] = divided;
        for below in pivot + 1..EIGHT {
            block[below] = minus(block[below], scaled(row, divided[below]));
        }
    }
    true
}

/// Eliminates what is right of a block of the diagonal.
#[inline(always)]
fn eliminate(diagonal: &[Eight; EIGHT], inverses: &[f64], rows: &mut [Eight; EIGHT]) {
    for pivot in 0..EIGHT {
        let row = rows[pivot];
        for below in pivot + 1..EIGHT {
            rows[below] = minus(rows[below], scaled(row, diagonal[pivot][below]));
        }
        rows[pivot] = scaled(row, inverses[pivot]);
    }
}

#[inline(always)]
fn solve((own, b): (&Factor, &mut [f64])) {
    let count = own.blocks.blocks().len();
    let (b, _) = b.as_chunks_mut::<EIGHT>();
    let (inverses, _) = own.inverses.as_chunks::<EIGHT>();
    for left in 0..count {
        let rows = left * EIGHT..(left + 1) * EIGHT;
        let diagonal = &own.blocks.block(left)[rows.clone()];
        let mut values = b[left];
        for pivot in 0..EIGHT {
            let value = values[pivot];
            for lane in pivot + 1..EIGHT {
                values[lane] -= diagonal[pivot][lane] * value;
            }
        }
        values = times_each(values, inverses[left]);
        b[left] = values;
        for (right, sums) in b.iter_mut().enumerate().skip(left + 1) {
            for (numbers, value) in own.blocks.block(right)[rows.clone()].iter().zip(values) {
                *sums = minus(*sums, scaled(*numbers, value));
            }
        }
    }
    for left in (0..count).rev() {
        let rows = left * EIGHT..(left + 1) * EIGHT;
        let diagonal = &own.blocks.block(left)[rows.clone()];
        let mut sums = [[0.0; EIGHT]; EIGHT];
        for (right, values) in b.iter().enumerate().skip(left + 1) {
            for (sums, numbers) in sums.iter_mut().zip(&own.blocks.block(right)[rows.clone()]) {
                *sums = plus(*sums, times_each(*numbers, *values));
            }
        }
        let mut values = b[left];
        for row in 0..EIGHT {
            values[row] = (values[row] - joined(sums[row])) * inverses[left][row];
        }
        for row in (0..EIGHT).rev() {
            for above in 0..row {
                values[above] -= diagonal[above][row] * values[row];
            }
        }
        b[left] = values;
    }
}
