//! One class of a model as a symbol of its own: what its loop is analysed by.
//!
//! In structure `conductance` the wind stands in the input, w = u − ΔG (T − T_gas), and the element answers by H = H0/(1 + ΔG·H0). That
//! has poles of its own, at 1 + ΔG·H0(−μ) = 0, with η = 1/(ΔG² Σ η0_k/(ξ_k − μ)²), and the very zeros of H0: no wind that only cools the
//! heated surface moves the time constants of the closed loop. The temperature without heating moves too, if it was not the gas's.

use super::plane::{Plane, PlaneError};
use super::secular;
use crate::model::export::part::{Part, name};
use crate::model::{Gas, Model, SAME_TEMPERATURE_K, Wind};

const ABSOLUTE_ZERO_C: f64 = -273.15;

/// A class ready to be analysed.
#[derive(Debug, Clone, PartialEq)]
pub struct Windy {
    pub label: String,
    /// The symbol in this wind.
    pub plane: Plane,
    /// The symbol without the wind in its input: `plane` itself but for structure `conductance`.
    pub structure: Plane,
    /// ΔG, W/K; 0 where the class has a symbol of its own.
    pub conductance_w_per_k: f64,
    /// Temperature without heating, °C.
    pub unheated_c: f64,
    /// Temperature of the gas, °C, where the wind is a conductance.
    pub gas_c: Option<f64>,
    /// By which readings are late, s. All else is said of the temperature, not of its reading.
    pub dead_time_s: f64,
}

impl Windy {
    /// One class of a pair, in a gas of `gas_c` °C if that is given, of the model's own otherwise.
    ///
    /// # Errors
    /// A sentence: no sliding surface, a wind under which the element would run away, an unknown gas temperature.
    pub fn of(part: &Part<'_>, gas_c: Option<f64>) -> Result<Self, String> {
        let refuse = |error: &dyn std::fmt::Display| format!("{}, class `{}`, {error}", name(part.pair), part.label);
        let class = part.class;
        if class.feed_through_k_per_w != 0.0 {
            return Err(refuse(&PlaneError::FeedThrough(class.feed_through_k_per_w)));
        }
        let structure = Plane::new(&part.pair.mesh_rad_s, &class.r_k_per_w).map_err(|error| refuse(&error))?;
        let mut unheated_c = part.offset_c();
        let Some(wind) = &part.model.wind else {
            if gas_c.is_some() {
                return Err(refuse(
                    &"does not know of a gas: its wind is no conductance, so leave --gas-temperature out",
                ));
            }
            let plane = structure.clone();
            let label = part.label.to_owned();
            let dead_time_s = part.dead_time_s();
            return Ok(Self {
                label,
                plane,
                structure,
                conductance_w_per_k: 0.0,
                unheated_c,
                gas_c: None,
                dead_time_s,
            });
        };
        let conductance_w_per_k = part.wind_w_per_k.unwrap_or(0.0);
        let gas_c = gas_temperature_c(wind, gas_c, conductance_w_per_k != 0.0).map_err(|error| refuse(&error))?;
        unheated_c += followed_k(part.model, &part.pair.output, gas_c);
        let mut plane = structure.clone();
        if let (true, Some(gas_c)) = (conductance_w_per_k != 0.0, gas_c) {
            plane = in_wind(&structure, conductance_w_per_k).map_err(|error| refuse(&error))?;
            unheated_c -= plane.steady_gain_k_per_w() * conductance_w_per_k * (unheated_c - gas_c);
        }
        let (label, dead_time_s) = (part.label.to_owned(), part.dead_time_s());
        Ok(Self { label, plane, structure, conductance_w_per_k, unheated_c, gas_c, dead_time_s })
    }

    /// Power in W that the wind takes, beyond the reference's, from an element at a temperature in °C.
    pub fn taken_w(&self, temperature_c: f64) -> f64 {
        self.gas_c.map_or(0.0, |gas_c| self.conductance_w_per_k * (temperature_c - gas_c))
    }
}

/// The gas that was asked for, or the model's own; `None` where nobody needs to know it.
pub fn gas_temperature_c(wind: &Wind, given_c: Option<f64>, needed: bool) -> Result<Option<f64>, String> {
    let own_c = match &wind.gas {
        Gas::ConstantC(constant_c) => Some(*constant_c),
        Gas::EstimatedC(estimate) => Some(estimate.value),
        Gas::Column(_) => wind.following.as_ref().map(|following| following.from_c),
    };
    if let Some(given_c) = given_c.filter(|given_c| *given_c <= ABSOLUTE_ZERO_C) {
        return Err(format!("cannot be used in a gas of {given_c} °C: nothing is colder than {ABSOLUTE_ZERO_C} °C"));
    }
    match (given_c.or(own_c), &wind.gas) {
        (None, Gas::Column(column)) if needed => Err(format!(
            "takes the temperature of the gas from the column `{column}` of a record, and there is none here: give it with --gas-temperature"
        )),
        (gas_c, _) => Ok(gas_c),
    }
}

/// A remark on a gas that is not the one to which the model belongs, where it does not follow its gas.
///
/// The part in the wind's conductance is moved by what was given; resistances and offset are not, as nothing tells how they would.
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

/// What an output has of a gas that differs from the one to which its offset belongs, in K.
pub fn followed_k(model: &Model, output: &str, gas_c: Option<f64>) -> f64 {
    let following = model.wind.as_ref().and_then(|wind| wind.following.as_ref());
    let at = model.outputs.iter().position(|known| known.name == output);
    let (Some(following), Some(gas_c), Some(at)) = (following, gas_c, at) else { return 0.0 };
    let gain: f64 = following.outputs.get(at).map_or(0.0, |followed| followed.f_k_per_k.iter().sum());
    gain * (gas_c - following.from_c)
}

/// H0/(1 + ΔG·H0) as a symbol, for resistances of one sign.
fn in_wind(structure: &Plane, conductance_w_per_k: f64) -> Result<Plane, String> {
    let (rates, eta): (Vec<f64>, Vec<f64>) = (structure.rates_rad_s().iter().zip(structure.eta_k_per_j()))
        .filter(|(_, eta)| **eta != 0.0)
        .map(|(rate, eta)| (*rate, *eta))
        .unzip();
    if eta.iter().any(|eta| *eta < 0.0) {
        return Err("is a wind on resistances of both signs, whose poles need not be real: analyse the reference, make a smaller model (`anemo reduce --order 3`), of which resistances come out of one sign sooner, or identify with --non-negative all".to_owned());
    }
    let loop_gain = conductance_w_per_k * structure.steady_gain_k_per_w();
    if loop_gain <= -1.0 {
        return Err(format!(
            "takes {:.3e} W/K less than the reference loses at all ({:.3e} W/K): its temperature would run away. ΔG must be above minus that",
            -conductance_w_per_k,
            1.0 / structure.steady_gain_k_per_w()
        ));
    }
    let roots = secular::roots(&rates, &eta, 1.0 / conductance_w_per_k);
    let poles: Vec<f64> = roots.iter().map(|root| root.value(&rates)).collect();
    let resistance = |(root, pole): (&secular::Root, &f64)| {
        let squares: f64 = eta.iter().enumerate().map(|(k, eta)| eta / root.gap(&rates, k).powi(2)).sum();
        1.0 / (conductance_w_per_k.powi(2) * squares * pole)
    };
    let resistances: Vec<f64> = roots.iter().zip(&poles).map(resistance).collect();
    Plane::new(&poles, &resistances).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::super::zeros::zeros;
    use super::*;
    use crate::model::export::testing;

    #[test]
    fn a_wind_moves_the_poles_and_leaves_the_zeros() {
        let structure = Plane::new(&[0.05, 0.4, 3.0, 25.0], &[30.0, 8.0, 2.5, 0.4]).unwrap();
        for conductance in [0.2, 1e-6, 50.0, -0.02] {
            let windy = in_wind(&structure, conductance).unwrap();
            // H(0) = H0(0)/(1 + ΔG·H0(0)); Γ stays, as a wind needs time to be felt.
            let exact = 40.9 / (1.0 + conductance * 40.9);
            assert!((windy.steady_gain_k_per_w() / exact - 1.0).abs() < 1e-12, "{conductance}");
            assert!((windy.gamma_k_per_j() / structure.gamma_k_per_j() - 1.0).abs() < 1e-12);
            for (a, b) in zeros(&structure).iter().zip(zeros(&windy)) {
                assert!((a.rate_rad_s / b.rate_rad_s - 1.0).norm() < 1e-10, "{conductance} {a:?} {b:?}");
            }
        }
        assert!(in_wind(&structure, -0.025).unwrap_err().contains("run away"));
    }

    #[test]
    fn an_element_that_is_warmer_than_the_gas_without_heating_is_cooled_by_wind() {
        // 10 K/W, 0.2 W/K: H = 10/3 K/W. Gas 5 K below the offset: T = 20 − (10/3)·0.2·5.
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        let part = Part::find(&model, None, Some("gust")).unwrap();
        let windy = Windy::of(&part, Some(15.0)).unwrap();
        assert!((windy.unheated_c - (20.0 - 10.0 / 3.0)).abs() < 1e-12);
        assert_eq!(windy.taken_w(25.0), 2.0);
        assert!((windy.plane.rates_rad_s()[0] - 0.5 * 3.0).abs() < 1e-12);
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
        model.wind.as_mut().unwrap().gas = Gas::Column("gas_c".to_owned());
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
        model.wind.as_mut().unwrap().gas = Gas::Column("gas_c".to_owned());
        let of = |model: &Model, class| Windy::of(&Part::find(model, None, Some(class)).unwrap(), None);
        assert!(of(&model, "still").is_ok());
        let frozen = Windy::of(&Part::find(&model, None, Some("gust")).unwrap(), Some(-300.0)).unwrap_err();
        assert!(frozen.contains("gas of -300 °C: nothing is colder than -273.15 °C"), "{frozen}");
        assert!(
            of(&model, "gust")
                .unwrap_err()
                .contains("`gas_c` of a record, and there is none here: give it with --gas-temperature")
        );
        let plain = testing::model(&[0.5], &[10.0]);
        let gas = Windy::of(&Part::find(&plain, None, None).unwrap(), Some(15.0)).unwrap_err();
        assert!(gas.contains("leave --gas-temperature out"), "{gas}");
        model.pairs[0].classes.get_mut("still").unwrap().feed_through_k_per_w = 3.0;
        assert!(of(&model, "still").unwrap_err().contains("follows the power at once by 3 K/W"));
    }
}
