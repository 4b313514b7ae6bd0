//! Optimal one-to-one pairing of things with others: features with the truth, features with those
//! of a golden file.

use std::collections::{BTreeMap, BTreeSet};

use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

/// Costs are told apart down to this.
const RESOLUTION: f64 = 1e-6;

/// A larger cost counts as this.
const LARGEST: f64 = 1e6;

/// Groups with more possible pairs than this are paired nearest first: the optimum of a thousand
/// things that all lie on each other would take minutes and mean nothing.
const MOST_CELLS: usize = 250_000;

/// Pairs rows with columns: as many pairs as can be, of these the ones whose costs add up to the
/// least. `costs` holds (row, column, cost >= 0) of every pair that is allowed, each once; the
/// result is sorted by row.
///
/// Rows and columns that no chain of allowed pairs joins do not bear on each other, so they are
/// paired apart: the effort grows with the cube of the largest such group only.
pub fn assign(rows: usize, columns: usize, costs: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    let mut groups = Groups::new(rows + columns);
    for (row, column, _) in costs {
        groups.join(*row, rows + column);
    }
    let mut by_group = BTreeMap::<usize, Vec<(usize, usize, f64)>>::new();
    for pair in costs {
        by_group.entry(groups.root(pair.0)).or_default().push(*pair);
    }
    let mut pairs: Vec<(usize, usize)> = by_group.values().flat_map(|g| assign_group(g)).collect();
    pairs.sort_unstable();
    pairs
}

/// Pairs a group in which everything bears on everything.
fn assign_group(costs: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    let distinct = |of: fn(&(usize, usize, f64)) -> usize| {
        let mut all: Vec<usize> = costs.iter().map(of).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (rows, columns) = (distinct(|c| c.0), distinct(|c| c.1));
    if rows.len().saturating_mul(columns.len()) > MOST_CELLS {
        return nearest_first(costs);
    }
    // The solver wants no more rows than columns.
    let turned = rows.len() > columns.len();
    let (short, long) = if turned {
        (&columns, &rows)
    } else {
        (&rows, &columns)
    };
    let steps = |cost: f64| (cost.clamp(0.0, LARGEST) / RESOLUTION) as i64;
    // One pair more outweighs any costs.
    let pair_weight = steps(LARGEST).saturating_mul(short.len() as i64 + 1);
    let mut weights = Matrix::new(short.len(), long.len(), 0_i64);
    for (row, column, cost) in costs {
        let (a, b) = if turned { (column, row) } else { (row, column) };
        let place = (short.binary_search(a), long.binary_search(b));
        if let (Ok(a), Ok(b)) = place
            && let Some(weight) = weights.get_mut((a, b))
        {
            *weight = pair_weight - steps(*cost);
        }
    }
    let (_, partners) = kuhn_munkres(&weights);
    let paired = |(a, b): (usize, usize)| {
        let is_allowed = weights.get((a, b)).is_some_and(|weight| *weight > 0);
        let (a, b) = (*short.get(a)?, *long.get(b)?);
        is_allowed.then_some(if turned { (b, a) } else { (a, b) })
    };
    partners
        .into_iter()
        .enumerate()
        .filter_map(paired)
        .collect()
}

fn nearest_first(costs: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    let mut costs = costs.to_vec();
    costs.sort_by(|a, b| a.2.total_cmp(&b.2));
    let (mut rows, mut columns) = (BTreeMap::new(), BTreeSet::new());
    for (row, column, _) in costs {
        if !rows.contains_key(&row) && columns.insert(column) {
            rows.insert(row, column);
        }
    }
    rows.into_iter().collect()
}

/// Groups of things that are joined.
struct Groups(Vec<usize>);

impl Groups {
    fn new(things: usize) -> Self {
        Self((0..things).collect())
    }

    fn root(&self, mut thing: usize) -> usize {
        while let Some(parent) = self.0.get(thing).filter(|parent| **parent != thing) {
            thing = *parent;
        }
        thing
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        if let Some(parent) = self.0.get_mut(a.max(b)) {
            *parent = a.min(b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Tries everything: the most pairs, then the least cost.
    fn best(costs: &[(usize, usize, f64)]) -> (usize, f64) {
        let Some(((row, column, cost), rest)) = costs.split_first() else {
            return (0, 0.0);
        };
        let without = best(rest);
        let free: Vec<_> = rest
            .iter()
            .filter(|c| c.0 != *row && c.1 != *column)
            .copied()
            .collect();
        let (pairs, sum) = best(&free);
        let with = (pairs + 1, sum + cost);
        if with.0 > without.0 || (with.0 == without.0 && with.1 < without.1) {
            with
        } else {
            without
        }
    }

    proptest! {
        #[test]
        fn no_other_pairing_is_better(
            rows in 1usize..6, columns in 1usize..6,
            allowed in prop::collection::vec((any::<bool>(), 0.0..3.0f64), 36),
        ) {
            let costs: Vec<_> = allowed
                .iter()
                .enumerate()
                .map(|(k, (is_allowed, cost))| (k / 6, k % 6, *is_allowed, *cost))
                .filter(|(row, column, is_allowed, _)| *is_allowed && *row < rows && *column < columns)
                .map(|(row, column, _, cost)| (row, column, cost))
                .take(14)
                .collect();
            let pairs = assign(rows, columns, &costs);
            let sum: f64 = pairs
                .iter()
                .map(|(row, column)| costs.iter().find(|c| (c.0, c.1) == (*row, *column)).unwrap().2)
                .sum();
            let (most, least) = best(&costs);
            prop_assert_eq!(pairs.len(), most);
            prop_assert!((sum - least).abs() < 1e-4, "{} {}", sum, least);
            let mut taken: Vec<usize> = pairs.iter().map(|p| p.1).collect();
            taken.sort_unstable();
            taken.dedup();
            prop_assert_eq!(taken.len(), pairs.len());
        }
    }

    #[test]
    fn nothing_is_paired_with_nothing() {
        assert_eq!(assign(0, 0, &[]), []);
        assert_eq!(assign(3, 2, &[]), []);
    }

    #[test]
    fn the_nearest_is_not_always_taken() {
        // Row 0 is nearest to column 0, but row 1 has no other.
        let costs = [(0, 0, 0.1), (0, 1, 0.9), (1, 0, 0.5)];
        assert_eq!(assign(2, 2, &costs), [(0, 1), (1, 0)]);
    }
}
