//! The command line of supple, as a library.
