//! Images of both boards in two trees, section by section.
//!
//! Sections that debuggers read are left out. Where a file or a crate has moved, its path in a
//! message of a panic and the order of functions may differ; sizes of functions and statics then
//! tell whether anything else does.

use super::compare::{self, Values};
use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::Result;
use image_analysis::symbols::Image;
use std::collections::BTreeMap;
use std::path::Path;

/// Compares the images and counts those that differ.
pub fn compare(old_tree: &Path) -> Result<usize> {
    install::thumb_target()?;
    let mut different = 0;
    for board in FirmwareBoard::ALL {
        shell::announce(&format!("images of {}", board.feature()));
        let old = values(&Image::read(&artefacts::image_in(old_tree, "firmware", board)?)?);
        let new = values(&Image::read(&artefacts::firmware(board)?)?);
        different += usize::from(compare::differs(&format!("image {}", board.feature()), &old, &new));
    }
    Ok(different)
}

fn values(image: &Image) -> Values {
    let mut sizes: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    image.symbols.iter().for_each(|symbol| sizes.entry(&symbol.name).or_default().push(symbol.size));
    sizes.values_mut().for_each(|sizes| sizes.sort_unstable());
    let sizes = sizes.into_iter().map(|(name, sizes)| (format!("size of {name}"), format!("{sizes:?}")));
    let sections = image.sections.iter().map(|section| (section.name.clone(), compare::digest(&section.content)));
    sections.chain(sizes).collect()
}
