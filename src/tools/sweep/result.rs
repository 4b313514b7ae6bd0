//! A sweep that has run: its cells in order, and how far the best one leads.

use std::cmp::Ordering;

use super::columns::Column;
use super::grid::Grid;
use super::runner::{About, CellError, Configured};
use super::score::Score;

/// Bits of all arcs that another value gains by chance.
const BY_CHANCE: f64 = 10.0;

/// A sweep that has run.
#[derive(Debug)]
pub struct Sweep {
    /// What the log itself says.
    pub log: About,
    /// What was swept.
    pub grid: Grid,
    /// Whether cells were held against the truth.
    pub with_truth: bool,
    /// By what the cells are ranked.
    pub ranked_by: Vec<&'static Column>,
    /// The log without the sweep.
    pub configured: Configured,
    /// Every cell, the best first, those that failed last.
    pub cells: Vec<Cell>,
}

/// One configuration.
#[derive(Debug)]
pub struct Cell {
    /// Its place in the grid.
    pub index: usize,
    /// What it came to.
    pub score: Result<Score, CellError>,
}

/// The best cell beside what is configured.
#[derive(Debug)]
pub enum Lead {
    /// They differ first in this column, the best cell being better in it.
    Better(LeadDifference),
    /// No ranked column tells them apart.
    Alike,
    /// The grid leaves out what is configured, which is better than all of it.
    Worse(LeadDifference),
    /// The configuration cannot be replayed without the sweep.
    Failed(String),
}

/// Where the best cell and the configured values differ first.
#[derive(Debug)]
pub struct LeadDifference {
    /// The column.
    pub column: &'static Column,
    /// In it, of the best cell and of what is configured; `None` where there is no such number.
    pub best: Option<f64>,
    /// See `best`.
    pub configured: Option<f64>,
    /// How many columns rank before it, in which both are alike.
    pub alike: usize,
}

/// Puts the best cells first; what failed comes last, what is equal stays in the grid's order.
pub fn rank(cells: &mut [Cell], by: &[&'static Column]) {
    cells.sort_by(|a, b| {
        let order = match (&a.score, &b.score) {
            (Ok(one), Ok(other)) => {
                let mut orders = by.iter().map(|column| column.compare(one, other));
                orders.find(|order| order.is_ne())
            }
            (a, b) => Some(b.is_ok().cmp(&a.is_ok())),
        };
        order.unwrap_or(Ordering::Equal).then(a.index.cmp(&b.index))
    });
}

impl Cell {
    fn scored(&self) -> Option<&Score> {
        self.score.as_ref().ok()
    }
}

impl Sweep {
    /// The best cell.
    pub fn best(&self) -> Option<(&Cell, &Score)> {
        let cell = self.cells.first()?;
        Some((cell, cell.scored()?))
    }

    /// How many cells could not be replayed.
    pub fn failed(&self) -> usize {
        self.cells.iter().filter(|cell| cell.score.is_err()).count()
    }

    /// Whether anything echoed in any cell.
    pub fn has_arcs(&self) -> bool {
        let mut scores = self.cells.iter().filter_map(Cell::scored);
        scores.any(|score| score.arcs > 0)
    }

    /// The cells that no ranked column tells from the best one, which is the first of them.
    pub fn leaders(&self) -> impl Iterator<Item = &Cell> {
        let best = self.best().map(|(_, score)| score);
        self.cells.iter().take_while(move |cell| {
            let (Some(best), Some(score)) = (best, cell.scored()) else {
                return false;
            };
            let mut by = self.ranked_by.iter();
            by.all(|column| column.compare(best, score).is_eq())
        })
    }

    /// Whether nothing that was swept makes a difference.
    pub fn is_flat(&self) -> bool {
        self.cells.len() > 1 && self.leaders().count() == self.cells.len()
    }

    /// How far the best cell leads over what is configured.
    pub fn lead(&self) -> Option<Lead> {
        let (_, best) = self.best()?;
        let configured = match &self.configured.score {
            Ok(score) => score,
            Err(error) => return Some(Lead::Failed(error.to_string())),
        };
        let mut ranked = self.ranked_by.iter().copied().enumerate();
        let first = ranked.find(|(_, column)| column.compare(best, configured).is_ne());
        let Some((alike, column)) = first else {
            return Some(Lead::Alike);
        };
        let difference = LeadDifference {
            column,
            best: (column.of)(best),
            configured: (column.of)(configured),
            alike,
        };
        Some(if column.compare(best, configured).is_lt() {
            Lead::Better(difference)
        } else {
            Lead::Worse(difference)
        })
    }
}

impl Sweep {
    /// Where the first ranked number is best between the values of an axis, through the best cell and its
    /// neighbours: a parabola's. `None` where it is not between them.
    pub fn interpolated(&self, place: usize) -> Option<f64> {
        let (best, score) = self.best()?;
        let column = self.ranked_by.first()?;
        let at = self.grid.places(best.index);
        let axis = self.grid.axes().get(place)?;
        let value = |step: isize| {
            let beside = at.get(place)?.checked_add_signed(step)?;
            axis.values.get(beside).copied()
        };
        let beside = |step: isize| {
            let wanted = at.get(place)?.checked_add_signed(step)?;
            let cell = self.cells.iter().find(|cell| {
                let places = self.grid.places(cell.index);
                let mut same = places.iter().zip(&at).enumerate();
                same.all(|(axis, (a, b))| if axis == place { *a == wanted } else { a == b })
            })?;
            (column.of)(cell.scored()?)
        };
        let [x0, x1, x2] = [value(-1)?, value(0)?, value(1)?];
        let [y0, y1, y2] = [beside(-1)?, (column.of)(score)?, beside(1)?];
        let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
        let bend = right - left;
        // The slope is zero where it lies between those halfway to the neighbours.
        let found = (x0 + x1) / 2.0 - left * ((x2 - x0) / 2.0) / bend;
        (found.is_finite() && (found - x0) * (found - x2) < 0.0).then_some(found)
    }

    /// Whether the lead in bits is one that the noise gives as well: fewer in all than a parameter gains by
    /// chance.
    pub fn is_tie(&self) -> bool {
        let (Some((_, best)), Ok(configured)) = (self.best(), &self.configured.score) else {
            return false;
        };
        let by_bits = self
            .ranked_by
            .first()
            .is_some_and(|column| column.name == "bits");
        let gained = configured.bits.zip(best.bits);
        let gained = gained.map(|(before, after)| (before - after) * best.arcs as f64);
        by_bits && gained.is_some_and(|gained| (0.0..=BY_CHANCE).contains(&gained))
    }
}

impl LeadDifference {
    /// Whether a table shows both numbers alike.
    pub fn is_small(&self) -> bool {
        let shown = |number| self.column.number(number);
        shown(self.best) == shown(self.configured)
    }
}
