//! Which wind estimates count in histograms: those that count in the summary of `anemo wind`.
//!
//! Both leave out what is before `counted_from_s`, and the first `settle_s` of every label; the
//! file of the estimates has both numbers among its metadata. A label begins here with its first
//! estimate, in the summary with its first tick: at most one output interval before.

use recording::Recording;

use super::columns::stretches;

/// Whether the row of an estimate counts, for every row of a recording; without such metadata all
/// do.
pub fn counted(recording: &Recording, time_s: &[f64]) -> Vec<bool> {
    let number = |key| recording.metadata(key).and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.0);
    let (from_s, settle_s) = (number("counted_from_s"), number("settle_s"));
    let mut counts: Vec<bool> = time_s.iter().map(|at_s| *at_s >= from_s).collect();
    let mut labels: Vec<(usize, usize)> =
        stretches(recording.events()).into_iter().map(|(from, to, _)| (from, to)).collect();
    if labels.is_empty() {
        labels.push((0, time_s.len()));
    }
    for (from, to) in labels {
        let to = to.min(time_s.len());
        for row in from..to {
            counts[row] &= time_s[row] - time_s[from] >= settle_s;
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beginning_of_every_label_and_of_the_recording_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        let rows: String = (0..12).map(|n| format!("{n},{},{n}\n", if n < 6 { "a" } else { "b" })).collect();
        let read = |metadata: &str| {
            std::fs::write(&path, format!("{metadata}time_s,event,wind_speed_m_s\n{rows}")).unwrap();
            let recording = Recording::read(&path).unwrap();
            let counted = counted(&recording, recording.time_s().unwrap());
            (0..12).filter(|row| counted[*row]).collect::<Vec<usize>>()
        };
        assert_eq!(read("# counted_from_s: 3\n# settle_s: 2\n"), [3, 4, 5, 8, 9, 10, 11]);
        assert_eq!(read("").len(), 12);
    }
}
