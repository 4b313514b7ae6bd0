//! Which program wrote a file.

use std::sync::LazyLock;

use serde::Serialize;

/// The program, at the head of every file that it writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Tool {
    name: &'static str,
    version: &'static str,
}

impl Tool {
    /// This one.
    pub const THIS: Self = Self {
        name: "tmam",
        version: env!("CARGO_PKG_VERSION"),
    };
}

/// The version, the commit that it was built from, and with which features.
///
/// Cargo does not know commits, so whoever builds says it, in the variable TMAM_COMMIT; no file that tmam writes has
/// it, so that all builds of a version write the same bytes.
pub static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    let commit = option_env!("TMAM_COMMIT").unwrap_or("not told by whoever built this");
    let features = [
        ("parquet", cfg!(feature = "parquet")),
        ("terminal", cfg!(feature = "terminal")),
        ("viewer", cfg!(feature = "viewer")),
    ];
    let features = features.into_iter().filter(|(_, is_in)| *is_in);
    let features: Vec<&str> = features.map(|(name, _)| name).collect();
    let features = match features.as_slice() {
        [] => "none".to_owned(),
        features => features.join(", "),
    };
    let version = Tool::THIS.version;
    format!("{version}\ncommit:   {commit}\nfeatures: {features}")
});
