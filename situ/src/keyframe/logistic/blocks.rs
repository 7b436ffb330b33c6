//! Matrices in blocks of eight columns, which a regression multiplies on the widest vectors.
//!
//! A block holds eight numbers of every row, one row after the other. Rows, columns and vectors are padded with zeros
//! to multiples of [`EIGHT`].

use crate::vector::{EIGHT, joined, loops};

/// The part of a row that is in a block.
pub(super) type Eight = [f64; EIGHT];

/// The number of samples that are processed together, so that data that is read twice is in the nearest cache.
pub(super) const PANEL: usize = 64;

/// The number of rows whose sums run side by side, because each addition waits for the one before it.
const TOGETHER: usize = 4;

/// A matrix.
pub(super) struct Blocks {
    /// Shape (blocks, rows).
    numbers: Vec<Eight>,
    /// The number of rows, padded.
    rows: usize,
}

impl Blocks {
    /// A matrix of zeros.
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        let rows = rows.max(1).next_multiple_of(EIGHT);
        Self { numbers: vec![[0.0; EIGHT]; rows * columns.div_ceil(EIGHT)], rows }
    }

    /// The rows as they are, with a last column of ones: one matrix for each [`PANEL`] rows.
    pub(super) fn panels(rows: &[&[f64]], dimension: usize) -> Vec<Self> {
        rows.chunks(PANEL).map(|rows| Self::with_ones(rows, dimension)).collect()
    }

    fn with_ones(rows: &[&[f64]], dimension: usize) -> Self {
        let mut matrix = Self::zeros(rows.len(), dimension + 1);
        let (last, lane) = (dimension / EIGHT, dimension % EIGHT);
        for (index, block) in matrix.numbers.chunks_exact_mut(matrix.rows).enumerate() {
            let first = index * EIGHT;
            if index < last {
                for (numbers, row) in block.iter_mut().zip(rows) {
                    numbers.copy_from_slice(&row[first..first + EIGHT]);
                }
            } else {
                for (numbers, row) in block.iter_mut().zip(rows) {
                    numbers[..lane].copy_from_slice(&row[first..]);
                    numbers[lane] = 1.0;
                }
            }
        }
        matrix
    }

    /// The rows turned into columns: shape (d, n).
    pub(super) fn transposed(rows: &[&[f64]], dimension: usize) -> Self {
        let mut matrix = Self::zeros(dimension, rows.len());
        let stride = matrix.rows;
        for (rows, block) in rows.chunks(EIGHT).zip(matrix.numbers.chunks_exact_mut(stride)) {
            for (lane, row) in rows.iter().enumerate() {
                block.iter_mut().zip(*row).for_each(|(numbers, value)| numbers[lane] = *value);
            }
        }
        matrix
    }

    /// The number of rows, padded.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns, padded.
    pub(super) fn columns(&self) -> usize {
        self.numbers.len() / self.rows * EIGHT
    }

    /// A block, shape (rows).
    #[inline(always)]
    pub(super) fn block(&self, index: usize) -> &[Eight] {
        &self.numbers[index * self.rows..(index + 1) * self.rows]
    }

    #[inline(always)]
    pub(super) fn block_mut(&mut self, index: usize) -> &mut [Eight] {
        &mut self.numbers[index * self.rows..(index + 1) * self.rows]
    }

    #[inline(always)]
    pub(super) fn blocks(&self) -> impl ExactSizeIterator<Item = &[Eight]> {
        self.numbers.chunks_exact(self.rows)
    }

    /// The product with a vector, which has one number per column.
    pub(super) fn times(&self, vector: &[f64], products: &mut [f64]) {
        loops!(times, (self, vector, products));
    }

    /// The product of the transpose with a vector, which has one number per row.
    pub(super) fn transpose_times(&self, vector: &[f64], products: &mut [f64]) {
        products.fill(0.0);
        loops!(transpose_times, (self, vector, products));
    }

    /// Xᵀ X, on and right of the diagonal. The entries left of it, in the blocks of the diagonal, have no meaning.
    pub(super) fn square(&self) -> Self {
        let mut square = Self::zeros(self.columns(), self.columns());
        loops!(add_square, (&self.numbers[..], self, self.columns(), &mut square));
        square
    }

    /// Xᵀ D X of so many columns, with the diagonal D, on and right of the diagonal; X is in panels.
    pub(super) fn weighted_square(
        panels: &[Self],
        diagonal: &[f64],
        size: usize,
        workspace: &mut [Eight],
        square: &mut Self,
    ) {
        square.numbers.fill([0.0; EIGHT]);
        loops!(weighted_square, (panels, diagonal, size, workspace, square));
    }

    /// Copies what is right of the diagonal to the left of it.
    pub(super) fn mirror(&mut self) {
        for right in 0..self.columns() / EIGHT {
            for row in 0..EIGHT * right {
                let numbers = self.block(right)[row];
                let left = self.block_mut(row / EIGHT);
                for (lane, number) in numbers.into_iter().enumerate() {
                    left[right * EIGHT + lane][row % EIGHT] = number;
                }
            }
            let diagonal = &mut self.block_mut(right)[right * EIGHT..(right + 1) * EIGHT];
            for row in 1..EIGHT {
                let (above, below) = diagonal.split_at_mut(row);
                below[0].iter_mut().zip(above).for_each(|(number, across)| *number = across[row]);
            }
        }
    }
}

/// The sum of each pair. It takes and returns values: if lane after lane were written to memory, the compiler could not
/// use vectors.
#[inline(always)]
pub(super) fn plus(mut left: Eight, right: Eight) -> Eight {
    for lane in 0..EIGHT {
        left[lane] += right[lane];
    }
    left
}

/// The difference of each pair.
#[inline(always)]
pub(super) fn minus(mut left: Eight, right: Eight) -> Eight {
    for lane in 0..EIGHT {
        left[lane] -= right[lane];
    }
    left
}

/// The product of each pair.
#[inline(always)]
pub(super) fn times_each(mut left: Eight, right: Eight) -> Eight {
    for lane in 0..EIGHT {
        left[lane] *= right[lane];
    }
    left
}

/// Eight numbers, each times the factor.
#[inline(always)]
pub(super) fn scaled(numbers: Eight, factor: f64) -> Eight {
    times_each(numbers, [factor; EIGHT])
}

#[inline(always)]
fn transpose_times((matrix, vector, sums): (&Blocks, &[f64], &mut [f64])) {
    add_transposed(matrix, vector, sums);
}

/// The product with a vector, which has one number per column.
#[inline(always)]
pub(super) fn times((matrix, vector, products): (&Blocks, &[f64], &mut [f64])) {
    for (group, products) in products.as_chunks_mut::<TOGETHER>().0.iter_mut().enumerate() {
        let from = group * TOGETHER;
        let mut sums = [[0.0; EIGHT]; TOGETHER];
        for (block, weights) in matrix.blocks().zip(vector.as_chunks::<EIGHT>().0) {
            for (sums, numbers) in sums.iter_mut().zip(&block[from..from + TOGETHER]) {
                *sums = plus(*sums, times_each(*numbers, *weights));
            }
        }
        for (product, sums) in products.iter_mut().zip(sums) {
            *product = joined(sums);
        }
    }
}

/// Adds the rows, each times its factor.
#[inline(always)]
pub(super) fn add_transposed(matrix: &Blocks, factors: &[f64], sums: &mut [f64]) {
    for (block, sums) in matrix.blocks().zip(sums.as_chunks_mut::<EIGHT>().0) {
        let mut parts = [[0.0; EIGHT]; TOGETHER];
        for (rows, factors) in block.as_chunks::<TOGETHER>().0.iter().zip(factors.as_chunks::<TOGETHER>().0) {
            for ((part, numbers), factor) in parts.iter_mut().zip(rows).zip(factors) {
                *part = plus(*part, scaled(*numbers, *factor));
            }
        }
        let [a, b, c, d] = parts;
        *sums = plus(*sums, plus(plus(a, b), plus(c, d)));
    }
}

/// `ROWS` rows of Lᵀ R: those of the columns of L from `FIRST` on.
#[inline(always)]
pub(super) fn some_rows<const FIRST: usize, const ROWS: usize>(left: &[Eight], right: &[Eight]) -> [Eight; ROWS] {
    let mut sums = [[0.0; EIGHT]; ROWS];
    for (left, right) in left.iter().zip(right) {
        for row in 0..ROWS {
            for lane in 0..EIGHT {
                sums[row][lane] += left[FIRST + row] * right[lane];
            }
        }
    }
    sums
}

#[inline(always)]
fn add(sums: &mut [Eight], more: &[Eight]) {
    for (sums, more) in sums.iter_mut().zip(more) {
        *sums = plus(*sums, *more);
    }
}

#[inline(always)]
fn weighted_square((panels, diagonal, size, workspace, square): (&[Blocks], &[f64], usize, &mut [Eight], &mut Blocks)) {
    for (panel, factors) in panels.iter().zip(diagonal.chunks(PANEL)) {
        let workspace = &mut workspace[..panel.numbers.len()];
        for (weighted, block) in workspace.chunks_exact_mut(panel.rows).zip(panel.blocks()) {
            for ((weighted, numbers), factor) in weighted.iter_mut().zip(block).zip(factors) {
                *weighted = scaled(*numbers, *factor);
            }
        }
        add_square((workspace, panel, size, square));
    }
}

/// Adds Lᵀ R of so many columns, on and right of the diagonal. L has the shape of R.
#[inline(always)]
fn add_square((left, right, size, square): (&[Eight], &Blocks, usize, &mut Blocks)) {
    for (index, left) in left.chunks_exact(right.rows).enumerate() {
        let first = index * EIGHT;
        for (column, right) in right.blocks().enumerate().skip(index) {
            let sums = &mut square.block_mut(column)[first..first + EIGHT];
            if size - first == 1 {
                add(sums, &some_rows::<0, 1>(left, right));
                continue;
            }
            add(sums, &some_rows::<0, 4>(left, right));
            if size - first > 4 {
                add(&mut sums[4..], &some_rows::<4, 4>(left, right));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A kernel has the same bits if it is compiled for any processor and for the widest vectors of this one. The sums
    /// are right too.
    #[test]
    fn the_same_bits_on_the_widest_vectors() {
        let rows: Vec<Vec<f64>> =
            (0..100).map(|row| (0..21).map(|at| libm::sin(f64::from(row * 21 + at))).collect()).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let (panels, size) = (Blocks::panels(&rows, 21), 22_usize);
        let diagonal: Vec<f64> = (0..104).map(|row| libm::cos(f64::from(row))).collect();
        let mut workspace = vec![[0.0; EIGHT]; PANEL * size.next_multiple_of(EIGHT) / EIGHT];
        let (mut plain, mut widest) = (Blocks::zeros(size, size), Blocks::zeros(size, size));
        weighted_square((&panels, &diagonal, size, &mut workspace, &mut plain));
        Blocks::weighted_square(&panels, &diagonal, size, &mut workspace, &mut widest);
        assert_eq!(plain.numbers, widest.numbers);
        let expected: f64 = (0..100).map(|row| diagonal[row] * rows[row][3] * rows[row][20]).sum();
        assert!((widest.block(2)[3][4] - expected).abs() < 1e-12, "an element is the sum that it says");
        let mut products = [[0.0; PANEL]; 2];
        let [plain, widest] = &mut products;
        times((&panels[0], &diagonal[..24], plain));
        panels[0].times(&diagonal[..24], widest);
        assert_eq!(plain, widest);
        let mut sums = [[0.0; 24]; 2];
        let [plain, widest] = &mut sums;
        transpose_times((&panels[0], &diagonal[..PANEL], plain));
        panels[0].transpose_times(&diagonal[..PANEL], widest);
        assert_eq!(plain, widest);
    }
}
