//! Files that appear under their name only once they are whole.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::core::legible::legible;
use crate::io::colour::in_colour;

/// An output that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot write {}: {source}",
    if is_stdout(path) { "standard output".into() } else { path.to_string_lossy() }
)]
pub struct OutputError {
    /// The output.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// An output being written: a file, or standard output where it is called `-`.
///
/// A file is written beside its target under a temporary name and takes its final name in
/// [`Output::commit`]; dropped before that, it disappears.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Stdout(BufWriter<Stdout>),
    /// A pipe or a device: there is no name to take later.
    Stream(BufWriter<fs::File>),
    File {
        file: BufWriter<NamedTempFile>,
        target: PathBuf,
        _listed: Listed,
    },
}

/// The files that are being written, under their temporary names.
static BEING_WRITTEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A place in the list, for as long as the file is being written.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn new(file: &NamedTempFile) -> Self {
        let path = file.path().to_owned();
        let mut list = BEING_WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        list.insert(path.clone());
        Self(path)
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        let mut list = BEING_WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        list.remove(&self.0);
    }
}

/// Removes what is being written: the process is about to end.
pub fn remove_unfinished() {
    let list = BEING_WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    for path in list.iter() {
        let _ = fs::remove_file(path);
    }
}

impl Output {
    /// Opens an output.
    ///
    /// # Errors
    /// When nothing can be written there.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let sink = open(path).map_err(|source| OutputError {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            sink,
        })
    }

    /// Writes a whole output.
    ///
    /// # Errors
    /// When it cannot be written; the file is gone then.
    pub fn whole(
        path: &Path,
        write: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let mut out = Self::create(path)?;
        write(&mut out).map_err(|source| out.failed(source))?;
        out.commit()
    }

    /// Whether a file could be written there: for work that takes long before it has anything to
    /// write. Leaves nothing behind; what is no file is not touched.
    ///
    /// # Errors
    /// When it could not.
    pub fn try_out(path: &Path) -> Result<(), OutputError> {
        if !is_stdout(path) && (path.is_file() || !path.exists() || path.is_dir()) {
            Self::create(path)?;
        }
        Ok(())
    }

    /// What errors call it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The error for a write that failed.
    pub fn failed(&self, source: io::Error) -> OutputError {
        OutputError {
            path: self.path.clone(),
            source,
        }
    }

    /// Writes what is buffered, to the disk where it is a file: then only its name can fail.
    ///
    /// # Errors
    /// When that fails.
    pub fn settle(&mut self) -> Result<(), OutputError> {
        let settled = match &mut self.sink {
            Sink::File { file, .. } => file
                .flush()
                .and_then(|()| file.get_ref().as_file().sync_all())
                .map_err(without_path),
            _ => self.flush(),
        };
        settled.map_err(|source| self.failed(source))
    }

    /// Writes what is buffered and gives the file its name.
    ///
    /// # Errors
    /// When that fails; the file is gone then.
    pub fn commit(mut self) -> Result<(), OutputError> {
        self.settle()?;
        let path = self.path;
        commit(self.sink).map_err(|source| OutputError { path, source })
    }
}

/// Writes a whole output.
///
/// # Errors
/// When it cannot be written; there is no file then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut out = Output::create(path)?;
    out.write_all(bytes).map_err(|source| out.failed(source))?;
    out.commit()
}

/// Prints to standard output, at once. A reader that has gone away is no reason to fail.
///
/// # Errors
/// When it cannot be written: a full disk behind it must not look like success.
pub fn print(text: &str) -> Result<(), OutputError> {
    let mut stdout = io::stdout().lock();
    let text = in_colour(text, &stdout);
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    unless_gone(written, ()).map_err(|source| OutputError {
        path: PathBuf::from("-"),
        source,
    })
}

/// Prints to standard error, at once: where standard output is a report that stands alone.
///
/// # Errors
/// Never: who does not read it misses nothing.
pub fn print_aside(text: &str) -> Result<(), OutputError> {
    let mut stderr = io::stderr().lock();
    let text = in_colour(text, &stderr);
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
    Ok(())
}

/// Shows text to a person, on standard error where standard output holds a file. What is in it cannot
/// steer the terminal, and a reader that has gone away has seen enough.
///
/// # Errors
/// When standard output cannot be written.
pub fn show(text: &str, aside: bool) -> Result<(), OutputError> {
    let text = legible(text);
    if aside {
        print_aside(&text)
    } else {
        print(&text)
    }
}

/// Makes the directory that a file is to be in, and those above it.
///
/// # Errors
/// When that cannot be done.
pub fn make_room(path: &Path) -> Result<(), OutputError> {
    let Some(directory) = path.parent().filter(|_| !is_stdout(path)) else {
        return Ok(());
    };
    fs::create_dir_all(directory).map_err(|source| OutputError {
        path: path.to_owned(),
        source: match directory.ancestors().find(|part| part.is_file()) {
            Some(file) => io::Error::new(source.kind(), format!("{} is no folder", file.display())),
            None => source,
        },
    })
}

/// Whether a path stands for standard output.
pub fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn open(path: &Path) -> io::Result<Sink> {
    if is_stdout(path) {
        return Ok(Sink::Stdout(BufWriter::new(io::stdout())));
    }
    // A link keeps pointing where it points: the file behind it is replaced, or made where there is none yet.
    let linked = || {
        let to = fs::read_link(path).ok()?;
        Some(path.parent()?.join(to))
    };
    let target = fs::canonicalize(path).ok().or_else(linked);
    let target = target.unwrap_or_else(|| path.to_owned());
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => {
            let stream = fs::OpenOptions::new().write(true).open(&target)?;
            return Ok(Sink::Stream(BufWriter::new(stream)));
        }
        _ => {}
    }
    let directory = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut temporary = tempfile::Builder::new();
    temporary.prefix(".tmam-").suffix(".part");
    #[cfg(unix)]
    {
        // As for any new file, the umask decides who may read it.
        use std::os::unix::fs::PermissionsExt as _;
        temporary.permissions(fs::Permissions::from_mode(0o666));
    }
    // The error names the temporary file; the person asked for another.
    let named = temporary
        .tempfile_in(directory)
        .map_err(|error| match error.kind() {
            io::ErrorKind::NotFound if !directory.is_dir() => io::Error::new(
                io::ErrorKind::NotFound,
                format!(
                    "there is no directory {}: make it first",
                    directory.display()
                ),
            ),
            _ => without_path(error),
        })?;
    // A file that is replaced stays open to those to whom it was.
    if let Ok(replaced) = fs::metadata(&target) {
        named.as_file().set_permissions(replaced.permissions())?;
    }
    let listed = Listed::new(&named);
    let file = BufWriter::new(named);
    Ok(Sink::File {
        file,
        target,
        _listed: listed,
    })
}

/// The error without the name of the temporary file.
fn without_path(error: io::Error) -> io::Error {
    let said = error.to_string();
    io::Error::new(
        error.kind(),
        said.split(" at path ").next().unwrap_or_default(),
    )
}

fn commit(sink: Sink) -> io::Result<()> {
    match sink {
        Sink::Stdout(mut stream) => unless_gone(stream.flush(), ()),
        Sink::Stream(mut stream) => stream.flush(),
        Sink::File { file, target, .. } => {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.persist(target)?;
            Ok(())
        }
    }
}

/// `done` for a write that failed because nobody reads any more.
fn unless_gone<T>(result: io::Result<T>, done: T) -> io::Result<T> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(done),
        other => other,
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            // A reader that has gone away (`| head`) wants no more.
            Sink::Stdout(stream) => unless_gone(stream.write(bytes), bytes.len()),
            Sink::Stream(stream) => stream.write(bytes),
            Sink::File { file, .. } => file.write(bytes).map_err(without_path),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Stdout(stream) => unless_gone(stream.flush(), ()),
            Sink::Stream(stream) => stream.flush(),
            Sink::File { file, .. } => file.flush().map_err(without_path),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_there_until_it_is_whole() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.json");
        let mut output = Output::create(&path).unwrap();
        output.write_all(b"half").unwrap();
        assert!(!path.exists());
        drop(output);
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);

        let mut output = Output::create(&path).unwrap();
        output.write_all(b"whole").unwrap();
        output.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_a_device_is_left_alone() {
        let directory = tempfile::tempdir().unwrap();
        let (file, link) = (directory.path().join("file"), directory.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let mut output = Output::create(&link).unwrap();
        output.write_all(b"new").unwrap();
        output.commit().unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());

        let output = Output::create(Path::new("/dev/null")).unwrap();
        assert!(matches!(output.sink, Sink::Stream(_)));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_replaced_keeps_its_mode() {
        use std::os::unix::fs::PermissionsExt as _;
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.json");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write_whole(&path, b"new").unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
    }

    #[test]
    fn a_directory_cannot_be_written_to() {
        let directory = tempfile::tempdir().unwrap();
        let error = Output::create(directory.path()).unwrap_err();
        assert!(error.to_string().starts_with("cannot write"));
        assert!(Output::create(&directory.path().join("no/such/out")).is_err());
    }
}
