//! A task of a plan, as the run that follows it sees it.
//!
//! Owns what becomes of a task that the cluster no longer has: it is sent again while it gets on, and given up after some
//! tries in vain. Never asks the cluster and never reads a frame: both are told.
//!
//! Start at [`Task::next`].

/// How often a task is sent without finishing a frame.
pub(super) const MOST_TRIES: u32 = 3;

/// A task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Task {
    /// From 1.
    pub(super) index: u32,
    /// Its frames that are not finished, each with the number of its clip, in the order in which it renders them.
    pub(super) left: Vec<(usize, u32)>,
    /// The job that it was sent with last, if this run knows it.
    pub(super) job: Option<String>,
    /// How often it was sent since it finished a frame.
    tries: u32,
    /// Frames that were left when it was sent last.
    at_start: usize,
}

/// What to do with a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// It ended without a new frame too often.
    GiveUp,
    /// All of its frames are finished.
    Nothing,
    /// It ended before its frames were finished.
    SendAgain,
    /// It waits or runs.
    Wait,
}

impl Task {
    /// Task `index` with these frames; it is in the cluster or will be sent.
    pub(super) fn new(index: u32, left: Vec<(usize, u32)>) -> Self {
        Self { index, at_start: left.len(), left, job: None, tries: 1 }
    }

    /// Takes out the frames that are there by `is_there`. With `ahead` the look ends after so many in a row that are not: a
    /// task that runs finishes them in their order. Returns those that were found.
    pub(super) fn take_finished(
        &mut self,
        ahead: Option<usize>,
        mut is_there: impl FnMut(usize, u32) -> bool,
    ) -> Vec<(usize, u32)> {
        let (mut found, mut in_a_row) = (Vec::new(), 0);
        self.left.retain(|&(clip, frame)| {
            if ahead.is_some_and(|most| in_a_row >= most) || !is_there(clip, frame) {
                in_a_row += 1;
                return true;
            }
            in_a_row = 0;
            found.push((clip, frame));
            false
        });
        found
    }

    /// What to do with it, where the cluster has it or not.
    pub(super) fn next(&self, is_live: bool) -> Next {
        match (self.left.is_empty(), is_live) {
            (true, _) => Next::Nothing,
            (false, true) => Next::Wait,
            (false, false) if self.left.len() == self.at_start && self.tries >= MOST_TRIES => Next::GiveUp,
            (false, false) => Next::SendAgain,
        }
    }

    /// It was sent again with `job`.
    pub(super) fn sent(&mut self, job: &str) {
        self.tries = if self.left.len() < self.at_start { 1 } else { self.tries + 1 };
        self.at_start = self.left.len();
        self.job = Some(job.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_that_ends_early_is_sent_again_while_it_gets_on_and_then_given_up() {
        let mut task = Task::new(1, (0..6).map(|frame| (0, frame)).collect());
        assert_eq!(task.next(true), Next::Wait);
        for _ in 0..9 {
            assert_eq!(task.next(false), Next::SendAgain);
            task.sent("7");
            if let Some(last) = task.left.pop() {
                assert_eq!(task.take_finished(None, |_, _| false), [], "{last:?}");
            }
            if task.left.len() == 1 {
                break;
            }
        }
        assert_eq!(task.next(false), Next::SendAgain, "it got on");
        task.sent("8");
        for job in ["9", "10"] {
            assert_eq!(task.next(false), Next::SendAgain);
            task.sent(job);
        }
        assert_eq!((task.next(true), task.next(false)), (Next::Wait, Next::GiveUp));
        assert_eq!(task.job.as_deref(), Some("10"));
        task.take_finished(None, |_, _| true);
        assert_eq!(task.next(false), Next::Nothing);
    }

    #[test]
    fn frames_of_a_running_task_are_looked_for_where_they_come_next() {
        let mut task = Task::new(1, (0..9).map(|frame| (0, frame)).collect());
        let mut asked = Vec::new();
        let found = task.take_finished(Some(2), |_, frame| {
            asked.push(frame);
            [0, 1, 3, 8].contains(&frame)
        });
        assert_eq!((found.len(), asked), (3, vec![0, 1, 2, 3, 4, 5]));
        assert_eq!(task.take_finished(None, |_, frame| frame == 8), [(0, 8)]);
    }
}
