//! Scripted teachers who demonstrate, err and correct.
