//! What a calibration must be for the board to be told of it: once each, complete, and of sizes that can be.
//!
//! Each is refused here by the file's own key and line. The board's own checks follow, and know neither.

use std::f64::consts::PI;

use dr_core::model::ORDER;
use dr_core::model::network::CROSS_ORDER;
use dr_core::sensor::wind::{Nusselt, NusseltConfig, Part};

use super::{CalibrationTable, GAS_C};
use crate::network::windless::{Cross, Own};
use crate::toml_file::{FileError, Source};

/// Temperatures at rest, °C: from absolute zero to where no platinum thermometer is.
const REST_C: std::ops::RangeInclusive<f64> = -273.15..=1000.0;
/// A reading that is noisier tells nothing, K.
const MOST_NOISE_K: f64 = 100.0;
/// Rates in rad/s and resistances in K/W are not greater than this.
const GREATEST: f64 = 1e6;
/// As the board takes them.
const DIAMETER_M: std::ops::RangeInclusive<f64> = 1e-4..=1.0;
const GAIN: std::ops::RangeInclusive<f64> = 0.1..=10.0;
const WINDLESS_W_K: std::ops::RangeInclusive<f64> = 0.0..=1e3;
const SURFACE: std::ops::RangeInclusive<f64> = -10.0..=10.0;

/// A calibration with the places of its elements in the head.
pub(super) struct Checked<'a> {
    pub source: &'a Source,
    pub table: &'a CalibrationTable,
    pub reference: Option<usize>,
    pub parts: &'a [usize],
    pub own: &'a [Own],
    pub cross: &'a [Cross],
}

impl Checked<'_> {
    pub(super) fn check(&self) -> Result<(), FileError> {
        self.numbers()?;
        self.own()?;
        self.cross()?;
        self.parts()?;
        self.curves()
    }

    fn numbers(&self) -> Result<(), FileError> {
        let Self { source, table, .. } = self;
        source.within("calibration.diameter_m", table.diameter_m, DIAMETER_M, "m")?;
        source.within("calibration.reference_gas_c", table.reference_gas_c, GAS_C, "°C")?;
        if let Some(reference) = self.reference
            && self.knows(reference)
        {
            let name = table.reference.as_deref().unwrap_or_default();
            let sentence =
                format!("is `{name}`, which is heated: it has a [[calibration.own]], and cannot measure the gas");
            return Err(source.refuse("calibration.reference", sentence));
        }
        Ok(())
    }

    fn own(&self) -> Result<(), FileError> {
        for (i, (of, own)) in self.table.own.iter().zip(self.own).enumerate() {
            let key = format!("calibration.own[{i}]");
            if self.own.iter().take(i).any(|before| before.element == own.element) {
                let sentence = format!("is `{}`, which has a [[calibration.own]] already", own.name);
                return Err(self.source.refuse(&format!("{key}.element"), sentence));
            }
            self.source.within(&format!("{key}.rest_c"), own.rest_c, REST_C, "°C")?;
            for noise_k in of.noise_k {
                self.source.within(&format!("{key}.noise_k"), noise_k, 0.0..=MOST_NOISE_K, "K")?;
            }
            self.relaxations(&key, ORDER, &own.mesh_rad_s, &own.r_k_per_w, own.surface.as_deref())?;
            let surface = |k: usize| own.surface.as_ref().map_or(1.0, |shares| shares[k]);
            let steady_k_per_w: f64 = own.r_k_per_w.iter().enumerate().map(|(k, r)| r * surface(k)).sum();
            if steady_k_per_w <= 0.0 {
                let sentence = format!("has a steady gain of {steady_k_per_w} K/W: heating must make it warmer");
                return Err(self.source.refuse(&key, sentence));
            }
        }
        Ok(())
    }

    fn cross(&self) -> Result<(), FileError> {
        for (i, (of, cross)) in self.table.cross.iter().zip(self.cross).enumerate() {
            let key = format!("calibration.cross[{i}]");
            let refuse = |sentence: String| Err(self.source.refuse(&key, sentence));
            if cross.from == cross.to {
                return refuse(format!("is from `{}` to itself: that is [[calibration.own]]", of.from));
            }
            for (name, element) in [(&of.from, cross.from), (&of.to, cross.to)] {
                if !self.knows(element) {
                    return refuse(format!("names `{name}`, which has no [[calibration.own]]"));
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
                    return Err(self.source.refuse("calibration.cross", sentence));
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
        let source = self.source;
        if mesh_rad_s.len() > most {
            let sentence = format!("are {}: the board carries {most}", mesh_rad_s.len());
            return Err(source.refuse(&format!("{key}.mesh_rad_s"), sentence));
        }
        for &rate in mesh_rad_s {
            source.positive(&format!("{key}.mesh_rad_s"), rate, "rad/s")?;
            source.within(&format!("{key}.mesh_rad_s"), rate, 0.0..=GREATEST, "rad/s")?;
        }
        if let Some(pair) = mesh_rad_s.windows(2).find(|pair| pair[1] <= pair[0]) {
            let sentence = format!("has {} after {} rad/s: they must ascend", pair[1], pair[0]);
            return Err(source.refuse(&format!("{key}.mesh_rad_s"), sentence));
        }
        for &r in r_k_per_w {
            source.within(&format!("{key}.r_k_per_w"), r, -GREATEST..=GREATEST, "K/W")?;
        }
        for &share in surface.unwrap_or_default() {
            source.within(&format!("{key}.surface"), share, SURFACE, "")?;
        }
        Ok(())
    }

    fn parts(&self) -> Result<(), FileError> {
        let source = self.source;
        let most_m2 = PI * self.table.diameter_m * self.table.diameter_m;
        for (i, (part, element)) in self.table.parts.iter().zip(self.parts).enumerate() {
            let key = format!("calibration.parts[{i}]");
            let refuse = |sentence: String| Err(source.refuse(&format!("{key}.element"), sentence));
            if self.parts.iter().take(i).any(|before| before == element) {
                return refuse(format!("is `{}`, which is another part's already", part.element));
            }
            match self.own.iter().find(|own| own.element == *element) {
                None => return refuse(format!("is `{}`, which has no [[calibration.own]]", part.element)),
                Some(own) if own.surface.is_none() => {
                    let sentence = "has no `surface` in its [[calibration.own]], and so no wind cools it";
                    return refuse(format!("is `{}`, which {sentence}", part.element));
                }
                Some(_) => {}
            }
            source.within(&format!("{key}.gain"), part.gain, GAIN, "")?;
            source.within(&format!("{key}.windless_w_k"), part.windless_w_k, WINDLESS_W_K, "W/K")?;
            source.positive(&format!("{key}.area_m2"), part.area_m2, "m²")?;
            source.within(&format!("{key}.area_m2"), part.area_m2, 0.0..=most_m2, "m²")?;
            Part::new(&part.surface()).map_err(|error| source.refuse(&key, format!("cannot be used: {error}")))?;
            if self.table.nusselt.is_some() && part.means[0] <= 0.0 {
                let sentence = format!("begins with {}: a part of a sphere faces its own axis", part.means[0]);
                return Err(source.refuse(&format!("{key}.means"), sentence));
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
        made.map(drop).map_err(|error| self.source.refuse("calibration.nusselt", format!("cannot be used: {error}")))
    }

    fn knows(&self, element: usize) -> bool {
        self.own.iter().any(|own| own.element == element)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::super::Head;
    use super::*;

    fn fixture() -> Source {
        Source::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml")).unwrap()
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
}
