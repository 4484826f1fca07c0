//! Simulated wind tunnel, instruments and recordings for thermal sigma-delta anemometers; the library behind the command `anemo`.

pub mod cli;
pub mod experiment;
pub mod head;
pub mod instrument;
pub mod plot;
pub mod recording;
pub mod run;
pub mod sensor;
pub mod summary;
pub mod toml_file;
