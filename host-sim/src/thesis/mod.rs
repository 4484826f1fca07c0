//! The experiments of the thesis, run on the simulated sensors, with its findings beside ours: `anemo thesis`.
//!
//! | module | holds |
//! |---|---|
//! | [`lab`], [`record`] | runs an experiment file and keeps what it recorded |
//! | [`identified`] | models of such records on the meshes of the thesis, and their peaks |
//! | [`findings`] | a published value, ours, and the bar between them |
//! | `settling` | how fast a step is answered, from noisy streams |
//! | [`page`] | what is written: a page and a picture a study |
//! | `rems` | what the studies of that transducer share |
//! | `rems_…`, `sphere_…` | the studies, one file each |
//!
//! A study runs the experiments of its own name in `experiments/thesis`, and every number on its page comes from these runs. Where the
//! thesis has no error figure, ours is the first.

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

pub use findings::{Finding, Findings};
pub use lab::{Lab, StudyError};

/// One figure or table of the thesis.
pub struct Study {
    /// As on the command line, and the name of its page.
    pub name: &'static str,
    pub title: &'static str,
    /// Where it stands in the thesis.
    pub source: &'static str,
    run: fn(&Lab) -> Result<Findings, StudyError>,
}

/// All of them, in the order of the pages.
pub const STUDIES: [Study; 7] = [
    Study { name: "rems-self", title: "REMS: self-heating of a die", source: "chapter 4", run: rems_self::run },
    Study { name: "rems-cross", title: "REMS: cross-heating between dice", source: "chapter 4", run: rems_cross::run },
    Study { name: "rems-dice", title: "REMS: four dice at once", source: "chapter 4", run: rems_dice::run },
    Study { name: "rems-boom", title: "REMS: the boom", source: "chapter 4", run: rems_boom::run },
    Study { name: "rems-loops", title: "REMS: a die in closed loop", source: "chapter 4", run: rems_loops::run },
    Study {
        name: "sphere-response",
        title: "Spheres A and B: a step of the wind",
        source: "the spherical sensors",
        run: sphere_response::run,
    },
    Study {
        name: "sphere-identification",
        title: "Spheres A and B: why one is slow and one is fast",
        source: "the spherical sensors",
        run: sphere_identification::run,
    },
];

impl Study {
    /// # Errors
    /// What could not be read, run or identified.
    pub fn run(&self, lab: &Lab) -> Result<Findings, StudyError> {
        (self.run)(lab)
    }
}
