//! The studies that there are, in the order of their pages.

use super::findings::StudyFindings;
use super::lab::StudyLab;
use super::{rems_boom, rems_cross, rems_dice, rems_loops, rems_self, sphere_identification, sphere_response};
use anyhow::Result;

/// One figure or table of the thesis.
pub struct Study {
    /// Name on the command line, and the name of its page.
    pub name: &'static str,
    /// Template of its page, which begins with its title.
    pub(super) page: &'static str,
    run: fn(&StudyLab, &mut StudyFindings) -> Result<()>,
}

/// All of them, in the order of the pages.
pub const STUDIES: [Study; 7] = [
    Study { name: "rems-self", page: include_str!("pages/rems-self.md"), run: rems_self::run },
    Study { name: "rems-cross", page: include_str!("pages/rems-cross.md"), run: rems_cross::run },
    Study { name: "rems-dice", page: include_str!("pages/rems-dice.md"), run: rems_dice::run },
    Study { name: "rems-boom", page: include_str!("pages/rems-boom.md"), run: rems_boom::run },
    Study { name: "rems-loops", page: include_str!("pages/rems-loops.md"), run: rems_loops::run },
    Study { name: "sphere-response", page: include_str!("pages/sphere-response.md"), run: sphere_response::run },
    Study {
        name: "sphere-identification",
        page: include_str!("pages/sphere-identification.md"),
        run: sphere_identification::run,
    },
];

impl Study {
    /// Heading of its page.
    pub fn title(&self) -> &'static str {
        self.page.lines().next().unwrap_or_default().trim_start_matches("# ")
    }

    /// Runs its experiments and judges them.
    ///
    /// # Errors
    /// What could not be read, run or identified.
    pub fn run(&self, lab: &StudyLab) -> Result<StudyFindings> {
        let mut findings = StudyFindings::default();
        (self.run)(lab, &mut findings)?;
        Ok(findings)
    }
}
