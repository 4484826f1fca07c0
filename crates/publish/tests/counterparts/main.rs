//! Outputs against programs that people use: `cargo xtask counterparts` brings them.
//!
//! Each test starts what it needs on the loopback, on ports that are free, and ends it. Where a
//! program is absent the test says so and skips, unless `ANEMO_COUNTERPARTS=all` is in the
//! environment.

mod bench;
mod live_page;
mod mqtt;
mod nmea;
mod scpi;
