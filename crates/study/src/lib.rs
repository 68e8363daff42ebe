//! Studies of supple: error against run time.
