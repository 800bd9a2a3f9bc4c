//! Cholesky factorisation of a symmetric positive definite matrix: solutions, determinant and inverse.

/// Solves `(A + shift I) x = b` by a Cholesky factorisation.
///
/// `matrix` holds A's lower triangle row by row in a square of `right.len()`; `factor`, as long, receives the
/// factor L and `right` the solution. `None` when the sum is not positive definite or not finite; `right` is
/// then meaningless.
#[must_use]
pub fn solve_shifted(
    matrix: &[f64],
    shift: f64,
    factor: &mut [f64],
    right: &mut [f64],
) -> Option<()> {
    let size = right.len();
    for row in 0..size {
        let (above, current) = factor.split_at_mut(row * size);
        let current = &mut current[..=row];
        current.copy_from_slice(&matrix[row * size..=row * size + row]);
        for column in 0..row {
            let other = &above[column * size..=column * size + column];
            let (left, place) = current.split_at_mut(column);
            place[0] = (place[0] - product(left, other)) / other[column];
        }
        let (left, diagonal) = current.split_at_mut(row);
        let square = diagonal[0] + shift - product(left, left);
        if !(square > 0.0 && square.is_finite()) {
            return None;
        }
        diagonal[0] = square.sqrt();
    }
    forward(factor, right);
    for row in (0..size).rev() {
        let line = &factor[row * size..=row * size + row];
        let (above, place) = right.split_at_mut(row);
        place[0] /= line[row];
        for (value, weight) in above.iter_mut().zip(line) {
            *value -= weight * place[0];
        }
    }
    Some(())
}

/// Solves `L x = b` in place, L as [`solve_shifted`] leaves it.
pub fn forward(factor: &[f64], right: &mut [f64]) {
    let size = right.len();
    for row in 0..size {
        let line = &factor[row * size..=row * size + row];
        right[row] = (right[row] - product(line, &right[..row])) / line[row];
    }
}

/// Logarithm of the determinant of `L L'`, of `size` rows.
#[must_use]
pub fn log_determinant(factor: &[f64], size: usize) -> f64 {
    2.0 * factor.iter().step_by(size + 1).map(|diagonal| diagonal.ln()).sum::<f64>()
}

/// Gives each column of the inverse of L, from its diagonal on, to `each`: the products of two of them are the inverse of `L L'`.
pub fn inverse_columns(factor: &[f64], size: usize, mut each: impl FnMut(usize, &[f64])) {
    let mut column = vec![0.0; size];
    for at in 0..size {
        for row in at..size {
            let line = &factor[row * size..=row * size + row];
            let one = if row == at { 1.0 } else { 0.0 };
            column[row] = (one - product(&line[at..row], &column[at..row])) / line[row];
        }
        each(at, &column[at..]);
    }
}

/// Inner product over the shorter slice, summed in eight lanes.
#[must_use]
pub fn product(left: &[f64], right: &[f64]) -> f64 {
    let size = left.len().min(right.len());
    let (left, right) = (left[..size].as_chunks::<8>(), right[..size].as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in left.0.iter().zip(right.0) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = left.1.iter().zip(right.1).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved() {
        // A + I = [[4, 2, 0], [2, 5, 1], [0, 1, 3]], x = [1, -2, 3].
        let matrix = [3.0, 0.0, 0.0, 2.0, 4.0, 0.0, 0.0, 1.0, 2.0];
        let mut right = [0.0, -5.0, 7.0];
        solve_shifted(&matrix, 1.0, &mut [0.0; 9], &mut right).unwrap();
        for (x, expected) in right.iter().zip([1.0, -2.0, 3.0]) {
            assert!((x - expected).abs() < 1e-14, "{right:?}");
        }
    }

    #[test]
    fn trace_of_the_inverse_and_determinant_are_those_of_a_small_matrix() {
        // A = [[4, 2, 0], [2, 5, 1], [0, 1, 3]]: determinant 44, diagonal of its inverse 14, 12 and 16 of 44.
        let matrix = [4.0, 0.0, 0.0, 2.0, 5.0, 0.0, 0.0, 1.0, 3.0];
        let mut factor = [0.0; 9];
        solve_shifted(&matrix, 0.0, &mut factor, &mut [0.0; 3]).unwrap();
        let mut trace = 0.0;
        inverse_columns(&factor, 3, |_, column| trace += product(column, column));
        assert!((trace - 42.0 / 44.0).abs() < 1e-14, "{trace}");
        assert!((log_determinant(&factor, 3) - 44.0_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn lanes_sum_what_a_plain_loop_sums() {
        for size in [0, 1, 7, 8, 9, 40] {
            let (a, b): (Vec<f64>, Vec<f64>) =
                (0..size).map(|at| (f64::from(at) + 0.5, f64::from(size - at))).unzip();
            let plain: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((product(&a, &b) - plain).abs() <= 1e-12 * plain, "{size}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        for matrix in
            [[1.0, 0.0, 2.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, f64::INFINITY]]
        {
            assert!(solve_shifted(&matrix, 0.0, &mut [0.0; 4], &mut [1.0; 2]).is_none());
        }
    }
}
