//! The studies that there are, in the order of their pages.

use super::error::StudyError;
use super::findings::StudyFindings;
use super::lab::StudyLab;
use super::{rems_boom, rems_cross, rems_dice, rems_loops, rems_self, sphere_identification, sphere_response};

/// One figure or table of the thesis.
pub struct Study {
    /// As on the command line, and the name of its page.
    pub name: &'static str,
    /// Heading of its page.
    pub title: &'static str,
    /// Where it stands in the thesis.
    pub source: &'static str,
    /// Template of its page.
    pub(super) page: &'static str,
    run: fn(&StudyLab) -> Result<StudyFindings, StudyError>,
}

/// All of them, in the order of the pages.
pub const STUDIES: [Study; 7] = [
    Study {
        name: "rems-self",
        page: include_str!("pages/rems-self.md"),
        title: "REMS: self-heating of a die",
        source: "chapter 4",
        run: rems_self::run,
    },
    Study {
        name: "rems-cross",
        page: include_str!("pages/rems-cross.md"),
        title: "REMS: cross-heating between dice",
        source: "chapter 4",
        run: rems_cross::run,
    },
    Study {
        name: "rems-dice",
        page: include_str!("pages/rems-dice.md"),
        title: "REMS: four dice at once",
        source: "chapter 4",
        run: rems_dice::run,
    },
    Study {
        name: "rems-boom",
        page: include_str!("pages/rems-boom.md"),
        title: "REMS: the boom",
        source: "chapter 4",
        run: rems_boom::run,
    },
    Study {
        name: "rems-loops",
        page: include_str!("pages/rems-loops.md"),
        title: "REMS: a die in closed loop",
        source: "chapter 4",
        run: rems_loops::run,
    },
    Study {
        name: "sphere-response",
        page: include_str!("pages/sphere-response.md"),
        title: "Spheres A and B: a step of the wind",
        source: "the spherical sensors",
        run: sphere_response::run,
    },
    Study {
        name: "sphere-identification",
        page: include_str!("pages/sphere-identification.md"),
        title: "Spheres A and B: why one is slow and one is fast",
        source: "the spherical sensors",
        run: sphere_identification::run,
    },
];

impl Study {
    /// Runs its experiments and judges them.
    ///
    /// # Errors
    /// What could not be read, run or identified.
    pub fn run(&self, lab: &StudyLab) -> Result<StudyFindings, StudyError> {
        (self.run)(lab)
    }
}
