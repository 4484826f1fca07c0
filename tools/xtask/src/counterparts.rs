//! Brings the programs that what `anemo` publishes is tested against: a broker, clients of SCPI,
//! Octave, a browser, one that writes down what a log asks of the disk, and a cluster for sweeps.
//! Tests start them on the loopback and end them; none is a service of the system.

use crate::{install, shell};
use anyhow::Result;

/// A program, its package in Debian, and the service that the package brings along.
struct Counterpart {
    program: &'static str,
    package: &'static str,
    service: Option<&'static str>,
}

const COUNTERPARTS: [Counterpart; 6] = [
    Counterpart { program: "mosquitto", package: "mosquitto", service: Some("mosquitto") },
    Counterpart { program: "mosquitto_sub", package: "mosquitto-clients", service: None },
    Counterpart { program: "lxi", package: "lxi-tools", service: None },
    Counterpart { program: "octave-cli", package: "octave", service: None },
    Counterpart { program: "strace", package: "strace", service: None },
    Counterpart { program: "chromium", package: "chromium", service: None },
];

/// A cluster, for the sweep of the Python package.
const SLURM: [Counterpart; 4] = [
    Counterpart { program: "munged", package: "munge", service: Some("munge") },
    Counterpart { program: "slurmctld", package: "slurmctld", service: Some("slurmctld") },
    Counterpart { program: "slurmd", package: "slurmd", service: Some("slurmd") },
    Counterpart { program: "sbatch", package: "slurm-client", service: None },
];

/// Installs the missing programs of the tests of every day.
pub fn run() -> Result<()> {
    install::python_environment("counterparts", "tools/xtask/python-counterparts.txt")?;
    install_all(&COUNTERPARTS);
    Ok(())
}

/// Installs the missing programs of a cluster, which only the nightly tests need.
pub fn slurm() {
    install_all(&SLURM);
}

/// A program that this system has no package of is named, and its tests skip.
fn install_all(counterparts: &[Counterpart]) {
    for &Counterpart { program, package, service } in counterparts {
        if install::is_on_path(program) {
            continue;
        }
        if let Err(error) = install::package_of_program(program, package) {
            shell::announce(&format!("{error:#}; the tests that need {program} will skip"));
        }
        // The package has started it; a user's machine is no server because of our tests.
        if let Some(service) = service.filter(|_| shell::answers("systemctl", &["is-system-running"])) {
            let _ = shell::run(shell::program("systemctl").args(["disable", "--now", service]));
        }
    }
}
