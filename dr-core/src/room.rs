/// Room for so many of something: a board's memory holds fewer than a host's.
pub const fn room(board: usize, host: usize) -> usize {
    if cfg!(target_os = "none") { board } else { host }
}
