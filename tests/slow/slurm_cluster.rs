//! A real Slurm cluster of one node, in a folder of its own.
//!
//! Owns its daemons, `munged`, `slurmctld` and `slurmd`: their settings, their start and their end. They listen on ports
//! and a socket of their own, and end with the value. Never touches a cluster that the machine has.
//!
//! Start at [`SlurmCluster::start`].

use claims::wait;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// The longest time in which a daemon starts, in seconds.
const START_S: u32 = 120;

/// The name of its partition.
pub(crate) const PARTITION: &str = "sheep";

/// A cluster.
pub(crate) struct SlurmCluster {
    folder: TempDir,
    /// In the order of their start.
    daemons: Vec<Child>,
}

impl SlurmCluster {
    /// A cluster whose node is idle, with so many cores.
    pub(crate) fn start(cores: u32) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let mut cluster = Self { folder, daemons: Vec::new() };
        let at = |name: &str| cluster.at(name);
        fs::write(at("munge.key"), [7; 1024]).unwrap();
        fs::set_permissions(at("munge.key"), fs::Permissions::from_mode(0o600)).unwrap();
        fs::write(at("slurm.conf"), cluster.settings(cores)).unwrap();
        let mut munged = daemon("munged", &["--foreground", "--force"]);
        for (option, name) in [
            ("--socket", "munge.socket"),
            ("--key-file", "munge.key"),
            ("--pid-file", "munge.pid"),
            ("--log-file", "munge.log"),
            ("--seed-file", "munge.seed"),
        ] {
            munged.arg(format!("{option}={}", at(name).display()));
        }
        cluster.spawn(munged);
        wait::until("the socket of munged", START_S, || cluster.at("munge.socket").exists());
        for program in ["slurmctld", "slurmd"] {
            let mut command = daemon(program, &["-D", "-f"]);
            command.arg(cluster.at("slurm.conf"));
            cluster.spawn(command);
        }
        let is_idle = || {
            for (number, daemon) in cluster.daemons.iter().enumerate() {
                let said = || fs::read_to_string(cluster.at(&format!("{number}.out"))).unwrap_or_default();
                assert!(!wait::ends_within(daemon, 0), "a daemon of Slurm has ended by itself: {}", said());
            }
            let said = cluster.command("sinfo").args(["--noheader", "--format=%T"]).output().unwrap();
            String::from_utf8_lossy(&said.stdout).trim() == "idle"
        };
        wait::until("an idle node", START_S, is_idle);
        cluster
    }

    /// `program` with this cluster's settings.
    pub(crate) fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new(program.as_ref());
        command.env("SLURM_CONF", self.at("slurm.conf"));
        command
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn spawn(&mut self, mut command: Command) {
        let log = fs::File::create(self.at(&format!("{}.out", self.daemons.len()))).unwrap();
        let both = log.try_clone().unwrap();
        let child = command.stdin(Stdio::null()).stdout(log).stderr(both).spawn();
        self.daemons.push(child.unwrap_or_else(|error| panic!("cannot run {command:?}: {error}")));
    }

    fn settings(&self, cores: u32) -> String {
        let told = |program: &str, option: &str| {
            let said = Command::new(program).arg(option).output().unwrap();
            String::from_utf8(said.stdout).unwrap().trim().to_owned()
        };
        let (host, user) = (fs::read_to_string("/proc/sys/kernel/hostname").unwrap(), told("id", "-un"));
        let host = host.trim().split('.').next().unwrap_or_default();
        // Free now; nobody else on this machine asks for just these.
        let listeners = [0; 2].map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
        let [controller, node] = listeners.map(|listener| listener.local_addr().unwrap().port());
        let folder = self.folder.path().display();
        format!(
            "ClusterName=farm\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser={user}\nSlurmdUser={user}\n\
             SlurmctldPort={controller}\nSlurmdPort={node}\nAuthType=auth/munge\n\
             AuthInfo=socket={folder}/munge.socket\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n\
             ReturnToService=2\nStateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n\
             SlurmctldPidFile={folder}/slurmctld.pid\nSlurmdPidFile={folder}/slurmd.pid\n\
             SlurmctldLogFile={folder}/slurmctld.log\nSlurmdLogFile={folder}/slurmd.log\n\
             SchedulerType=sched/backfill\nSchedulerParameters=sched_interval=1,batch_sched_delay=0\n\
             SelectType=select/cons_tres\nMpiDefault=none\nSlurmdParameters=config_overrides\nKillWait=1\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=4000 State=UNKNOWN\n\
             PartitionName={PARTITION} Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
        )
    }
}

impl Drop for SlurmCluster {
    fn drop(&mut self) {
        let _ = self.command("scancel").arg(format!("--partition={PARTITION}")).output();
        for mut daemon in self.daemons.drain(..).rev() {
            let _ = kill_process(Pid::from_child(&daemon), Signal::TERM);
            if !wait::ends_within(&daemon, 20) {
                let _ = daemon.kill();
            }
            let _ = daemon.wait();
        }
    }
}

/// A daemon of Slurm; those lie where only the administrator looks.
fn daemon(program: &str, words: &[&str]) -> Command {
    let path = Path::new("/usr/sbin").join(program);
    assert!(path.exists(), "`{}` is not there: .ci/install check", path.display());
    let mut command = Command::new(path);
    command.args(words);
    command
}
