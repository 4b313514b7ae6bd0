//! An arc on its way to a label.

use super::arc::Arc;
use super::report::ArcReport;
use super::window::WindowResult;

/// An arc that has no label yet.
#[derive(Debug, Clone)]
pub struct Pending {
    /// What is known of it so far.
    pub report: ArcReport,
    /// The arc between its neighbours, where the three make a triple.
    pub triple: Option<[Arc; 3]>,
    /// Whether the entry after it has come.
    pub is_followed: bool,
    /// What its windows came to, once no wider one will be looked at.
    pub window: Option<WindowResult>,
}
