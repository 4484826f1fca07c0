//! Tables of pages.

/// A table: its head, with `|` between the titles, and rows of as many cells.
pub struct ResultTable {
    head: String,
    rows: Vec<Vec<String>>,
}

impl ResultTable {
    /// A table of these rows.
    pub fn new<R: Into<Vec<String>>>(head: &str, rows: impl IntoIterator<Item = R>) -> Self {
        Self { head: head.to_owned(), rows: rows.into_iter().map(Into::into).collect() }
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let rule = "---|".repeat(self.head.split(" | ").count());
        let rows: String = self.rows.iter().map(|row| format!("| {} |\n", row.join(" | "))).collect();
        format!("| {} |\n|{rule}\n{rows}", self.head)
    }
}
