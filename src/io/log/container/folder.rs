//! Folders: the parts of one recording, as `ros2 bag` splits it, or drives of which each is a log.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// The files in a folder that are logs or parts of one, in the order of their numbers.
pub fn parts(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut parts = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let part = entry?.path();
        if place_of_ending(&part).is_some() && part.is_file() {
            parts.push(part);
        }
    }
    // One that was unpacked beside its packed one is one part.
    let unpacked: BTreeSet<PathBuf> = parts
        .iter()
        .filter(|part| {
            part.extension()
                .is_some_and(|it| it.eq_ignore_ascii_case("mcap"))
        })
        .cloned()
        .collect();
    parts.retain(|part| unpacked.contains(part) || !unpacked.contains(&part.with_extension("")));
    parts.sort_by_cached_key(|part| (number(part).1, part.clone()));
    Ok(parts)
}

/// The drives that a path names: the log itself, a folder that is one recording in parts, or each log in any
/// other folder, by name. What cannot be looked into is left to whoever reads it.
pub fn drives(path: &Path) -> Vec<PathBuf> {
    let itself = || vec![path.to_owned()];
    if !path.is_dir() || is_one_recording(path) {
        return itself();
    }
    let inner = std::fs::read_dir(path).into_iter().flatten().flatten();
    let folders = inner.map(|entry| entry.path());
    let folders = folders.filter(|inner| inner.is_dir() && is_one_recording(inner));
    let mut drives: Vec<PathBuf> = parts(path).unwrap_or_default();
    drives.extend(folders);
    drives.sort();
    match drives.is_empty() {
        true => itself(),
        false => drives,
    }
}

/// Whether the files in a folder belong together: `ros2 bag` says so beside them, and numbers them from 0 under
/// one name.
pub fn is_one_recording(folder: &Path) -> bool {
    let parts = parts(folder).unwrap_or_default();
    let numbered = || {
        let mut numbered = (0..).zip(&parts);
        let first = parts.first().map(|part| number(part).0);
        numbered.all(|(place, part)| {
            let (name, number) = number(part);
            number == Some(place) && Some(name) == first
        })
    };
    !parts.is_empty() && (folder.join("metadata.yaml").is_file() || numbered())
}

/// Where the ending of a log's name begins: `.mcap`, or what `ros2 bag` and others call it once it is packed.
pub fn place_of_ending(part: &Path) -> Option<usize> {
    const ENDINGS: [&str; 4] = [".mcap", ".mcap.zstd", ".mcap.zst", ".mcap.gz"];
    let name = part.file_name()?.to_string_lossy().to_ascii_lowercase();
    let ending = ENDINGS.iter().find(|ending| name.ends_with(**ending))?;
    name.len().checked_sub(ending.len())
}

/// A part's name up to the number at its end, and that: `bag_` and 10 of `bag_10.mcap`.
fn number(part: &Path) -> (String, Option<u64>) {
    let name = part.file_name().unwrap_or_default().to_string_lossy();
    let stem = place_of_ending(part).and_then(|place| name.get(..place));
    let stem = stem.unwrap_or_default();
    let before = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = stem.get(before.len()..).unwrap_or_default();
    (before.to_owned(), digits.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_one_drive_only_where_its_files_are_parts_of_one() {
        let folder = |names: &[&str]| {
            let folder = tempfile::tempdir().unwrap();
            for name in names {
                std::fs::write(folder.path().join(name), "").unwrap();
            }
            folder
        };
        for (names, count) in [
            (&["bag_0.mcap", "bag_1.mcap", "bag_10.mcap"][..], 3),
            (&["bag_0.mcap", "bag_1.mcap", "bag_2.mcap.zstd"], 1),
            (&["bag_0.mcap", "bag_2.mcap", "metadata.yaml"], 1),
            (&["hall_0.mcap", "room_1.mcap"], 2),
            (&["drive_1.mcap", "drive_2.mcap"], 2),
            (&["room.mcap", "room.mcap.zst", "notes.txt"], 1),
            (&["notes.txt"], 1),
            (&["D.MCAP", "e.mcap"], 2),
        ] {
            let folder = folder(names);
            let drives = drives(folder.path());
            assert_eq!(drives.len(), count, "{names:?}: {drives:?}");
        }
        let single = folder(&["room.mcap"]);
        assert_eq!(drives(single.path()), [single.path().join("room.mcap")]);
        let split = folder(&["bag_0.mcap", "bag_1.mcap"]);
        assert_eq!(drives(split.path()), [split.path()]);
        let of_both = folder(&["room.mcap"]);
        let inner = of_both.path().join("bag");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(inner.join("bag_0.mcap"), "").unwrap();
        assert_eq!(
            drives(of_both.path()),
            [inner, of_both.path().join("room.mcap")]
        );
    }
}
