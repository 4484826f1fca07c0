//! Tables for a terminal.

/// Lines of cells as columns that are as wide as what stands in them, two blanks apart; those numbered in `right` are set to the right.
pub fn columns(lines: &[Vec<String>], right: &[usize]) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let set = |(i, (cell, &width)): (usize, (&String, &usize))| {
        if right.contains(&i) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
    };
    let line = |cells: &Vec<String>| {
        let cells: Vec<String> = cells.iter().zip(&widths).enumerate().map(set).collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell_and_lines_end_with_their_text() {
        let lines = [vec!["key", "°C", "state"], vec!["a longer one", "-12.5", ""], vec!["b"]];
        let lines: Vec<Vec<String>> =
            lines.iter().map(|line| line.iter().map(|&cell| cell.to_owned()).collect()).collect();
        assert_eq!(columns(&lines, &[1]), "key              °C  state\na longer one  -12.5\nb\n");
        assert_eq!(columns(&[], &[]), "");
    }
}
