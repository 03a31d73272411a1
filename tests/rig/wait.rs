//! Waits with a limit, which fail with what they waited for.
//!
//! Owns the wait for a state, for a line and for the end of a process. Never reads a clock: the kernel counts the time.
//!
//! Start at [`until`] and [`output`].

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use std::io::{BufRead, BufReader, Read};
use std::os::fd::AsFd;
use std::process::{Child, ExitStatus, Output};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

/// Waits until `is_so`, which is asked every millisecond, for at most `seconds`.
pub fn until(what: &str, seconds: u32, mut is_so: impl FnMut() -> bool) {
    let tick = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
    for _ in 0..u64::from(seconds) * 1_000 {
        if is_so() {
            return;
        }
        poll(&mut [], Some(&tick)).unwrap();
    }
    panic!("waited {seconds} s for this: {what}");
}

/// The next line from `from`, with its end; empty at the end of the stream. It begins within `seconds`.
pub fn line(what: &str, seconds: u32, from: &mut BufReader<impl Read + AsFd>) -> String {
    let is_there = from.buffer().contains(&b'\n') || is_ready(from.get_ref(), seconds);
    assert!(is_there, "waited {seconds} s for this: {what}");
    let mut line = String::new();
    from.read_line(&mut line).unwrap();
    line
}

/// Whether `child` ends within `seconds`. It is left running if not.
pub fn ends_within(child: &Child, seconds: u32) -> bool {
    let Ok(handle) = pidfd_open(Pid::from_child(child), PidfdFlags::empty()) else { return true };
    is_ready(&handle, seconds)
}

/// The exit status of `child`, which ends within `seconds`.
pub fn ended(what: &str, seconds: u32, child: &mut Child) -> ExitStatus {
    if !ends_within(child, seconds) {
        child.kill().unwrap();
        child.wait().unwrap();
        panic!("waited {seconds} s for the end of this: {what}");
    }
    child.wait().unwrap()
}

/// What `child` says on its pipes and its exit status; it ends within `seconds`.
pub fn output(what: &str, seconds: u32, child: Child) -> Output {
    let handle = pidfd_open(Pid::from_child(&child), PidfdFlags::empty()).unwrap();
    let (sender, said) = channel();
    thread::spawn(move || sender.send(child.wait_with_output()));
    let Ok(output) = said.recv_timeout(Duration::from_secs(seconds.into())) else {
        pidfd_send_signal(handle, Signal::KILL).ok();
        panic!("waited {seconds} s for the end of this: {what}");
    };
    output.unwrap()
}

/// Whether `file` can be read, or has ended, within `seconds`.
pub fn is_ready(file: &impl AsFd, seconds: u32) -> bool {
    let limit = Timespec { tv_sec: i64::from(seconds), tv_nsec: 0 };
    poll(&mut [PollFd::new(file, PollFlags::IN)], Some(&limit)).unwrap() > 0
}

#[cfg(test)]
mod tests {
    use super::{ended, line, output, until};
    use std::io::BufReader;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::process::{Child, Command, Stdio};

    fn sleeping() -> Child {
        Command::new("sleep").arg("600").stdout(Stdio::piped()).spawn().unwrap()
    }

    #[test]
    fn a_wait_that_is_in_vain_ends_and_says_what_it_waited_for() {
        let mut child = sleeping();
        let mut pipe = BufReader::new(child.stdout.take().unwrap());
        let waits: [&mut dyn FnMut(); 4] = [
            &mut || until("a miracle", 1, || false),
            &mut || drop(line("a miracle", 1, &mut pipe)),
            &mut || assert!(ended("a miracle", 1, &mut sleeping()).success()),
            &mut || drop(output("a miracle", 1, sleeping())),
        ];
        for wait in waits {
            let said = catch_unwind(AssertUnwindSafe(wait)).unwrap_err().downcast::<String>().unwrap();
            assert!(said.starts_with("waited 1 s for ") && said.ends_with("this: a miracle"), "{said}");
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }

    #[test]
    fn what_comes_in_time_is_handed_over() {
        let echo = || Command::new("echo").arg("one\ntwo").stdout(Stdio::piped()).spawn().unwrap();
        let mut pipe = BufReader::new(echo().stdout.take().unwrap());
        assert_eq!([(); 3].map(|()| line("a line", 60, &mut pipe)), ["one\n", "two\n", ""]);
        assert!(ended("echo", 60, &mut echo()).success());
        assert_eq!(output("echo", 60, echo()).stdout, b"one\ntwo\n");
    }
}
