//! Normal equations of a path and of what it shares: poses couple with their neighbours only, and all of
//! them with a few shared unknowns. Poses are eliminated first, which leaves a small dense system (the
//! Schur complement).
//!
//! A shared unknown couples with few poses: all that is done for one runs along the chain of poses once, and
//! products are taken only where it couples.
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
    /// With shared unknowns.
    coupling: Coupling,
    gradient: Vector3<f64>,
}

/// What the rows of a pose have in the columns of shared unknowns, by their places.
#[derive(Debug, Clone, Default)]
struct Coupling(Vec<(usize, Vector3<f64>)>);

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
            coupling: Coupling::default(),
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
                        pose.coupling.add(*place, by_pose * (by * information));
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
    pub fn factor(self) -> Option<Factor> {
        let chain = Chain::of(&self.poses)?;
        // `A^-1 B`, of each pose only the columns that a pose up to it couples with: the upper triangle asks
        // for no others, and neither way along the chain brings in any.
        let mut width = 0;
        let rows = self.poses.iter().map(|pose| {
            width = width.max(pose.coupling.width());
            pose.coupling.rows(width)
        });
        let mut eliminated: Vec<Rows> = rows.collect();
        chain.solve(&mut eliminated);
        let mut alone: Vec<Vector3<f64>> = self.poses.iter().map(|pose| pose.gradient).collect();
        chain.solve(&mut alone);
        // C - B^T A^-1 B by its upper triangle, the gradient beside it.
        let mut complement = self.shared;
        let mut right = self.shared_gradient;
        for ((rows, alone), pose) in eliminated.iter().zip(&alone).zip(&self.poses) {
            for (place, by) in &pose.coupling.0 {
                let mut column = complement.column_mut(*place);
                let column = column.as_mut_slice().iter_mut().take(place + 1);
                for (entry, of) in column.zip(rows.columns()) {
                    *entry -= by.dot(&of);
                }
                if let Some(entry) = right.get_mut(*place) {
                    *entry -= by.dot(alone);
                }
            }
        }
        Some(Factor {
            chain,
            poses: self.poses,
            complement: Cholesky::new(complement.transpose())?,
            right,
        })
    }
}

impl Coupling {
    /// Adds to a column.
    fn add(&mut self, place: usize, by: Vector3<f64>) {
        match self.0.binary_search_by_key(&place, |(place, _)| *place) {
            Ok(at) => {
                if let Some((_, sum)) = self.0.get_mut(at) {
                    *sum += by;
                }
            }
            Err(at) => self.0.insert(at, (place, by)),
        }
    }

    /// Columns up to the last that is not zero.
    fn width(&self) -> usize {
        self.0.last().map_or(0, |(place, _)| place + 1)
    }

    /// So many columns, the others of which are zero.
    fn rows(&self, columns: usize) -> Rows {
        let mut rows = Rows::zeros(columns);
        for (place, by) in &self.0 {
            rows.add(*place, by);
        }
        rows
    }

    /// The sum of these columns times a value each.
    fn times(&self, values: &[f64]) -> Vector3<f64> {
        let columns = self.0.iter();
        columns.fold(Vector3::zeros(), |sum, (place, by)| {
            sum + by * values.get(*place).copied().unwrap_or_default()
        })
    }
}

/// The poses' own normal equations `A`, factored from the first pose to the last.
#[derive(Debug, Clone)]
struct Chain(Vec<Link>);

/// One pose of a chain.
#[derive(Debug, Clone)]
struct Link {
    /// The inverse of its block, the poses before it being eliminated.
    inverse: Matrix3<f64>,
    /// Its block with the pose before it times the inverse of that.
    gain: Matrix3<f64>,
    log_determinant: f64,
}

impl Chain {
    fn of(poses: &[PoseRows]) -> Option<Self> {
        let mut links: Vec<Link> = Vec::with_capacity(poses.len());
        let mut with_last = Matrix3::zeros();
        for pose in poses {
            let before = links
                .last()
                .map_or_else(Matrix3::zeros, |last| last.inverse);
            let gain = with_last * before;
            let own: Matrix3<f64> = pose.diagonal - gain * with_last.transpose();
            let own = Cholesky::new(own)?;
            let diagonal = own.l_dirty().diagonal();
            links.push(Link {
                inverse: own.inverse(),
                gain,
                log_determinant: 2.0 * diagonal.iter().map(|d| libm::log(*d)).sum::<f64>(),
            });
            with_last = pose.next.transpose();
        }
        Some(Self(links))
    }

    /// `A^-1` times rows, three of them a pose.
    fn solve<R: Block>(&self, rows: &mut [R]) {
        let mut before: Option<&R> = None;
        for (rows, link) in rows.iter_mut().zip(&self.0) {
            if let Some(before) = before {
                rows.subtract(&link.gain, before);
            }
            before = Some(rows);
        }
        let mut after: Option<(&R, &Link)> = None;
        for (rows, link) in rows.iter_mut().zip(&self.0).rev() {
            rows.transform(&link.inverse);
            if let Some((after, link)) = after {
                rows.subtract(&link.gain.transpose(), after);
            }
            after = Some((rows, link));
        }
    }
}

/// The three rows of one pose.
trait Block {
    /// Subtracts `matrix` times another's.
    fn subtract(&mut self, matrix: &Matrix3<f64>, other: &Self);
    /// Multiplies by `matrix` from the left.
    fn transform(&mut self, matrix: &Matrix3<f64>);
}

impl Block for Vector3<f64> {
    fn subtract(&mut self, matrix: &Matrix3<f64>, other: &Self) {
        *self -= matrix * other;
    }

    fn transform(&mut self, matrix: &Matrix3<f64>) {
        *self = matrix * *self;
    }
}

/// Three rows, a column each for every shared unknown.
#[derive(Debug, Clone)]
struct Rows([Vec<f64>; 3]);

impl Rows {
    fn zeros(columns: usize) -> Self {
        let row = || vec![0.0; columns];
        Self([row(), row(), row()])
    }

    fn columns(&self) -> impl Iterator<Item = Vector3<f64>> {
        let [x, y, z] = &self.0;
        let columns = x.iter().zip(y).zip(z);
        columns.map(|((x, y), z)| Vector3::new(*x, *y, *z))
    }

    fn columns_mut(&mut self) -> impl Iterator<Item = [&mut f64; 3]> {
        let [x, y, z] = &mut self.0;
        let columns = x.iter_mut().zip(y).zip(z);
        columns.map(|((x, y), z)| [x, y, z])
    }

    fn add(&mut self, place: usize, by: &Vector3<f64>) {
        for (row, by) in self.0.iter_mut().zip(by.iter()) {
            if let Some(entry) = row.get_mut(place) {
                *entry += by;
            }
        }
    }

    /// Adds a column times a row.
    fn add_product(&mut self, column: &Vector3<f64>, row: &[f64]) {
        for ([x, y, z], by) in self.columns_mut().zip(row) {
            *x += column.x * by;
            *y += column.y * by;
            *z += column.z * by;
        }
    }

    /// The rows times those of another pose.
    fn dot(&self, other: &Self) -> Matrix3<f64> {
        let pairs = self.columns().zip(other.columns());
        pairs.fold(Matrix3::zeros(), |sum, (a, b)| sum + a * b.transpose())
    }
}

/// Columns that the other has and these do not are left out, and so are those that only these have.
impl Block for Rows {
    fn subtract(&mut self, matrix: &Matrix3<f64>, other: &Self) {
        for ([x, y, z], column) in self.columns_mut().zip(other.columns()) {
            let product = matrix * column;
            *x -= product.x;
            *y -= product.y;
            *z -= product.z;
        }
    }

    fn transform(&mut self, matrix: &Matrix3<f64>) {
        for [x, y, z] in self.columns_mut() {
            let product = matrix * Vector3::new(*x, *y, *z);
            (*x, *y, *z) = (product.x, product.y, product.z);
        }
    }
}

/// The factors of the normal equations.
#[derive(Debug, Clone)]
pub struct Factor {
    chain: Chain,
    poses: Vec<PoseRows>,
    complement: Cholesky<f64, Dyn>,
    right: DVector<f64>,
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
    pub fn solution(&self) -> Solution {
        let shared = self.complement.solve(&self.right);
        let poses = self.poses.iter();
        let mut poses: Vec<Vector3<f64>> = poses
            .map(|pose| pose.gradient - pose.coupling.times(shared.as_slice()))
            .collect();
        self.chain.solve(&mut poses);
        Solution { poses, shared }
    }

    /// Logarithm of the determinant of the normal equations.
    pub fn log_determinant(&self) -> f64 {
        let poses = self.chain.0.iter().map(|link| link.log_determinant);
        let shared = self.complement.l_dirty().diagonal();
        let shared = shared.iter().map(|d| libm::log(*d));
        poses.sum::<f64>() + 2.0 * shared.sum::<f64>()
    }

    /// The covariance of the shared unknowns.
    pub fn shared_covariance(&self) -> DMatrix<f64> {
        self.complement.inverse()
    }

    /// The covariances of the poses, of which the first has none.
    pub fn pose_covariances(&self, shared: &DMatrix<f64>) -> PoseCovariances {
        // How the poses follow the shared unknowns, A^-1 B, and that times the covariance of these: of the
        // poses with them, but for the sign.
        let poses = self.poses.iter();
        let mut eliminated: Vec<Rows> = poses
            .clone()
            .map(|pose| pose.coupling.rows(shared.ncols()))
            .collect();
        self.chain.solve(&mut eliminated);
        let with_shared = |pose: &PoseRows| {
            let mut rows = Rows::zeros(shared.ncols());
            for (place, by) in &pose.coupling.0 {
                rows.add_product(by, shared.column(*place).as_slice());
            }
            rows
        };
        let mut with_shared: Vec<Rows> = poses.map(with_shared).collect();
        self.chain.solve(&mut with_shared);
        let mut found = PoseCovariances::default();
        let mut after: Option<(&Link, &Rows, Matrix3<f64>)> = None;
        let poses = self.chain.0.iter().zip(&eliminated).zip(&with_shared);
        for ((link, eliminated), with_shared) in poses.rev() {
            // The block of A^-1, and the one beside it.
            let mut own = link.inverse;
            if let Some((later, later_eliminated, inverse)) = after {
                let next = -later.gain.transpose() * inverse;
                own -= next * later.gain;
                found.next.push(next + with_shared.dot(later_eliminated));
            }
            found.own.push(own + with_shared.dot(eliminated));
            after = Some((link, eliminated, own));
        }
        found.own.reverse();
        found.next.reverse();
        // The first pose stays.
        for first in [found.own.first_mut(), found.next.first_mut()] {
            first
                .into_iter()
                .for_each(|first| *first = Matrix3::zeros());
        }
        found
    }
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
        let found = factor.solution();
        let shared = factor.shared_covariance();
        for (at, pose) in found.poses.iter().enumerate() {
            assert!((pose - expected.fixed_rows::<3>(3 * at)).norm() < 1e-9);
        }
        assert!((&found.shared - expected.rows(18, 5)).norm() < 1e-9);
        let determinant = libm::log(1.0 / inverse.determinant());
        assert!((factor.log_determinant() - determinant).abs() < 1e-9);
        assert!((&shared - inverse.view((18, 18), (5, 5))).norm() < 1e-9);
        let covariances = factor.pose_covariances(&shared);
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
