//! The page of a figure: its titles, and its charts in rows as far as its width has room. All
//! lengths are in points.

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

    /// Of all charts: what titles, labels and names at the left need.
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

/// How many of some charts have room side by side: about equally many in each row.
fn abreast(charts: usize, wide: f64) -> usize {
    let most = ((wide / LEAST_WIDTH) as usize).max(1);
    charts.div_ceil(charts.div_ceil(most).max(1)).max(1)
}
