//! Summary of a run, for people and as JSON.

use std::fmt;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::error::EarlyEnd;
use super::start::SetPointJudgement;
use anemometry::wind::tally::EstimateSummary;

/// Summary of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct RunSummary {
    /// Title of the experiment.
    pub title: String,
    /// Name of the head.
    pub head: String,
    /// Who ran it: name and version of the firmware, or of this program.
    pub firmware: String,
    /// Rows of the recording.
    pub ticks: u32,
    /// Length of the run, s: that of the experiment, or up to the last row if it ended early.
    pub duration_s: f64,
    /// Ticks that happened, but of which no sample arrived.
    pub lost: u32,
    /// Frames that arrived damaged.
    pub damaged: u32,
    /// Ticks for which the board was late.
    pub late: u32,
    /// All trips, in the order of time.
    pub trips: Vec<TripSummary>,
    /// Cause of its early end; left out if nothing did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<EarlyEnd>,
    /// Hash of all states, temperatures and bits, where the instrument shows them all.
    pub hash: Option<String>,
    /// Hash of all states of the anemometer and all its estimates; left out for heads without a
    /// calibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind_hash: Option<String>,
    /// Judgement of its set-points, by the models.
    #[serde(flatten)]
    pub judgement: SetPointJudgement,
    /// Ticks in winds beyond what is known of convection, when simulated.
    pub extrapolated: Option<u32>,
    /// Validity, in words.
    #[serde(skip)]
    pub validity: &'static str,
    /// Elements that never came within 0.1 K of a set-point, the first or one of a change.
    pub unreached: Vec<String>,
    /// The wind estimates of a calibrated head; left out for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind: Option<EstimateSummary>,
    /// Means by element, in the order of the head.
    #[serde(serialize_with = "by_name")]
    pub elements: Vec<ElementSummary>,
}

/// One trip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TripSummary {
    /// When, s after the start.
    pub time_s: f64,
    /// Cause of the trip.
    pub cause: &'static str,
    /// The element, or the whole instrument.
    pub element: String,
}

/// Means of one element over the whole run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElementSummary {
    /// Name of the element.
    #[serde(skip)]
    pub name: String,
    /// Over the good readings; `None` if there was none.
    pub mean_temperature_c: Option<f64>,
    /// Mean power, W.
    pub mean_power_w: f64,
}

fn by_name<S: Serializer>(elements: &[ElementSummary], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(elements.len()))?;
    for element in elements {
        map.serialize_entry(&element.name, element)?;
    }
    map.end()
}

impl fmt::Display for RunSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} · head {} · {}", self.title, self.head, self.firmware)?;
        write!(f, "{} ticks, {} s; {} lost", self.ticks, self.duration_s, self.lost)?;
        for (count, what) in [(self.damaged, "frames damaged"), (self.late, "ticks late")] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        writeln!(f)?;
        if let Some(hash) = &self.hash {
            writeln!(f, "hash of all states, temperatures and bits: {hash}")?;
        }
        if let Some(hash) = &self.wind_hash {
            writeln!(f, "hash of all estimates of the wind: {hash}")?;
        }
        if let Some(ticks @ 1..) = self.extrapolated {
            let share = 100.0 * f64::from(ticks) / f64::from(self.ticks.max(1));
            writeln!(f, "in {ticks} ticks ({share:.0} %) the wind was beyond {}", self.validity)?;
        }
        if let unjudged @ 1.. = self.judgement.unjudged {
            let what = if unjudged == 1 { "set-point" } else { "set-points" };
            writeln!(
                f,
                "whether {unjudged} {what} can be held was not judged before the run: the experiment names no `models` of these elements"
            )?;
        }
        if let Some(ended) = &self.ended {
            writeln!(f, "ended early, what had arrived is kept: {ended}")?;
        }
        for element in &self.unreached {
            writeln!(f, "{element} never came within 0.1 K of its set-point")?;
        }
        for TripSummary { time_s, cause, element } in &self.trips {
            writeln!(f, "tripped at {time_s} s: {cause}, {element}; heaters low from then on")?;
        }
        if let Some(wind) = &self.wind {
            write!(f, "\nwind: {wind}")?;
        }
        writeln!(f)?;
        let width = self.elements.iter().map(|element| element.name.chars().count()).max().unwrap_or(0).max(7);
        writeln!(f, "{:width$}  mean temperature  mean power  (whole run, warm-up included)", "element")?;
        for element in &self.elements {
            let temperature =
                element.mean_temperature_c.map_or("no reading".to_owned(), |celsius| format!("{celsius:.3} °C"));
            writeln!(f, "{:width$}  {temperature:>16}  {:>7.3} mW", element.name, element.mean_power_w * 1e3)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary() -> RunSummary {
        let element = |name: &str, mean_temperature_c| ElementSummary {
            name: name.to_owned(),
            mean_temperature_c,
            mean_power_w: 0.0125,
        };
        RunSummary {
            title: "Test".to_owned(),
            head: "sphere-b".to_owned(),
            firmware: "anemo".to_owned(),
            ticks: 10,
            duration_s: 0.1,
            lost: 0,
            damaged: 0,
            late: 0,
            ended: None,
            trips: vec![TripSummary { time_s: 0.05, cause: "open", element: "core1".to_owned() }],
            hash: Some("00ff".to_owned()),
            wind_hash: None,
            unreached: vec!["sector9".to_owned()],
            judgement: SetPointJudgement { judged: 0, unjudged: 1 },
            extrapolated: None,
            validity: "",
            wind: None,
            elements: vec![element("sector1", Some(-23.15)), element("core1", None)],
        }
    }

    #[test]
    fn json_names_the_elements_in_the_order_of_the_head() {
        let json = serde_json::to_string(&summary()).unwrap();
        assert!(json.contains(
            r#""elements":{"sector1":{"mean_temperature_c":-23.15,"mean_power_w":0.0125},"core1":{"mean_temperature_c":null,"mean_power_w":0.0125}}"#
        ));
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!((&value["ticks"], &value["lost"], &value["hash"]), (&10.into(), &0.into(), &"00ff".into()));
        assert_eq!(value["trips"][0]["cause"], "open");
    }

    #[test]
    fn people_are_told_of_trips_and_missing_readings() {
        let text = summary().to_string();
        assert!(text.contains("tripped at 0.05 s: open, core1; heaters low from then on"));
        assert!(text.contains("sector9 never came within 0.1 K of its set-point"));
        assert!(text.contains("core1          no reading   12.500 mW"), "{text}");
    }
}
