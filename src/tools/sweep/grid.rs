//! The cells of a sweep: every combination of values.

use super::axes::{Axis, AxisError, MOST_CELLS};
use crate::core::config::Config;
use crate::io::config::file::{ConfigError, check, overridden};

/// Every combination of the values of some axes; the last one runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    axes: Vec<Axis>,
}

impl Grid {
    /// The grid over some axes.
    ///
    /// # Errors
    /// No axis, one key on two of them, or too many cells.
    pub fn new(axes: Vec<Axis>) -> Result<Self, AxisError> {
        if axes.is_empty() {
            return Err(AxisError::Nothing);
        }
        let mut keys: Vec<String> = axes.iter().map(Axis::key).collect();
        keys.sort();
        if let Some([key, _]) = keys.array_windows().find(|[a, b]| a == b) {
            return Err(AxisError::SweptTwice { key: key.clone() });
        }
        let cells: f64 = axes.iter().map(|axis| axis.values.len() as f64).product();
        if cells > MOST_CELLS as f64 {
            return Err(AxisError::TooManyCells { cells });
        }
        Ok(Self { axes })
    }

    /// What is swept.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The place of a cell on every axis.
    pub fn places(&self, cell: usize) -> Vec<usize> {
        let mut rest = cell;
        let mut places: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let count = axis.values.len().max(1);
                let place = rest % count;
                rest /= count;
                place
            })
            .collect();
        places.reverse();
        places
    }

    /// The value of a cell on every axis.
    pub fn values(&self, cell: usize) -> Vec<f64> {
        let places = self.places(cell).into_iter();
        self.axes
            .iter()
            .zip(places)
            .filter_map(|(axis, place)| axis.values.get(place).copied())
            .collect()
    }

    /// A configuration with the values of a cell.
    ///
    /// # Errors
    /// Values that do not go together.
    pub fn configuration(&self, base: &Config, cell: usize) -> Result<Config, ConfigError> {
        let values = self.values(cell).into_iter();
        let mut config = base.clone();
        // Each by itself: TOML does not take two dotted keys of a table that is closed.
        for (axis, value) in self.axes.iter().zip(values) {
            config = overridden(&config, &axis.line(value))?;
        }
        check(&config)?;
        Ok(config)
    }

    /// The flags of `tmam replay` that give a cell.
    pub fn flags(&self, cell: usize) -> String {
        let values = self.values(cell).into_iter();
        let flags = self.axes.iter().zip(values).map(|(axis, value)| {
            let line = axis.line(value).replacen(" = ", "=", 1);
            if line.contains(['"', ' ', '\'']) {
                format!("--set '{line}'")
            } else {
                format!("--set {line}")
            }
        });
        flags.collect::<Vec<String>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(axes: &[(&str, &str)]) -> Result<Grid, AxisError> {
        Grid::new(
            axes.iter()
                .map(|(key, spec)| Axis::parse(key, spec).unwrap())
                .collect(),
        )
    }

    #[test]
    fn the_last_axis_runs_fastest() {
        let grid = grid(&[("triple.alpha", "0.3,0.5"), ("triple.gamma", "5:15:5")]).unwrap();
        assert_eq!(grid.cells(), 6);
        assert_eq!(grid.values(0), [0.3, 5.0]);
        assert_eq!(grid.values(1), [0.3, 10.0]);
        assert_eq!(grid.values(5), [0.5, 15.0]);
        assert_eq!(
            grid.flags(4),
            "--set triple.alpha=0.5 --set triple.gamma=10"
        );
        let config = grid.configuration(&Config::default(), 5).unwrap();
        assert_eq!(config.triple.gamma, 15_f64.to_radians());
        assert_eq!((config.triple.alpha, config.triple.beta), (0.5, 2.0));
    }

    #[test]
    fn one_part_of_a_mount_and_a_count_can_be_swept() {
        let grid = grid(&[("sonar.'/us front'.yaw", "90"), ("map.confirm_runs", "3")]).unwrap();
        let config = grid.configuration(&Config::default(), 0).unwrap();
        let sonar = &config.sonar["/us front"];
        assert_eq!((sonar.x, sonar.yaw), (None, Some(90_f64.to_radians())));
        assert_eq!(config.map.confirm_runs, 3);
        assert!(
            grid.flags(0)
                .starts_with("--set 'sonar.\"/us front\".yaw=90'")
        );
    }

    #[test]
    fn what_is_too_much_or_too_little_is_refused() {
        let said = |axes: &[(&str, &str)]| grid(axes).unwrap_err().to_string();
        assert!(said(&[]).contains("nothing to sweep"));
        assert!(said(&[("triple.beta", "2"), ("triple.beta", "3")]).contains("given twice"));
        let many = [("triple.beta", "2:999:1"), ("map.gate", "1:999:1")];
        assert!(said(&many).contains("997002 cells, more than 100000"));
    }

    #[test]
    fn values_that_do_not_go_together_fail_by_themselves() {
        let grid = grid(&[("input.start", "1,5"), ("input.end", "3")]).unwrap();
        assert!(grid.configuration(&Config::default(), 0).is_ok());
        assert!(grid.configuration(&Config::default(), 1).is_err());
    }
}
