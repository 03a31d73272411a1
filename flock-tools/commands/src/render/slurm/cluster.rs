//! Slurm's commands, and what they answer.
//!
//! Owns the words for `sbatch`, `squeue` and `scancel`. They find the cluster as on every command line: by `slurm.conf`.
//! Never decides what is sent.
//!
//! Start at [`Cluster::submit`]. The manuals of these commands say what the words mean.

use std::collections::HashMap;
use std::ffi::OsString;
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::ops::Range;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use super::SlurmArgs;
use super::plan_file::ranges;

/// The cluster, as far as the tasks of one plan go.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// The name of their jobs.
    pub(super) name: String,
}

/// What all tasks have in common.
#[derive(Debug)]
pub(super) struct Batch<'a> {
    /// The working folder: the flock's.
    pub(super) folder: &'a Path,
    /// The file of each task's output, in that folder: `%A` is the job, `%a` the task.
    pub(super) log: &'a str,
    /// What a task runs.
    pub(super) program: &'a Path,
    /// Its words; each is plain, or `"$SLURM_ARRAY_TASK_ID/N"`.
    pub(super) words: &'a [String],
    /// Cores of a task.
    pub(super) threads: NonZeroUsize,
    /// Memory of a task, in bytes.
    pub(super) bytes: u64,
}

/// A task that waits or runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LiveTask {
    /// Slurm's word, such as `RUNNING`.
    pub(super) state: String,
    /// Why it waits, in Slurm's words.
    pub(super) reason: String,
}

/// What Slurm did not do.
#[derive(Debug, thiserror::Error)]
pub(super) enum ClusterError {
    /// It does not answer as its manual says.
    #[error("`{program}` answers `{said}`")]
    Answer { program: &'static str, said: String },
    /// It refused.
    #[error("`{program}` failed: {said}")]
    Failed { program: &'static str, said: String },
    /// There is no such command.
    #[error("cannot start `{program}`, a command of Slurm")]
    Start { program: &'static str, source: io::Error },
}

impl Cluster {
    /// Sends the tasks `indices` of `batch` as an array. Returns the job's number.
    pub(super) fn submit(&self, batch: &Batch<'_>, indices: &[u32], args: &SlurmArgs) -> Result<String, ClusterError> {
        let mut sbatch = Command::new("sbatch");
        sbatch.args(self.options(batch, indices, args)).stdin(Stdio::piped());
        let said = said("sbatch", &mut sbatch, &script(batch.program, batch.words))?;
        // With several clusters the cluster's name follows.
        let job = said.trim().split(';').next().unwrap_or_default().to_owned();
        if job.is_empty() || !job.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(ClusterError::Answer { program: "sbatch", said });
        }
        Ok(job)
    }

    fn options(&self, batch: &Batch<'_>, indices: &[u32], args: &SlurmArgs) -> Vec<OsString> {
        let megabytes = batch.bytes.div_ceil(1 << 20);
        let mut options: Vec<OsString> = vec![
            "--parsable".into(),
            "--requeue".into(),
            "--open-mode=append".into(),
            "--nodes=1".into(),
            "--ntasks=1".into(),
            format!("--job-name={}", self.name).into(),
            format!("--array={}", list(indices)).into(),
            format!("--cpus-per-task={}", batch.threads).into(),
            format!("--mem={megabytes}M").into(),
            format!("--output={}", batch.log).into(),
        ];
        let mut chdir = OsString::from("--chdir=");
        chdir.push(batch.folder);
        options.push(chdir);
        options.extend(args.partition.iter().map(|name| format!("--partition={name}").into()));
        options.extend(args.time.iter().map(|limit| format!("--time={limit}").into()));
        options.extend(args.sbatch.iter().map(OsString::from));
        options
    }

    /// The tasks that wait or run, by their numbers.
    pub(super) fn live(&self) -> Result<HashMap<u32, LiveTask>, ClusterError> {
        let mut squeue = Command::new("squeue");
        squeue.args(["--noheader", "--array", "--format=%K|%T|%r"]).arg(format!("--name={}", self.name));
        // A person may want to see tasks that are over.
        squeue.env_remove("SQUEUE_STATES");
        let said = said("squeue", &mut squeue, &[])?;
        live(&said).ok_or(ClusterError::Answer { program: "squeue", said })
    }

    /// Ends all tasks.
    pub(super) fn cancel(&self) -> Result<(), ClusterError> {
        said("scancel", Command::new("scancel").arg(format!("--name={}", self.name)), &[]).map(drop)
    }
}

/// Runs `command`, which reads `input`. Returns its standard output.
fn said(program: &'static str, command: &mut Command, input: &[u8]) -> Result<String, ClusterError> {
    let start = |source| ClusterError::Start { program, source };
    let stdin = if input.is_empty() { Stdio::null() } else { Stdio::piped() };
    let mut child = command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(start)?;
    if let Some(mut pipe) = child.stdin.take() {
        // One that refuses its options does not read.
        let _ = pipe.write_all(input);
    }
    let Output { status, stdout, stderr } = child.wait_with_output().map_err(start)?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if status.success() {
        return Ok(text(&stdout));
    }
    let said = text(&stderr);
    Err(ClusterError::Failed { program, said: if said.is_empty() { status.to_string() } else { said } })
}

/// The script of every task.
fn script(program: &Path, words: &[String]) -> Vec<u8> {
    let mut script = b"#!/bin/sh\nexec ".to_vec();
    script.extend(quoted(program));
    for word in words {
        script.push(b' ');
        script.extend_from_slice(word.as_bytes());
    }
    script.push(b'\n');
    script
}

/// A path as one word of a shell.
fn quoted(path: &Path) -> Vec<u8> {
    let mut word = vec![b'\''];
    for byte in path.as_os_str().as_bytes() {
        match byte {
            b'\'' => word.extend_from_slice(b"'\\''"),
            byte => word.push(*byte),
        }
    }
    word.push(b'\'');
    word
}

/// Ascending numbers as Slurm writes arrays: `1-3,7`.
fn list(indices: &[u32]) -> String {
    let part = |range: Range<u32>| match (range.start, range.end - 1) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    };
    ranges(indices).into_iter().map(part).collect::<Vec<_>>().join(",")
}

/// The tasks in the answer of `squeue`; `None` if it is no such answer.
fn live(said: &str) -> Option<HashMap<u32, LiveTask>> {
    let task = |line: &str| {
        let mut fields = line.trim().splitn(3, '|');
        let index = fields.next()?.parse().ok()?;
        let (state, reason) = (fields.next()?.to_owned(), fields.next()?.to_owned());
        Some((index, LiveTask { state, reason }))
    };
    said.lines().filter(|line| !line.trim().is_empty()).map(task).collect()
}

/// The path of the output of task `index` of `job` by the pattern `log`, in `folder`.
pub(super) fn log_of(folder: &Path, log: &str, job: &str, index: u32) -> PathBuf {
    folder.join(log.replace("%A", job).replace("%a", &index.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_written_and_queues_are_read_as_slurm_does() {
        assert_eq!(list(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
        let said = "3|RUNNING|None\n12|PENDING|launch failed requeued held\n";
        let tasks = live(said).unwrap();
        assert_eq!(
            (tasks.len(), &*tasks[&3].state, &*tasks[&12].reason),
            (2, "RUNNING", "launch failed requeued held")
        );
        assert_eq!(live(""), Some(HashMap::new()));
        assert_eq!(live("slurm_load_jobs error: Unable to contact slurm controller"), None);
    }

    #[test]
    fn a_script_runs_the_program_whatever_its_path_is() {
        let words = ["render", "."].map(str::to_owned);
        let script = String::from_utf8(script(Path::new("/it's $HOME/dreams"), &words)).unwrap();
        assert_eq!(script, "#!/bin/sh\nexec '/it'\\''s $HOME/dreams' render .\n");
    }

    #[test]
    fn own_words_for_sbatch_come_last_so_that_they_override_ours() {
        let args = SlurmArgs {
            partition: Some("sheep".to_owned()),
            sbatch: vec!["--mem=0".to_owned()],
            ..SlurmArgs::default()
        };
        let batch = Batch {
            folder: Path::new("/flock"),
            log: "%A_%a.log",
            program: Path::new("dreams"),
            words: &[],
            threads: NonZeroUsize::new(4).unwrap(),
            bytes: 3_000_001,
        };
        let options = Cluster { name: "dreams-1".to_owned() }.options(&batch, &[1, 2], &args);
        let options: Vec<_> = options.iter().map(|option| option.to_str().unwrap()).collect();
        let last = ["--chdir=/flock", "--partition=sheep", "--mem=0"];
        assert_eq!(options[options.len() - 3..], last);
        for wanted in ["--array=1-2", "--mem=3M", "--cpus-per-task=4", "--requeue"] {
            assert!(options.contains(&wanted), "{options:?}");
        }
        assert_eq!(log_of(batch.folder, batch.log, "12", 3), Path::new("/flock/12_3.log"));
    }
}
