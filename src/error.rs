//! What can go wrong in a replay, and the exit code that goes with it.
