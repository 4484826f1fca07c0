//! Numbers for people: short, and a value with no more digits than its standard error leaves.

/// Five digits.
pub fn brief(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.4e}");
    }
    let digits = (4 - size.max(1e-3).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A value to the second digit of its standard error.
pub fn estimate(value: f64, se: f64) -> String {
    if !(se > 0.0 && se.is_finite()) {
        return brief(value);
    }
    let place = se.log10().floor() as i32 - 1;
    // Small quantities keep a common power of ten, so that value and error can be compared.
    if value.abs().max(se) < 1e-3 {
        let exponent = value.abs().max(se).log10().floor() as i32;
        let (scale, digits) = (10_f64.powi(exponent), (exponent - place).clamp(0, 9) as usize);
        return format!("({:.digits$} ± {:.digits$})e{exponent}", value / scale, se / scale);
    }
    let digits = (-place).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    // There is no −0.00.
    let text =
        if text.bytes().any(|digit| (b'1'..=b'9').contains(&digit)) { &text } else { text.trim_start_matches('-') };
    format!("{text} ± {se:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_show_the_digits_that_their_errors_leave() {
        assert_eq!(estimate(843.79231, 0.0113), "843.792 ± 0.011");
        assert_eq!(estimate(-36.2146, 0.43), "-36.21 ± 0.43");
        assert_eq!(estimate(8.0005e-4, 2.6e-8), "(8.00050 ± 0.00026)e-4");
        assert_eq!(estimate(1234.5, 67.0), "1234 ± 67");
        assert_eq!(estimate(20.0, 0.0), "20");
        assert_eq!(
            (estimate(-0.004, 0.12), estimate(0.17184, 1.2e-5)),
            ("0.00 ± 0.12".into(), "0.171840 ± 0.000012".into())
        );
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!((brief(0.05), brief(3000.0), brief(1.5708e-4)), ("0.05".into(), "3000".into(), "1.5708e-4".into()));
        assert_eq!(brief(0.0), "0");
    }
}
