//! Dense matrices, as few as doubling needs.

/// A dense matrix, row by row.
#[derive(Clone)]
pub(super) struct Matrix {
    pub(super) columns: usize,
    pub(super) data: Vec<f64>,
}

impl Matrix {
    pub(super) fn zero(rows: usize, columns: usize) -> Self {
        Matrix { columns, data: vec![0.0; rows * columns] }
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Matrix { columns: self.columns, data: self.data.iter().map(|value| factor * value).collect() }
    }

    /// The square block on top, and the rows below it.
    pub(super) fn split(&self) -> (Self, Self) {
        let (top, rest) = self.data.split_at(self.columns * self.columns);
        (Matrix { columns: self.columns, data: top.to_vec() }, Matrix { columns: self.columns, data: rest.to_vec() })
    }

    /// The diagonal of a square matrix.
    pub(super) fn diagonal(&mut self) -> impl Iterator<Item = &mut f64> {
        self.data.iter_mut().step_by(self.columns + 1)
    }

    /// The product with the leading rows of `right`, as many as this matrix has columns.
    pub(super) fn times(&self, right: &Matrix) -> Self {
        let rows = self.data.len() / self.columns;
        let mut product = Matrix::zero(rows, right.columns);
        let outputs = product.data.chunks_exact_mut(right.columns);
        for (output, factors) in outputs.zip(self.data.chunks_exact(self.columns)) {
            for (factor, row) in factors.iter().zip(right.data.chunks_exact(right.columns)) {
                add_multiple(output, *factor, row);
            }
        }
        product
    }

    pub(super) fn add(&mut self, other: &Matrix) {
        add_multiple(&mut self.data, 1.0, &other.data);
    }

    /// Adds diag(factors) times `other`.
    pub(super) fn add_rows(&mut self, factors: &[f64], other: &Matrix) {
        let rows = self.data.chunks_exact_mut(self.columns).zip(other.data.chunks_exact(other.columns));
        rows.zip(factors).for_each(|((output, row), factor)| add_multiple(output, *factor, row));
    }

    /// Adds `other` times the diag of the leading `factors`.
    pub(super) fn add_columns(&mut self, other: &Matrix, factors: &[f64]) {
        let rows = self.data.chunks_exact_mut(self.columns).zip(other.data.chunks_exact(other.columns));
        for (output, row) in rows {
            output.iter_mut().zip(row.iter().zip(factors)).for_each(|(sum, (value, factor))| *sum += value * factor);
        }
    }
}

/// Adds `factor` times `row` to `output`.
pub(super) fn add_multiple(output: &mut [f64], factor: f64, row: &[f64]) {
    output.iter_mut().zip(row).for_each(|(sum, value)| *sum += factor * value);
}

/// Solves `matrix` x = `right` in place by Gauss elimination with partial pivoting.
pub(super) fn solve(mut matrix: Matrix, right: &mut Matrix) {
    let (n, m) = (matrix.columns, right.columns);
    for k in 0..n {
        let size = |i: &usize| matrix.data[i * n + k].abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(k);
        if pivot != k {
            (0..n).for_each(|j| matrix.data.swap(k * n + j, pivot * n + j));
            (0..m).for_each(|j| right.data.swap(k * m + j, pivot * m + j));
        }
        let (upper, lower) = matrix.data.split_at_mut((k + 1) * n);
        let (right_upper, right_lower) = right.data.split_at_mut((k + 1) * m);
        let (row, right_row) = (&upper[k * n + k..], &right_upper[k * m..]);
        for (below, right_below) in lower.chunks_exact_mut(n).zip(right_lower.chunks_exact_mut(m)) {
            let factor = -below[k] / row[0];
            add_multiple(&mut below[k..], factor, row);
            add_multiple(right_below, factor, right_row);
        }
    }
    for k in (0..n).rev() {
        let (upper, lower) = right.data.split_at_mut((k + 1) * m);
        let output = &mut upper[k * m..];
        let row = &matrix.data[k * n..(k + 1) * n];
        for (factor, solved) in row[k + 1..].iter().zip(lower.chunks_exact(m)) {
            add_multiple(output, -factor, solved);
        }
        output.iter_mut().for_each(|value| *value /= row[k]);
    }
}
