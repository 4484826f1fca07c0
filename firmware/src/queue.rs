//! Into a queue, without a panic that could be reached.
//!
//! heapless takes a queue's size from memory and divides by it, so that the compiler sees a
//! division by zero wherever it does not happen to know the size. No queue has size 0; a check here
//! shows it to the compiler.

use heapless::spsc::Producer;

/// Puts an item into a queue, or gives it back if there is no room.
///
/// # Errors
/// The item.
#[inline(always)]
pub fn put<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    // The capacity is the size less 1.
    if queue.capacity().wrapping_add(1) == 0 {
        return Err(item);
    }
    queue.enqueue(item)
}
