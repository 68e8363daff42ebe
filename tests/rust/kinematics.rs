//! Pins and handles.
