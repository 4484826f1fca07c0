//! What continuous integration does, with the time of every stage.

use crate::{install, lint, shell, test};
use anyhow::Result;

pub fn run() -> Result<()> {
    let prepare = || {
        install::thumb_target()?;
        install::lint_tools()?;
        install::qemu()
    };
    let stages: [(&str, &dyn Fn() -> Result<()>); 3] =
        [("prepare", &prepare), ("lint", &lint::run), ("test", &test::run)];
    let mut times = Vec::new();
    for (name, stage) in stages {
        let time = shell::timed(name, stage)?;
        times.push(format!("{name} {:.0} s", time.as_secs_f64()));
    }
    shell::announce(&times.join(", "));
    Ok(())
}
