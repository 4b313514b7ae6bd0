//! Names of outputs: a file is called what it is.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::builder::ValueParser;

/// Extensions of what tmam and its neighbours read and write.
const KNOWN: [&str; 22] = [
    "bag", "csv", "db3", "geojson", "gz", "html", "json", "jsonl", "mcap", "md", "parquet", "pgm",
    "png", "rrd", "svg", "toml", "tum", "txt", "xml", "yaml", "yml", "zst",
];

/// A file of one kind: other names will do, but none that says that it is of another kind.
pub fn ending_in(extension: &'static str) -> ValueParser {
    ValueParser::from(move |name: &str| {
        let file = PathBuf::from(name);
        let given = file.extension().and_then(OsStr::to_str);
        let given = given.map(str::to_ascii_lowercase);
        match given.filter(|given| KNOWN.contains(&&**given) && given != extension) {
            None => Ok(file),
            Some(given) => Err(format!(
                "what is written there is no .{given} file; give a name that ends in .{extension}"
            )),
        }
    })
}

/// Whether a name is that of a folder for outputs of several logs: one that is there, or that is not called as a file
/// of such outputs is.
pub fn is_folder(name: &Path) -> bool {
    let extension = name.extension().and_then(OsStr::to_str);
    let is_slashed = name.to_string_lossy().ends_with('/');
    name.is_dir() || is_slashed || extension.is_none_or(|extension| !KNOWN.contains(&extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_another_kind_is_refused() {
        #[derive(Debug, clap::Parser)]
        struct Args {
            #[arg(short, value_parser = ending_in("rrd"))]
            output: PathBuf,
        }
        let parsed = |name| <Args as clap::Parser>::try_parse_from(["tmam", "-o", name]);
        for name in ["a.rrd", "-", "/dev/null", "a", "a.rrd.part", "v1.2"] {
            assert_eq!(parsed(name).unwrap().output, PathBuf::from(name));
        }
        for name in ["drive.mcap", "a.json", "out/tmam.toml", "t.txt", "D.MCAP"] {
            let error = parsed(name).unwrap_err().to_string();
            assert!(error.contains("a name that ends in .rrd"), "{error}");
        }
    }
}
