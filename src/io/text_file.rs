//! Files that are read whole: configurations, worlds, golden files.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// No such file is longer; a log that is given in its place is not read to its end.
const LONGEST: u64 = 16 << 20;

/// How a file begins that Git LFS puts in the place of another one, and what to do about it.
pub const LFS_POINTER: (&[u8], &str) = (
    b"version https://git-lfs",
    "it is what Git LFS puts in the place of a file: `git lfs pull` fetches the file",
);

/// Refuses what Git LFS puts in the place of a file.
fn fetched<T: AsRef<[u8]>>(content: T) -> io::Result<T> {
    let (begin, what) = LFS_POINTER;
    match content.as_ref().starts_with(begin) {
        true => Err(io::Error::new(io::ErrorKind::InvalidData, what)),
        false => Ok(content),
    }
}

/// Reads a whole file.
///
/// # Errors
/// A file that cannot be read, or that Git LFS did not fetch.
pub fn read_bytes(path: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    fetched(fs::read(path)?)
}

/// Reads a whole file of UTF-8.
///
/// # Errors
/// A file that cannot be read, is longer than 16 MiB, is no text, or that Git LFS did not fetch.
pub fn read_text(path: impl AsRef<Path>) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?
        .take(LONGEST + 1)
        .read_to_string(&mut text)
        .map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => {
                io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8")
            }
            _ => error,
        })?;
    if text.len() as u64 > LONGEST {
        let message = "it is longer than 16 MiB, which no such file is";
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    fetched(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_or_no_text_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        std::fs::write(&path, "a = 1").unwrap();
        assert_eq!(read_text(&path).unwrap(), "a = 1");
        std::fs::write(&path, vec![b' '; LONGEST as usize + 1]).unwrap();
        assert_eq!(
            read_text(&path).unwrap_err().kind(),
            io::ErrorKind::FileTooLarge
        );
        std::fs::write(&path, [0xff, 0xfe]).unwrap();
        assert_eq!(
            read_text(&path).unwrap_err().kind(),
            io::ErrorKind::InvalidData
        );
    }

    #[test]
    fn what_git_lfs_did_not_fetch_is_called_that() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
        std::fs::write(&path, pointer).unwrap();
        for error in [
            read_text(&path).unwrap_err(),
            read_bytes(&path).unwrap_err(),
        ] {
            assert!(error.to_string().contains("`git lfs pull`"), "{error}");
        }
    }
}
