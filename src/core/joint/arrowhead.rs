//! Normal equations of a path and of what it shares: poses couple with their neighbours only, and all of
//! them with a few shared unknowns. Poses are eliminated first, which leaves a small dense system (the
//! Schur complement).
//!
//! All loops are our own, in one order: libraries that choose their instructions when they run give other
//! bytes on other machines.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector3};

/// `J^T R^-1 J` and `J^T R^-1 r` over poses (three unknowns each) and shared unknowns.
#[derive(Debug, Clone)]
pub struct Arrowhead {
    poses: Vec<PoseRows>,
    shared: DMatrix<f64>,
    shared_gradient: DVector<f64>,
}

/// The rows of one pose.
#[derive(Debug, Clone)]
struct PoseRows {
    diagonal: Matrix3<f64>,
    /// With the pose after it.
    next: Matrix3<f64>,
    /// With shared unknowns, by their places.
    shared: Vec<(usize, Vector3<f64>)>,
    gradient: Vector3<f64>,
}

/// What one residual says: its derivatives by the poses and shared unknowns that it depends on.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// The earlier of the two neighbouring poses.
    pub earlier: usize,
    /// By the two poses.
    pub by_poses: [Vector3<f64>; 2],
    /// By shared unknowns.
    pub by_shared: &'a [(usize, f64)],
    /// Measured minus predicted.
    pub residual: f64,
    /// One over the variance.
    pub information: f64,
}

impl Arrowhead {
    /// Nothing known yet of so many poses and shared unknowns, but for the first pose, which stays.
    pub fn new(poses: usize, shared: usize) -> Self {
        let rows = PoseRows {
            diagonal: Matrix3::zeros(),
            next: Matrix3::zeros(),
            shared: Vec::new(),
            gradient: Vector3::zeros(),
        };
        let mut poses = vec![rows; poses];
        if let Some(first) = poses.first_mut() {
            first.diagonal = Matrix3::identity();
        }
        Self {
            poses,
            shared: DMatrix::zeros(shared, shared),
            shared_gradient: DVector::zeros(shared),
        }
    }

    /// Adds a residual.
    pub fn add(&mut self, row: &Row) {
        let Row {
            earlier,
            mut by_poses,
            by_shared,
            residual,
            information,
        } = *row;
        if earlier == 0 {
            by_poses[0] = Vector3::zeros();
        }
        for (at, by_pose) in by_poses.iter().enumerate() {
            if let Some(pose) = self.poses.get_mut(earlier + at) {
                pose.diagonal += by_pose * by_pose.transpose() * information;
                pose.gradient += by_pose * (residual * information);
                if *by_pose != Vector3::zeros() {
                    for (place, by) in by_shared {
                        pose.shared.push((*place, by_pose * (by * information)));
                    }
                }
            }
        }
        if let Some(pose) = self.poses.get_mut(earlier) {
            pose.next += by_poses[0] * by_poses[1].transpose() * information;
        }
        self.add_shared(by_shared, residual, information);
    }

    /// Adds a residual that depends on shared unknowns only.
    pub fn add_shared(&mut self, by_shared: &[(usize, f64)], residual: f64, information: f64) {
        for (row, by_row) in by_shared {
            if let Some(gradient) = self.shared_gradient.get_mut(*row) {
                *gradient += by_row * residual * information;
            }
            for (column, by_column) in by_shared {
                if let Some(entry) = self.shared.get_mut((*row, *column)) {
                    *entry += by_row * by_column * information;
                }
            }
        }
    }

    /// Eliminates the poses; `None` where they, or what is left, are not determined.
    pub fn factor(&self) -> Option<Factor> {
        let mut complement = self.shared.clone();
        let mut right = self.shared_gradient.clone();
        let mut poses: Vec<PoseFactor> = Vec::with_capacity(self.poses.len());
        let mut next = Matrix3::zeros();
        for rows in &self.poses {
            let coupling = match poses.last() {
                // L_(k, k-1) = A_(k, k-1) L_(k-1)^-T
                Some(before) => before.lower.solve_lower_triangular(&next)?.transpose(),
                None => Matrix3::zeros(),
            };
            next = rows.next;
            let lower = Cholesky::new(rows.diagonal - coupling * coupling.transpose())?.l();
            let mut reduced = match poses.last() {
                Some(before) => before.reduced.times(&-coupling),
                None => Rows::default(),
            };
            for (place, by) in &rows.shared {
                reduced.add(*place, by);
            }
            let gradient = match poses.last() {
                Some(before) => rows.gradient - coupling * before.gradient,
                None => rows.gradient,
            };
            let factor = PoseFactor {
                lower,
                coupling,
                reduced: reduced.solved(&lower),
                gradient: lower.solve_lower_triangular(&gradient)?,
            };
            factor.reduced.take_from(&mut complement);
            for (right, column) in right.iter_mut().zip(factor.reduced.columns()) {
                *right -= column.dot(&factor.gradient);
            }
            poses.push(factor);
        }
        let complement = Cholesky::new(complement)?;
        Some(Factor {
            poses,
            complement,
            right,
        })
    }
}

/// Three rows over the shared unknowns that were seen so far.
#[derive(Debug, Clone, Default)]
struct Rows([Vec<f64>; 3]);

impl Rows {
    fn add(&mut self, place: usize, by: &Vector3<f64>) {
        for (row, by) in self.0.iter_mut().zip(by.iter()) {
            if row.len() <= place {
                row.resize(place + 1, 0.0);
            }
            if let Some(entry) = row.get_mut(place) {
                *entry += by;
            }
        }
    }

    fn columns(&self) -> impl Iterator<Item = Vector3<f64>> {
        let [x, y, z] = &self.0;
        x.iter()
            .zip(y)
            .zip(z)
            .map(|((x, y), z)| Vector3::new(*x, *y, *z))
    }

    fn of(columns: impl Iterator<Item = Vector3<f64>>) -> Self {
        let mut rows = Self::default();
        let [x, y, z] = &mut rows.0;
        for column in columns {
            x.push(column.x);
            y.push(column.y);
            z.push(column.z);
        }
        rows
    }

    /// `matrix` times the rows.
    fn times(&self, matrix: &Matrix3<f64>) -> Self {
        Self::of(self.columns().map(|column| matrix * column))
    }

    /// `lower^-1` times the rows.
    fn solved(&self, lower: &Matrix3<f64>) -> Self {
        Self::of(self.columns().map(|column| {
            let x = column.x / lower.m11;
            let y = (column.y - lower.m21 * x) / lower.m22;
            let z = (column.z - lower.m31 * x - lower.m32 * y) / lower.m33;
            Vector3::new(x, y, z)
        }))
    }

    /// `lower^-T` times the rows.
    fn solved_transposed(&self, lower: &Matrix3<f64>) -> Self {
        Self::of(self.columns().map(|column| {
            let z = column.z / lower.m33;
            let y = (column.y - lower.m32 * z) / lower.m22;
            let x = (column.x - lower.m21 * y - lower.m31 * z) / lower.m11;
            Vector3::new(x, y, z)
        }))
    }

    /// Subtracts the product of the rows with themselves from the lower triangle of a matrix.
    fn take_from(&self, matrix: &mut DMatrix<f64>) {
        let [x, y, z] = &self.0;
        for (at, column) in self.columns().enumerate() {
            let mut entries = matrix.column_mut(at);
            let entries = entries.as_mut_slice().iter_mut().skip(at);
            let rows = x
                .iter()
                .skip(at)
                .zip(y.iter().skip(at))
                .zip(z.iter().skip(at));
            for (entry, ((x, y), z)) in entries.zip(rows) {
                *entry -= column.x * x + column.y * y + column.z * z;
            }
        }
    }

    /// The rows times a symmetric matrix.
    fn times_symmetric(&self, matrix: &DMatrix<f64>) -> Self {
        let [x, y, z] = &self.0;
        Self::of(matrix.column_iter().map(|column| {
            let rows = x.iter().zip(y).zip(z).zip(column.iter());
            rows.fold(Vector3::zeros(), |sum, (((x, y), z), by)| {
                sum + Vector3::new(*x, *y, *z) * *by
            })
        }))
    }

    /// The rows times those of another pose.
    fn dot(&self, other: &Self) -> Matrix3<f64> {
        let pairs = self.columns().zip(other.columns());
        pairs.fold(Matrix3::zeros(), |sum, (a, b)| sum + a * b.transpose())
    }
}

/// The factors of the normal equations.
#[derive(Debug, Clone)]
pub struct Factor {
    poses: Vec<PoseFactor>,
    complement: Cholesky<f64, Dyn>,
    right: DVector<f64>,
}

/// The rows of one pose in `L`, and what is left of its other rows.
#[derive(Debug, Clone)]
struct PoseFactor {
    lower: Matrix3<f64>,
    /// With the pose before it.
    coupling: Matrix3<f64>,
    /// `L^-1 B`, of the shared unknowns that this pose or one before it has to do with.
    reduced: Rows,
    /// `L^-1 g`.
    gradient: Vector3<f64>,
}

/// The step of the poses and of the shared unknowns.
#[derive(Debug, Clone)]
pub struct Solution {
    pub poses: Vec<Vector3<f64>>,
    pub shared: DVector<f64>,
}

/// Covariances of poses.
#[derive(Debug, Clone, Default)]
pub struct PoseCovariances {
    /// Of each.
    pub own: Vec<Matrix3<f64>>,
    /// Of each with the one after it.
    pub next: Vec<Matrix3<f64>>,
}

impl Factor {
    /// The unknowns that the residuals ask for.
    pub fn solution(&self) -> Option<Solution> {
        let shared = self.complement.solve(&self.right);
        let mut poses = Vec::with_capacity(self.poses.len());
        let mut after = Vector3::zeros();
        for factor in self.poses.iter().rev() {
            let mut right = factor.gradient - after;
            for (column, value) in factor.reduced.columns().zip(shared.iter()) {
                right -= column * *value;
            }
            let step = factor.lower.tr_solve_lower_triangular(&right)?;
            after = factor.coupling.transpose() * step;
            poses.push(step);
        }
        poses.reverse();
        Some(Solution { poses, shared })
    }

    /// Logarithm of the determinant of the normal equations.
    pub fn log_determinant(&self) -> f64 {
        let poses = self.poses.iter().map(|factor| factor.lower.diagonal());
        let poses = poses.map(|d| libm::log(d.x) + libm::log(d.y) + libm::log(d.z));
        let shared = self.complement.l_dirty().diagonal();
        let shared = shared.iter().map(|d| libm::log(*d));
        2.0 * (poses.sum::<f64>() + shared.sum::<f64>())
    }

    /// The covariance of the shared unknowns.
    pub fn shared_covariance(&self) -> DMatrix<f64> {
        self.complement.inverse()
    }

    /// The covariances of the poses, of which the first has none.
    pub fn pose_covariances(&self, shared: &DMatrix<f64>) -> Option<PoseCovariances> {
        let mut found = PoseCovariances::default();
        let mut after: Option<Carried> = None;
        for factor in self.poses.iter().rev() {
            let inverse = Cholesky::pack_dirty(factor.lower).inverse();
            let (mut own, mut next) = (inverse, Matrix3::zeros());
            let mut right = factor.reduced.clone();
            for row in &mut right.0 {
                row.resize(shared.nrows(), 0.0);
            }
            if let Some(later) = &after {
                // L_(k+1, k) L_k^-1
                let gain = factor
                    .lower
                    .tr_solve_lower_triangular(&later.coupling.transpose())?;
                next = -(gain * later.inverse);
                own -= next * gain.transpose();
                let carried = later.by_shared.times(&later.coupling.transpose());
                for (row, carried) in right.0.iter_mut().zip(&carried.0) {
                    for (entry, carried) in row.iter_mut().zip(carried) {
                        *entry -= carried;
                    }
                }
            }
            let by_shared = right.solved_transposed(&factor.lower);
            let spread = by_shared.times_symmetric(shared);
            found.own.push(own + spread.dot(&by_shared));
            if let Some(later) = &after {
                found.next.push(next + spread.dot(&later.by_shared));
            }
            after = Some(Carried {
                coupling: factor.coupling,
                inverse: own,
                by_shared,
            });
        }
        found.own.reverse();
        found.next.reverse();
        // The first pose stays.
        for first in [found.own.first_mut(), found.next.first_mut()] {
            first
                .into_iter()
                .for_each(|first| *first = Matrix3::zeros());
        }
        Some(found)
    }
}

/// What the covariance of a pose takes from the pose after it.
struct Carried {
    coupling: Matrix3<f64>,
    /// Its block in the inverse of the poses' own normal equations.
    inverse: Matrix3<f64>,
    /// Its rows of `A^-1 B`.
    by_shared: Rows,
}

#[cfg(test)]
mod tests {
    use super::*;

    type Residual = (usize, [Vector3<f64>; 2], Vec<(usize, f64)>, f64);

    /// Residuals along a chain of poses, some of them with shared unknowns.
    fn rows() -> Vec<Residual> {
        let mut rows = Vec::new();
        for k in 0..5_usize {
            for axis in 0..3 {
                let by = Vector3::ith(axis, 1.0 + 0.1 * k as f64);
                let skew = Vector3::new(0.1, -0.2, 0.3 * axis as f64);
                rows.push((
                    k,
                    [-by + skew, by],
                    vec![(0, 0.1 * axis as f64)],
                    0.3 - 0.1 * k as f64,
                ));
            }
            let at = Vector3::new(0.3, 0.5 - 0.1 * k as f64, 0.2);
            let mark = 1 + 2 * (k % 2);
            rows.push((
                k,
                [at * 0.4, at * 0.6],
                vec![(mark, 0.7), (mark + 1, 0.1 * k as f64)],
                0.2,
            ));
            rows.push((k, [at, at * 0.1], vec![(mark, 0.1), (mark + 1, -0.8)], -0.1));
        }
        rows
    }

    fn arrowhead() -> (Arrowhead, DMatrix<f64>, DVector<f64>) {
        let (poses, shared) = (6, 5);
        let mut sparse = Arrowhead::new(poses, shared);
        let size = 3 * poses + shared;
        let mut dense = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for at in 0..3 {
            dense[(at, at)] = 1.0;
        }
        for (earlier, by_poses, by_shared, residual) in rows() {
            sparse.add(&Row {
                earlier,
                by_poses,
                by_shared: &by_shared,
                residual,
                information: 2.0,
            });
            let mut row = DVector::zeros(size);
            for (at, by) in by_poses.iter().enumerate() {
                if earlier + at > 0 {
                    row.fixed_rows_mut::<3>(3 * (earlier + at)).copy_from(by);
                }
            }
            for (place, by) in &by_shared {
                row[3 * poses + place] = *by;
            }
            dense += 2.0 * &row * row.transpose();
            right += row * (2.0 * residual);
        }
        for place in 0..shared {
            sparse.add_shared(&[(place, 1.0)], 0.0, 0.5);
            dense[(3 * poses + place, 3 * poses + place)] += 0.5;
        }
        (sparse, dense, right)
    }

    #[test]
    fn the_solution_and_the_covariances_are_those_of_the_whole_system() {
        let (sparse, dense, right) = arrowhead();
        let inverse = dense.try_inverse().unwrap();
        let expected = &inverse * right;
        let factor = sparse.factor().unwrap();
        let found = factor.solution().unwrap();
        let shared = factor.shared_covariance();
        for (at, pose) in found.poses.iter().enumerate() {
            assert!((pose - expected.fixed_rows::<3>(3 * at)).norm() < 1e-9);
        }
        assert!((&found.shared - expected.rows(18, 5)).norm() < 1e-9);
        let determinant = libm::log(1.0 / inverse.determinant());
        assert!((factor.log_determinant() - determinant).abs() < 1e-9);
        assert!((&shared - inverse.view((18, 18), (5, 5))).norm() < 1e-9);
        let covariances = factor.pose_covariances(&shared).unwrap();
        for at in 1..6 {
            let own = inverse.fixed_view::<3, 3>(3 * at, 3 * at);
            assert!((covariances.own[at] - own).norm() < 1e-9, "{at}");
        }
        for at in 1..5 {
            let next = inverse.fixed_view::<3, 3>(3 * at, 3 * at + 3);
            assert!((covariances.next[at] - next).norm() < 1e-9, "{at}");
        }
        assert_eq!(covariances.own[0], Matrix3::zeros());
    }

    #[test]
    fn what_nothing_determines_has_no_solution() {
        let mut sparse = Arrowhead::new(2, 1);
        sparse.add_shared(&[(0, 1.0)], 1.0, 1.0);
        assert!(sparse.factor().is_none());
    }
}
