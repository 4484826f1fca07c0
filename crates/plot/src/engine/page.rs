//! The page of a figure: its titles, and its charts in rows as far as its width has room, or only
//! the panels that are named. All lengths are in points.

use anyhow::bail;

use super::chart::{Chart, ChartFrame, Figure};
use super::colour::{INK, QUIET};
use super::layout::{ChartLayout, EDGE, LEAST_NAMED};
use super::svg::{Anchor, MM, Svg};
use super::words::two_lines;

/// Beyond the right end of the charts: half of the last label.
const RIGHT: f64 = 12.0;
/// Charts side by side are at least so wide, with their labels.
const LEAST_WIDTH: f64 = 55.0 * MM;
/// Sizes of letters, and from line to line.
const TITLE: f64 = 10.0;
const TITLE_LINE: f64 = 12.5;
const SUBTITLE: f64 = 7.0;
const SUBTITLE_LINE: f64 = 9.5;

impl Figure {
    /// Every row of charts as a figure of its own, without titles: for a page that breaks between
    /// them. Their axes stand below each other as in the whole figure.
    pub fn apart(&self) -> impl Iterator<Item = Self> {
        let left_rooms = Some(self.most_left_room());
        let row =
            move |row: &Vec<Chart>| Self { rows: vec![row.clone()], width: self.width, left_rooms, ..Self::default() };
        self.rows.iter().map(row)
    }

    /// Room of all charts: what titles, labels and names at the left need.
    fn most_left_room(&self) -> [f64; 3] {
        let rooms = self.charts().map(|chart| chart.left_room(self.width.points()));
        rooms.fold([0.0; 3], |most, room| std::array::from_fn(|i| f64::max(most[i], room[i])))
    }

    /// Draws it as SVG, of its width in millimetres and with a view box in points. The same figure
    /// always makes the same text.
    pub fn svg(&self) -> String {
        let wide = self.width.points();
        let rows: Vec<&[Chart]> = self.rows.iter().flat_map(|row| row.chunks(abreast(row.len(), wide))).collect();
        let [titles, labels_room, names] = self.left_rooms.unwrap_or_else(|| self.most_left_room());
        let left = EDGE + f64::max(titles + labels_room, names);
        let mut svg = Svg::default();
        let room = wide - 2.0 * EDGE;
        let mut y = EDGE;
        // Bold letters take a tenth more.
        for line in two_lines(&self.title, 1.12 * TITLE, room).iter().filter(|line| !line.is_empty()) {
            svg.bold(line, (EDGE, y + TITLE_LINE / 2.0), TITLE, INK, Anchor::Start);
            y += TITLE_LINE;
        }
        for line in two_lines(&self.subtitle, SUBTITLE, room).iter().filter(|line| !line.is_empty()) {
            svg.text(line, (EDGE, y + SUBTITLE_LINE / 2.0), SUBTITLE, QUIET, Anchor::Start);
            y += SUBTITLE_LINE;
        }
        let mut above: Option<ChartLayout> = None;
        for (i, row) in rows.iter().enumerate() {
            let has_close_up = rows.get(i + 1).is_some_and(|next| next[0].frame == ChartFrame::CloseUp);
            let share = wide / row.len() as f64;
            // Charts below each other end at one place.
            let alike = rows.iter().filter(|other| other.len() == row.len()).copied().flatten();
            let names = alike.map(|chart| chart.right_room(wide)).fold(RIGHT, f64::max);
            let place = |(i, chart)| ChartLayout::of(chart, share * i as f64 + left, share - left - names);
            let mut charts: Vec<ChartLayout> = row.iter().enumerate().map(place).collect();
            let top = y + charts.iter().map(ChartLayout::room_above).fold(0.0, f64::max);
            y = top;
            for layout in &mut charts {
                layout.labels_room = labels_room;
                // The close-up has the same axis, and its title.
                layout.has_end_names = wide >= LEAST_NAMED;
                layout.has_x_title = layout.chart.x_labels && !has_close_up;
                (layout.rect.top, layout.rect.bottom) = (top, top + layout.chart.height);
                y = y.max(layout.rect.bottom + layout.room_below());
                layout.draw(&mut svg, wide - 1.0);
                if let Some(above) = above.as_ref().filter(|_| layout.chart.frame == ChartFrame::CloseUp) {
                    layout.lead_here(above, &mut svg);
                }
            }
            above = charts.pop();
        }
        svg.finish(wide, y + EDGE)
    }
}

/// Number of charts that have room side by side: about equally many in each row.
fn abreast(charts: usize, wide: f64) -> usize {
    let most = ((wide / LEAST_WIDTH) as usize).max(1);
    charts.div_ceil(charts.div_ceil(most).max(1)).max(1)
}

impl Figure {
    /// Only the charts whose captions begin with one of these names, in capitals or not, with the
    /// strip of conditions above and the close-up below; all of them if there is no name.
    ///
    /// # Errors
    /// If no caption begins with a name.
    pub fn only(mut self, names: &[String]) -> anyhow::Result<Self> {
        let begins = |chart: &Chart, name: &str| chart.caption.to_lowercase().starts_with(&name.to_lowercase());
        if let Some(name) = names.iter().find(|name| name.is_empty() || !self.charts().any(|of| begins(of, name))) {
            let captions = self.charts().filter(|chart| chart.frame != ChartFrame::CloseUp);
            let captions = captions.map(Chart::caption).filter(|caption| !caption.is_empty());
            let panels = captions.collect::<Vec<_>>().join("`, `");
            bail!("the picture has no panel `{name}`; it has `{panels}`");
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
