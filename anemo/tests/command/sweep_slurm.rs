//! A sweep on a cluster with Slurm: a controller and two nodes on this machine, in a folder of
//! their own, ended by their process numbers. `cargo xtask counterparts` brings the programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::process::{anemo, stdout, words};
use crate::sweep::{outcomes, write_sweep};
use recording::Recording;

const PROGRAMS: [&str; 6] = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "kill"];
const PATIENCE: Duration = Duration::from_secs(90);

/// Whether all programs are there; if not, that is said, or refused where all are wanted.
fn has_programs() -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).chain(["/usr/sbin".into()]).collect();
    let missing = PROGRAMS.iter().find(|name| !folders.iter().any(|folder| folder.join(name).is_file()));
    if let Some(missing) = missing {
        let is_wanted = std::env::var_os("ANEMO_COUNTERPARTS").is_some_and(|wanted| wanted == "all");
        assert!(!is_wanted, "{missing} is absent: `cargo xtask counterparts` installs it");
        eprintln!("skipped: {missing} is absent (`cargo xtask counterparts` installs it)");
    }
    missing.is_none()
}

/// Ports for controller and nodes.
#[allow(clippy::disallowed_types, reason = "asks for ports that are free, and hears nothing")]
fn free_ports() -> [u16; 3] {
    // Held all at once, so that they differ.
    let held = [(); 3].map(|()| std::net::TcpListener::bind("127.0.0.1:0").unwrap());
    held.map(|listener| listener.local_addr().unwrap().port())
}

/// A cluster of two nodes with one core each.
struct Cluster {
    folder: PathBuf,
}

impl Cluster {
    fn start(folder: &Path) -> Self {
        let cluster = Self { folder: folder.to_owned() };
        for sub in ["state", "spool-n1", "spool-n2"] {
            fs::create_dir_all(folder.join(sub)).unwrap();
        }
        let at = |name: &str| folder.join(name).display().to_string();
        let port = free_ports();
        let user = String::from_utf8(Command::new("id").arg("-un").output().unwrap().stdout).unwrap();
        let user = user.trim();
        let node = |name: &str, port: u16| {
            format!("NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=100\n")
        };
        let configuration = format!(
            "ClusterName=anemo\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort={}\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nAuthInfo=socket={}\nCredType=cred/munge\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nSwitchType=switch/none\nMpiDefault=none\nReturnToService=2\n\
             SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0\nSchedulerType=sched/builtin\nMinJobAge=300\n\
             SlurmctldPidFile={}\nSlurmdPidFile={}\nStateSaveLocation={}\nSlurmdSpoolDir={}\nSlurmctldLogFile={}\nSlurmdLogFile={}\n\
             {}{}PartitionName=day Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP\n",
            port[0],
            at("munge.socket"),
            at("slurmctld.pid"),
            at("slurmd-%n.pid"),
            at("state"),
            at("spool-%n"),
            at("slurmctld.log"),
            at("slurmd-%n.log"),
            node("n1", port[1]),
            node("n2", port[2]),
        );
        fs::write(folder.join("slurm.conf"), configuration).unwrap();
        fs::write(folder.join("munge.key"), [0x5a; 128]).unwrap();
        fs::set_permissions(folder.join("munge.key"), std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
        cluster.run(
            "munged",
            &[
                "--force",
                &format!("--socket={}", at("munge.socket")),
                &format!("--key-file={}", at("munge.key")),
                &format!("--pid-file={}", at("munged.pid")),
                &format!("--log-file={}", at("munged.log")),
                &format!("--seed-file={}", at("munged.seed")),
            ],
        );
        cluster.run("slurmctld", &[]);
        cluster.run("slurmd", &["-N", "n1"]);
        cluster.run("slurmd", &["-N", "n2"]);
        cluster.wait_until("both nodes are idle", |cluster| {
            cluster.printed("sinfo", &["-h", "-N", "-o", "%t"]) == "idle\nidle\n"
        });
        cluster
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        let path = std::env::var("PATH").unwrap_or_default();
        command.env("SLURM_CONF", self.folder.join("slurm.conf")).env("PATH", format!("{path}:/usr/sbin"));
        command.current_dir(&self.folder);
        command
    }

    fn run(&self, program: &str, arguments: &[&str]) {
        let output = self.command(program).args(arguments).output().unwrap();
        assert!(output.status.success(), "{program}: {output:?}");
    }

    fn printed(&self, program: &str, arguments: &[&str]) -> String {
        String::from_utf8_lossy(&self.command(program).args(arguments).output().unwrap().stdout).into_owned()
    }

    fn wait_until(&self, what: &str, mut is_so: impl FnMut(&Self) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !is_so(self) {
            if Instant::now() > deadline {
                let queue = self.printed("squeue", &[]) + &self.printed("sinfo", &[]);
                let log = fs::read_to_string(self.folder.join("slurmctld.log")).unwrap_or_default();
                panic!("waited too long until {what}:\n{queue}{log}");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Submits the sweep as a user does.
    fn submit(&self) -> Output {
        let mut command = self.command(env!("CARGO_BIN_EXE_anemo"));
        command.args(words("sweep sweep.toml -o out --slurm --tasks 4 --partition day")).output().unwrap()
    }

    fn wait_for_all_jobs(&self) {
        self.wait_until("all jobs have ended", |cluster| cluster.printed("squeue", &["-h"]).is_empty());
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for daemon in ["slurmd-n1", "slurmd-n2", "slurmctld", "munged"] {
            let Ok(number) = fs::read_to_string(self.folder.join(format!("{daemon}.pid"))) else { continue };
            let number = number.trim();
            let _ = Command::new("kill").arg(number).status();
            let deadline = Instant::now() + Duration::from_secs(10);
            while Path::new("/proc").join(number).exists() && Instant::now() < deadline {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    }
}

#[test]
fn a_sweep_on_slurm_with_a_killed_task_comes_to_the_same_and_repeats_only_what_was_killed() {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // About 1 s each.
    write_sweep(folder, 2000.0, 8, "");
    stdout(&anemo(folder, &words("sweep sweep.toml -o plain")));
    let plain = outcomes(&folder.join("plain"));
    let cluster = Cluster::start(folder);

    let said = stdout(&cluster.submit());
    assert!(said.contains(": 4 of 4 shards; job "), "{said}");
    // The second run of a shard has begun: the process that does it is killed.
    let first_done: Vec<(String, String, usize)> = {
        cluster.wait_until("a run is done", |_| {
            folder.join("out").exists() && outcomes(&folder.join("out")).iter().any(|(_, result, _)| !result.is_empty())
        });
        outcomes(&folder.join("out"))
    };
    assert!(first_done.iter().any(|(_, result, _)| result.is_empty()), "all are done before one is killed");
    let mut killed = None;
    cluster.wait_until("a run is in the middle", |_| {
        let begun = outcomes(&folder.join("out")).into_iter().find(|(_, result, _)| result.is_empty());
        let Some((hash, ..)) = begun else { return false };
        let log = fs::read_to_string(folder.join(format!("out/run={hash}/attempts.log"))).unwrap();
        let process = log.trim_end().rsplit(' ').next().unwrap().to_owned();
        let was_killed = Command::new("kill").args(["-9", &process]).status().unwrap().success();
        killed = Some(hash);
        was_killed
    });
    let killed = killed.unwrap();
    cluster.wait_for_all_jobs();
    let messages = |of: &str| {
        let files = fs::read_dir(folder.join("out/slurm")).unwrap().map(|file| file.unwrap().path());
        let of = files.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(of));
        of.map(|path| fs::read_to_string(path).unwrap()).collect::<String>()
    };
    let gathered = messages("gather-");
    assert!(gathered.contains("runs are missing: ") && gathered.contains("/4; the others are kept"), "{gathered}");

    let said = stdout(&cluster.submit());
    assert!(said.contains(": 1 of 4 shards; job "), "{said}");
    cluster.wait_for_all_jobs();
    let all = outcomes(&folder.join("out"));
    let results = |of: &[(String, String, usize)]| {
        of.iter().map(|(run, result, _)| (run.clone(), result.clone())).collect::<Vec<_>>()
    };
    assert_eq!(results(&all), results(&plain), "{}", messages(""));
    for (hash, _, attempts) in &all {
        assert_eq!(*attempts, if *hash == killed { 2 } else { 1 }, "{hash}, killed {killed}");
    }
    let tables = ["out", "plain"].map(|name| Recording::read(&folder.join(name).join("results.parquet")).unwrap());
    assert_eq!(tables[0].columns, tables[1].columns);
    let said = stdout(&cluster.submit());
    assert!(said.starts_with("no run is missing; job "), "{said}");
    cluster.wait_for_all_jobs();
}
