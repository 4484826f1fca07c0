//! Messages of a running anemometer to other programs.
//!
//! | module | what it is |
//! |---|---|
//! | [`feed`] | rows and events, from the run to everybody who listens |
//! | [`commands`] | what a listener may ask of the run |
//! | [`mod@format`] | rows as NMEA 0183, Gill's strings, MQTT messages |
//! | [`output`] | one thread an address: UDP, TCP, serial ports, MQTT, SCPI |
//! | [`target`] | addresses as a user writes them |
//! | [`listen`] | the only place that opens sockets |
//! | [`page`] | the live page, for a browser |
//!
//! The feature `tls` adds encrypted connections of MQTT, with 12 packages.

pub mod commands;
pub mod feed;
pub mod format;
pub mod listen;
pub mod output;
pub mod page;
pub mod target;

pub use output::start;
pub use target::targets;
