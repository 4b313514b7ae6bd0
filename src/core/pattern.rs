//! Patterns of topics and sonars.

/// A pattern that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{pattern}` is not a glob: {reason}")]
pub struct PatternError {
    /// As written.
    pub pattern: String,
    pub reason: String,
}

/// Compiles glob patterns; `*` crosses slashes, as topics are paths that nobody nests on purpose.
///
/// # Errors
/// The first pattern that is not a glob.
pub fn glob_set(patterns: &[String]) -> Result<globset::GlobSet, PatternError> {
    let bad = |pattern: &str, error: &globset::Error| PatternError {
        pattern: pattern.to_owned(),
        reason: error.kind().to_string(),
    };
    let mut set = globset::GlobSetBuilder::new();
    for pattern in patterns {
        set.add(globset::Glob::new(pattern).map_err(|e| bad(pattern, &e))?);
    }
    set.build().map_err(|e| bad(&patterns.join(" "), &e))
}
/// Whether patterns choose a name: one of them fits, or there is none.
pub fn is_chosen(patterns: &[String], name: &str) -> bool {
    patterns.is_empty() || glob_set(patterns).is_ok_and(|set| set.is_match(name))
}
