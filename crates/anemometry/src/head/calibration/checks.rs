//! Checks of a calibration before the board gets it: nothing twice, nothing missing, all numbers of
//! a possible size.
//!
//! Refusals name the key and line of the file. The board's own checks follow, and know neither.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use dr_core::model::ORDER;
use dr_core::model::convection_observer::config::CROSS_ORDER;
use dr_core::wind::card_inverse::DICE;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{ConvectionSettings, HeadForm, Nusselt, NusseltSurface};
use recording::toml_file::{FileError, TomlSource};
use recording::utc;

use super::super::element::HeadElement;
use super::checked::Calibration;
use super::table::{CalibrationConditions, CalibrationTable, ConvectionModelTable, UncertaintyTable};

use crate::gas::{TEMPERATURE_RANGE_K, ZERO_CELSIUS_K};

/// Temperatures of a gas whose properties are known, °C.
pub(super) const GAS_C: std::ops::RangeInclusive<f64> =
    *TEMPERATURE_RANGE_K.start() - ZERO_CELSIUS_K..=*TEMPERATURE_RANGE_K.end() - ZERO_CELSIUS_K;
/// Temperatures at rest, °C: from absolute zero to where no platinum thermometer is.
const REST_C: std::ops::RangeInclusive<f64> = -273.15..=1000.0;
/// A noisier reading is none, K.
const MOST_NOISE_K: f64 = 100.0;
/// Rates in rad/s and resistances in K/W are not greater than this.
const GREATEST: f64 = 1e6;
/// Diameters as the board takes them, m.
pub const DIAMETER_M: std::ops::RangeInclusive<f64> = 1e-6..=1.0;
/// Uncertainties of directions beyond which there is none, as the board takes them, °.
pub const DIRECTION_ERROR_MAX_DEG: std::ops::RangeInclusive<f64> = 0.01..=90.0;
const GAIN: std::ops::RangeInclusive<f64> = 0.1..=10.0;
const QUIESCENT_W_K: std::ops::RangeInclusive<f64> = 0.0..=1e3;
const MOST_AREA_M2: f64 = 1.0;
const SURFACE: std::ops::RangeInclusive<f64> = -10.0..=10.0;

/// Heading of the tables of self-heating.
const SELF_HEATING: &str = "[[calibration.self_heating]]";

impl Calibration {
    /// The calibration of a table.
    ///
    /// # Errors
    /// The key and line of what is not known, stands twice or cannot be.
    pub fn from_table(
        source: &TomlSource,
        table: CalibrationTable,
        elements: &[HeadElement],
    ) -> Result<Self, FileError> {
        let calibration = Self::placed(source, table, elements)?;
        calibration.check_numbers(source)?;
        calibration.check_self_heating(source)?;
        calibration.check_cross_heating(source)?;
        calibration.check_surfaces(source)?;
        calibration.check_curves(source)?;
        calibration.check_correction(source)?;
        Ok(calibration)
    }

    fn check_numbers(&self, source: &TomlSource) -> Result<(), FileError> {
        let table = &self.table;
        for (key, value, range, unit) in [
            ("calibration.direction_error_max_deg", table.direction_error_max_deg, DIRECTION_ERROR_MAX_DEG, "°"),
            ("calibration.diameter_m", table.diameter_m, DIAMETER_M, "m"),
            ("calibration.reference_gas_c", table.reference_gas_c, GAS_C, "°C"),
        ] {
            source.within(key, value, range, unit)?;
        }
        let corrected_on = table.correction.as_ref().and_then(|of| of.made_on.as_ref());
        for (key, day) in [("calibration", table.made_on.as_ref()), ("calibration.correction", corrected_on)] {
            if let Some(day) = day.filter(|day| !utc::is_day(day)) {
                let sentence = format!("is `{day}`: a day belongs there, as 2026-03-01");
                return Err(source.refuse(&format!("{key}.made_on"), sentence));
            }
        }
        if self.reference.is_some_and(|reference| self.knows(reference)) {
            let name = table.reference.as_deref().unwrap_or_default();
            let sentence = format!("is `{name}`, which is heated: it has a {SELF_HEATING}, and cannot measure the gas");
            return Err(source.refuse("calibration.reference", sentence));
        }
        Ok(())
    }

    fn check_self_heating(&self, source: &TomlSource) -> Result<(), FileError> {
        for (i, own) in self.network.own.iter().enumerate() {
            let key = format!("calibration.self_heating[{i}]");
            if self.network.own.iter().take(i).any(|before| before.element == own.element) {
                let sentence = format!("is `{}`, which has a {SELF_HEATING} already", own.name);
                return Err(source.refuse(&format!("{key}.element"), sentence));
            }
            source.within(&format!("{key}.rest_c"), own.rest_c, REST_C, "°C")?;
            for noise_k in [own.noise.low_k, own.noise.high_k] {
                positive_to(source, &format!("{key}.noise_k"), noise_k, MOST_NOISE_K, "K")?;
            }
            check_relaxations(source, &key, ORDER, &own.mesh_rad_s, &own.r_k_per_w, own.surface.as_deref())?;
            let surface = |k: usize| own.surface.as_ref().map_or(1.0, |shares| shares[k]);
            let steady_k_per_w: f64 = own.r_k_per_w.iter().enumerate().map(|(k, r)| r * surface(k)).sum();
            if steady_k_per_w <= 0.0 {
                let sentence = format!("has a steady gain of {steady_k_per_w} K/W: heating must make it warmer");
                return Err(source.refuse(&key, sentence));
            }
        }
        Ok(())
    }

    fn check_cross_heating(&self, source: &TomlSource) -> Result<(), FileError> {
        for (i, cross) in self.network.cross.iter().enumerate() {
            let key = format!("calibration.cross_heating[{i}]");
            let refuse = |sentence: String| Err(source.refuse(&key, sentence));
            let (from, to) = (&cross.from_name, &cross.to_name);
            if cross.from == cross.to {
                return refuse(format!("is from `{from}` to itself: that is {SELF_HEATING}"));
            }
            for (name, element) in [(from, cross.from), (to, cross.to)] {
                if !self.knows(element) {
                    return refuse(format!("names `{name}`, which has no {SELF_HEATING}"));
                }
            }
            let pair = (cross.from, cross.to);
            if self.network.cross.iter().take(i).any(|before| (before.from, before.to) == pair) {
                return refuse(format!("is from `{from}` to `{to}`, as another one before it"));
            }
            check_relaxations(source, &key, CROSS_ORDER, &cross.mesh_rad_s, &cross.r_k_per_w, Some(&cross.surface))?;
        }
        for from in &self.network.own {
            for to in self.network.own.iter().filter(|to| to.element != from.element) {
                if !self.network.cross.iter().any(|cross| (cross.from, cross.to) == (from.element, to.element)) {
                    let sentence = format!("lacks the pair from `{}` to `{}`", from.name, to.name);
                    return Err(source.refuse("calibration.cross_heating", sentence));
                }
            }
        }
        Ok(())
    }

    fn check_surfaces(&self, source: &TomlSource) -> Result<(), FileError> {
        let count = self.surfaces.len();
        let form = self.table.form;
        let counts = form.surfaces();
        if !counts.contains(&count) {
            let (least, most) = (counts.start(), counts.end());
            let sentence = match form {
                HeadForm::Single => format!("are {count}: a single element has one"),
                _ => format!("are {count}: {least} to {most} belong here, and four dice on a card"),
            };
            return Err(source.refuse("calibration.surfaces", sentence));
        }
        let most_m2 = match form {
            HeadForm::Sphere | HeadForm::Cube => PI * self.table.diameter_m * self.table.diameter_m,
            HeadForm::Cylinder | HeadForm::Wires | HeadForm::Single => MOST_AREA_M2,
        };
        for (i, (of, element)) in self.table.surfaces.iter().zip(&self.surfaces).enumerate() {
            let key = format!("calibration.surfaces[{i}]");
            let own = self.network.own.iter().find(|own| own.element == *element);
            let why = match own.map(|own| &own.surface) {
                _ if self.surfaces[..i].contains(element) => Some("which is another surface's already".to_owned()),
                None => Some(format!("which has no {SELF_HEATING}")),
                Some(None) => Some(format!("which has no `surface` in its {SELF_HEATING}, and so no wind cools it")),
                Some(Some(_)) => None,
            };
            if let Some(why) = why {
                return Err(source.refuse(&format!("{key}.element"), format!("is `{}`, {why}", of.element)));
            }
            source.within(&format!("{key}.gain"), of.gain, GAIN, "")?;
            source.within(&format!("{key}.quiescent_w_k"), of.quiescent_w_k, QUIESCENT_W_K, "W/K")?;
            positive_to(source, &format!("{key}.area_m2"), of.area_m2, most_m2, "m²")?;
            NusseltSurface::new(form, &of.surface())
                .map_err(|error| source.refuse(&key, format!("cannot be used: {error}")))?;
            if self.table.nusselt.is_some() && form != HeadForm::Single && of.means[0] <= 0.0 {
                let sentence = format!("begins with {}: a surface faces its own axis", of.means[0]);
                return Err(source.refuse(&format!("{key}.means"), sentence));
            }
        }
        Ok(())
    }

    fn check_curves(&self, source: &TomlSource) -> Result<(), FileError> {
        let CalibrationTable { nusselt, card, convection, uncertainty, .. } = &self.table;
        if let Some(of) = uncertainty {
            check_uncertainty(source, of)?;
        }
        if let Some(key) = self.table.conditions.as_ref().and_then(CalibrationConditions::fault) {
            return Err(source.refuse(&format!("calibration.conditions.{key}"), "must be two numbers, the least first"));
        }
        if card.is_some() && (nusselt.is_some() || self.surfaces.len() != DICE) {
            let sentence = "belongs to four dice on a card, which have no [calibration.nusselt]";
            return Err(source.refuse("calibration.card", sentence));
        }
        let Some(nusselt) = nusselt else { return Ok(()) };
        let made = Nusselt::new(self.table.form, &nusselt.config());
        let mut made =
            made.map_err(|error| source.refuse("calibration.nusselt", format!("cannot be used: {error}")))?;
        let Some(convection) = convection else { return Ok(()) };
        check_convection(source, convection, nusselt.most_reynolds)?;
        let taken = ConvectionSettings::new(&convection.config());
        let taken = taken.and_then(|taken| made.rest_at(taken.nusselt_at_rest));
        taken.map_err(|error| source.refuse("calibration.convection", format!("cannot be used: {error}")))
    }

    /// Tells whether the corrections are of this calibration's four surfaces, and can be.
    fn check_correction(&self, source: &TomlSource) -> Result<(), FileError> {
        let Some(correction) = &self.table.correction else { return Ok(()) };
        if self.table.surfaces.len() != SECTORS || self.table.card.is_some() {
            let sentence = "belongs to heads of four surfaces round a body: this one has another form";
            return Err(source.refuse("calibration.correction", sentence));
        }
        let names = |of: &[String]| format!("`{}`", of.join("`, `"));
        let own: Vec<String> = self.table.surfaces.iter().map(|of| of.element.clone()).collect();
        let its: Vec<String> = correction.surfaces.iter().map(|of| of.element.clone()).collect();
        if own != its {
            let sentence = format!("must have the calibration's surfaces in its order, {}", names(&own));
            return Err(source.refuse("calibration.correction", sentence));
        }
        for (i, of) in correction.surfaces.iter().enumerate() {
            let key = format!("calibration.correction.surfaces[{i}]");
            for (name, number, least, most, unit) in [
                ("offset_w", of.offset_w, -1.0, 1.0, "W"),
                ("offset_u_w", of.offset_u_w, 0.0, 1.0, "W"),
                ("gain_change", of.gain_change, -0.9, 9.0, ""),
                ("gain_change_u", of.gain_change_u, 0.0, 9.0, ""),
            ] {
                source.within(&format!("{key}.{name}"), number, least..=most, unit)?;
            }
            let board = of.config().checked();
            board.map(drop).map_err(|error| source.refuse(&key, format!("cannot be used: {error}")))?;
        }
        Ok(())
    }

    fn knows(&self, element: usize) -> bool {
        self.network.own.iter().any(|own| own.element == element)
    }
}

/// The board's own limits, in the units of the file.
fn check_uncertainty(source: &TomlSource, of: &UncertaintyTable) -> Result<(), FileError> {
    let lists = [
        ("conductance_share", &of.conductance_share[..], 0.0..=1.0, ""),
        ("speed_share", &of.speed_share, 0.0..=1.0, ""),
        ("direction_deg", &of.direction_deg, 0.0..=180.0, "°"),
        ("chi_square_most", &[of.chi_square_most], 1.0..=1e9, ""),
    ];
    for (key, numbers, range, unit) in lists {
        for number in numbers {
            source.within(&format!("calibration.uncertainty.{key}"), *number, range.clone(), unit)?;
        }
    }
    let board = of.config().checked();
    board.map(drop).map_err(|error| source.refuse("calibration.uncertainty", format!("cannot be used: {error}")))
}

/// Ranges of what the board would refuse without a key.
fn check_convection(source: &TomlSource, of: &ConvectionModelTable, most_reynolds: f64) -> Result<(), FileError> {
    let within = |key: &str, value: f64, range: RangeInclusive<f64>, unit: &str| {
        source.within(&format!("calibration.convection.{key}"), value, range, unit).map(drop)
    };
    within("nusselt_at_rest", of.nusselt_at_rest, 0.01..=1000.0, "")?;
    within("slowest_reynolds", of.slowest_reynolds, 0.0..=most_reynolds, "")?;
    within("gas_c", of.gas_c[1], GAS_C, "°C")?;
    within("gas_c", of.gas_c[0], *GAS_C.start()..=of.gas_c[1], "°C")?;
    within("speed_share_per_k", of.speed_share_per_k, 0.0..=1.0, "")?;
    within("direction_deg_per_k", of.direction_deg_per_k, 0.0..=45.0, "°")?;
    if let Some(rise) = &of.rise {
        within("rise.gravity_m_s2", rise.gravity_m_s2, 0.0..=100.0, "m/s²")?;
        within("rise.at_rest", rise.at_rest, 0.0..=10.0, "")?;
        // Steeper, two winds would make one stream.
        within("rise.decay", rise.decay, 0.0..=10_f64.min(0.95 / rise.at_rest.max(1e-6)), "")?;
    }
    if let Some(stem) = &of.stem {
        within("stem.unknown_deg", stem.unknown_deg, 0.0..=90.0, "°")?;
        for factor in stem.factor {
            within("stem.factor", factor, 0.1..=3.0, "")?;
        }
        for deflection in stem.deflection {
            within("stem.deflection", deflection, -0.9..=3.0, "")?;
        }
    }
    Ok(())
}

/// Passes a value above zero and at most so great.
fn positive_to(source: &TomlSource, key: &str, value: f64, most: f64, unit: &str) -> Result<f64, FileError> {
    source.positive(key, value, unit).and_then(|value| source.within(key, value, 0.0..=most, unit))
}

/// Rates and what belongs to them.
fn check_relaxations(
    source: &TomlSource,
    key: &str,
    most: usize,
    mesh_rad_s: &[f64],
    r_k_per_w: &[f64],
    surface: Option<&[f64]>,
) -> Result<(), FileError> {
    let rates = mesh_rad_s.len();
    for others in [r_k_per_w.len(), surface.map_or(rates, <[f64]>::len)] {
        if others != rates || rates == 0 {
            return Err(source.refuse(key, format!("has {rates} rates and {others} numbers that belong to them")));
        }
    }
    let mesh_key = format!("{key}.mesh_rad_s");
    if rates > most {
        return Err(source.refuse(&mesh_key, format!("are {rates}: the board carries {most}")));
    }
    for &rate in mesh_rad_s {
        positive_to(source, &mesh_key, rate, GREATEST, "rad/s")?;
    }
    if let Some(pair) = mesh_rad_s.windows(2).find(|pair| pair[1] <= pair[0]) {
        let sentence = format!("has {} after {} rad/s: they must ascend", pair[1], pair[0]);
        return Err(source.refuse(&mesh_key, sentence));
    }
    for &r in r_k_per_w {
        source.within(&format!("{key}.r_k_per_w"), r, -GREATEST..=GREATEST, "K/W")?;
    }
    for &share in surface.unwrap_or_default() {
        source.within(&format!("{key}.surface"), share, SURFACE, "")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::head::file::Head;
    use recording::toml_file::TomlSource;

    fn fixture() -> TomlSource {
        TomlSource::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml"))
            .unwrap()
    }

    /// Sentence about the fixture with its n-th `from` replaced.
    fn refused(n: usize, from: &str, to: &str) -> String {
        let mut source = fixture();
        let (at, _) = source.text.match_indices(from).nth(n).unwrap_or_else(|| panic!("{from}"));
        let tail = source.text.split_off(at);
        source.text += &tail.replacen(from, to, 1);
        Head::from_source(source).unwrap_err().to_string()
    }

    /// The first line with this key below a heading.
    fn with(heading: &str, key: &str, value: &str) -> String {
        let mut source = fixture();
        let at = source.text.find(heading).unwrap();
        let start = at + source.text[at..].find(&format!("\n{key} = ")).unwrap() + 1;
        let end = start + source.text[start..].find('\n').unwrap();
        source.text.replace_range(start..end, &format!("{key} = {value}"));
        Head::from_source(source).unwrap_err().to_string()
    }

    #[test]
    fn what_stands_twice_or_is_missing_is_refused_by_its_key() {
        let part = "element = \"sector2\"\naxis";
        assert!(
            refused(0, part, "element = \"sector1\"\naxis")
                .contains("`calibration.surfaces[1].element` is `sector1`, which is another")
        );
        assert!(refused(0, part, "element = \"core1\"\naxis").contains("`core1`, which has no `surface`"));
        let own = refused(0, "element = \"core2\"\nrest_c", "element = \"core1\"\nrest_c");
        assert!(
            own.contains(
                "`calibration.self_heating[5].element` is `core1`, which has a [[calibration.self_heating]] already"
            ),
            "{own}"
        );
        let pair = "from = \"sector1\"\nto = \"sector3\"";
        assert!(refused(0, pair, "from = \"sector1\"\nto = \"sector2\"").contains("as another one before it"));
        assert!(refused(0, pair, "from = \"sector1\"\nto = \"sector1\"").contains("to itself"));
        let mut source = fixture();
        source.text.truncate(source.text.rfind("[[calibration.cross_heating]]").unwrap());
        let missing = Head::from_source(source).unwrap_err().to_string();
        assert!(missing.contains("lacks the pair from `core2` to `core1`"), "{missing}");
    }

    #[test]
    fn what_cannot_be_is_refused_by_its_key() {
        for (heading, key, value, said) in [
            ("[calibration]", "diameter_m", "10.0", "calibration.diameter_m"),
            ("[calibration]", "reference", "\"sector1\"\nmade_on = \"March 2026\"", "calibration.made_on"),
            ("[calibration]", "reference_gas_c", "500.0", "calibration.reference_gas_c"),
            ("[[calibration.surfaces]]", "gain", "-1.0", "calibration.surfaces[0].gain"),
            ("[[calibration.surfaces]]", "area_m2", "1e9", "calibration.surfaces[0].area_m2"),
            ("[[calibration.surfaces]]", "means", "[0.0, 0.0, 0.0, 0.0, 0.0]", "calibration.surfaces[0].means"),
            ("[[calibration.surfaces]]", "axis", "[0.0, 0.0, 0.0]", "calibration.surfaces[0]"),
            ("[[calibration.self_heating]]", "rest_c", "-400.0", "calibration.self_heating[0].rest_c"),
            ("[[calibration.self_heating]]", "noise_k", "[1e30, 1e30]", "calibration.self_heating[0].noise_k"),
            ("[[calibration.self_heating]]", "r_k_per_w", "[-1e4, 1.0, 1.0, 1.0]", "calibration.self_heating[0]"),
            (
                "[[calibration.self_heating]]",
                "mesh_rad_s",
                "[0.02, 0.01, 1.0, 2.0]",
                "calibration.self_heating[0].mesh_rad_s",
            ),
            ("[calibration.nusselt]", "least_reynolds", "4000.0", "calibration.nusselt"),
        ] {
            let sentence = with(heading, key, value);
            assert!(sentence.contains(&format!("`{said}`")), "{key} = {value}: {sentence}");
            assert!(sentence.contains(", line "), "{sentence}");
        }
    }

    #[test]
    fn uncertainties_and_conditions_are_refused_by_key_in_the_units_of_the_file() {
        let good = "[calibration.uncertainty]\nconductance_share = [0.001, 0.001, 0.001, 0.001]\nspeed_share = [0.01, 0.01, 0.01, 0.01]\n\
                    direction_deg = [1.0, 1.0, 1.0, 1.0]\nchi_square_most = 6.6\n\
                    [calibration.conditions]\ngas_c = [20.0, 21.0]\npressure_pa = [1e5, 1e5]\nsurface_c = [50.0, 50.0]\n";
        let with = |from: &str, to: &str| {
            let mut source = fixture();
            assert!(good.contains(from), "{from}");
            source.text += &good.replacen(from, to, 1);
            Head::from_source(source)
        };
        assert!(with("0.001", "0.002").unwrap().calibration.unwrap().table.conditions.is_some());
        let refused = |from: &str, to: &str| with(from, to).unwrap_err().to_string();
        for (from, to, said) in [
            (
                "direction_deg = [1.0",
                "direction_deg = [200.0",
                "`calibration.uncertainty.direction_deg` is 200 °: it must lie between 0 and 180 °",
            ),
            ("speed_share = [0.01", "speed_share = [-0.01", "`calibration.uncertainty.speed_share` is -0.01"),
            (
                "direction_deg = [1.0",
                "direction_deg = [1.0, 1.0",
                "`direction_deg`: invalid length 5, expected a list of 4",
            ),
            ("chi_square_most = 6.6", "chi_square_most = 0.5", "`calibration.uncertainty.chi_square_most` is 0.5"),
            ("gas_c = [20.0", "gas_c = [22.0", "`calibration.conditions.gas_c` must be two numbers, the least first"),
        ] {
            let sentence = refused(from, to);
            assert!(sentence.contains(said) && sentence.contains(", line "), "{sentence}");
        }
    }

    #[test]
    fn errors_name_the_key_with_its_line() {
        let mut source = fixture();
        let at = source.text.find("\ngain = ").unwrap() + 1;
        let end = at + source.text[at..].find('\n').unwrap();
        source.text.replace_range(at..end, "gain = 0.0");
        let line = 1 + source.text[..at].matches('\n').count();
        let sentence = Head::from_source(source).unwrap_err().to_string();
        assert!(sentence.contains(&format!("line {line}: `calibration.surfaces[0].gain` is 0")), "{sentence}");
    }
}
