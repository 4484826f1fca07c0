//! Queues, without a panic that could be reached.
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
    if has_size(queue) { queue.enqueue(item) } else { Err(item) }
}

/// Returns true if there is room for an item.
#[inline(always)]
pub fn has_room<T>(queue: &Producer<'_, T>) -> bool {
    has_size(queue) && queue.ready()
}

/// Returns true if the other side has taken all items.
#[inline(always)]
pub fn is_empty<T>(queue: &Producer<'_, T>) -> bool {
    has_size(queue) && queue.is_empty()
}

/// Always. The capacity is the size less 1.
#[inline(always)]
fn has_size<T>(queue: &Producer<'_, T>) -> bool {
    queue.capacity().wrapping_add(1) != 0
}
