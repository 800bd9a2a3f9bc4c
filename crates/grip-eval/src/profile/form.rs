//! The form of a height profile: the least-squares polynomial through all heights.

/// The least-squares polynomial of `degree` through `heights` at equal steps, as long as `heights` and in their unit. Degree 0
/// is their mean, 1 a line, 2 an arc; a degree that the heights do not determine is lowered to one that they do.
///
/// Summed over polynomials that are orthogonal on the places t of the heights (from -1 to 1), by the recurrence
/// p(k+1) = t p(k) - b p(k-1) with b = |p(k)|^2 / |p(k-1)|^2 (G. E. Forsythe, *J. SIAM* 5, 1957), so that no system of
/// equations is solved and high degrees lose no digits.
#[must_use]
pub fn least_squares(heights: &[f64], degree: u8) -> Vec<f64> {
    let n = heights.len();
    let scale = 2.0 / (n.max(2) - 1) as f64;
    let mut form = vec![0.0; n];
    let (mut before, mut current) = (vec![0.0; n], vec![1.0; n]);
    let mut norm_before = 1.0;
    for _ in 0..(usize::from(degree) + 1).min(n) {
        let norm: f64 = current.iter().map(|p| p * p).sum();
        let share = current.iter().zip(heights).map(|(p, z)| p * z).sum::<f64>() / norm;
        form.iter_mut().zip(&current).for_each(|(f, p)| *f += share * p);
        let ratio = norm / norm_before;
        // The polynomial before becomes the next one in place.
        for (i, (p, q)) in before.iter_mut().zip(&current).enumerate() {
            *p = (i as f64 * scale - 1.0) * q - ratio * *p;
        }
        core::mem::swap(&mut before, &mut current);
        norm_before = norm;
    }
    form
}

#[cfg(test)]
mod tests {
    use super::least_squares;

    fn wavy(n: u32) -> Vec<f64> {
        let height = |i: u32| {
            f64::from(i * 7919 % 1013) / 1013.0 + (f64::from(i) / 40.0).sin() + 0.01 * f64::from(i)
        };
        (0..n).map(height).collect()
    }

    /// Normal equations in the powers of t, solved by elimination.
    fn plainly(heights: &[f64], degree: usize) -> Vec<f64> {
        let t = |i: usize| i as f64 * 2.0 / (heights.len() - 1) as f64 - 1.0;
        let power = |i: usize, k: usize| t(i).powi(i32::try_from(k).unwrap());
        let sum = |f: &dyn Fn(usize) -> f64| (0..heights.len()).map(f).sum::<f64>();
        let m = degree + 1;
        let mut rows: Vec<Vec<f64>> = (0..m)
            .map(|j| {
                let left = (0..m).map(|k| sum(&|i| power(i, j + k)));
                left.chain([sum(&|i| power(i, j) * heights[i])]).collect()
            })
            .collect();
        for k in 0..m {
            for j in (0..m).filter(|j| *j != k) {
                let factor = rows[j][k] / rows[k][k];
                let pivot = rows[k].clone();
                for (value, above) in rows[j].iter_mut().zip(pivot) {
                    *value -= factor * above;
                }
            }
        }
        let coefficient = |k: usize| rows[k][m] / rows[k][k];
        (0..heights.len()).map(|i| (0..m).map(|k| coefficient(k) * power(i, k)).sum()).collect()
    }

    #[test]
    fn it_is_the_solution_of_the_normal_equations() {
        let heights = wavy(700);
        for degree in 0..=6 {
            let fast = least_squares(&heights, degree);
            for (got, want) in fast.iter().zip(plainly(&heights, degree.into())) {
                assert!((got - want).abs() < 1e-10, "{degree}: {got} {want}");
            }
        }
    }

    #[test]
    fn a_polynomial_is_its_own_form() {
        let arc: Vec<f64> = (0..500)
            .map(|i| f64::from(i) / 500.0)
            .map(|x| 3.0 - 2.0 * x + 7.0 * x * x - 4.0 * x.powi(3))
            .collect();
        for (degree, within) in [(3, 1e-13), (9, 1e-12)] {
            let form = least_squares(&arc, degree);
            assert!(form.iter().zip(&arc).all(|(f, z)| (f - z).abs() < within), "{degree}");
        }
        assert!(least_squares(&arc, 1).iter().zip(&arc).any(|(f, z)| (f - z).abs() > 0.1));
    }

    #[test]
    fn few_heights_lower_the_degree() {
        assert!(least_squares(&[], 3).is_empty());
        assert_eq!(least_squares(&[4.0], 3), [4.0]);
        let two = least_squares(&[4.0, 6.0], 8);
        assert!((two[0] - 4.0).abs() < 1e-12 && (two[1] - 6.0).abs() < 1e-12, "{two:?}");
    }
}
