//! Names of outputs: a file is called what it is.

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::builder::ValueParser;

/// Extensions of what tmam and its neighbours read and write.
const KNOWN: [&str; 13] = [
    "csv", "html", "json", "jsonl", "mcap", "md", "bag", "parquet", "rrd", "toml", "tum", "db3",
    "xml",
];

/// A file of one kind: other names will do, but none that says that it is of another kind.
pub fn ending_in(extension: &'static str) -> ValueParser {
    ValueParser::from(move |name: &str| {
        let file = PathBuf::from(name);
        let given = file.extension().and_then(OsStr::to_str);
        match given.filter(|given| KNOWN.contains(given) && *given != extension) {
            None => Ok(file),
            Some(given) => Err(format!(
                "this is no .{given} file: its name ends in .{extension}"
            )),
        }
    })
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
        for name in ["drive.mcap", "a.json", "out/tmam.toml"] {
            let error = parsed(name).unwrap_err().to_string();
            assert!(error.contains("its name ends in .rrd"), "{error}");
        }
    }
}
