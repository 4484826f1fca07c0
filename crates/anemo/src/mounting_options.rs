//! Options of how a head is mounted, in place of what its file or its recording has.

use crate::output::Failure;
use anemometry::head::Head;
use recording::Metadata;
use recording::head_mounting::{HeadMounting, direction};

#[derive(clap::Args)]
pub struct MountingArguments {
    /// Compass direction of the head's x axis, degrees clockwise from north, in place of
    /// `heading_deg`.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub heading: Option<f64>,
    /// What points up in the head's frame, in place of `up`: 0,0,1 of a head that stands upright,
    /// 0,0,-1 of one that hangs.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<String>,
}

impl MountingArguments {
    /// The direction that points up.
    pub fn up(&self) -> Result<Option<[f64; 3]>, Failure> {
        self.up.as_deref().map(direction).transpose().map_err(|error| Failure::usage(format!("--up: {error}")))
    }

    /// That of a recording, whose values, and those of a head file that is named beside it, these
    /// replace; none without a heading.
    pub fn of_recording(&self, metadata: &Metadata, named: Option<&Head>) -> Result<Option<HeadMounting>, Failure> {
        let heading_deg = self.heading.or(named.and_then(|head| head.heading_deg));
        let up = self.up()?.or(named.and_then(|head| head.up));
        let mounting = HeadMounting::from_metadata(metadata, heading_deg, up).map_err(Failure::usage)?;
        if mounting.is_none() && self.up.is_some() {
            return Err(Failure::usage("--up needs the direction of the head's x axis, too: --heading"));
        }
        Ok(mounting)
    }
}
