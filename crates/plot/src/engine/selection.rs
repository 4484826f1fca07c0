//! A part of a figure: the panels that are named, for a column of a journal.

use super::chart::{Chart, ChartFrame, Figure};
use crate::error::PlotError;

impl Figure {
    /// Only the charts whose captions begin with one of these names, in capitals or not, with the
    /// strip of conditions above and the close-up below; all of them if there is no name.
    ///
    /// # Errors
    /// If no caption begins with a name.
    pub fn only(mut self, names: &[String]) -> Result<Self, PlotError> {
        let begins = |chart: &Chart, name: &str| chart.caption.to_lowercase().starts_with(&name.to_lowercase());
        if let Some(name) = names.iter().find(|name| name.is_empty() || !self.charts().any(|of| begins(of, name))) {
            let captions = self.charts().filter(|chart| chart.frame != ChartFrame::CloseUp);
            let captions = captions.map(Chart::caption).filter(|caption| !caption.is_empty());
            let panels = captions.collect::<Vec<_>>().join("`, `");
            return Err(PlotError::Panel { name: name.clone(), panels });
        }
        if names.is_empty() {
            return Ok(self);
        }
        let mut kept: Vec<bool> = Vec::new();
        for chart in self.charts() {
            kept.push(match chart.frame {
                ChartFrame::CloseUp => kept.last() == Some(&true),
                _ => names.iter().any(|name| !chart.caption.is_empty() && begins(chart, name)),
            });
        }
        // From below: of charts over one x axis the last has its labels. If it goes, the one above
        // takes over; the strip on top stays if any of them does.
        let (mut is_unlabelled, mut is_any_kept) = (false, false);
        for (chart, is_kept) in self.rows.iter_mut().flatten().rev().zip(kept.iter_mut().rev()) {
            if chart.x_labels {
                (is_unlabelled, is_any_kept) = (!*is_kept, false);
            } else if chart.caption.is_empty() {
                *is_kept = is_any_kept;
            } else if *is_kept && is_unlabelled {
                (chart.x_labels, is_unlabelled) = (true, false);
            }
            is_any_kept |= *is_kept;
        }
        let mut kept = kept.into_iter();
        self.rows.iter_mut().for_each(|row| row.retain(|_| kept.next() == Some(true)));
        self.rows.retain(|row| !row.is_empty());
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::trace::Trace;

    fn figure() -> Figure {
        let chart = |caption: &str| Chart::new(caption, "K").trace(Trace::line("", vec![(0.0, 1.0), (5.0, 2.0)]));
        let mut over_time = [Chart::new("", "").bare(), chart("Temperature"), chart("Power"), chart("Off")];
        over_time[..3].iter_mut().for_each(|chart| chart.x_labels = false);
        Figure::new("t").stack(over_time).row([chart("Phase")])
    }

    #[test]
    fn what_is_left_keeps_its_labels_below_the_last() {
        let names = ["temp".to_owned(), "POWER".to_owned()];
        let part = figure().only(&names).unwrap();
        let left: Vec<_> = part.charts().map(|chart| (chart.caption(), chart.x_labels)).collect();
        assert_eq!(left, [("", false), ("Temperature", false), ("Power", true)]);
        assert_eq!(figure().only(&[]).unwrap().charts().count(), 5);
        assert_eq!(figure().only(&["Phase".to_owned()]).unwrap().charts().count(), 1);
    }

    #[test]
    fn a_panel_that_is_not_there_is_refused_with_those_that_are() {
        for name in ["phasor", ""] {
            let error = figure().only(&[name.to_owned()]).unwrap_err().to_string();
            assert_eq!(
                error,
                format!("the picture has no panel `{name}`; it has `Temperature`, `Power`, `Off`, `Phase`")
            );
        }
    }
}
