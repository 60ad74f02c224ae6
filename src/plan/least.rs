//! Least squares without negative weights [Lawson 1974, ch. 23], from sums of products.

/// Weights w >= 0 that make w' G w - 2 b' w least; `gram` is G, symmetric, row by row. Columns that the others already give get 0.
///
/// ```
/// # use luxpipe::plan::least::nonnegative;
/// // Of (x - 1)^2 + (y + 1)^2 the least without negative numbers lies at (1, 0).
/// assert_eq!(nonnegative(&[1.0, 0.0, 0.0, 1.0], &[1.0, -1.0]), [1.0, 0.0]);
/// ```
pub fn nonnegative(gram: &[f64], b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let mut weights = vec![0.0; n];
    let mut free: Vec<usize> = Vec::new();
    let scale = (0..n).map(|i| gram[i * n + i]).fold(0.0, f64::max);
    // Each takes in one column, or leaves one out: twice as many as there are columns hardly ever happen.
    for _ in 0..6 * n {
        let slope = |i: usize| b[i] - (0..n).map(|j| gram[i * n + j] * weights[j]).sum::<f64>();
        let best = (0..n).filter(|i| !free.contains(i)).map(|i| (slope(i) / gram[i * n + i].max(1e-300).sqrt(), i));
        let Some((gain, i)) = best.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if gain <= 1e-10 * scale.sqrt() {
            break;
        }
        free.push(i);
        loop {
            let Some(wanted) = solve(gram, b, n, &free) else {
                // What it would add the others have.
                free.pop();
                return weights;
            };
            if wanted.iter().all(|w| *w > 0.0) {
                free.iter().zip(&wanted).for_each(|(i, w)| weights[*i] = *w);
                break;
            }
            // As far toward there as none is negative.
            let mut step = 1.0f64;
            for (i, w) in free.iter().zip(&wanted).filter(|(_, w)| **w <= 0.0) {
                step = step.min(weights[*i] / (weights[*i] - w));
            }
            free.iter().zip(&wanted).for_each(|(i, w)| weights[*i] += step * (w - weights[*i]));
            let before = free.len();
            free.retain(|i| weights[*i] > 1e-14);
            (0..n).filter(|i| !free.contains(i)).for_each(|i| weights[i] = 0.0);
            if free.is_empty() || free.len() == before {
                break;
            }
        }
    }
    weights
}

/// The weights of some columns without bounds; `None` where they depend on each other.
pub fn solve(gram: &[f64], b: &[f64], n: usize, columns: &[usize]) -> Option<Vec<f64>> {
    let root = factor(gram, n, columns)?;
    Some(back(&root, forth(&root, columns.iter().map(|i| b[*i]).collect())))
}

/// Cholesky's lower triangle of some rows and columns of a matrix of n, row by row.
pub fn factor(gram: &[f64], n: usize, columns: &[usize]) -> Option<Vec<f64>> {
    let k = columns.len();
    let mut root = vec![0.0; k * k];
    for i in 0..k {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|m| root[i * k + m] * root[j * k + m]).sum();
            let rest = gram[columns[i] * n + columns[j]] - sum;
            root[i * k + j] = if i == j {
                if rest <= 1e-12 * gram[columns[i] * n + columns[i]] {
                    return None;
                }
                rest.sqrt()
            } else {
                rest / root[j * k + j]
            };
        }
    }
    Some(root)
}

/// Solves L x = y.
pub fn forth(root: &[f64], mut y: Vec<f64>) -> Vec<f64> {
    let k = y.len();
    for i in 0..k {
        let sum: f64 = (0..i).map(|m| root[i * k + m] * y[m]).sum();
        y[i] = (y[i] - sum) / root[i * k + i];
    }
    y
}

/// Solves L' x = y.
fn back(root: &[f64], mut y: Vec<f64>) -> Vec<f64> {
    let k = y.len();
    for i in (0..k).rev() {
        let sum: f64 = (i + 1..k).map(|m| root[m * k + i] * y[m]).sum();
        y[i] = (y[i] - sum) / root[i * k + i];
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least of a convex function over the positive corner: its slope is 0 where a weight is positive, and not uphill elsewhere.
    #[test]
    fn slopes_are_those_of_the_least() {
        let mut state = 1u64;
        let mut draw = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64 - 0.5
        };
        for n in 1..14 {
            let rows: Vec<Vec<f64>> = (0..2 * n).map(|_| (0..n).map(|_| draw() + 0.3).collect()).collect();
            let y: Vec<f64> = (0..2 * n).map(|_| draw()).collect();
            let sum = |f: &dyn Fn(usize) -> f64| (0..2 * n).map(f).sum::<f64>();
            let gram: Vec<f64> = (0..n * n).map(|i| sum(&|r| rows[r][i / n] * rows[r][i % n])).collect();
            let b: Vec<f64> = (0..n).map(|i| sum(&|r| rows[r][i] * y[r])).collect();
            let w = nonnegative(&gram, &b);
            for i in 0..n {
                let slope = (0..n).map(|j| gram[i * n + j] * w[j]).sum::<f64>() - b[i];
                assert!(w[i] >= 0.0 && slope > -1e-8 && (w[i] == 0.0 || slope < 1e-8), "{n}: {w:?}, slope {slope}");
            }
        }
    }
}
