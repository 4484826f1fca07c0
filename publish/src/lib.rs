//! What a running anemometer tells other programs.
//!
//! | module | what it is |
//! |---|---|
//! | [`feed`] | rows and events, from the run to everybody who listens |
//! | [`commands`] | what a listener may ask of the run |
//! | [`format`] | rows as NMEA 0183, Gill's strings, InfluxDB's lines, MQTT messages |
//! | [`listen`] | the only place that opens sockets |

pub mod commands;
pub mod feed;
pub mod format;
pub mod listen;
