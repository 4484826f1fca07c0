//! What must hold of the firmware before it may heat anything: no task panics, the stack suffices, and an overflow ends as a fault.

use crate::artefacts::{self, Board};
use crate::call_graph::CallGraph;
use crate::{install, overflow, panics, stack};
use anyhow::{Context, Result, bail};

pub fn run() -> Result<()> {
    install::thumb_target()?;
    install::flip_link()?;
    install::qemu()?;
    let mut faults = Vec::new();
    for board in Board::ALL {
        let graph = CallGraph::read(&artefacts::firmware(board)?)?;
        println!("\n{}", board.feature());
        let found = [panics::check(&graph).context("panics"), stack::check(&graph).context("stack")];
        faults.extend(found.into_iter().filter_map(Result::err).map(|fault| format!("{}: {fault:#}", board.feature())));
        println!(
            "  {:<40} {:>8} of {}",
            "functions that run after start-up",
            panics::reachable(&graph),
            graph.functions.len()
        );
    }
    faults.extend(overflow::run().context("overflow").err().map(|fault| format!("{fault:#}")));
    if !faults.is_empty() {
        bail!("{}", faults.join("\n"));
    }
    Ok(())
}
