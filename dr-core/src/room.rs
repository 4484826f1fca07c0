//! Room for what a head has several of.

/// Room for so many: the memory of a board holds fewer than that of a host.
pub const fn room(board: usize, host: usize) -> usize {
    if cfg!(target_os = "none") { board } else { host }
}
