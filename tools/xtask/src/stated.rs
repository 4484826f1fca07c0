//! Numbers that a page states and a job measures: they may differ by little only.

use crate::shell;
use anyhow::{Context, Result, ensure};

/// Share of a number by which its page may be behind.
const TOLERANCE: f64 = 0.05;

/// Compares what was measured with the first numbers that follow a text of a page.
pub fn check(page: &str, before: &str, measured: &[f64]) -> Result<()> {
    let text = std::fs::read_to_string(shell::root().join(page)).with_context(|| format!("{page} cannot be read"))?;
    let stated = numbers_behind(&text, before).with_context(|| format!("{page} has no `{before}`"))?;
    let is_near = |(of_page, measured): (&f64, &f64)| (of_page - measured).abs() <= TOLERANCE * measured.abs();
    let agrees = stated.len() >= measured.len() && stated.iter().zip(measured).all(is_near);
    ensure!(agrees, "{page} does not state behind `{before}` what was measured: {measured:.1?}");
    Ok(())
}

fn numbers_behind(text: &str, before: &str) -> Option<Vec<f64>> {
    let behind = text.split_once(before)?.1.lines().next()?;
    Some(behind.split([' ', ';', ',', ')']).filter_map(|word| word.parse().ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_behind_the_text_in_its_line() {
        let text = "1 KiB\nstack | 30.1 and 41.0 KiB; 2)\n3";
        assert_eq!(numbers_behind(text, "stack | "), Some(vec![30.1, 41.0, 2.0]));
        assert_eq!(numbers_behind(text, "heap"), None);
    }

    #[test]
    fn a_page_that_states_another_number_is_refused() {
        let page = "docs/reference/wire.md";
        assert!(check(page, "A frame has at most ", &[256.0]).is_ok());
        assert!(check(page, "A frame has at most ", &[224.0]).is_err());
    }
}
