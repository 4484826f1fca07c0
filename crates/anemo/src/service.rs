//! A log as a service of the system: the unit that systemd starts it by.

use std::path::Path;

use crate::output::Failure;

/// The option that asks for the unit.
const OPTION: &str = "--service";

/// The unit that runs the command of this process in its folder, and again after it has failed.
///
/// # Errors
/// If a word of the command is no text, or this program's place is not known.
pub(super) fn unit(title: &str) -> Result<String, Failure> {
    let program = crate::program::own_program()?;
    let folder = std::env::current_dir().map_err(Failure::work)?;
    let arguments = std::env::args_os().skip(1).filter(|argument| argument != OPTION);
    let arguments = arguments.map(|argument| word(Path::new(&argument)));
    let words = std::iter::once(word(&program)).chain(arguments).collect::<Result<Vec<_>, _>>()?;
    text(title, &folder, &words, std::env::var("USER").ok().as_deref())
}

fn text(title: &str, folder: &Path, words: &[String], user: Option<&str>) -> Result<String, Failure> {
    // A path stands as it is, but for the sign of a specifier.
    let folder = plain(folder)?.replace('%', "%%");
    let title = title.replace(['\n', '\r'], " ").replace('%', "%%");
    let user = user.filter(|user| *user != "root").map_or_else(String::new, |user| format!("User={user}\n"));
    Ok(format!(
        "[Unit]
Description=anemo log: {title}

[Service]
ExecStart={}
WorkingDirectory={folder}
{user}SupplementaryGroups=dialout
Restart=on-failure
RestartSec=10
# Wrong usage and a trip are for a person.
RestartPreventExitStatus=2 3
TimeoutStopSec=60

[Install]
WantedBy=multi-user.target
",
        words.join(" ")
    ))
}

fn plain(path: &Path) -> Result<&str, Failure> {
    path.to_str().ok_or_else(|| Failure::usage(format!("{}: a unit can name only what is UTF-8", path.display())))
}

/// A word of a command as a unit has it (systemd.service, "Command lines").
fn word(word: &Path) -> Result<String, Failure> {
    let word = plain(word)?;
    let escaped = word.replace('\\', r"\\").replace('"', "\\\"").replace('%', "%%").replace('$', "$$");
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "/._-:=+,%".contains(letter);
    let needs_quotes = escaped.is_empty() || !escaped.chars().all(is_plain);
    Ok(if needs_quotes { format!("\"{}\"", escaped.replace('\n', "\\n")) } else { escaped })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_mean_to_systemd_what_they_mean_here() {
        let of = |text: &str| word(Path::new(text)).unwrap();
        assert_eq!(of("serial:/dev/ttyACM0"), "serial:/dev/ttyACM0");
        assert_eq!([of("100 %"), of("$HOME"), of(r#"a"b\c"#)], ["\"100 %%\"", "\"$$HOME\"", r#""a\"b\\c""#]);
        assert_eq!([of(""), of("a;b")], ["\"\"", "\"a;b\""]);
    }

    #[test]
    fn a_unit_names_the_user_unless_it_is_root() {
        let of = |user| text("Gusts\nat 5 %", Path::new("/srv/a b"), &["/bin/anemo".to_owned()], user).unwrap();
        assert!(of(Some("mast")).contains("\nWorkingDirectory=/srv/a b\nUser=mast\n"));
        assert!(!of(Some("root")).contains("User=") && of(None).contains("Description=anemo log: Gusts at 5 %%\n"));
    }
}
