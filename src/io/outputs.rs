//! The set of files that a replay writes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

use crate::io::output::{Output, OutputError, is_stdout, make_room};

/// What stands as `%20` in the value of a partition.
const ESCAPED: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'_')
    .remove(b'.')
    .remove(b'~');

/// Which outputs are asked for.
#[derive(Debug, Clone, Default)]
pub struct Requested {
    /// The recording's file.
    pub recording: Option<PathBuf>,
    /// The features' file.
    pub features: Option<PathBuf>,
    /// The trace's file.
    pub trace: Option<PathBuf>,
    /// The path's file.
    pub path: Option<PathBuf>,
    /// The map's file.
    pub map: Option<PathBuf>,
    /// The file beside it that says what it means.
    pub beside_map: Option<PathBuf>,
    /// The file of the table of arcs.
    pub arcs: Option<PathBuf>,
    /// The evaluation's file.
    pub evaluation: Option<PathBuf>,
    /// What is read besides the log.
    pub inputs: Vec<PathBuf>,
    /// No recording, even where no output is named.
    pub no_recording: bool,
    /// Shown in an open viewer, which is an output as well.
    pub live: bool,
    /// Folders that are not there are made.
    pub makes_folders: bool,
}

/// The outputs of a replay, open.
#[derive(Debug)]
pub struct Outputs {
    /// For the recording.
    pub recording: Option<Output>,
    /// For the features.
    pub features: Option<Output>,
    /// For the trace.
    pub trace: Option<Output>,
    /// For the path.
    pub path: Option<Output>,
    /// For the map.
    pub map: Option<Output>,
    /// For what is beside it.
    pub beside_map: Option<Output>,
    /// For the table of arcs.
    pub arcs: Option<Output>,
    /// For the evaluation.
    pub evaluation: Option<Output>,
}

/// Why the outputs cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OutputsError {
    /// Two outputs in one file would destroy each other, and one in an input's place the input.
    #[error(
        "{} is named twice; give every input and output a name of its own",
        if is_stdout(path) { "standard output".into() } else { path.to_string_lossy() }
    )]
    NamedTwice {
        /// The file.
        path: PathBuf,
    },
    /// One of them cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Requested {
    /// Opens the outputs: those that are named, or else a recording and features named after the
    /// log, in the current directory.
    ///
    /// # Errors
    /// A file that is named twice or cannot be written.
    pub fn open(mut self, log: &Path) -> Result<Outputs, OutputsError> {
        if !self.live && self.paths().iter().all(Option::is_none) {
            self.recording = (!self.no_recording).then(|| named_after(log, ".rrd"));
            self.features = Some(named_after(log, ".features.json"));
        }
        let inputs = std::iter::once(log).chain(self.inputs.iter().map(PathBuf::as_path));
        refuse_collisions(&inputs.collect::<Vec<_>>(), &self.paths())?;
        if self.makes_folders {
            self.paths()
                .iter()
                .flatten()
                .try_for_each(|path| make_room(path))?;
        }
        let create = |path: Option<PathBuf>| path.as_deref().map(Output::create).transpose();
        Ok(Outputs {
            recording: create(self.recording)?,
            features: create(self.features)?,
            trace: create(self.trace)?,
            path: create(self.path)?,
            map: create(self.map)?,
            beside_map: create(self.beside_map)?,
            arcs: create(self.arcs)?,
            evaluation: create(self.evaluation)?,
        })
    }

    /// Of one drive among several, where folders are requested: files in these that are called as it is. Tables of
    /// arcs lie in folders by `log=NAME`, which engines read as a column.
    pub fn of_drive(&self, drive: &str) -> Self {
        let called = |folder: &Option<PathBuf>, ending: &str| {
            let folder = folder.as_ref()?;
            Some(folder.join(format!("{drive}{ending}")))
        };
        let partition = format!("log={}", utf8_percent_encode(drive, ESCAPED));
        Self {
            recording: called(&self.recording, ".rrd"),
            features: called(&self.features, ".features.json"),
            trace: called(&self.trace, ".trace.jsonl"),
            arcs: (self.arcs.as_ref()).map(|folder| folder.join(partition).join("arcs.parquet")),
            makes_folders: true,
            ..self.clone()
        }
    }

    /// The files that are named.
    pub fn paths(&self) -> [Option<&Path>; 8] {
        [
            &self.recording,
            &self.features,
            &self.trace,
            &self.path,
            &self.map,
            &self.beside_map,
            &self.arcs,
            &self.evaluation,
        ]
        .map(Option::as_deref)
    }
}

/// Refuses outputs in one file, or in the place of a file that is read.
///
/// # Errors
/// The file that is named twice.
pub fn refuse_collisions(inputs: &[&Path], outputs: &[Option<&Path>]) -> Result<(), OutputsError> {
    let mut taken: BTreeSet<PathBuf> = inputs.iter().map(|path| place(path)).collect();
    for path in outputs.iter().copied().flatten() {
        let place = place(path);
        // What is no file can be written to twice.
        let is_file = !path.exists() || path.is_file();
        if !taken.insert(place) && is_file {
            return Err(OutputsError::NamedTwice {
                path: path.to_owned(),
            });
        }
    }
    Ok(())
}

/// Where a path leads, also before there is a file, or a directory for it.
fn place(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let there = |part: &Path| {
        let rest = absolute.strip_prefix(part).ok()?;
        Some(part.canonicalize().ok()?.join(rest))
    };
    absolute
        .ancestors()
        .find_map(there)
        .unwrap_or_else(|| absolute.clone())
}

/// The name that a log has by the folder that its table of arcs is asked for in, `log=NAME`.
pub fn partition(table: &Path) -> Option<String> {
    let folder = table.parent()?.file_name()?.to_str()?;
    let name = percent_decode_str(folder.strip_prefix("log=")?);
    Some(name.decode_utf8_lossy().into_owned())
}

fn named_after(log: &Path, extension: &str) -> PathBuf {
    let mut name = log.file_stem().unwrap_or(log.as_os_str()).to_owned();
    name.push(extension);
    PathBuf::from(name)
}

impl Outputs {
    /// Writes all of them to their ends.
    ///
    /// # Errors
    /// When one of them cannot be written.
    pub fn settle(self) -> Result<Settled, OutputError> {
        let outputs = [
            self.recording,
            self.features,
            self.trace,
            self.path,
            self.map,
            self.beside_map,
            self.arcs,
            self.evaluation,
        ];
        Settled::new(outputs.into_iter().flatten())
    }
}

/// Outputs that are whole, but have not taken their names: what is to be said of them is said before, and where
/// that fails none appears.
#[derive(Debug, Default)]
pub struct Settled(Vec<Output>);

impl Settled {
    /// Writes outputs to their ends.
    ///
    /// # Errors
    /// When one of them cannot be written.
    pub fn new(outputs: impl IntoIterator<Item = Output>) -> Result<Self, OutputError> {
        let mut outputs: Vec<Output> = outputs.into_iter().collect();
        outputs.iter_mut().try_for_each(Output::settle)?;
        Ok(Self(outputs))
    }

    /// The files.
    pub fn files(&self) -> Vec<PathBuf> {
        let paths = self.0.iter().map(Output::path);
        paths
            .filter(|path| !is_stdout(path))
            .map(Path::to_owned)
            .collect()
    }

    /// Whether one output went to standard output.
    pub fn to_stdout(&self) -> bool {
        self.0.iter().any(|output| is_stdout(output.path()))
    }

    /// Gives every file its name.
    ///
    /// # Errors
    /// When one of them cannot take its name.
    pub fn commit(self) -> Result<(), OutputError> {
        self.0.into_iter().try_for_each(Output::commit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_partition_says_how_a_log_is_called() {
        for name in ["drive", "monday r1", "a=b%41", "\u{fc}ber/2", ""] {
            let requested = Requested {
                arcs: Some("arcs".into()),
                ..Requested::default()
            };
            let table = requested.of_drive(name).arcs.unwrap();
            assert_eq!(partition(&table).as_deref(), Some(name));
        }
        assert_eq!(
            partition(Path::new("arcs/log=%zz/a.parquet")).unwrap(),
            "%zz"
        );
        assert_eq!(partition(Path::new("log/arcs.parquet")), None);
    }
}
