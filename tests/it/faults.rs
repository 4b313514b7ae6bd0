//! Damaged logs: what can be read of them is used, what cannot is said, and nothing is made up.

mod bounded;
mod corpus;
mod crafted;
mod damage;
mod exit_codes;
mod hostile;
mod index;
mod injection;
mod pristine;
mod raw;
