//! One class of a model as a symbol of its own: what its loop is analysed by.
//!
//! In structure `conductance` the wind stands in the input, w = u − ΔG (T − T_gas), and the element
//! answers by H = H0/(1 + ΔG·H0). That has poles of its own, at 1 + ΔG·H0(−μ) = 0, with η = 1/(ΔG²
//! Σ η0_k/(ξ_k − μ)²), and the very zeros of H0: no wind that only cools the heated surface moves
//! the time constants of the closed loop. The temperature without heating moves too, if it was not
//! the gas's.

use super::secular;
use super::sliding_surface::{SlidingSurface, feed_through};
use crate::model::pair_class::{PairClass, name};
use crate::model::{Model, ModelError, ModelGas, ModelWind, SAME_TEMPERATURE_K, refuse_other_units};

const ABSOLUTE_ZERO_C: f64 = -273.15;

/// A class ready to be analysed.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopModel {
    /// Label of the class.
    pub label: String,
    /// The symbol in this wind.
    pub surface: SlidingSurface,
    /// The symbol without the wind in its input: `surface` itself but for structure `conductance`.
    pub structure: SlidingSurface,
    /// ΔG, W/K; 0 where the class has a symbol of its own.
    pub conductance_w_per_k: f64,
    /// g of losses that grow with temperature, W/K²; 0 without.
    pub loss_w_per_k2: f64,
    /// Temperature without heating, °C.
    pub unheated_c: f64,
    /// Temperature of the gas, °C, where the wind is a conductance.
    pub gas_c: Option<f64>,
    /// By which readings are late, s. All else is said of the temperature, not of its reading.
    pub dead_time_s: f64,
}

impl LoopModel {
    /// One class of a pair, in a gas of `gas_c` °C if that is given, of the model's own otherwise.
    ///
    /// # Errors
    /// No sliding surface, a wind under which the element would run away, an unknown gas
    /// temperature.
    pub fn of(part: &PairClass<'_>, gas_c: Option<f64>) -> Result<Self, ModelError> {
        let named = |fault| model_error!("{}, class `{}`, {fault}", name(part.pair), part.label);
        Self::build(part, gas_c).map_err(named)
    }

    fn build(part: &PairClass<'_>, gas_c: Option<f64>) -> Result<Self, ModelError> {
        refuse_other_units(part.model)?;
        let class = part.class;
        refuse_if!(class.feed_through_k_per_w != 0.0, feed_through(class.feed_through_k_per_w));
        let structure = SlidingSurface::new(&part.pair.mesh_rad_s, &class.r_k_per_w)?;
        let mut found = Self {
            label: part.label.to_owned(),
            surface: structure.clone(),
            structure,
            conductance_w_per_k: 0.0,
            loss_w_per_k2: part.loss_w_per_k2(),
            unheated_c: part.offset_c(),
            gas_c: None,
            dead_time_s: part.dead_time_s(),
        };
        let Some(wind) = &part.model.wind else {
            refuse_if!(
                gas_c.is_some(),
                model_error!("does not know of a gas: its wind is no conductance, so leave --gas-temperature out")
            );
            return Ok(found);
        };
        found.conductance_w_per_k = part.wind_w_per_k.unwrap_or(0.0);
        found.gas_c = gas_temperature_c(wind, gas_c, found.conductance_w_per_k != 0.0)?;
        found.unheated_c += followed_k(part.model, &part.pair.output, found.gas_c);
        if let (true, Some(gas_c)) = (found.conductance_w_per_k != 0.0, found.gas_c) {
            found.surface = in_wind(&found.structure, found.conductance_w_per_k)?;
            found.unheated_c -=
                found.surface.steady_gain_k_per_w * found.conductance_w_per_k * (found.unheated_c - gas_c);
        }
        Ok(found)
    }

    /// Power in W that growing losses take at a rise in K over the temperature without heating.
    pub fn lost_w(&self, rise_k: f64) -> f64 {
        self.loss_w_per_k2 * (rise_k * rise_k)
    }

    /// Where a constant power in W ends, in K: ΔT + b ΔT² = ΣR · P.
    pub fn steady_rise_k(&self, power_w: f64) -> f64 {
        let linear_k = self.surface.steady_gain_k_per_w * power_w;
        let root = (1.0 + 4.0 * self.loss_w_per_k2 * self.surface.steady_gain_k_per_w * linear_k).max(0.0).sqrt();
        2.0 * linear_k / (1.0 + root)
    }

    /// Power in W that the wind takes, beyond the reference's, from an element at a temperature in
    /// °C.
    pub fn taken_w(&self, temperature_c: f64) -> f64 {
        self.gas_c.map_or(0.0, |gas_c| self.conductance_w_per_k * (temperature_c - gas_c))
    }
}

/// The error for a low level in W that is not below the high one.
pub fn levels_descend(low_w: f64, high_w: f64) -> ModelError {
    model_error!("the low level is {low_w} W and the high level {high_w} W: the high one must be above")
}

/// The gas temperature that was given, or the model's own; `None` where nobody needs to know it.
///
/// # Errors
/// If it is missing or impossible: the rest of a sentence that begins with the model.
pub fn gas_temperature_c(wind: &ModelWind, given_c: Option<f64>, needed: bool) -> Result<Option<f64>, ModelError> {
    let own_c = match &wind.gas {
        ModelGas::ConstantC(constant_c) => Some(*constant_c),
        ModelGas::EstimatedC(estimate) => Some(estimate.value),
        ModelGas::Column(_) => wind.following.as_ref().map(|following| following.from_c),
    };
    if let Some(given_c) = given_c.filter(|given_c| *given_c <= ABSOLUTE_ZERO_C) {
        return Err(model_error!(
            "cannot be used in a gas of {given_c} °C: nothing is colder than {ABSOLUTE_ZERO_C} °C"
        ));
    }
    match (given_c.or(own_c), &wind.gas) {
        (None, ModelGas::Column(column)) if needed => Err(model_error!(
            "takes the temperature of the gas from the column `{column}` of a record, and there is none here: give it with --gas-temperature"
        )),
        (gas_c, _) => Ok(gas_c),
    }
}

/// A remark on a gas that is not the one to which the model belongs, where it does not follow its
/// gas.
///
/// The part in the wind's conductance is moved by what was given; resistances and offset are not,
/// as nothing is known of how they would.
pub fn of_another_gas(model: &Model, gas_c: Option<f64>) -> Option<String> {
    let (wind, its_c) = (model.wind.as_ref()?, gas_c?);
    if wind.following.is_some() {
        return None;
    }
    let recorded_c = model.provenance.conditions.as_ref().map(|conditions| conditions.gas_temperature_c);
    let own_c = gas_temperature_c(wind, None, false).ok()?.or(recorded_c)?;
    ((its_c - own_c).abs() > SAME_TEMPERATURE_K).then(|| {
        format!(
            "the gas is at {its_c} °C, and the model is of a gas at {own_c} °C: the model's resistances and offset are of its own record, and do not change with that",
            own_c = (1e3 * own_c).round() / 1e3
        )
    })
}

/// Part of an output that comes from a gas that differs from the one to which its offset belongs,
/// in K.
pub fn followed_k(model: &Model, output: &str, gas_c: Option<f64>) -> f64 {
    let following = model.wind.as_ref().and_then(|wind| wind.following.as_ref());
    let at = model.outputs.iter().position(|known| known.name == output);
    let (Some(following), Some(gas_c), Some(at)) = (following, gas_c, at) else { return 0.0 };
    let gain: f64 = following.outputs.get(at).map_or(0.0, |followed| followed.f_k_per_k.iter().sum());
    gain * (gas_c - following.from_c)
}

/// H0/(1 + ΔG·H0) as a symbol, for resistances of one sign.
fn in_wind(structure: &SlidingSurface, conductance_w_per_k: f64) -> Result<SlidingSurface, ModelError> {
    let (rates, eta): (Vec<f64>, Vec<f64>) = (structure.rates_rad_s.iter().zip(&structure.eta_k_per_j))
        .filter(|(_, eta)| **eta != 0.0)
        .map(|(rate, eta)| (*rate, *eta))
        .unzip();
    if eta.iter().any(|eta| *eta < 0.0) {
        return Err(model_error!(
            "is a wind on resistances of both signs, whose poles need not be real: analyse the reference, make a smaller model (`anemo model reduce --order 3`), of which resistances come out of one sign sooner, or identify with --non-negative all"
        ));
    }
    let loop_gain = conductance_w_per_k * structure.steady_gain_k_per_w;
    if loop_gain <= -1.0 {
        return Err(model_error!(
            "takes {:.3e} W/K less than the reference loses at all ({:.3e} W/K): its temperature would run away. ΔG must be above minus that",
            -conductance_w_per_k,
            1.0 / structure.steady_gain_k_per_w
        ));
    }
    let roots = secular::roots(&rates, &eta, 1.0 / conductance_w_per_k);
    let poles: Vec<f64> = roots.iter().map(|root| root.value(&rates)).collect();
    let resistance = |(root, pole): (&secular::Root, &f64)| {
        let squares: f64 = eta.iter().enumerate().map(|(k, eta)| eta / root.gap(&rates, k).powi(2)).sum();
        1.0 / (conductance_w_per_k.powi(2) * squares * pole)
    };
    let resistances: Vec<f64> = roots.iter().zip(&poles).map(resistance).collect();
    SlidingSurface::new(&poles, &resistances)
}

#[cfg(test)]
mod tests {
    use nalgebra::ComplexField as _;

    use super::super::zeros::zeros;
    use super::*;
    use crate::model::testing;

    #[test]
    fn a_wind_moves_the_poles_and_leaves_the_zeros() {
        let structure = SlidingSurface::new(&[0.05, 0.4, 3.0, 25.0], &[30.0, 8.0, 2.5, 0.4]).unwrap();
        for conductance in [0.2, 1e-6, 50.0, -0.02] {
            let loop_model = in_wind(&structure, conductance).unwrap();
            // H(0) = H0(0)/(1 + ΔG·H0(0)); Γ stays, as a wind needs time to be felt.
            let exact = 40.9 / (1.0 + conductance * 40.9);
            assert!((loop_model.steady_gain_k_per_w / exact - 1.0).abs() < 1e-12, "{conductance}");
            assert!((loop_model.gamma_k_per_j / structure.gamma_k_per_j - 1.0).abs() < 1e-12);
            for (a, b) in zeros(&structure).iter().zip(zeros(&loop_model)) {
                assert!((a.rate_rad_s / b.rate_rad_s - 1.0).modulus() < 1e-10, "{conductance} {a:?} {b:?}");
            }
        }
        assert!(in_wind(&structure, -0.025).unwrap_err().to_string().contains("run away"));
    }

    #[test]
    fn an_element_that_is_warmer_than_the_gas_without_heating_is_cooled_by_wind() {
        // 10 K/W, 0.2 W/K: H = 10/3 K/W. Gas 5 K below the offset: T = 20 − (10/3)·0.2·5.
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        let part = PairClass::find(&model, None, Some("gust")).unwrap();
        let loop_model = LoopModel::of(&part, Some(15.0)).unwrap();
        assert!((loop_model.unheated_c - (20.0 - 10.0 / 3.0)).abs() < 1e-12);
        assert_eq!(loop_model.taken_w(25.0), 2.0);
        assert!((loop_model.surface.rates_rad_s[0] - 0.5 * 3.0).abs() < 1e-12);
    }

    #[test]
    fn another_gas_than_the_models_is_said_unless_it_is_followed() {
        let mut model = testing::model(&[0.5], &[10.0]);
        assert_eq!(of_another_gas(&model, Some(15.0)), None);
        testing::add_wind(&mut model, "gust", 0.2);
        assert_eq!((of_another_gas(&model, Some(20.4)), of_another_gas(&model, None)), (None, None));
        let said = of_another_gas(&model, Some(15.0)).unwrap();
        assert!(said.starts_with("the gas is at 15 °C, and the model is of a gas at 20 °C: "), "{said}");
        // A column that was not followed: the record's own conditions tell, if anything does.
        model.wind.as_mut().unwrap().gas = ModelGas::Column("gas_c".to_owned());
        assert_eq!(of_another_gas(&model, Some(15.0)), None);
        model.provenance.conditions = Some(crate::model::Conditions {
            species: "air".to_owned(),
            pressure_pa: 1e5,
            gas_temperature_c: 20.0,
            support_temperature_c: 20.0,
        });
        assert!(of_another_gas(&model, Some(15.0)).is_some());
        testing::follow_gas(&mut model, 18.0);
        assert_eq!(of_another_gas(&model, Some(15.0)), None);
    }

    #[test]
    fn an_unknown_gas_and_a_feed_through_are_refused_in_words() {
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        model.wind.as_mut().unwrap().gas = ModelGas::Column("gas_c".to_owned());
        let of = |model: &Model, class| LoopModel::of(&PairClass::find(model, None, Some(class)).unwrap(), None);
        assert!(of(&model, "still").is_ok());
        let frozen =
            LoopModel::of(&PairClass::find(&model, None, Some("gust")).unwrap(), Some(-300.0)).unwrap_err().to_string();
        assert!(frozen.contains("gas of -300 °C: nothing is colder than -273.15 °C"), "{frozen}");
        assert!(
            of(&model, "gust")
                .unwrap_err()
                .to_string()
                .contains("`gas_c` of a record, and there is none here: give it with --gas-temperature")
        );
        let plain = testing::model(&[0.5], &[10.0]);
        let gas = LoopModel::of(&PairClass::find(&plain, None, None).unwrap(), Some(15.0)).unwrap_err().to_string();
        assert!(gas.contains("leave --gas-temperature out"), "{gas}");
        model.pairs[0].classes.get_mut("still").unwrap().feed_through_k_per_w = 3.0;
        assert!(of(&model, "still").unwrap_err().to_string().contains("follows the power at once by 3 K/W"));
    }
}
