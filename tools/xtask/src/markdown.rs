//! The parts of a Markdown page: lines of prose, and blocks between fences.

/// A part of a page. Lines are numbered from 1.
pub enum Part<'a> {
    Prose { line: usize, text: &'a str },
    Block(FencedBlock<'a>),
}

impl Part<'_> {
    /// Tells an empty line of prose.
    pub fn is_empty_line(&self) -> bool {
        matches!(self, Part::Prose { text, .. } if text.trim().is_empty())
    }
}

/// Block between two fences.
pub struct FencedBlock<'a> {
    /// Line of the opening fence.
    pub line: usize,
    /// Words behind the opening fence: the language first.
    pub info: &'a str,
    /// Indent of the opening fence, in spaces.
    pub indent: usize,
    /// The lines between the fences, without that indent.
    pub lines: Vec<&'a str>,
}

/// A page's parts in their order.
pub fn parts(text: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let mut open: Option<(&str, FencedBlock)> = None;
    for (number, raw) in text.lines().enumerate() {
        let start = raw.trim_start();
        if let Some((fence, mut block)) = open.take() {
            if start.starts_with(fence) && start.trim_end().trim_start_matches(&fence[..1]).is_empty() {
                parts.push(Part::Block(block));
            } else {
                let indent = block.indent.min(raw.len() - start.len());
                block.lines.push(&raw[indent..]);
                open = Some((fence, block));
            }
            continue;
        }
        let line = number + 1;
        let mark = start.chars().next().filter(|mark| matches!(mark, '`' | '~'));
        let info = mark.map_or(start, |mark| start.trim_start_matches(mark));
        let fence = &start[..start.len() - info.len()];
        // Code in a line of prose may begin it with as many backticks.
        if fence.len() >= 3 && !info.contains('`') {
            let indent = raw.len() - start.len();
            open = Some((fence, FencedBlock { line, info: info.trim(), indent, lines: Vec::new() }));
        } else {
            parts.push(Part::Prose { line, text: raw });
        }
    }
    parts.extend(open.map(|(_, block)| Part::Block(block)));
    parts
}

/// Lines of prose with their numbers.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    parts(text).into_iter().filter_map(|part| match part {
        Part::Prose { line, text } => Some((line, text)),
        Part::Block(_) => None,
    })
}

/// Code within the prose, which may begin in one line and end in the next, and the line where it
/// begins.
pub fn inline_code(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut open: Option<(usize, String)> = None;
    let mut before = 0;
    for (line, text) in prose(text) {
        // A paragraph ends: a backtick without its other one is just that.
        if text.trim().is_empty() || line != before + 1 {
            open = None;
        }
        before = line;
        for (part, text) in text.split('`').enumerate() {
            if part > 0 {
                open = match open.take() {
                    Some(code) => {
                        found.push(code);
                        None
                    }
                    None => Some((line, String::new())),
                };
            }
            if let Some((_, code)) = &mut open {
                if !code.is_empty() {
                    code.push(' ');
                }
                // Within a table a bar is written so.
                code.push_str(&text.trim().replace("\\|", "|"));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_ends_at_a_fence_as_long_as_its_own_and_loses_its_indent() {
        let text = "a\n````text x\n```\nin\n```\n````\n- item\n\n  ```\n  in\n    deep\n  ```\n```` no ```` b\n";
        let parts = parts(text);
        let blocks: Vec<_> =
            parts.iter().filter_map(|part| if let Part::Block(block) = part { Some(block) } else { None }).collect();
        assert_eq!(blocks.len(), 2);
        assert_eq!((blocks[0].line, blocks[0].info, &blocks[0].lines[..]), (2, "text x", &["```", "in", "```"][..]));
        assert_eq!((blocks[1].line, blocks[1].indent, &blocks[1].lines[..]), (9, 2, &["in", "  deep"][..]));
        assert_eq!(prose(text).map(|(line, _)| line).collect::<Vec<_>>(), [1, 7, 8, 13]);
    }

    #[test]
    fn code_in_prose_may_go_on_in_the_next_line() {
        let text = "see `a` and `b\nc`, `d\n\n`e` | `f \\| g`\n";
        let found: Vec<_> = inline_code(text).into_iter().map(|(line, code)| format!("{line} {code}")).collect();
        assert_eq!(found, ["1 a", "1 b c", "4 e", "4 f | g"]);
    }
}
