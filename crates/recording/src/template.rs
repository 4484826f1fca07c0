//! Filling pages: a template, of Markdown or HTML, with placeholders such as `{gas_c}`, and a value
//! for each name.
//!
//! A placeholder without a value and a value without a placeholder are both refused, so that text
//! and numbers stay together.

use anyhow::{Context, bail};

/// Puts values into the places of their names.
///
/// # Errors
/// The first name that only the template or only the values have.
pub fn fill(template: &str, values: &[(&str, &str)]) -> anyhow::Result<String> {
    let mut text = String::with_capacity(template.len());
    let mut used = vec![false; values.len()];
    let mut rest = template;
    while let Some((before, after)) = rest.split_once('{') {
        let short = || after.chars().take(20).collect::<String>();
        let (name, behind) =
            after.split_once('}').with_context(|| format!("a brace of the page is not closed: {}", short()))?;
        let place = values.iter().position(|(known, _)| *known == name);
        let place =
            place.with_context(|| format!("the page asks for `{{{name}}}`, and there is no value of that name"))?;
        used[place] = true;
        text += before;
        text += values[place].1;
        rest = behind;
    }
    match values.iter().zip(used).find(|(_, used)| !used) {
        Some(((name, _), _)) => bail!("`{name}` has a value, and the page has no such placeholder"),
        None => Ok(text + rest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_take_the_places_of_their_names() {
        let filled = fill("{a} of {b}, {a}.\n", &[("a", "3"), ("b", "{c}")]);
        assert_eq!(filled.unwrap(), "3 of {c}, 3.\n");
    }

    #[test]
    fn a_name_that_only_one_side_has_is_refused() {
        let sentence = |template: &str, values: &[(&str, &str)]| fill(template, values).unwrap_err().to_string();
        assert_eq!(sentence("{a}", &[]), "the page asks for `{a}`, and there is no value of that name");
        assert_eq!(sentence("", &[("a", "3")]), "`a` has a value, and the page has no such placeholder");
        assert_eq!(sentence("3 {a", &[]), "a brace of the page is not closed: a");
    }
}
