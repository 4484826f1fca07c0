//! Checks of a calibration before the board gets it: nothing twice, nothing missing, all numbers of
//! a possible size.
//!
//! Refusals name the key and line of the file. The board's own checks follow, and know neither.

use std::f64::consts::PI;

use dr_core::model::ORDER;
use dr_core::model::convection_observer::config::CROSS_ORDER;
use dr_core::wind::{Nusselt, NusseltConfig, SphereSurface};

use super::keys::CalibrationKeys;
use super::table::CalibrationTable;
use crate::gas::{TEMPERATURE_RANGE_K, ZERO_CELSIUS_K};
use crate::network::parameters::{CrossHeatingParameters, SelfHeatingParameters};
use recording::toml_file::FileError;

/// Temperatures of a gas whose properties are known, °C.
pub(super) const GAS_C: std::ops::RangeInclusive<f64> =
    *TEMPERATURE_RANGE_K.start() - ZERO_CELSIUS_K..=*TEMPERATURE_RANGE_K.end() - ZERO_CELSIUS_K;
/// Temperatures at rest, °C: from absolute zero to where no platinum thermometer is.
const REST_C: std::ops::RangeInclusive<f64> = -273.15..=1000.0;
/// A noisier reading is none, K.
const MOST_NOISE_K: f64 = 100.0;
/// Rates in rad/s and resistances in K/W are not greater than this.
const GREATEST: f64 = 1e6;
/// As the board takes them.
const DIAMETER_M: std::ops::RangeInclusive<f64> = 1e-4..=1.0;
const GAIN: std::ops::RangeInclusive<f64> = 0.1..=10.0;
const QUIESCENT_W_K: std::ops::RangeInclusive<f64> = 0.0..=1e3;
const SURFACE: std::ops::RangeInclusive<f64> = -10.0..=10.0;

/// A calibration with the places of its elements in the head.
pub(super) struct CalibrationChecks<'a> {
    pub keys: CalibrationKeys<'a>,
    pub table: &'a CalibrationTable,
    pub reference: Option<usize>,
    pub surfaces: &'a [usize],
    pub own: &'a [SelfHeatingParameters],
    pub cross: &'a [CrossHeatingParameters],
}

impl CalibrationChecks<'_> {
    pub(super) fn check(&self) -> Result<(), FileError> {
        self.numbers()?;
        self.own()?;
        self.cross()?;
        self.surfaces()?;
        self.curves()
    }

    fn numbers(&self) -> Result<(), FileError> {
        let Self { keys, table, .. } = self;
        keys.within("calibration.diameter_m", table.diameter_m, DIAMETER_M, "m")?;
        keys.within("calibration.reference_gas_c", table.reference_gas_c, GAS_C, "°C")?;
        if let Some(reference) = self.reference
            && self.knows(reference)
        {
            let name = table.reference.as_deref().unwrap_or_default();
            let sentence = format!(
                "is `{name}`, which is heated: it has a {}, and cannot measure the gas",
                keys.heading("self_heating")
            );
            return Err(keys.refuse("calibration.reference", sentence));
        }
        Ok(())
    }

    fn own(&self) -> Result<(), FileError> {
        for (i, (of, own)) in self.table.self_heating.iter().zip(self.own).enumerate() {
            let key = format!("calibration.self_heating[{i}]");
            if self.own.iter().take(i).any(|before| before.element == own.element) {
                let sentence = format!("is `{}`, which has a {} already", own.name, self.keys.heading("self_heating"));
                return Err(self.keys.refuse(&format!("{key}.element"), sentence));
            }
            self.keys.within(&format!("{key}.rest_c"), own.rest_c, REST_C, "°C")?;
            for noise_k in of.noise_k {
                self.keys.within(&format!("{key}.noise_k"), noise_k, 0.0..=MOST_NOISE_K, "K")?;
            }
            self.relaxations(&key, ORDER, &own.mesh_rad_s, &own.r_k_per_w, own.surface.as_deref())?;
            let surface = |k: usize| own.surface.as_ref().map_or(1.0, |shares| shares[k]);
            let steady_k_per_w: f64 = own.r_k_per_w.iter().enumerate().map(|(k, r)| r * surface(k)).sum();
            if steady_k_per_w <= 0.0 {
                let sentence = format!("has a steady gain of {steady_k_per_w} K/W: heating must make it warmer");
                return Err(self.keys.refuse(&key, sentence));
            }
        }
        Ok(())
    }

    fn cross(&self) -> Result<(), FileError> {
        for (i, (of, cross)) in self.table.cross_heating.iter().zip(self.cross).enumerate() {
            let key = format!("calibration.cross_heating[{i}]");
            let refuse = |sentence: String| Err(self.keys.refuse(&key, sentence));
            if cross.from == cross.to {
                return refuse(format!(
                    "is from `{}` to itself: that is {}",
                    of.from,
                    self.keys.heading("self_heating")
                ));
            }
            for (name, element) in [(&of.from, cross.from), (&of.to, cross.to)] {
                if !self.knows(element) {
                    return refuse(format!("names `{name}`, which has no {}", self.keys.heading("self_heating")));
                }
            }
            let pair = (cross.from, cross.to);
            if self.cross.iter().take(i).any(|before| (before.from, before.to) == pair) {
                return refuse(format!("is from `{}` to `{}`, as another one before it", of.from, of.to));
            }
            self.relaxations(&key, CROSS_ORDER, &cross.mesh_rad_s, &cross.r_k_per_w, Some(&cross.surface))?;
        }
        for from in self.own {
            for to in self.own.iter().filter(|to| to.element != from.element) {
                if !self.cross.iter().any(|cross| (cross.from, cross.to) == (from.element, to.element)) {
                    let sentence = format!("lacks the pair from `{}` to `{}`", from.name, to.name);
                    return Err(self.keys.refuse("calibration.cross_heating", sentence));
                }
            }
        }
        Ok(())
    }

    /// Rates and what belongs to them.
    fn relaxations(
        &self,
        key: &str,
        most: usize,
        mesh_rad_s: &[f64],
        r_k_per_w: &[f64],
        surface: Option<&[f64]>,
    ) -> Result<(), FileError> {
        let keys = self.keys;
        if mesh_rad_s.len() > most {
            let sentence = format!("are {}: the board carries {most}", mesh_rad_s.len());
            return Err(keys.refuse(&format!("{key}.mesh_rad_s"), sentence));
        }
        for &rate in mesh_rad_s {
            keys.positive(&format!("{key}.mesh_rad_s"), rate, "rad/s")?;
            keys.within(&format!("{key}.mesh_rad_s"), rate, 0.0..=GREATEST, "rad/s")?;
        }
        if let Some(pair) = mesh_rad_s.windows(2).find(|pair| pair[1] <= pair[0]) {
            let sentence = format!("has {} after {} rad/s: they must ascend", pair[1], pair[0]);
            return Err(keys.refuse(&format!("{key}.mesh_rad_s"), sentence));
        }
        for &r in r_k_per_w {
            keys.within(&format!("{key}.r_k_per_w"), r, -GREATEST..=GREATEST, "K/W")?;
        }
        for &share in surface.unwrap_or_default() {
            keys.within(&format!("{key}.surface"), share, SURFACE, "")?;
        }
        Ok(())
    }

    fn surfaces(&self) -> Result<(), FileError> {
        let keys = self.keys;
        let heading = keys.heading("self_heating");
        let most_m2 = PI * self.table.diameter_m * self.table.diameter_m;
        for (i, (of, element)) in self.table.surfaces.iter().zip(self.surfaces).enumerate() {
            let key = format!("calibration.surfaces[{i}]");
            let refuse = |sentence: String| Err(keys.refuse(&format!("{key}.element"), sentence));
            if self.surfaces.iter().take(i).any(|before| before == element) {
                return refuse(format!("is `{}`, which is another surface's already", of.element));
            }
            match self.own.iter().find(|own| own.element == *element) {
                None => return refuse(format!("is `{}`, which has no {heading}", of.element)),
                Some(own) if own.surface.is_none() => {
                    return refuse(format!(
                        "is `{}`, which has no `surface` in its {heading}, and so no wind cools it",
                        of.element
                    ));
                }
                Some(_) => {}
            }
            keys.within(&format!("{key}.gain"), of.gain, GAIN, "")?;
            keys.within(&format!("{key}.quiescent_w_k"), of.quiescent_w_k, QUIESCENT_W_K, "W/K")?;
            keys.positive(&format!("{key}.area_m2"), of.area_m2, "m²")?;
            keys.within(&format!("{key}.area_m2"), of.area_m2, 0.0..=most_m2, "m²")?;
            SphereSurface::new(&of.surface()).map_err(|error| keys.refuse(&key, format!("cannot be used: {error}")))?;
            if self.table.nusselt.is_some() && of.means[0] <= 0.0 {
                let sentence = format!("begins with {}: a surface of a sphere faces its own axis", of.means[0]);
                return Err(keys.refuse(&format!("{key}.means"), sentence));
            }
        }
        Ok(())
    }

    fn curves(&self) -> Result<(), FileError> {
        let Some(nusselt) = &self.table.nusselt else { return Ok(()) };
        let rows = nusselt.amplitudes.iter().map(|row| row.map(|a| a as f32));
        let Ok(amplitudes) = <[_; _]>::try_from(rows.collect::<Vec<_>>()) else { return Ok(()) };
        let (least_reynolds, most_reynolds) = (nusselt.least_reynolds as f32, nusselt.most_reynolds as f32);
        let made = Nusselt::new(&NusseltConfig { least_reynolds, most_reynolds, amplitudes });
        made.map(drop).map_err(|error| self.keys.refuse("calibration.nusselt", format!("cannot be used: {error}")))
    }

    fn knows(&self, element: usize) -> bool {
        self.own.iter().any(|own| own.element == element)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::head::file::Head;
    use recording::toml_file::TomlSource;

    fn fixture() -> TomlSource {
        TomlSource::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml"))
            .unwrap()
    }

    /// What is said of the fixture with its n-th `from` replaced.
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
                .contains("`calibration.parts[1].element` is `sector1`, which is another")
        );
        assert!(refused(0, part, "element = \"core1\"\naxis").contains("`core1`, which has no `surface`"));
        let own = refused(0, "element = \"core2\"\nrest_c", "element = \"core1\"\nrest_c");
        assert!(
            own.contains("`calibration.own[5].element` is `core1`, which has a [[calibration.own]] already"),
            "{own}"
        );
        let pair = "from = \"sector1\"\nto = \"sector3\"";
        assert!(refused(0, pair, "from = \"sector1\"\nto = \"sector2\"").contains("as another one before it"));
        assert!(refused(0, pair, "from = \"sector1\"\nto = \"sector1\"").contains("to itself"));
        let mut source = fixture();
        source.text.truncate(source.text.rfind("[[calibration.cross]]").unwrap());
        let missing = Head::from_source(source).unwrap_err().to_string();
        assert!(missing.contains("lacks the pair from `core2` to `core1`"), "{missing}");
    }

    #[test]
    fn what_cannot_be_is_refused_by_its_key() {
        for (heading, key, value, said) in [
            ("[calibration]", "diameter_m", "10.0", "calibration.diameter_m"),
            ("[calibration]", "reference_gas_c", "500.0", "calibration.reference_gas_c"),
            ("[[calibration.parts]]", "gain", "-1.0", "calibration.parts[0].gain"),
            ("[[calibration.parts]]", "area_m2", "1e9", "calibration.parts[0].area_m2"),
            ("[[calibration.parts]]", "means", "[0.0, 0.0, 0.0, 0.0, 0.0]", "calibration.parts[0].means"),
            ("[[calibration.parts]]", "axis", "[0.0, 0.0, 0.0]", "calibration.parts[0]"),
            ("[[calibration.own]]", "rest_c", "-400.0", "calibration.own[0].rest_c"),
            ("[[calibration.own]]", "noise_k", "[1e30, 1e30]", "calibration.own[0].noise_k"),
            ("[[calibration.own]]", "r_k_per_w", "[-1e4, 1.0, 1.0, 1.0]", "calibration.own[0]"),
            ("[[calibration.own]]", "mesh_rad_s", "[0.02, 0.01, 1.0, 2.0]", "calibration.own[0].mesh_rad_s"),
            ("[calibration.nusselt]", "least_reynolds", "4000.0", "calibration.nusselt"),
        ] {
            let sentence = with(heading, key, value);
            assert!(sentence.contains(&format!("`{said}`")), "{key} = {value}: {sentence}");
            assert!(sentence.contains(", line "), "{sentence}");
        }
    }

    /// The fixture, which has the keys from before version 0.2, with today's.
    fn renamed() -> TomlSource {
        let mut source = fixture();
        for (old, new) in [
            ("[[calibration.parts]]", "[[calibration.surfaces]]"),
            ("[[calibration.own]]", "[[calibration.self_heating]]"),
            ("[[calibration.cross]]", "[[calibration.cross_heating]]"),
            ("windless_w_k", "quiescent_w_k"),
        ] {
            assert!(source.text.contains(old), "{old}");
            source.text = source.text.replace(old, new);
        }
        source
    }

    #[test]
    fn a_head_is_read_with_old_keys_and_with_todays() {
        let calibration = |source: TomlSource| Head::from_source(source).unwrap().calibration.unwrap();
        assert_eq!(calibration(fixture()), calibration(renamed()));
    }

    #[test]
    fn errors_name_the_key_as_the_file_has_it_with_its_line() {
        for (mut source, key) in [(fixture(), "calibration.parts[0].gain"), (renamed(), "calibration.surfaces[0].gain")]
        {
            let at = source.text.find("\ngain = ").unwrap() + 1;
            let end = at + source.text[at..].find('\n').unwrap();
            source.text.replace_range(at..end, "gain = 0.0");
            let line = 1 + source.text[..at].matches('\n').count();
            let sentence = Head::from_source(source).unwrap_err().to_string();
            assert!(sentence.contains(&format!("line {line}: `{key}` is 0")), "{sentence}");
        }
    }
}
