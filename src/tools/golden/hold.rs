//! Golden files from a Rust test: another crate's features, held in `cargo test`.

use std::path::{Path, PathBuf};

use super::compare::{compare, settled};
use super::file::{Golden, GoldenError};
use super::results::Results;
use super::text::describe;
use super::tolerance::{Tolerance, ToleranceError};
use crate::core::legible::inert_line;
use crate::core::wording::counted;
use crate::io::output::{OutputError, make_room, write_whole};

/// The environment variable that, set to 1, makes [`hold`] write the golden file.
pub const UPDATE: &str = "UPDATE_GOLDEN";

/// What [`hold`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// The results are what the golden file says.
    Matches,
    /// The golden file was written.
    Written,
}

/// Why results do not pass.
#[derive(Debug, thiserror::Error)]
pub enum HoldError {
    /// They are not what the golden file says.
    #[error(
        "{} from {}:\n  {}\nIf this is as it should be, run again with {UPDATE}=1 and review what changed.",
        counted(differences.len() as u64, "difference"), path.display(), differences.join("\n  ")
    )]
    Differs {
        /// The golden file.
        path: PathBuf,
        /// Each in a line.
        differences: Vec<String>,
    },
    /// There is no golden file.
    #[error("there is no golden file {}; run with {UPDATE}=1 to write it", path.display())]
    Missing {
        /// Where it should be.
        path: PathBuf,
    },
    /// There is nothing to hold.
    #[error("no feature was found, and an empty result is never blessed; {} is left as it is", path.display())]
    Empty {
        /// The golden file.
        path: PathBuf,
    },
    /// A golden file must not be written where nobody looks.
    #[error("{UPDATE} is set, and so is CI: golden files are blessed by people. Unset {UPDATE}")]
    InCi,
    /// A log's golden file holds far more, and would be lost.
    #[error(
        "{} is the golden file of a log, {log}, and no place for the results of a test: name another file. \
         A log's is written with `tmam check LOG --golden DIR --bless`", path.display()
    )]
    OfALog {
        /// The golden file.
        path: PathBuf,
        /// The log.
        log: String,
    },
    /// The golden file is no golden file.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// The tolerance makes no sense.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// The golden file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Holds results to a golden file, within `tolerance`; those in the file say what it was written with. What is
/// within them stays as it is when the file is written again.
///
/// # Errors
/// Differences, in words; and whatever keeps them from being found.
pub fn hold(
    path: impl AsRef<Path>,
    actual: &Results,
    tolerance: &Tolerance,
) -> Result<Held, HoldError> {
    let set = |name: &str| std::env::var(name).is_ok_and(|value| is_set(&value));
    let file = path.as_ref().to_owned();
    let path = file.as_path();
    if set(UPDATE) {
        if set("CI") {
            return Err(HoldError::InCi);
        }
        return write(path, actual, tolerance);
    }
    if !path.exists() {
        return Err(HoldError::Missing { path: file });
    }
    tolerance.check()?;
    let golden = of_a_test(path)?;
    if golden.results.is_empty() && actual.is_empty() {
        return Err(HoldError::Empty { path: file });
    }
    let found = compare(&golden.results, actual, tolerance);
    if found.matches(false) {
        return Ok(Held::Matches);
    }
    let differences = found.differences.iter().map(describe).collect();
    let path = file;
    Err(HoldError::Differs { path, differences })
}

/// A golden file that was made from no log.
fn of_a_test(path: &Path) -> Result<Golden, HoldError> {
    let (golden, _) = Golden::read(path)?;
    match golden.log() {
        None => Ok(golden),
        Some(log) => Err(HoldError::OfALog {
            path: path.to_owned(),
            log: inert_line(&log.file),
        }),
    }
}

/// Whether an environment variable's value means yes.
pub fn is_set(value: &str) -> bool {
    let value = value.trim().to_ascii_lowercase();
    !matches!(value.as_str(), "" | "0" | "false" | "no" | "off")
}

fn write(path: &Path, actual: &Results, tolerance: &Tolerance) -> Result<Held, HoldError> {
    if actual.is_empty() {
        return Err(HoldError::Empty {
            path: path.to_owned(),
        });
    }
    tolerance.check()?;
    let actual = match path.exists() {
        true => settled(&of_a_test(path)?.results, actual.clone(), tolerance),
        false => actual.clone(),
    };
    let bytes = Golden::new(None, *tolerance, actual).render()?;
    make_room(path)?;
    write_whole(path, &bytes)?;
    Ok(Held::Written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::golden::Feature;

    #[test]
    fn only_what_says_yes_is_set() {
        for no in ["", " ", "0", "false", "False", "FALSE", "no", "off"] {
            assert!(!is_set(no), "{no}");
        }
        for yes in ["1", "true", "True", "yes", "github"] {
            assert!(is_set(yes), "{yes}");
        }
    }

    #[test]
    fn the_golden_file_of_a_log_is_neither_held_to_nor_written_over() {
        let sample = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/golden/room_step.golden.json"
        );
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("room_step.golden.json");
        std::fs::copy(sample, &path).unwrap();
        let found = Results::of_map([Feature::point(1.0, 2.0)]);
        for refused in [
            hold(&path, &found, &Tolerance::default()),
            write(&path, &found, &Tolerance::default()),
        ] {
            assert!(
                matches!(refused, Err(HoldError::OfALog { .. })),
                "{refused:?}"
            );
        }
        assert_eq!(
            std::fs::read(&path).unwrap(),
            std::fs::read(sample).unwrap()
        );
    }

    #[test]
    fn the_folder_of_a_new_golden_file_is_made() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("tests/golden/a.golden.json");
        let found = Results::of_map([Feature::point(1.0, 2.0)]);
        let written = write(&path, &found, &Tolerance::default()).unwrap();
        assert_eq!(written, Held::Written);
        assert!(path.is_file());
    }

    #[test]
    fn the_tolerance_of_the_call_is_that_of_the_comparison_and_of_the_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.golden.json");
        let with = |rho| Tolerance {
            position: rho,
            ..Tolerance::default()
        };
        let at = |y| Results::of_map([Feature::point(1.0, y)]);
        write(&path, &at(2.0), &with(0.02)).unwrap();
        let held = |y, tolerance: f64| hold(&path, &at(y), &with(tolerance));
        assert!(matches!(held(2.05, 0.1), Ok(Held::Matches)));
        assert!(matches!(held(2.05, 0.02), Err(HoldError::Differs { .. })));
        // What is within tolerance stays as it is.
        write(&path, &at(2.05), &with(0.1)).unwrap();
        let (golden, _) = Golden::read(&path).unwrap();
        assert_eq!((golden.results, golden.tolerances), (at(2.0), with(0.1)));

        std::fs::write(&path, "{").unwrap();
        assert!(write(&path, &at(3.0), &with(0.03)).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"{");
    }
}
