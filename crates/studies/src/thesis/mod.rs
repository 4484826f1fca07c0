//! The experiments of the thesis, run on the simulated sensors, with its findings beside ours:
//! `studies thesis`.
//!
//! | module | holds |
//! |---|---|
//! | [`lab`], [`record`] | runs an experiment file and keeps what it recorded |
//! | [`identified`] | models of such records on the meshes of the thesis, and their peaks |
//! | [`findings`] | a published value, ours, and the bar between them |
//! | `settling` | how fast a step is answered, from noisy streams |
//! | [`page`], `pages/` | what is written: a page and a picture a study, and the templates of the pages |
//! | `catalogue` | the list of studies |
//! | `rems` | what the studies of that transducer share |
//! | `rems_…`, `sphere_…` | the studies, one file each |
//!
//! A study runs the experiments of its own name in `experiments/thesis`, and every number on its
//! page comes from these runs. Where the thesis has no error figure, ours is the first.

mod catalogue;
pub mod findings;
pub mod identified;
pub mod lab;
pub mod page;
pub mod record;
mod rems;
mod rems_boom;
mod rems_cross;
mod rems_dice;
mod rems_loops;
mod rems_self;
mod settling;
mod sphere_identification;
mod sphere_response;

pub use catalogue::{STUDIES, Study};
pub use findings::StudyFindings;
pub use lab::StudyLab;
