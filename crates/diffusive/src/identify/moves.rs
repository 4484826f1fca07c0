//! How an input moves from row to row: what a drift is told from a body by.

/// Rows that are gone through side by side.
const ABREAST: usize = 16;

/// How an input moves from row to row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InputMoves {
    /// Rows in which it moves by more than a tenth of its range.
    pub moves: u64,
    /// Sum of all its changes, whatever their sign.
    pub travel: f64,
    pub last: f64,
}

impl InputMoves {
    /// Takes the next values; a move is `far` or more.
    pub fn add(&mut self, values: &[f64], far: f64) {
        // Side by side, as a single sum would wait for each of its additions.
        let (mut moves, mut travel) = ([0_u64; ABREAST], [0.0; ABREAST]);
        let mut add = |values: &[f64], before: &[f64]| {
            for (at, (value, before)) in values.iter().zip(before).enumerate() {
                let by = (value - before).abs();
                moves[at] += u64::from(by > far);
                travel[at] += by;
            }
        };
        add(&values[..1], &[self.last]);
        for (values, before) in values[1..].chunks(ABREAST).zip(values.chunks(ABREAST)) {
            add(values, before);
        }
        self.moves += moves.iter().sum::<u64>();
        self.travel += travel.iter().sum::<f64>();
        self.last = values[values.len() - 1];
    }
}
