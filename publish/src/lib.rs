//! What a running anemometer tells other programs.
//!
//! | module | what it is |
//! |---|---|
//! | [`feed`] | rows and events, from the run to everybody who listens |
//! | [`commands`] | what a listener may ask of the run |
//! | [`listen`] | the only place that opens sockets |
//! | [`page`] | the live page, for a browser |

pub mod commands;
pub mod feed;
pub mod listen;
pub mod page;
