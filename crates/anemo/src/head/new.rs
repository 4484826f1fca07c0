//! `anemo head new`: a folder to begin with, a head file and its first experiments.

use std::path::{Path, PathBuf};

use anemometry::head::Head;
use host_sim::new_head::{self, NewExperiments, NewHeadError, NewHeadKind, OVERHEAT_K};

use crate::choice::choice;
use crate::output::Failure;

/// Winds to estimate.
const WINDS: u32 = 30;

/// Begin a head: a folder with a commented head file that can be simulated at once, and its first
/// experiments.
///
/// `head.toml` has the elements, their limits, and the body that simulates them; `held.toml` holds
/// all elements in winds; an `identify-….toml` for every element is a record for `anemo head
/// identify`, `tunnel.toml` one for `anemo calibrate`, and `winds.toml` one to estimate. Change the
/// numbers to those of the head at hand, then check it. With --from the head is one that there is,
/// or a changed one, whose experiments are to follow. What comes next is printed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo head new tube --kind cylinder
  anemo head new ball --kind sphere --sectors 6
  anemo head new pathfinder --from heads/pathfinder.toml --overheat 10
  anemo head check tube/head.toml --overheat 20
  anemo run tube/held.toml --on sim -o held.parquet --plot held.svg")]
pub struct NewArguments {
    /// The folder, which must not be there yet; its name becomes the head's.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// What is heated in the stream.
    #[arg(long, value_parser = choice([
        ("wire", "one hot film needle and a reference: speed", NewHeadKind::Wire),
        ("crossed-wires", "two hot film needles across each other: speed and direction in front of them", NewHeadKind::CrossedWires),
        ("cylinder", "three sectors around a tube, or as many as --sectors says: the wind across it", NewHeadKind::Cylinder),
        ("sphere", "four sectors of a sphere on two cores, or as many as --sectors says: the wind vector", NewHeadKind::Sphere),
        ("plate", "one film on a plate and a reference: speed", NewHeadKind::Plate),
    ]))]
    kind: Option<NewHeadKind>,
    /// Number of sectors: 3 to 8, 12, 16, 24 or 32 of a cylinder, 4, 6, 8, 12, 16, 20, 24 or 32 of
    /// a sphere; without it the least. Boards take a calibration of 8 at most.
    #[arg(long, value_name = "COUNT")]
    sectors: Option<usize>,
    /// A head file, with a [body] or a `sensor`, that the folder begins with in place of a kind.
    #[arg(long, value_name = "HEAD", conflicts_with_all = ["kind", "sectors"])]
    from: Option<PathBuf>,
    /// Elements over the gas in all experiments, K.
    #[arg(long, value_name = "K", default_value_t = OVERHEAT_K)]
    overheat: f64,
}

impl From<NewHeadError> for Failure {
    fn from(error: NewHeadError) -> Self {
        match error {
            NewHeadError::Unwritten { .. } => Self::work(error),
            error => Self::usage(error),
        }
    }
}

/// Writes the folder.
pub fn begin(arguments: &NewArguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let name = folder.file_name().and_then(|name| name.to_str()).filter(|name| is_name(name)).ok_or_else(|| {
        Failure::usage(format!(
            "{}: a folder of letters, digits and hyphens belongs here: its name becomes the head's",
            folder.display()
        ))
    })?;
    let overheat_k = arguments.overheat;
    crate::output::positive(&[("--overheat", Some(overheat_k))])?;
    let head = head(arguments, name)?;
    let made = new_head::write(folder, &head, overheat_k, WINDS)?;
    made.too_strong.iter().chain(&made.uncalibrated).for_each(|note| crate::output::warn(note));
    crate::output::print(&next(Path::display(folder), &made, overheat_k))
}

/// The commands that follow.
fn next(folder: std::path::Display<'_>, made: &NewExperiments, overheat_k: f64) -> String {
    let NewExperiments { identified, is_part, still_s, .. } = made;
    let only = if *is_part { format!(" \\\n  --elements {}", identified.join(",")) } else { String::new() };
    let elements = identified.join(" ");
    let network = format!(
        "{folder}/head.toml and its experiments are there. Next, the head and the head in winds:\n  \
         anemo head check {folder}/head.toml --overheat {overheat_k}\n  \
         anemo run {folder}/held.toml --on sim -o {folder}/held.parquet --plot {folder}/held.svg\n\
         its network in quiescent gas:\n  \
         for e in {elements}\n  \
         do anemo run {folder}/identify-$e.toml --on sim -o {folder}/id-$e.parquet; done\n  \
         anemo head identify {folder}/id-*.parquet -o {folder}/network.json{only}\n",
    );
    let calibration = format!(
        "its calibration, and winds that this has not seen:\n  \
         anemo run {folder}/tunnel.toml --on sim -o {folder}/tunnel.parquet\n  \
         anemo calibrate {folder}/tunnel.parquet --network {folder}/network.json --settle 5 -o {folder}/calibrated.toml\n  \
         anemo run {folder}/winds.toml --on sim -o {folder}/winds.parquet\n  \
         anemo wind {folder}/winds.parquet --head {folder}/calibrated.toml --from {still_s} --settle 3 --bandwidth 1 --fixed \\\n  \
         --plot {folder}/winds.svg\n",
    );
    if made.uncalibrated.is_some() { network } else { network + &calibration }
}

/// The head of a kind, or of a file.
fn head(arguments: &NewArguments, name: &str) -> Result<Head, Failure> {
    let kind = match (arguments.kind, &arguments.from) {
        (Some(kind), _) => kind,
        (None, Some(path)) => return Ok(Head::read(path)?.named(name)?),
        (None, None) => return Err(Failure::usage("either --kind or --from is needed: what the folder begins with")),
    };
    let known = kind.sectors();
    let sectors = arguments.sectors.unwrap_or(known[0]);
    if !known.contains(&sectors) {
        let counts: Vec<String> = known.iter().map(usize::to_string).collect();
        return Err(Failure::usage(format!("--sectors is {sectors}: a head of this kind has {}", counts.join(", "))));
    }
    Ok(new_head::of_kind(kind, name, sectors)?)
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}
