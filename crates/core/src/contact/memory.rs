//! The memory of buffers.

/// Returns the memory of a buffer in bytes, by its capacity.
pub(super) fn buffer_bytes<T>(buffer: &Vec<T>) -> usize {
    buffer.capacity() * size_of::<T>()
}
