//! Images of both boards in two trees, section by section.
//!
//! Sections that debuggers read are left out. Where a file or a crate has moved, its path in a
//! message of a panic and the order of functions may differ; sizes of functions and statics then
//! tell whether anything else does.

use super::compare::{CommandResult, ResultComparison};
use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::Result;
use image_analysis::symbols::Image;
use std::collections::BTreeMap;
use std::path::Path;

pub fn compare(old_tree: &Path) -> Result<Vec<(String, ResultComparison)>> {
    install::thumb_target()?;
    let compared = |board: FirmwareBoard| {
        shell::announce(&format!("images of {}", board.feature()));
        let old = result(&Image::read(&artefacts::image_in(old_tree, "firmware", board)?)?);
        let new = result(&Image::read(&artefacts::firmware(board)?)?);
        Ok((format!("image {}", board.feature()), ResultComparison::of(&old, &new)))
    };
    FirmwareBoard::ALL.into_iter().map(compared).collect()
}

fn result(image: &Image) -> CommandResult {
    let mut result = CommandResult::default();
    for section in &image.sections {
        result.add_content(&section.name, &section.content);
    }
    let mut sizes: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    image.symbols.iter().for_each(|symbol| sizes.entry(&symbol.name).or_default().push(symbol.size));
    for (name, mut sizes) in sizes {
        sizes.sort_unstable();
        result.values.insert(format!("size of {name}"), sizes.into());
    }
    result
}
