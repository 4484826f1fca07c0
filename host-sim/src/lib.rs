//! Simulated wind tunnel, instruments and recordings for thermal sigma-delta anemometers; the library behind the command `anemo`.
//!
//! In the order in which a run goes through them:
//!
//! | module | holds |
//! |---|---|
//! | [`experiment`], [`head`] | the files that people write, read strictly ([`toml_file`]) and checked |
//! | [`sensor`] | the simulated sensors in their wind |
//! | [`instrument`] | what runs an experiment: in this process, in the emulator, at a serial port |
//! | [`run`](mod@run) | set-up, ticks, rows: the same for every instrument |
//! | [`recording`], [`plot`], [`summary`] | what is left of a run |
//! | [`identify`], [`model`] | models from recordings |
//! | [`network`] | the windless network of a head, as the board runs it |
//! | [`calibrate`] | a head's calibration from its readings in known winds |
//! | [`answer`] | the wind off line, from recordings of a calibrated head |
//! | [`predict`], [`design`] | what a closed loop will do, from a model, and which one to build |
//! | [`study`] | what the whole instrument has to reach, and reaches |
//! | [`thesis`] | the experiments of the thesis, with its findings beside ours |
//! | [`cli`] | the command line |

pub mod answer;
pub mod calibrate;
pub mod cli;
pub mod design;
pub mod estimate;
pub mod experiment;
pub mod head;
pub mod identify;
pub mod instrument;
pub mod model;
pub mod network;
pub mod plot;
pub mod predict;
pub mod recording;
pub mod run;
pub mod self_test;
pub mod sensor;
pub mod settings;
pub mod study;
pub mod summary;
pub mod table;
pub mod thesis;
pub mod toml_file;
