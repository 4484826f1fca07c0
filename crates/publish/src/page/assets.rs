//! The page as one file: its styles and scripts are put in where its text names them.

use std::sync::LazyLock;

/// Every file that the page is made of, by its name in `{{…}}`.
const PARTS: [(&str, &str); 5] = [
    ("uPlot.min.css", include_str!("assets/uPlot.min.css")),
    ("page.css", include_str!("assets/page.css")),
    ("uPlot.iife.min.js", include_str!("assets/uPlot.iife.min.js")),
    ("charts.js", include_str!("assets/charts.js")),
    ("page.js", include_str!("assets/page.js")),
];

static PAGE: LazyLock<String> = LazyLock::new(|| {
    PARTS.iter().fold(include_str!("assets/page.html").to_owned(), |page, (name, text)| {
        page.replace(&format!("{{{{{name}}}}}"), text)
    })
});

/// The page.
pub fn page() -> &'static str {
    &PAGE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_whole_and_loads_nothing() {
        let own = page();
        assert!(!own.contains("{{") || !PARTS.iter().any(|(name, _)| own.contains(&format!("{{{{{name}}}}}"))));
        for outside in ["src=", "@import", "url(", "<link rel=\"stylesheet\"", "import("] {
            assert!(!own.contains(outside), "{outside}");
        }
        // The browser would end the script there.
        assert_eq!(own.matches("</script>").count(), 3);
    }
}
