//! Rows of the regression in panels of four columns, and their products.
//!
//! ```text
//! AᵀA = Σ_n a_n a_nᵀ,     tile (p, q) = Σ_n (columns 4p … 4p+3 of row n)ᵀ (columns 4q … 4q+3)
//! ```
//!
//! Four values of f64 are one register of an x86-64-v3 machine. Sums run from row to row in every
//! lane by itself, with a rounding after each product and each sum, so that every machine gives the
//! same bits, whatever its vectors.

use pulp::{Simd, WithSimd};

/// Columns of a panel.
pub const LANES: usize = 4;

/// Rows of a panel: the few panels with which a sum is busy fit in the fastest cache.
pub const BATCH: usize = 128;

pub type Lanes = [f64; LANES];
pub type Panel = [Lanes; BATCH];
/// Sums, and what rounding took from them.
pub type Tile = [[Lanes; LANES]; 2];

/// Panels that `width` columns take; the last may have lanes to spare.
pub fn panels(width: usize) -> usize {
    width.div_ceil(LANES)
}

/// The tiles (p, q) of `count` panels that are summed, in their order: those on and above the
/// diagonal, but the last panel's stand in its row rather than in its column, where spare lanes
/// cost nothing.
pub fn places(count: usize) -> impl Iterator<Item = (usize, usize)> {
    let last = count.saturating_sub(1);
    (0..last).flat_map(move |p| (p..last).map(move |q| (p, q))).chain((0..count).map(move |q| (last, q)))
}

/// How many they are.
pub fn tiles(count: usize) -> usize {
    count * (count + 1) / 2
}

/// Adds the products of the first `rows` rows to the tiles. Panels that are not live are 0 in all
/// of them, and add nothing; the last is live.
pub fn add_products(panels: &[Panel], is_live: &[bool], width: usize, rows: usize, tiles: &mut [Tile]) {
    pulp::Arch::new().dispatch(Products { panels, is_live, width, rows, tiles });
}

struct Products<'a> {
    panels: &'a [Panel],
    is_live: &'a [bool],
    width: usize,
    rows: usize,
    tiles: &'a mut [Tile],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { panels, is_live, width, rows, mut tiles } = self;
        let Some((last, full)) = panels.split_last() else { return };
        for (p, left) in full.iter().enumerate() {
            let (row, others) = tiles.split_at_mut(full.len() - p);
            if is_live[p] {
                products::<4>(left, &full[p..], &is_live[p..full.len()], rows, row);
            }
            tiles = others;
        }
        match width - LANES * full.len() {
            1 => products::<1>(last, panels, is_live, rows, tiles),
            2 => products::<2>(last, panels, is_live, rows, tiles),
            3 => products::<3>(last, panels, is_live, rows, tiles),
            _ => products::<4>(last, panels, is_live, rows, tiles),
        }
    }
}

/// The tiles of `USED` columns of one panel with several, run by run of those that are live.
#[inline(always)]
fn products<const USED: usize>(
    left: &Panel,
    mut right: &[Panel],
    is_live: &[bool],
    rows: usize,
    mut tiles: &mut [Tile],
) {
    for run in is_live.chunk_by(|one, next| one == next) {
        let (own, others) = right.split_at(run.len());
        let (row, left_over) = tiles.split_at_mut(run.len());
        if run[0] {
            // Several tiles at a time: sums that stand side by side need not wait for each other.
            // Three full ones would be more than sixteen registers hold.
            let (own, row) = if USED < LANES { in_groups::<USED, 3>(left, own, rows, row) } else { (own, row) };
            let (own, row) = in_groups::<USED, 2>(left, own, rows, row);
            in_groups::<USED, 1>(left, own, rows, row);
        }
        (right, tiles) = (others, left_over);
    }
}

#[inline(always)]
fn in_groups<'a, 'b, const USED: usize, const Q: usize>(
    left: &Panel,
    right: &'a [Panel],
    rows: usize,
    tiles: &'b mut [Tile],
) -> (&'a [Panel], &'b mut [Tile]) {
    let (groups, right) = right.as_chunks::<Q>();
    let (targets, tiles) = tiles.as_chunks_mut::<Q>();
    for (group, target) in groups.iter().zip(targets) {
        let mut sums = [[[0.0; LANES]; USED]; Q];
        for n in 0..rows.min(BATCH) {
            let a = &left[n];
            for q in 0..Q {
                let b = &group[q][n];
                for i in 0..USED {
                    sums[q][i] = add(&sums[q][i], a[i], b);
                }
            }
        }
        for ([totals, rests], sums) in target.iter_mut().zip(&sums) {
            let totals = totals.as_flattened_mut().iter_mut().zip(rests.as_flattened_mut());
            for ((total, rest), part) in totals.zip(sums.as_flattened()) {
                let (sum, lost) = exact_sum(*total, *part);
                (*total, *rest) = (sum, *rest + lost);
            }
        }
    }
    (right, tiles)
}

/// A sum, and what rounding took from it (D. E. Knuth, *The Art of Computer Programming* 2, 4.2.2).
#[inline(always)]
pub fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let own = sum - a;
    (sum, (a - (sum - own)) + (b - own))
}

/// Written out lane by lane: so it becomes vector instructions.
#[inline(always)]
fn add(sum: &Lanes, a: f64, b: &Lanes) -> Lanes {
    [sum[0] + a * b[0], sum[1] + a * b[1], sum[2] + a * b[2], sum[3] + a * b[3]]
}
