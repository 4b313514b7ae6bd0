//! A replay on one page of HTML that needs nothing else, for a ticket, or as an artefact of CI; and its pictures.

pub mod change;
pub mod map;
pub mod page;
mod plane;
