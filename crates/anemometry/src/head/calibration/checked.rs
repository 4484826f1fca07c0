//! A checked calibration, in f64.

use dr_core::wind::HeadForm;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

use super::super::element::HeadElement;
use super::table::CalibrationTable;

use crate::network::parameters::QuiescentNetwork;

/// A checked calibration, in f64.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Table as it is written, but for the network.
    pub table: CalibrationTable,
    /// Place in the head of the element that measures the gas.
    pub reference: Option<usize>,
    /// Places in the head of the elements of the surfaces.
    pub surfaces: Vec<usize>,
    /// The quiescent-gas network, with the noise of readings.
    pub network: QuiescentNetwork,
}

impl Calibration {
    /// The calibration of a table with the places of its elements in the head, not checked yet.
    ///
    /// # Errors
    /// The key and line of a name that no element has.
    pub(super) fn placed(
        source: &TomlSource,
        mut table: CalibrationTable,
        elements: &[HeadElement],
    ) -> Result<Self, FileError> {
        let names: Vec<&str> = elements.iter().map(|element| element.name.as_str()).collect();
        let place = |key: &str, name: &str| {
            names.iter().position(|known| *known == name).ok_or_else(|| {
                let hint = suggest(name, names.iter().copied());
                source.refuse(key, format!("is `{name}`, which is no element of this head; {hint}"))
            })
        };
        let reference = table.reference.as_ref().map(|name| place("calibration.reference", name)).transpose()?;
        let mut surfaces = Vec::with_capacity(table.surfaces.len());
        for (i, of) in table.surfaces.iter().enumerate() {
            surfaces.push(place(&format!("calibration.surfaces[{i}].element"), &of.element)?);
        }
        let (mut own, mut cross) = (std::mem::take(&mut table.self_heating), std::mem::take(&mut table.cross_heating));
        for (i, own) in own.iter_mut().enumerate() {
            own.element = place(&format!("calibration.self_heating[{i}].element"), &own.name)?;
        }
        for (i, cross) in cross.iter_mut().enumerate() {
            cross.from = place(&format!("calibration.cross_heating[{i}].from"), &cross.from_name)?;
            cross.to = place(&format!("calibration.cross_heating[{i}].to"), &cross.to_name)?;
        }
        Ok(Self { table, reference, surfaces, network: QuiescentNetwork { own, cross } })
    }

    /// Normal of the plane, for a head that outputs the wind in a plane only: of a card, across a
    /// cylinder, or of wires.
    pub fn plane_normal(&self) -> Option<[f64; 3]> {
        let first = self.table.surfaces.first()?;
        plane_normal(self.table.form, self.table.card.is_some(), first.axis, first.corner)
    }
}

/// The same from form, card, and the axis and corner of the first surface.
pub fn plane_normal(form: HeadForm, is_card: bool, axis: [f64; 3], corner: [f64; 3]) -> Option<[f64; 3]> {
    match form {
        HeadForm::Cylinder | HeadForm::Wires => Some(corner),
        HeadForm::Sphere | HeadForm::Cube | HeadForm::Single => is_card.then_some(axis),
    }
}
