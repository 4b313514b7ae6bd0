//! Which drives are meant by what is named: logs, folders of logs, and patterns that no shell has taken apart.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use globset::{GlobBuilder, GlobMatcher};

use crate::core::pattern::PatternError;
use crate::io::log::container::{self, place_of_ending};

/// A drive among others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drive {
    /// Its log, or the folder of the log's parts.
    pub path: PathBuf,
    /// What its outputs are called; no other drive of the run has the name.
    pub name: String,
}

/// Why it cannot be told which drives are meant.
#[derive(Debug, thiserror::Error)]
pub enum DrivesError {
    /// A pattern that is none.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A pattern that fits no file.
    #[error(
        "`{pattern}` fits no file; `*` stays in its folder, `**` goes through all folders below"
    )]
    NoneFits {
        /// As typed.
        pattern: String,
    },
}

/// The logs that are meant, in the order in which they are named: of a folder its drives, of a pattern what
/// fits it. What is not there stays as it is, for whoever reads it to say so.
///
/// # Errors
/// A pattern that is none, or that fits nothing.
pub fn logs(named: &[PathBuf]) -> Result<Vec<PathBuf>, DrivesError> {
    let mut logs = Vec::new();
    for path in named {
        if path.exists() || !is_pattern(path) {
            logs.extend(container::drives(path));
        } else {
            let fitting = fitting(path)?;
            logs.extend(fitting.iter().flat_map(|path| container::drives(path)));
        }
    }
    Ok(logs)
}

/// The drives of these logs, each once and with a name of its own: that of its file without the ending, with
/// the folders before it where several are called so.
pub fn drives(logs: Vec<PathBuf>) -> Vec<Drive> {
    let mut known = BTreeSet::new();
    let mut drives: Vec<(PathBuf, Vec<String>, usize)> = Vec::new();
    for path in logs {
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        if known.insert(place) {
            let words = words(&std::path::absolute(&path).unwrap_or_else(|_| path.clone()));
            drives.push((path, words, 1));
        }
    }
    let name = |words: &[String], used: usize| {
        let used = words.len().saturating_sub(used);
        words.get(used..).unwrap_or_default().join("_")
    };
    loop {
        let mut called = BTreeMap::<String, u32>::new();
        for (_, words, used) in &drives {
            *called.entry(name(words, *used)).or_default() += 1;
        }
        let mut longer = false;
        for (_, words, used) in &mut drives {
            let is_shared = called.get(&name(words, *used)) > Some(&1);
            if is_shared && *used < words.len() {
                (*used, longer) = (*used + 1, true);
            }
        }
        if !longer {
            break;
        }
    }
    // What lies packed beside itself unpacked has no folder to tell it by.
    let mut taken = BTreeSet::new();
    let named = drives.into_iter().map(|(path, words, used)| {
        let short = name(&words, used);
        let numbered = (2..).map(|number| format!("{short}_{number}"));
        let mut names = std::iter::once(short.clone()).chain(numbered);
        let name = names.find(|name| !taken.contains(name)).unwrap_or_default();
        taken.insert(name.clone());
        Drive { path, name }
    });
    named.collect()
}

/// The folders and the name of a log, which is without its ending.
fn words(log: &Path) -> Vec<String> {
    let parts = log.components();
    let mut words: Vec<String> = parts
        .filter_map(|part| match part {
            Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
            _ => None,
        })
        .collect();
    if let (Some(last), Some(place)) = (words.last_mut(), place_of_ending(log)) {
        last.truncate(place);
    }
    words
}

fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '[', '{'])
}

/// The paths that fit a pattern, by name.
fn fitting(pattern: &Path) -> Result<Vec<PathBuf>, DrivesError> {
    let text = pattern.to_string_lossy();
    let glob = GlobBuilder::new(&text).literal_separator(true).build();
    let glob = glob.map_err(|error| PatternError {
        pattern: text.clone().into_owned(),
        reason: error.kind().to_string(),
    })?;
    let whole = pattern.components();
    let root: PathBuf = whole
        .take_while(|part| !is_pattern(part.as_ref()))
        .collect();
    let mut found = Vec::new();
    collect(&root, &glob.compile_matcher(), &mut found);
    found.sort();
    if found.is_empty() {
        return Err(DrivesError::NoneFits {
            pattern: text.into_owned(),
        });
    }
    Ok(found)
}

/// Looks for what fits in a folder and in those below it, but for hidden ones and those that a link leads to.
fn collect(folder: &Path, glob: &GlobMatcher, found: &mut Vec<PathBuf>) {
    let looked_into = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let entries = fs::read_dir(looked_into).into_iter().flatten().flatten();
    for entry in entries {
        let name = entry.file_name();
        let path = folder.join(&name);
        if name.to_string_lossy().starts_with('.') {
            continue;
        }
        if glob.is_match(&path) {
            found.push(path);
        } else if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            collect(&path, glob, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    fn names(folder: &tempfile::TempDir, named: &[&str]) -> Vec<String> {
        let named: Vec<PathBuf> = named.iter().map(|name| folder.path().join(name)).collect();
        let drives = drives(logs(&named).unwrap());
        drives.into_iter().map(|drive| drive.name).collect()
    }

    #[test]
    fn files_folders_and_patterns_name_drives() {
        let folder = folder(&[
            "a.mcap",
            "week/b.mcap.zst",
            "week/bag/bag_0.mcap",
            "week/bag/metadata.yaml",
            "week/.hidden/c.mcap",
            "week/notes.txt",
        ]);
        assert_eq!(names(&folder, &["a.mcap", "week"]), ["a", "b", "bag"]);
        assert_eq!(names(&folder, &["*.mcap"]), ["a"]);
        assert_eq!(names(&folder, &["week/b*"]), ["b", "bag"]);
        assert_eq!(names(&folder, &["**/*.mcap"]), ["a", "bag_0"]);
        assert_eq!(names(&folder, &["absent.mcap"]), ["absent"]);
        let none = logs(&[folder.path().join("week/*.bag")]).unwrap_err();
        assert!(none.to_string().contains("fits no file"), "{none}");
        assert!(logs(&[folder.path().join("week/[*.mcap")]).is_err());
    }

    #[test]
    fn every_drive_has_a_name_of_its_own() {
        let folder = folder(&[
            "monday/r1/drive.mcap",
            "tuesday/r1/drive.mcap",
            "tuesday/r2/drive.mcap",
            "x/hall.mcap",
            "x/hall.mcap.gz",
        ]);
        let all = names(
            &folder,
            &[
                "monday/r1/drive.mcap",
                "tuesday/r1",
                "tuesday/r2",
                "x/*",
                "x",
            ],
        );
        let expected = ["monday_r1_drive", "tuesday_r1_drive", "r2_drive"];
        assert_eq!(all.get(..3).unwrap(), expected);
        assert_eq!(all.len(), 5);
        assert_eq!(BTreeSet::from_iter(&all).len(), 5, "{all:?}");
    }
}
