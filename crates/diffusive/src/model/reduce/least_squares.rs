//! Small dense least squares, min ‖B x − y‖, plain or with x ≥ 0 (C. L. Lawson and R. J. Hanson,
//! *Solving Least Squares Problems*, ch. 23), by QR on columns of unit norm.
//!
//! Not by normal equations: free poles may come so close to each other that the square of their
//! columns' condition is out of f64's reach.

use nalgebra::{DMatrix, DVector};

/// The solution; `None` if the columns are dependent.
pub fn plain(columns: &DMatrix<f64>, y: &DVector<f64>) -> Option<DVector<f64>> {
    let (unit, norm) = unit_columns(columns)?;
    Some(by_qr(unit, y)?.component_div(&norm))
}

/// The solution that has no negative entry; `None` if the columns are dependent.
pub fn non_negative(columns: &DMatrix<f64>, y: &DVector<f64>) -> Option<DVector<f64>> {
    let (unit, norm) = unit_columns(columns)?;
    let n = unit.ncols();
    let mut x = DVector::zeros(n);
    let mut free = vec![false; n];
    let flat = 1e-13 * y.norm();
    // Each round frees one more entry for good, or ends; rounding could only make it go in circles.
    for _ in 0..10 * n {
        let slope = unit.tr_mul(&(y - &unit * &x));
        let steepest = (0..n).filter(|&i| !free[i] && slope[i] > flat).max_by(|&a, &b| slope[a].total_cmp(&slope[b]));
        let Some(steepest) = steepest else { break };
        free[steepest] = true;
        loop {
            let used: Vec<usize> = (0..n).filter(|&i| free[i]).collect();
            let Some(part) = by_qr(unit.select_columns(&used), y) else {
                // It adds nothing that the others do not have.
                free[steepest] = false;
                break;
            };
            let mut wanted = DVector::zeros(n);
            used.iter().zip(part.iter()).for_each(|(&i, &value)| wanted[i] = value);
            let blocked = used.iter().filter(|&&i| wanted[i] <= 0.0).map(|&i| x[i] / (x[i] - wanted[i]));
            let share = blocked.fold(f64::INFINITY, f64::min);
            if share.is_infinite() {
                x = wanted;
                break;
            }
            let share = if share.is_finite() { share } else { 0.0 };
            x += (wanted - &x) * share;
            for i in used {
                if x[i] <= flat * 1e-3 {
                    x[i] = 0.0;
                    free[i] = false;
                }
            }
        }
    }
    Some(x.component_div(&norm))
}

fn unit_columns(columns: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let norm = DVector::from_iterator(columns.ncols(), columns.column_iter().map(|column| column.norm()));
    if norm.iter().any(|norm| !(norm.is_finite() && *norm > 0.0)) {
        return None;
    }
    let mut unit = columns.clone();
    for (mut column, norm) in unit.column_iter_mut().zip(norm.iter()) {
        column /= *norm;
    }
    Some((unit, norm))
}

fn by_qr(columns: DMatrix<f64>, y: &DVector<f64>) -> Option<DVector<f64>> {
    let n = columns.ncols();
    let qr = columns.qr();
    let r = qr.r();
    if (0..n).any(|i| r[(i, i)].abs() < 1e-13) {
        return None;
    }
    let mut rotated = y.clone();
    qr.q_tr_mul(&mut rotated);
    r.solve_upper_triangular(&rotated.rows(0, n).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> DMatrix<f64> {
        DMatrix::from_row_slice(4, 2, &[1.0, 1.0, 1.0, 2.0, 1.0, 3.0, 1.0, 4.0])
    }

    #[test]
    fn a_line_through_points_is_found() {
        let x = plain(&columns(), &DVector::from_vec(vec![3.0, 5.0, 7.0, 9.0])).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-13 && (x[1] - 2.0).abs() < 1e-13);
        let x = non_negative(&columns(), &DVector::from_vec(vec![3.0, 5.0, 7.0, 9.0])).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-13 && (x[1] - 2.0).abs() < 1e-13);
    }

    #[test]
    fn a_bound_entry_is_zero_and_the_others_make_the_best_of_it() {
        // y = 2 t − 1: without the intercept the slope is Σ t y / Σ t² = 50/30
        let x = non_negative(&columns(), &DVector::from_vec(vec![1.0, 3.0, 5.0, 7.0])).unwrap();
        assert_eq!(x[0], 0.0);
        assert!((x[1] - 5.0 / 3.0).abs() < 1e-13);
        let x = non_negative(&columns(), &DVector::from_vec(vec![-1.0, -3.0, -5.0, -7.0])).unwrap();
        assert_eq!(x, DVector::zeros(2));
    }

    #[test]
    fn dependent_columns_have_no_solution() {
        let twice = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
        assert_eq!(plain(&twice, &DVector::from_vec(vec![1.0, 2.0, 3.0])), None);
    }
}
