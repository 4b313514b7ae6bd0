//! Text that a person wrote: configurations and worlds.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// No such file is longer; a log that is given in its place is not read to its end.
const LONGEST: u64 = 16 << 20;

/// Reads a whole file of UTF-8.
///
/// # Errors
/// A file that cannot be read, is longer than 16 MiB, or is no text.
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
    Ok(text)
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
}
