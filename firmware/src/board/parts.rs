//! What the start-up of a board hands to the application.

use wire::ResetCause;

/// The parts of a board. Their types are the board's own.
pub struct BoardParts<FrontEnd, HostReceiver, HostTransmitter, Watchdog, Idler, SettingsFlash> {
    /// Readings in, heaters out.
    pub front_end: FrontEnd,
    /// Bytes from the host.
    pub host_receiver: HostReceiver,
    /// Frames to the host.
    pub host_transmitter: HostTransmitter,
    /// Resets the board unless it is fed.
    pub watchdog: Watchdog,
    /// What to do when there is nothing to do.
    pub idler: Idler,
    /// Where settings are kept.
    pub settings: SettingsFlash,
    /// Why the processor started.
    pub reset: ResetCause,
}
